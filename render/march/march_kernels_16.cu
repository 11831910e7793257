// Kernels for voxels of 16 bits.
// See march_kernels.cuh.
#include "render/march/march_kernels.cuh"

namespace warpscope {

template void launchMarch<int16_t, false, true>(const MarchJob<int16_t>&, const RenderSettings&, const ShadingSetup&, const LightVolume&,
                     std::optional<Heuristic>, cudaStream_t);
template void launchMarch<int16_t, false, false>(const MarchJob<int16_t>&, const RenderSettings&, const ShadingSetup&, const LightVolume&,
                     std::optional<Heuristic>, cudaStream_t);
template void launchMarch<uint16_t, false, true>(const MarchJob<uint16_t>&, const RenderSettings&, const ShadingSetup&, const LightVolume&,
                     std::optional<Heuristic>, cudaStream_t);
template void launchMarch<uint16_t, false, false>(const MarchJob<uint16_t>&, const RenderSettings&, const ShadingSetup&, const LightVolume&,
                     std::optional<Heuristic>, cudaStream_t);
template void launchLightVolume<int16_t, false, true>(const LightVolumeJob&, const VolumeView<int16_t>&, size_t, size_t, uint16_t*, cudaStream_t);
template void launchLightVolume<int16_t, false, false>(const LightVolumeJob&, const VolumeView<int16_t>&, size_t, size_t, uint16_t*, cudaStream_t);
template void launchLightVolume<uint16_t, false, true>(const LightVolumeJob&, const VolumeView<uint16_t>&, size_t, size_t, uint16_t*, cudaStream_t);
template void launchLightVolume<uint16_t, false, false>(const LightVolumeJob&, const VolumeView<uint16_t>&, size_t, size_t, uint16_t*, cudaStream_t);

}  // namespace warpscope
