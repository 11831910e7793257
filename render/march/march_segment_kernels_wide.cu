// Kernels of pre-integrated steps, for interpolants, what wider voxels become.
// See march_segment_kernels.cuh.
#include "render/march/march_segment_kernels.cuh"

namespace warpscope {

template void launchSegments<InterpolantVoxel, true>(const MarchJob<InterpolantVoxel>&, const SegmentLookup&, const ShadingSetup&, const LightVolume&, std::optional<Heuristic>,
                                                     cudaStream_t);
template void launchSegments<InterpolantVoxel, false>(const MarchJob<InterpolantVoxel>&, const SegmentLookup&, const ShadingSetup&, const LightVolume&, std::optional<Heuristic>,
                                                      cudaStream_t);

}  // namespace warpscope
