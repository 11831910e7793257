// Kernels of greatest values and of surfaces, for voxels of 8 bits.
// See march_mode_kernels.cuh.
#include "render/march/march_mode_kernels.cuh"

namespace warpscope {

template void launchMip<int8_t, false, true>(const MarchJob<int8_t>&, const MipSetup&, std::optional<Heuristic>, cudaStream_t);
template void launchIsosurfaces<int8_t, false, true>(const MarchJob<int8_t>&, const IsosurfaceSetup&, const ShadingSetup&, std::optional<Heuristic>,
                                                     cudaStream_t);
template void launchMip<int8_t, false, false>(const MarchJob<int8_t>&, const MipSetup&, std::optional<Heuristic>, cudaStream_t);
template void launchIsosurfaces<int8_t, false, false>(const MarchJob<int8_t>&, const IsosurfaceSetup&, const ShadingSetup&, std::optional<Heuristic>,
                                                      cudaStream_t);
template void launchMip<uint8_t, false, true>(const MarchJob<uint8_t>&, const MipSetup&, std::optional<Heuristic>, cudaStream_t);
template void launchIsosurfaces<uint8_t, false, true>(const MarchJob<uint8_t>&, const IsosurfaceSetup&, const ShadingSetup&, std::optional<Heuristic>,
                                                      cudaStream_t);
template void launchMip<uint8_t, false, false>(const MarchJob<uint8_t>&, const MipSetup&, std::optional<Heuristic>, cudaStream_t);
template void launchIsosurfaces<uint8_t, false, false>(const MarchJob<uint8_t>&, const IsosurfaceSetup&, const ShadingSetup&, std::optional<Heuristic>,
                                                       cudaStream_t);

}  // namespace warpscope
