// Kernels of greatest values and of surfaces, for interpolants, what wider voxels become.
// See march_mode_kernels.cuh.
#include "render/march/march_mode_kernels.cuh"

namespace warpscope {

template void launchMip<InterpolantVoxel, false, true>(const MarchJob<InterpolantVoxel>&, const MipSetup&, std::optional<Heuristic>, cudaStream_t);
template void launchIsosurfaces<InterpolantVoxel, false, true>(const MarchJob<InterpolantVoxel>&, const IsosurfaceSetup&, const ShadingSetup&,
                                                               std::optional<Heuristic>, cudaStream_t);
template void launchMip<InterpolantVoxel, false, false>(const MarchJob<InterpolantVoxel>&, const MipSetup&, std::optional<Heuristic>, cudaStream_t);
template void launchIsosurfaces<InterpolantVoxel, false, false>(const MarchJob<InterpolantVoxel>&, const IsosurfaceSetup&, const ShadingSetup&,
                                                                std::optional<Heuristic>, cudaStream_t);
template void launchMip<InterpolantVoxel, true, true>(const MarchJob<InterpolantVoxel>&, const MipSetup&, std::optional<Heuristic>, cudaStream_t);
template void launchIsosurfaces<InterpolantVoxel, true, true>(const MarchJob<InterpolantVoxel>&, const IsosurfaceSetup&, const ShadingSetup&,
                                                              std::optional<Heuristic>, cudaStream_t);
template void launchMip<InterpolantVoxel, true, false>(const MarchJob<InterpolantVoxel>&, const MipSetup&, std::optional<Heuristic>, cudaStream_t);
template void launchIsosurfaces<InterpolantVoxel, true, false>(const MarchJob<InterpolantVoxel>&, const IsosurfaceSetup&, const ShadingSetup&,
                                                               std::optional<Heuristic>, cudaStream_t);

}  // namespace warpscope
