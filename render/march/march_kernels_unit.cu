// Kernels for voxels that are fractions of the volume's range, with and without such as are not finite.
// See march_kernels.cuh.
#include "render/march/march_kernels.cuh"

namespace warpscope {

template void launchMarch<UnitVoxel, false, true>(const MarchJob<UnitVoxel>&, const RenderSettings&,
                                                  std::optional<Heuristic>, cudaStream_t);
template void launchMarch<UnitVoxel, false, false>(const MarchJob<UnitVoxel>&, const RenderSettings&,
                                                   std::optional<Heuristic>, cudaStream_t);
template void launchMarch<UnitVoxel, true, true>(const MarchJob<UnitVoxel>&, const RenderSettings&,
                                                 std::optional<Heuristic>, cudaStream_t);
template void launchMarch<UnitVoxel, true, false>(const MarchJob<UnitVoxel>&, const RenderSettings&,
                                                  std::optional<Heuristic>, cudaStream_t);

}  // namespace warpscope
