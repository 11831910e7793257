#pragma once
namespace warpscope {
inline constexpr double kSphereSurfaceError = 8 * 0x1p-24;
inline constexpr double kSphereDistanceError = 8 * 0x1p-24;
inline constexpr double kBoxDistanceError = 3.001 * 0x1p-24;
}
