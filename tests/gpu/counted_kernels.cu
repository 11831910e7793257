// Kernels with counters, for voxels of one type, kept in cells: compiling them for all takes minutes.
// See render/march/march_kernels.cuh and those beside it.
#include "render/march/march_segment_kernels.cuh"

#include "render/base/error.h"

namespace warpscope {

template void launchMarch<uint8_t, false, true>(const MarchJob<uint8_t>&, const RenderSettings&, const ShadingSetup&, const LightVolume&, std::optional<Heuristic>,
                                                cudaStream_t);
template void launchLightVolume<uint8_t, false, true>(const LightVolumeJob&, const VolumeView<uint8_t>&, size_t, size_t, uint16_t*, cudaStream_t);
template void launchMip<uint8_t, false, true>(const MarchJob<uint8_t>&, const MipSetup&, std::optional<Heuristic>, cudaStream_t);
template void launchIsosurfaces<uint8_t, false, true>(const MarchJob<uint8_t>&, const IsosurfaceSetup&, const ShadingSetup&, std::optional<Heuristic>, cudaStream_t);

template void launchSegments<uint8_t, true>(const MarchJob<uint8_t>&, const SegmentLookup&, const ShadingSetup&, const LightVolume&, std::optional<Heuristic>,
                                            cudaStream_t);

namespace {

[[noreturn]] void refuse() { throw InputError("kernels with counters march volumes of uint8 in cells alone"); }

}  // namespace

#define WARPSCOPE_NO_KERNELS(Voxel, kHasHoles, kByCells)                                                                                                 \
  template <>                                                                                                                                            \
  void launchMarch<Voxel, kHasHoles, kByCells>(const MarchJob<Voxel>&, const RenderSettings&, const ShadingSetup&, const LightVolume&,                      \
                                               std::optional<Heuristic>, cudaStream_t) {                                                                  \
    refuse();                                                                                                                                            \
  }                                                                                                                                                      \
  template <>                                                                                                                                            \
  void launchLightVolume<Voxel, kHasHoles, kByCells>(const LightVolumeJob&, const VolumeView<Voxel>&, size_t, size_t, uint16_t*, cudaStream_t) {           \
    refuse();                                                                                                                                            \
  }                                                                                                                                                      \
  template <>                                                                                                                                            \
  void launchMip<Voxel, kHasHoles, kByCells>(const MarchJob<Voxel>&, const MipSetup&, std::optional<Heuristic>, cudaStream_t) {                            \
    refuse();                                                                                                                                            \
  }                                                                                                                                                      \
  template <>                                                                                                                                            \
  void launchIsosurfaces<Voxel, kHasHoles, kByCells>(const MarchJob<Voxel>&, const IsosurfaceSetup&, const ShadingSetup&, std::optional<Heuristic>,          \
                                                     cudaStream_t) {                                                                                     \
    refuse();                                                                                                                                            \
  }
WARPSCOPE_NO_KERNELS(uint8_t, false, false)
WARPSCOPE_NO_KERNELS(int8_t, false, true)
WARPSCOPE_NO_KERNELS(int8_t, false, false)
WARPSCOPE_NO_KERNELS(uint16_t, false, true)
WARPSCOPE_NO_KERNELS(uint16_t, false, false)
WARPSCOPE_NO_KERNELS(int16_t, false, true)
WARPSCOPE_NO_KERNELS(int16_t, false, false)
WARPSCOPE_NO_KERNELS(InterpolantVoxel, false, true)
WARPSCOPE_NO_KERNELS(InterpolantVoxel, false, false)
WARPSCOPE_NO_KERNELS(InterpolantVoxel, true, true)
WARPSCOPE_NO_KERNELS(InterpolantVoxel, true, false)
#undef WARPSCOPE_NO_KERNELS

#define WARPSCOPE_NO_SEGMENTS(Voxel, kByCells)                                                                                                           \
  template <>                                                                                                                                            \
  void launchSegments<Voxel, kByCells>(const MarchJob<Voxel>&, const SegmentLookup&, const ShadingSetup&, const LightVolume&, std::optional<Heuristic>,     \
                                       cudaStream_t) {                                                                                                   \
    refuse();                                                                                                                                            \
  }
WARPSCOPE_NO_SEGMENTS(uint8_t, false)
WARPSCOPE_NO_SEGMENTS(int8_t, true)
WARPSCOPE_NO_SEGMENTS(int8_t, false)
WARPSCOPE_NO_SEGMENTS(uint16_t, true)
WARPSCOPE_NO_SEGMENTS(uint16_t, false)
WARPSCOPE_NO_SEGMENTS(int16_t, true)
WARPSCOPE_NO_SEGMENTS(int16_t, false)
WARPSCOPE_NO_SEGMENTS(InterpolantVoxel, true)
WARPSCOPE_NO_SEGMENTS(InterpolantVoxel, false)
#undef WARPSCOPE_NO_SEGMENTS

}  // namespace warpscope
