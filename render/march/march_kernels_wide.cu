// Kernels for voxels that are interpolants, with and without such as are not finite.
// See march_kernels.cuh.
#include "render/march/march_kernels.cuh"

namespace warpscope {

template void launchMarch<InterpolantVoxel, false, true>(const MarchJob<InterpolantVoxel>&, const RenderSettings&, const ShadingSetup&, const LightVolume&,
                     std::optional<Heuristic>, cudaStream_t);
template void launchMarch<InterpolantVoxel, false, false>(const MarchJob<InterpolantVoxel>&, const RenderSettings&, const ShadingSetup&, const LightVolume&,
                     std::optional<Heuristic>, cudaStream_t);
template void launchMarch<InterpolantVoxel, true, true>(const MarchJob<InterpolantVoxel>&, const RenderSettings&, const ShadingSetup&, const LightVolume&,
                     std::optional<Heuristic>, cudaStream_t);
template void launchMarch<InterpolantVoxel, true, false>(const MarchJob<InterpolantVoxel>&, const RenderSettings&, const ShadingSetup&, const LightVolume&,
                     std::optional<Heuristic>, cudaStream_t);
template void launchLightVolume<InterpolantVoxel, false, true>(const LightVolumeJob&, const VolumeView<InterpolantVoxel>&, size_t, size_t, uint16_t*, cudaStream_t);
template void launchLightVolume<InterpolantVoxel, false, false>(const LightVolumeJob&, const VolumeView<InterpolantVoxel>&, size_t, size_t, uint16_t*, cudaStream_t);
template void launchLightVolume<InterpolantVoxel, true, true>(const LightVolumeJob&, const VolumeView<InterpolantVoxel>&, size_t, size_t, uint16_t*, cudaStream_t);
template void launchLightVolume<InterpolantVoxel, true, false>(const LightVolumeJob&, const VolumeView<InterpolantVoxel>&, size_t, size_t, uint16_t*, cudaStream_t);

}  // namespace warpscope
