// Kernels of pieces, for voxels of 16 bits.
// See piece_kernels.cuh.
#include "render/march/piece_kernels.cuh"

namespace warpscope {

template void launchPieces<int16_t, false>(const PieceJob<int16_t>&, const ShadingSetup&, cudaStream_t);
template void launchPieces<uint16_t, false>(const PieceJob<uint16_t>&, const ShadingSetup&, cudaStream_t);

}  // namespace warpscope
