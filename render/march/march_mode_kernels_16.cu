// Kernels of greatest values and of surfaces, for voxels of 16 bits.
// See march_mode_kernels.cuh.
#include "render/march/march_mode_kernels.cuh"

namespace warpscope {

template void launchMip<int16_t, false, true>(const MarchJob<int16_t>&, const MipSetup&, std::optional<Heuristic>, cudaStream_t);
template void launchIsosurfaces<int16_t, false, true>(const MarchJob<int16_t>&, const IsosurfaceSetup&, const ShadingSetup&, std::optional<Heuristic>,
                                                      cudaStream_t);
template void launchMip<int16_t, false, false>(const MarchJob<int16_t>&, const MipSetup&, std::optional<Heuristic>, cudaStream_t);
template void launchIsosurfaces<int16_t, false, false>(const MarchJob<int16_t>&, const IsosurfaceSetup&, const ShadingSetup&, std::optional<Heuristic>,
                                                       cudaStream_t);
template void launchMip<uint16_t, false, true>(const MarchJob<uint16_t>&, const MipSetup&, std::optional<Heuristic>, cudaStream_t);
template void launchIsosurfaces<uint16_t, false, true>(const MarchJob<uint16_t>&, const IsosurfaceSetup&, const ShadingSetup&, std::optional<Heuristic>,
                                                       cudaStream_t);
template void launchMip<uint16_t, false, false>(const MarchJob<uint16_t>&, const MipSetup&, std::optional<Heuristic>, cudaStream_t);
template void launchIsosurfaces<uint16_t, false, false>(const MarchJob<uint16_t>&, const IsosurfaceSetup&, const ShadingSetup&, std::optional<Heuristic>,
                                                        cudaStream_t);

}  // namespace warpscope
