// Kernels of pieces, for voxels of more than 16 bits, which are interpolants.
// See piece_kernels.cuh.
#include "render/march/piece_kernels.cuh"

namespace warpscope {

template void launchPieces<InterpolantVoxel, false>(const PieceJob<InterpolantVoxel>&, const ShadingSetup&, cudaStream_t);
template void launchPieces<InterpolantVoxel, true>(const PieceJob<InterpolantVoxel>&, const ShadingSetup&, cudaStream_t);

}  // namespace warpscope
