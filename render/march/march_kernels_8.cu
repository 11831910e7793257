// Kernels for voxels of 8 bits.
// See march_kernels.cuh.
#include "render/march/march_kernels.cuh"

namespace warpscope {

template void launchMarch<int8_t, false, true>(const MarchJob<int8_t>&, const RenderSettings&, const ShadingSetup&, const LightVolume&,
                     std::optional<Heuristic>, cudaStream_t);
template void launchMarch<int8_t, false, false>(const MarchJob<int8_t>&, const RenderSettings&, const ShadingSetup&, const LightVolume&,
                     std::optional<Heuristic>, cudaStream_t);
template void launchMarch<uint8_t, false, true>(const MarchJob<uint8_t>&, const RenderSettings&, const ShadingSetup&, const LightVolume&,
                     std::optional<Heuristic>, cudaStream_t);
template void launchMarch<uint8_t, false, false>(const MarchJob<uint8_t>&, const RenderSettings&, const ShadingSetup&, const LightVolume&,
                     std::optional<Heuristic>, cudaStream_t);
template void launchLightVolume<int8_t, false, true>(const LightVolumeJob&, const VolumeView<int8_t>&, size_t, size_t, uint16_t*, cudaStream_t);
template void launchLightVolume<int8_t, false, false>(const LightVolumeJob&, const VolumeView<int8_t>&, size_t, size_t, uint16_t*, cudaStream_t);
template void launchLightVolume<uint8_t, false, true>(const LightVolumeJob&, const VolumeView<uint8_t>&, size_t, size_t, uint16_t*, cudaStream_t);
template void launchLightVolume<uint8_t, false, false>(const LightVolumeJob&, const VolumeView<uint8_t>&, size_t, size_t, uint16_t*, cudaStream_t);

}  // namespace warpscope
