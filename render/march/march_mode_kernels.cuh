// Kernels of the modes in which a ray is not composited: the greatest value, and surfaces. The loops are mip.h's and isosurface.h's, one ray a thread.
// Three kernels for the first and seven for the second a kind of voxel: heuristics and light are chosen at a surface, of which a ray meets few, not compiled.
#pragma once

#include "render/march/march_kernels.cuh"

namespace warpscope {

/// Lit where the setup has any strength, else as it is: surfaces are too few for the choice to matter.
struct LitIfAny : Lit {
  template <class Source>
  WARPSCOPE_HD glm::vec3 shade(const ClassifiedSample& sample, const Ray& ray, const Source& source, int k) const {
    return setup.isLit ? Lit::shade(sample, ray, source, k) : sample.color;
  }
};

/// The pixel's only sample goes to the first of its places.
template <class Source, class Depth, class Light, class Voxel>
__global__ void __launch_bounds__(kTileBlockThreads)
    marchModeSamples(const __grid_constant__ MarchJob<Voxel> job, const __grid_constant__ typename Source::Setup setup, const Depth depth,
                     const __grid_constant__ Light light) {
  const PixelPlace pixel = pixelOfSquare(job.firstRow);
  if (pixel.x >= job.camera.width || pixel.y >= job.endRow) return;
  float cosine;
  const RayPath path = rayThrough(job, pixel, &cosine);
  const ModeView<Voxel, typename Source::Setup> view{job.view, setup};
  RayColor gathered;
  const DepthResult found = depthOfRay(
      job, path, depth, [&] { return Source(view, path.ray, path.lattice); }, light, gathered);
  const size_t first = (size_t{pixel.y} * job.camera.width + pixel.x) * static_cast<size_t>(job.slots);
  storeSample(job, pixel, cosine, first, found, gathered.premultiplied());
  for (int slot = 1; slot < job.slots; ++slot) job.samples[first + slot] = 0;
}

/// As marchSeveralSamples.
template <class Source, class Depth, class Light, class Voxel>
__global__ void __launch_bounds__(kTileBlockThreads)
    marchSeveralModeSamples(const __grid_constant__ MarchJob<Voxel> job, const __grid_constant__ typename Source::Setup setup, const Depth depth,
                            const __grid_constant__ Light light) {
  const PixelPlace pixel = pixelOfSquare(job.firstRow);
  if (pixel.x >= job.camera.width || pixel.y >= job.endRow) return;
  float cosine;
  const RayPath path = rayThrough(job, pixel, &cosine);
  const ModeView<Voxel, typename Source::Setup> view{job.view, setup};
  RaySamples found;
  findSamples(
      depth, path, [&] { return Source(view, path.ray, path.lattice); }, light, job.limits, job.threshold, job.slots, found);
  storeSamples(job, pixel, cosine, found);
}

/// As marchSpreads.
template <class Source, class Voxel>
__global__ void __launch_bounds__(kTileBlockThreads)
    marchModeSpreads(const __grid_constant__ MarchJob<Voxel> job, const __grid_constant__ typename Source::Setup setup) {
  const PixelPlace pixel = pixelOfSquare(job.firstRow);
  if (pixel.x >= job.camera.width || pixel.y >= job.endRow) return;
  const RayPath path = rayThrough(job, pixel);
  const ModeView<Voxel, typename Source::Setup> view{job.view, setup};
  storeSpreads(job, pixel, path, [&] { return Source(view, path.ray, path.lattice); });
}

/// As marchRaySegments.
template <class Source, class Light, class Voxel>
__global__ void __launch_bounds__(kTileBlockThreads)
    marchModeSegments(const __grid_constant__ MarchJob<Voxel> job, const __grid_constant__ typename Source::Setup setup, const __grid_constant__ Light light) {
  const PixelPlace pixel = pixelOfSquare(job.firstRow);
  if (pixel.x >= job.camera.width || pixel.y >= job.endRow) return;
  float cosine;
  const RayPath path = rayThrough(job, pixel, &cosine);
  const ModeView<Voxel, typename Source::Setup> view{job.view, setup};
  storeRaySegments(job, pixel, path, cosine, [&] { return Source(view, path.ray, path.lattice); }, light);
}

template <class Source, class Light, class Voxel>
__global__ void __launch_bounds__(kTileBlockThreads)
    marchModeColors(const __grid_constant__ MarchJob<Voxel> job, const __grid_constant__ typename Source::Setup setup, const __grid_constant__ Light light) {
  const PixelPlace pixel = pixelOfSquare(job.firstRow);
  if (pixel.x >= job.camera.width || pixel.y >= job.endRow) return;
  const RayPath path = rayThrough(job, pixel);
  RayColor gathered;
  Source source(ModeView<Voxel, typename Source::Setup>{job.view, setup}, path.ray, path.lattice);
  marchRay(path, 0, path.lattice.count, source, light, job.limits, gathered, [](const CountingSample&) { return true; });
  job.image[size_t{pixel.y} * job.camera.width + pixel.x] = gathered.premultiplied();
}

template <class Voxel, bool kHasHoles, bool kByCells>
void launchMip(const MarchJob<Voxel>& job, const MipSetup& setup, std::optional<Heuristic> heuristic, cudaStream_t stream) {
  const dim3 grid = squareGrid(job.camera.width, job.endRow - job.firstRow);
  using Source = MipSource<Voxel, kHasHoles, kByCells>;
  if (heuristic)
    marchModeSamples<Source><<<grid, kTileBlockThreads, 0, stream>>>(job, setup, EntranceDepth{}, Unlit{});  // the first is the only one
  else
    marchModeColors<Source><<<grid, kTileBlockThreads, 0, stream>>>(job, setup, Unlit{});
  if (heuristic && job.segmentSlots > 0) launchWithMergers(marchModeSegments<Source, Unlit, Voxel>, grid, stream, job.segmentSlots, job, setup, Unlit{});
  WARPSCOPE_CUDA_CHECK_LAUNCH();
#if WARPSCOPE_COUNTERS
  handOverDeviceCounts(stream);
#endif
}

template <class Voxel, bool kHasHoles, bool kByCells>
void launchIsosurfaces(const MarchJob<Voxel>& job, const IsosurfaceSetup& setup, const ShadingSetup& shading, std::optional<Heuristic> heuristic,
                       cudaStream_t stream) {
  const dim3 grid = squareGrid(job.camera.width, job.endRow - job.firstRow);
  using Source = IsosurfaceSource<Voxel, kHasHoles, kByCells>;
  const LitIfAny light{{shading}};
  if (heuristic)
    visitAnyHeuristic(*heuristic, [&](auto depth) {
      if (job.slots > 1)
        marchSeveralModeSamples<Source><<<grid, kTileBlockThreads, 0, stream>>>(job, setup, depth, light);
      else
        marchModeSamples<Source><<<grid, kTileBlockThreads, 0, stream>>>(job, setup, depth, light);
    });
  else
    marchModeColors<Source><<<grid, kTileBlockThreads, 0, stream>>>(job, setup, light);
  if (heuristic && job.hasSpread) marchModeSpreads<Source><<<grid, kTileBlockThreads, 0, stream>>>(job, setup);
  if (heuristic && job.segmentSlots > 0) launchWithMergers(marchModeSegments<Source, LitIfAny, Voxel>, grid, stream, job.segmentSlots, job, setup, light);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
#if WARPSCOPE_COUNTERS
  handOverDeviceCounts(stream);
#endif
}

}  // namespace warpscope
