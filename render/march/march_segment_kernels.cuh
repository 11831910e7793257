// Kernels of steps that are classified by the values at their ends: the loop of march.h with the source of segment_source.h, one ray a thread.
// Six kernels for each light and kind of voxel: heuristics are chosen at a sample that counts, not compiled.
#pragma once

#include "render/effects/segment_source.h"
#include "render/march/march_mode_kernels.cuh"

namespace warpscope {

template <class Voxel, bool kByCells>
void launchSegments(const MarchJob<Voxel>& job, const SegmentLookup& segments, const ShadingSetup& shading, const LightVolume& lightVolume,
                    std::optional<Heuristic> heuristic, cudaStream_t stream) {
  const dim3 grid = squareGrid(job.camera.width, job.endRow - job.firstRow);
  using Source = SegmentSource<Voxel, kByCells>;
  visitLight(shading, lightVolume, [&](auto light) {
    if (heuristic)
      visitAnyHeuristic(*heuristic, [&](auto depth) {
        if (job.isDivided)
          marchSeveralModeSamples<Source><<<grid, kTileBlockThreads, 0, stream>>>(job, segments, depth, light);
        else
          marchModeSamples<Source><<<grid, kTileBlockThreads, 0, stream>>>(job, segments, depth, light);
      });
    else
      marchModeColors<Source><<<grid, kTileBlockThreads, 0, stream>>>(job, segments, light);
    if (heuristic && job.segmentSlots > 0)
      launchWithMergers(marchModeSegments<Source, decltype(light), Voxel>, grid, stream, job.segmentSlots, job, segments, light);
  });
  if (heuristic && job.hasSpread) marchModeSpreads<Source><<<grid, kTileBlockThreads, 0, stream>>>(job, segments);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
#if WARPSCOPE_COUNTERS
  handOverDeviceCounts(stream);
#endif
}

}  // namespace warpscope
