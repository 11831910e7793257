// Kernels of pre-integrated steps, for voxels of 16 bits.
// See march_segment_kernels.cuh.
#include "render/march/march_segment_kernels.cuh"

namespace warpscope {

template void launchSegments<int16_t, true>(const MarchJob<int16_t>&, const SegmentLookup&, const ShadingSetup&, const LightVolume&, std::optional<Heuristic>,
                                            cudaStream_t);
template void launchSegments<int16_t, false>(const MarchJob<int16_t>&, const SegmentLookup&, const ShadingSetup&, const LightVolume&, std::optional<Heuristic>,
                                             cudaStream_t);
template void launchSegments<uint16_t, true>(const MarchJob<uint16_t>&, const SegmentLookup&, const ShadingSetup&, const LightVolume&, std::optional<Heuristic>,
                                             cudaStream_t);
template void launchSegments<uint16_t, false>(const MarchJob<uint16_t>&, const SegmentLookup&, const ShadingSetup&, const LightVolume&, std::optional<Heuristic>,
                                              cudaStream_t);

}  // namespace warpscope
