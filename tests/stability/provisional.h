#pragma once
namespace warpscope {
inline constexpr double kSphereSurfaceError = 8 * 0x1p-24;
inline constexpr double kSphereDistanceError = 8 * 0x1p-24;
inline constexpr double kBoxDistanceError = 3.001 * 0x1p-24;
inline constexpr double kDepthCodeError = 3.001 * 0x1p-24;
inline constexpr double kPositionError = 0x1p-21;
inline constexpr double kMarchedOpacityError = 4 * 0x1p-24;
inline constexpr double kMarchedColorError = 19 * 0x1p-24;
inline constexpr double kLatticeError = 3 * 0x1p-24;
inline constexpr double kLatticeStepError = 1.001 * 0x1p-24;
inline constexpr double kOpacityTie = 3e-15;
inline constexpr double kOpacityError = 1.001 * 0x1p-24;
inline constexpr double kTrilinearError = 9.001 * 0x1p-24;
inline constexpr double kVoxelPlaceError = 4.001 * 0x1p-24;
}
