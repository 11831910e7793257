// Kernels of pieces, for voxels of 16 bits.
// See piece_kernels.cuh.
#include "render/march/piece_kernels.cuh"

namespace warpscope {

template void launchPieces<int16_t, false>(const PieceJob<int16_t>&, const ShadingSetup&, const LightVolume&, cudaStream_t);
template void launchMipPieces<int16_t, false>(const PieceJob<int16_t>&, const MipSetup&, cudaStream_t);
template void launchIsosurfacePieces<int16_t, false>(const PieceJob<int16_t>&, const IsosurfaceSetup&, const ShadingSetup&, cudaStream_t);
template void launchPieceNormals<int16_t, false>(const PieceJob<int16_t>&, const ShadingSetup&, const LitPlace*, uint32_t, NormalCode*, cudaStream_t);
template void launchSegmentPieces<int16_t>(const PieceJob<int16_t>&, const SegmentLookup&, const ShadingSetup&, const LightVolume&, cudaStream_t);
template void launchPieces<uint16_t, false>(const PieceJob<uint16_t>&, const ShadingSetup&, const LightVolume&, cudaStream_t);
template void launchMipPieces<uint16_t, false>(const PieceJob<uint16_t>&, const MipSetup&, cudaStream_t);
template void launchIsosurfacePieces<uint16_t, false>(const PieceJob<uint16_t>&, const IsosurfaceSetup&, const ShadingSetup&, cudaStream_t);
template void launchPieceNormals<uint16_t, false>(const PieceJob<uint16_t>&, const ShadingSetup&, const LitPlace*, uint32_t, NormalCode*, cudaStream_t);
template void launchSegmentPieces<uint16_t>(const PieceJob<uint16_t>&, const SegmentLookup&, const ShadingSetup&, const LightVolume&, cudaStream_t);

}  // namespace warpscope
