// Kernels of pieces, for voxels of 8 bits.
// See piece_kernels.cuh.
#include "render/march/piece_kernels.cuh"

namespace warpscope {

template void launchPieces<int8_t, false>(const PieceJob<int8_t>&, const ShadingSetup&, const LightVolume&, cudaStream_t);
template void launchMipPieces<int8_t, false>(const PieceJob<int8_t>&, const MipSetup&, cudaStream_t);
template void launchIsosurfacePieces<int8_t, false>(const PieceJob<int8_t>&, const IsosurfaceSetup&, const ShadingSetup&, cudaStream_t);
template void launchPieceNormals<int8_t, false>(const PieceJob<int8_t>&, const ShadingSetup&, const LitPlace*, uint32_t, NormalCode*, cudaStream_t);
template void launchSegmentPieces<int8_t>(const PieceJob<int8_t>&, const SegmentLookup&, const ShadingSetup&, const LightVolume&, cudaStream_t);
template void launchPieces<uint8_t, false>(const PieceJob<uint8_t>&, const ShadingSetup&, const LightVolume&, cudaStream_t);
template void launchMipPieces<uint8_t, false>(const PieceJob<uint8_t>&, const MipSetup&, cudaStream_t);
template void launchIsosurfacePieces<uint8_t, false>(const PieceJob<uint8_t>&, const IsosurfaceSetup&, const ShadingSetup&, cudaStream_t);
template void launchPieceNormals<uint8_t, false>(const PieceJob<uint8_t>&, const ShadingSetup&, const LitPlace*, uint32_t, NormalCode*, cudaStream_t);
template void launchSegmentPieces<uint8_t>(const PieceJob<uint8_t>&, const SegmentLookup&, const ShadingSetup&, const LightVolume&, cudaStream_t);

}  // namespace warpscope
