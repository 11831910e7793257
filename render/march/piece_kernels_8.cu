// Kernels of pieces, for voxels of 8 bits.
// See piece_kernels.cuh.
#include "render/march/piece_kernels.cuh"

namespace warpscope {

template void launchPieces<int8_t, false>(const PieceJob<int8_t>&, const ShadingSetup&, cudaStream_t);
template void launchPieces<uint8_t, false>(const PieceJob<uint8_t>&, const ShadingSetup&, cudaStream_t);

}  // namespace warpscope
