// Kernels of pieces, for voxels of more than 16 bits, which are interpolants.
// See piece_kernels.cuh.
#include "render/march/piece_kernels.cuh"

namespace warpscope {

template void launchPieces<InterpolantVoxel, false>(const PieceJob<InterpolantVoxel>&, const ShadingSetup&, const LightVolume&, cudaStream_t);
template void launchMipPieces<InterpolantVoxel, false>(const PieceJob<InterpolantVoxel>&, const MipSetup&, cudaStream_t);
template void launchIsosurfacePieces<InterpolantVoxel, false>(const PieceJob<InterpolantVoxel>&, const IsosurfaceSetup&, const ShadingSetup&, cudaStream_t);
template void launchPieceNormals<InterpolantVoxel, false>(const PieceJob<InterpolantVoxel>&, const ShadingSetup&, const LitPlace*, uint32_t, NormalCode*, cudaStream_t);
template void launchPieces<InterpolantVoxel, true>(const PieceJob<InterpolantVoxel>&, const ShadingSetup&, const LightVolume&, cudaStream_t);
template void launchMipPieces<InterpolantVoxel, true>(const PieceJob<InterpolantVoxel>&, const MipSetup&, cudaStream_t);
template void launchIsosurfacePieces<InterpolantVoxel, true>(const PieceJob<InterpolantVoxel>&, const IsosurfaceSetup&, const ShadingSetup&, cudaStream_t);
template void launchPieceNormals<InterpolantVoxel, true>(const PieceJob<InterpolantVoxel>&, const ShadingSetup&, const LitPlace*, uint32_t, NormalCode*, cudaStream_t);
template void launchSegmentPieces<InterpolantVoxel>(const PieceJob<InterpolantVoxel>&, const SegmentLookup&, const ShadingSetup&, const LightVolume&, cudaStream_t);

}  // namespace warpscope
