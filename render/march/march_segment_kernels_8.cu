// Kernels of pre-integrated steps, for voxels of 8 bits.
// See march_segment_kernels.cuh.
#include "render/march/march_segment_kernels.cuh"

namespace warpscope {

template void launchSegments<int8_t, true>(const MarchJob<int8_t>&, const SegmentLookup&, const ShadingSetup&, const LightVolume&, std::optional<Heuristic>,
                                           cudaStream_t);
template void launchSegments<int8_t, false>(const MarchJob<int8_t>&, const SegmentLookup&, const ShadingSetup&, const LightVolume&, std::optional<Heuristic>,
                                            cudaStream_t);
template void launchSegments<uint8_t, true>(const MarchJob<uint8_t>&, const SegmentLookup&, const ShadingSetup&, const LightVolume&, std::optional<Heuristic>,
                                            cudaStream_t);
template void launchSegments<uint8_t, false>(const MarchJob<uint8_t>&, const SegmentLookup&, const ShadingSetup&, const LightVolume&, std::optional<Heuristic>,
                                             cudaStream_t);

}  // namespace warpscope
