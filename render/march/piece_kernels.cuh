// One ray a thread, the part of it that lies in a block: the loop of march.h with the source of volume_source_scalar.h, which looks at no sample beyond the block.
// The steps are those of TileMarcher::marchPiece, so that a ray may be marched here and there.
// Two kernels a kind of voxel: heuristics, refined bins and segments are chosen at the samples, beside which memory that holds voxels but no cells takes longer. Included by the piece_kernels_*.cu alone.
#pragma once

#include "render/march/march_kernels.cuh"
#include "render/march/piece_launch.h"

namespace warpscope {

template <class Light, class Voxel, bool kHasHoles>
__global__ void __launch_bounds__(kTileBlockThreads) marchPieces(const __grid_constant__ PieceJob<Voxel> job, const __grid_constant__ Light light) {
  const uint32_t number = blockIdx.x * kTileBlockThreads + threadIdx.x;
  if (number >= job.count) return;
  const PieceRay ray = job.rays[number];
  RelayedState state;
  SharedSegmentMerger segments(job.segmentSlots > 0 ? mergerRoomFor(job.segmentSlots) : 0);  // without room it has no memory, and is not used
  if (ray.met >= 0) {
    state = job.met[ray.met];
    if (job.segmentSlots > 0) segments.take(job.metSegments[ray.met]);
  }

  const RayPath path = rayThrough(job, {ray.x, ray.y});
  const SampleSpan own = samplesWithin(job.block, job.view, path.ray, path.lattice);
  const int begin = maxOf(own.begin, state.next);
  state.next = maxOf(own.end, state.next);

  bool isDone = ray.isLast, hasListed = false;
  if (begin < own.end) {
    ScalarVolumeSource<Voxel, kHasHoles, false> source(job.view, path.ray, path.lattice);
    SegmentedColor<StableMarch, SharedSegmentMerger> gathered(job.segmentSlots > 0 ? &segments : nullptr, path.lattice);
    static_cast<RayColor&>(gathered) = state.color;
    marchRay(path, begin, own.end, source, light, job.limits, gathered, [&](const CountingSample& met) {
      if (!job.wantsSamples) return true;
      if (job.listed != nullptr) {
        hasListed = true;
        const uint32_t place = atomicAdd(job.listedCount, 1u);
        if (place < job.listedRoom) job.listed[place] = {number, met};
        return place < job.listedRoom;  // else the CPU marches it again
      }
      if (!state.hasCounted) state.fold = job.depth.start(job.threshold, ProfileFold{});
      state.hasCounted = true;
      state.fold.add(met);
      if (job.hasSpread) state.moments.add(met);
      return true;
    });
    state.color = gathered;
    isDone = isDone || gathered.transmittance.value() < job.limits.stopBelow;
  }
  const bool hasSegments = job.segmentSlots > 0 && segments.size() > 0;
  int left = -1;
  if (state.hasMet() || hasSegments || hasListed) {
    left = static_cast<int>(atomicAdd(job.leftCount, 1u));
    job.left[left] = state;
  }
  if (job.segmentSlots > 0 && left >= 0) {
    if (isDone) segments.reduceTo(job.segmentSlots);
    SegmentMerger kept(mergerRoomFor(job.segmentSlots));
    kept.take(segments);
    job.leftSegments[left] = kept;
  }
  job.results[number] = {left, isDone};
}

template <class Voxel, bool kHasHoles>
void launchPieces(const PieceJob<Voxel>& job, const ShadingSetup& shading, cudaStream_t stream) {
  const unsigned blocks = cuda::blocksFor(job.count, kTileBlockThreads);
  visitLight(shading, [&](auto light) {
    constexpr auto kernel = marchPieces<decltype(light), Voxel, kHasHoles>;
    if (job.segmentSlots > 0)
      launchWithMergers(kernel, blocks, stream, job.segmentSlots, job, light);
    else
      kernel<<<blocks, kTileBlockThreads, 0, stream>>>(job, light);
  });
  WARPSCOPE_CUDA_CHECK_LAUNCH();
}

}  // namespace warpscope
