// One ray a thread: the loop of march.h with the sources of volume_source_pairs.h and volume_source_scalar.h, a kernel for each voxel type and heuristic.
// Warps are tiles of 8 x 4 pixels, whose rays stay together. Included by the march_kernels_*.cu alone, one for each kind of voxel.
#pragma once

#include <type_traits>

#include "render/core/color.h"
#include "render/core/counters.h"
#include "render/core/ray_sphere.h"
#include "render/cuda/pixel_tiles.cuh"
#include "render/effects/relight.h"
#include "render/march/march.h"
#include "render/march/march_launch.h"
#include "render/march/ray_samples.h"
#include "render/march/segment_encoder.h"
#include "render/march/shared_mergers.cuh"
#include "render/march/volume_source_pairs.h"

namespace warpscope {

/// The path of a pixel's ray, and its cosine.
template <class Job>
__device__ inline RayPath rayThrough(const Job& job, const PixelPlace& pixel, float* cosine = nullptr) {
  const PixelRay ofPixel = job.pixels.ray(pixel.x, pixel.y);
  if (cosine != nullptr) *cosine = ofPixel.cosine;
  RayPath path;
  path.ray = ofPixel.ray;
  const RayInterval inside = intersectBox(reciprocalOf(path.ray.origin, path.ray.direction), job.clip.bounds, 0.0f, kNoHit);
  WARPSCOPE_COUNT(rays, 1);
  if (job.isClipped) WARPSCOPE_COUNT(clippedRays, 1);
  path.lattice = makeLattice(job.isClipped ? clipped(job.clip, path.ray, inside) : inside, job.step);
  path.lattice.t0 += job.jitter.shiftOf(pixel.x, pixel.y);
  return path;
}

/// Blocks of a multiprocessor that there are registers for. Measured on an H200: fewer registers make loops wait for
/// constants, more leave too few rays to wait with. Bins that are refined take a call, and what it needs.
/// Gradients and what is made of them want more registers.
template <class Light, bool kIsRefined>
constexpr int kBlocksAtOnce = !std::is_same_v<Light, Unlit> ? 5 : kIsRefined ? 7 : 6;

/// What a kernel reads the volume through. Not where segments are merged, which take the registers that a second sample wants: that takes longer.
template <class Light, class Voxel, bool kHasHoles, bool kByCells, bool kIsRefined = true>
using SourceFor = std::conditional_t<std::is_same_v<Light, Unlit>, UnlitVolumeSource<Voxel, kHasHoles, kByCells, kIsRefined>,
                                     ScalarVolumeSource<Voxel, kHasHoles, kByCells, StableMarch, kIsRefined>>;

/// The depth of a ray's only sample; `gathered` becomes the ray's light. `makeSource()` gives a source at the path's beginning.
template <class Job, class Depth, class MakeSource, class Light, class Gathered>
__device__ inline DepthResult depthOfRay(const Job& job, const RayPath& path, const Depth& depth, const MakeSource& makeSource, const Light& light,
                                         Gathered& gathered) {
  std::conditional_t<Depth::kTwoPass, FirstPass, ProfileFold> first;
  auto fold = depth.start(job.threshold, ProfileFold{});
  auto source = makeSource();
  marchRay(path, 0, path.lattice.count, source, light, job.limits, gathered, [&](const CountingSample& sample) {
    if constexpr (Depth::kTwoPass)
      first.add(sample);
    else
      fold.add(sample);
    return true;
  });
  if constexpr (Depth::kTwoPass) {
    fold = depth.start(job.threshold, first.profile);
    if (!first.decides(fold) && job.hasSecondPass) {  // again, up to where the fold has what it wants
      WARPSCOPE_COUNT(secondPasses, 1);
      RayOpacity opacity;
      auto again = makeSource();
      marchRay(path, 0, path.lattice.count, again, light, job.limits, opacity, [&](const CountingSample& sample) {
        fold.add(sample);
        return !fold.crossed;
      });
    }
  }
  return depth.result(fold);
}

template <class Job>
__device__ inline void storeSample(const Job& job, const PixelPlace& pixel, float cosine, size_t place, const DepthResult& depth, const glm::vec4& color) {
  job.samples[place] = packRaySample(job.rule, job.pixels, pixel.x, pixel.y, cosine, depth, color.a);
  job.colors[place] = job.colorTables->encode(color);
}

/// Into the pixel's job.slots places, the first of them filled.
template <class Job>
__device__ inline void storeSamples(const Job& job, const PixelPlace& pixel, float cosine, const RaySamples& found) {
  const size_t first = (size_t{pixel.y} * job.camera.width + pixel.x) * static_cast<size_t>(job.slots);
  for (int slot = 0; slot < job.slots; ++slot) {
    job.samples[first + slot] = 0;
    if (slot < found.size()) storeSample(job, pixel, cosine, first + slot, found[slot].depth, found[slot].color);
  }
}

/// How far the depths of a ray's samples are spread, into the places of those samples, and their radii where these depend on it: a march of its own, in which nothing is lit and no depth is
/// chosen, so that no other kernel has to be compiled with and without. `makeSource()` gives a source at the path's beginning.
template <class Job, class MakeSource>
__device__ inline void storeSpreads(const Job& job, const PixelPlace& pixel, const RayPath& path, const MakeSource& makeSource) {
  size_t place = (size_t{pixel.y} * job.camera.width + pixel.x) * static_cast<size_t>(job.slots);
  MomentsFold moments;
  const auto store = [&] {
    WARPSCOPE_COUNT(spreads, 1);
    const float spread = moments.result().spread;
    if (job.spreads != nullptr) job.spreads[place] = spread;
    if (job.rule.policy == RadiusPolicy::uncertainty) job.samples[place] = withUncertainRadius(job.rule, job.pixels.edge, job.samples[place], spread);
    ++place;
    moments = {};
  };
  ProfileFold whole;
  {
    RayOpacity opacity;
    auto source = makeSource();
    marchRay(path, 0, path.lattice.count, source, Unlit{}, job.limits, opacity, [&](const CountingSample& sample) {
      whole.add(sample);
      if (job.slots == 1) moments.add(sample);
      return true;
    });
  }
  if (!whole.any) return;
  if (job.slots == 1) return store();
  auto source = makeSource();
  marchParts<PieceOpacity>(
      path, source, Unlit{}, job.limits, RayParts{whole.accumulatedEnd, job.slots}, [&](const CountingSample& sample) { moments.add(sample); },
      [&](const PieceOpacity&) { store(); });
}

/// Segments that a march has found, into the pixel's places. `source` is any of the ray's path.
template <class Job, class Merger, class Source, class Light>
__device__ inline void storeFoundSegments(const Job& job, const PixelPlace& pixel, const RayPath& path, float cosine, Merger& found, bool isEnded, const Source& source,
                                          const Light& light) {
  WARPSCOPE_COUNT(segmentedRays, 1);
  found.finish(job.segmentSlots, path.lattice);
  const size_t place = size_t{pixel.y} * job.camera.width + pixel.x, first = place * static_cast<size_t>(job.segmentSlots);
  const SegmentSlots slots{job.segments.depths + first, job.segments.colors + first, job.segments.normals != nullptr ? job.segments.normals + first : nullptr};
  const SegmentEncoder encoder(*job.colorTables, job.rule.quantization, cosine, job.segments.normals != nullptr);
  job.segmentCounts[place] = storeSegments(found, isEnded, encoder, slots, [&](int i) {
    if constexpr (requires { light.setup.isLit; }) {
      float gradient[3];
      gradientAt<Source::kLoadsCells, Source::kLeavesOutHoles>(source.view(), path.ray, placeToLight(found[i]), gradient);
      return normalOf(light.setup, gradient);
    } else {
      return NormalCode{0};
    }
  });
}

/// The ray's segments: a march of its own, in the picture's light, beside one that found the samples. `makeSource()` gives a source at the path's beginning.
template <class Job, class MakeSource, class Light>
__device__ inline void storeRaySegments(const Job& job, const PixelPlace& pixel, const RayPath& path, float cosine, const MakeSource& makeSource,
                                        const Light& light) {
  SharedSegmentMerger<> found(mergerRoomFor(job.segmentSlots));
  SegmentedColor<StableMarch, SharedSegmentMerger<>> gathered(&found, path.lattice);
  auto source = makeSource();
  marchRay(path, 0, path.lattice.count, source, light, job.limits, gathered, [](const CountingSample&) { return true; });
  storeFoundSegments(job, pixel, path, cosine, found, gathered.transmittance.value() < job.limits.stopBelow, source, light);
}

template <class Light, class Voxel, bool kHasHoles, bool kByCells>
__global__ void __launch_bounds__(kTileBlockThreads) marchRaySegments(const __grid_constant__ MarchJob<Voxel> job, const __grid_constant__ Light light) {
  const PixelPlace pixel = pixelOfSquare(job.firstRow);
  if (pixel.x >= job.camera.width || pixel.y >= job.endRow) return;
  float cosine;
  const RayPath path = rayThrough(job, pixel, &cosine);
  storeRaySegments(job, pixel, path, cosine, [&] { return ScalarVolumeSource<Voxel, kHasHoles, kByCells>(job.view, path.ray, path.lattice); }, light);
}

/// The pixel's only sample and its ray's segments, in one march. kRoom: of the mergers; 0: what the job's segments take.
template <int kRoom, class Depth, class Light, bool kIsRefined, class Voxel, bool kHasHoles, bool kByCells>
__global__ void __launch_bounds__(kTileBlockThreads)
    marchSegmentedSamples(const __grid_constant__ MarchJob<Voxel> job, const Depth depth, const __grid_constant__ Light light) {
  const PixelPlace pixel = pixelOfSquare(job.firstRow);
  if (pixel.x >= job.camera.width || pixel.y >= job.endRow) return;
  float cosine;
  const RayPath path = rayThrough(job, pixel, &cosine);
  const auto makeSource = [&] { return ScalarVolumeSource<Voxel, kHasHoles, kByCells, StableMarch, kIsRefined>(job.view, path.ray, path.lattice); };
  SharedSegmentMerger<kRoom> segments(mergerRoomFor(job.segmentSlots));
  SegmentedColor<StableMarch, SharedSegmentMerger<kRoom>> gathered(&segments, path.lattice);
  const DepthResult found = depthOfRay(job, path, depth, makeSource, light, gathered);
  storeSample(job, pixel, cosine, size_t{pixel.y} * job.camera.width + pixel.x, found, gathered.premultiplied());
  storeFoundSegments(job, pixel, path, cosine, segments, gathered.transmittance.value() < job.limits.stopBelow, makeSource(), light);
}

template <class Voxel, bool kHasHoles, bool kByCells>
__global__ void __launch_bounds__(kTileBlockThreads) marchSpreads(const __grid_constant__ MarchJob<Voxel> job) {
  const PixelPlace pixel = pixelOfSquare(job.firstRow);
  if (pixel.x >= job.camera.width || pixel.y >= job.endRow) return;
  const RayPath path = rayThrough(job, pixel);
  storeSpreads(job, pixel, path, [&] { return SourceFor<Unlit, Voxel, kHasHoles, kByCells>(job.view, path.ray, path.lattice); });
}

template <class Depth, class Light, bool kIsRefined, class Voxel, bool kHasHoles, bool kByCells>
__global__ void __launch_bounds__(kTileBlockThreads, (kBlocksAtOnce<Light, kIsRefined>))
    marchSamples(const __grid_constant__ MarchJob<Voxel> job, const Depth depth, const __grid_constant__ Light light) {
  const PixelPlace pixel = pixelOfSquare(job.firstRow);
  if (pixel.x >= job.camera.width || pixel.y >= job.endRow) return;
  float cosine;
  const RayPath path = rayThrough(job, pixel, &cosine);
  using Source = SourceFor<Light, Voxel, kHasHoles, kByCells, kIsRefined>;
  RayColor gathered;
  const DepthResult found = depthOfRay(
      job, path, depth, [&] { return Source(job.view, path.ray, path.lattice); }, light, gathered);
  storeSample(job, pixel, cosine, size_t{pixel.y} * job.camera.width + pixel.x, found, gathered.premultiplied());
}

/// As marchSamples, for several samples a ray: job.slots places for each pixel, the first of them filled, near to far.
template <class Depth, class Light, class Voxel, bool kHasHoles, bool kByCells>
__global__ void __launch_bounds__(kTileBlockThreads, (kBlocksAtOnce<Light, true>))
    marchSeveralSamples(const __grid_constant__ MarchJob<Voxel> job, const Depth depth, const __grid_constant__ Light light) {
  const PixelPlace pixel = pixelOfSquare(job.firstRow);
  if (pixel.x >= job.camera.width || pixel.y >= job.endRow) return;
  float cosine;
  const RayPath path = rayThrough(job, pixel, &cosine);
  const auto makeSource = [&] { return SourceFor<Light, Voxel, kHasHoles, kByCells>(job.view, path.ray, path.lattice); };
  WARPSCOPE_COUNT(dividedRays, 1);
  RaySamples found;
  findSamples(depth, path, makeSource, light, job.limits, job.threshold, job.slots, found);
  storeSamples(job, pixel, cosine, found);
}

template <class March, class Light, bool kIsRefined, class Voxel, bool kHasHoles, bool kByCells>
__global__ void __launch_bounds__(kTileBlockThreads, (kBlocksAtOnce<Light, kIsRefined>))
    marchColors(const __grid_constant__ MarchJob<Voxel> job, const __grid_constant__ Light light) {
  const PixelPlace pixel = pixelOfSquare(job.firstRow);
  if (pixel.x >= job.camera.width || pixel.y >= job.endRow) return;
  const RayPath path = rayThrough(job, pixel);
  GatheredColor<March> gathered;
  using Source = std::conditional_t<std::is_same_v<March, StableMarch>, SourceFor<Light, Voxel, kHasHoles, kByCells, kIsRefined>,
                                    ScalarVolumeSource<Voxel, kHasHoles, kByCells, March, kIsRefined>>;
  Source source(job.view, path.ray, path.lattice);
  marchRay(path, 0, path.lattice.count, source, light, job.limits, gathered,
           [](const CountingSample&) { return true; });
  job.image[size_t{pixel.y} * job.camera.width + pixel.x] = gathered.premultiplied();
}

#if WARPSCOPE_COUNTERS
/// Adds what this file's kernels have counted to the host's. A function of each file: the counts are.
static void handOverDeviceCounts(cudaStream_t stream) {
  unsigned long long counted[kCounters];
  static const unsigned long long kNone[kCounters] = {};
  WARPSCOPE_CUDA_CHECK(cudaMemcpyFromSymbolAsync(counted, deviceCounts, sizeof counted, 0, cudaMemcpyDeviceToHost, stream));
  WARPSCOPE_CUDA_CHECK(cudaMemcpyToSymbolAsync(deviceCounts, kNone, sizeof kNone, 0, cudaMemcpyHostToDevice, stream));
  WARPSCOPE_CUDA_CHECK(cudaStreamSynchronize(stream));
  for (size_t i = 0; i < kCounters; ++i)
    if (counted[i] != 0) HostCounts::instance().add(static_cast<Counter>(i), counted[i]);
}
#endif

/// A place a thread: those beside each other go the same way.
template <class Voxel, bool kHasHoles, bool kByCells>
__global__ void __launch_bounds__(128) fillLightVolume(const __grid_constant__ LightVolumeJob job, const __grid_constant__ VolumeView<Voxel> view, size_t first,
                                                       size_t end, uint16_t* values) {
  const size_t place = first + size_t{blockIdx.x} * blockDim.x + threadIdx.x;
  if (place < end) fillPlace<ScalarVolumeSource<Voxel, kHasHoles, kByCells>>(job, view, place, values);
}

template <class Voxel, bool kHasHoles, bool kByCells>
void launchLightVolume(const LightVolumeJob& job, const VolumeView<Voxel>& view, size_t first, size_t end, uint16_t* values, cudaStream_t stream) {
  constexpr unsigned kThreads = 128;
  fillLightVolume<Voxel, kHasHoles, kByCells><<<cuda::blocksFor(end - first, kThreads), kThreads, 0, stream>>>(job, view, first, end, values);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
#if WARPSCOPE_COUNTERS
  handOverDeviceCounts(stream);
#endif
}

/// March kernels of volumes without holes, by cells, are there for the room of usual segments and for any, the others for any.
inline constexpr int kUsualRoom = mergerRoomFor(kUsualSegments);

/// How many kernels there are for a kind of voxel: one a heuristic where nothing is lit, the rays are not divided, nobody wants their segments, empty cells are passed over and no bin is
/// refined, which is the usual march; one for the heuristics of one pass and one for those of two elsewhere. There the choice at each sample is lost beside
/// gradients, second passes, segments and voxels that are all looked at, and costs 8 % where rays are divided, 11 % where bins are refined (an H100); the compiler
/// would need twice as long without.
template <class Voxel, bool kHasHoles, bool kByCells>
void launchMarch(const MarchJob<Voxel>& job, const RenderSettings& settings, const ShadingSetup& shading, const LightVolume& lightVolume,
                 std::optional<Heuristic> heuristic, cudaStream_t stream) {
  const dim3 grid = squareGrid(job.camera.width, job.endRow - job.firstRow);
  visitLight(shading, lightVolume, [&](auto light) {
    using Light = decltype(light);
    constexpr bool kIsLit = !std::is_same_v<Light, Unlit>, kIsUsual = !kIsLit && kByCells && !kHasHoles;
    const auto visitRefined = [&](auto&& f) { kIsLit || job.view.transfer.isRefined ? f(std::true_type{}) : f(std::bool_constant<kIsLit>{}); };
    if (heuristic && job.isDivided) {
      visitAnyHeuristic(*heuristic, [&](auto depth) {
        marchSeveralSamples<decltype(depth), Light, Voxel, kHasHoles, kByCells><<<grid, kTileBlockThreads, 0, stream>>>(job, depth, light);
      });
    } else if (heuristic && job.segmentSlots > 0) {
      visitRefined([&](auto isRefined) {
        visitAnyHeuristic(*heuristic, [&](auto depth) {
          const auto launch = [&](auto room) {
            launchWithMergers(marchSegmentedSamples<decltype(room)::value, decltype(depth), Light, decltype(isRefined)::value, Voxel, kHasHoles, kByCells>, grid, stream,
                              job.segmentSlots, job, depth, light);
          };
          if constexpr (kByCells && !kHasHoles)
            if (mergerRoomFor(job.segmentSlots) == kUsualRoom) return launch(std::integral_constant<int, kUsualRoom>{});
          launch(std::integral_constant<int, 0>{});
        });
      });
    } else if (heuristic) {
      visitRefined([&](auto isRefined) {
        const auto march = [&](auto depth) {
          marchSamples<decltype(depth), Light, decltype(isRefined)::value, Voxel, kHasHoles, kByCells><<<grid, kTileBlockThreads, 0, stream>>>(job, depth, light);
        };
        if constexpr (kIsUsual && !decltype(isRefined)::value)
          visitHeuristic(*heuristic, march);
        else
          visitAnyHeuristic(*heuristic, march);
      });
    } else if (settings.arithmetic == Arithmetic::textbook) {
      marchColors<TextbookMarch, Light, false, Voxel, kHasHoles && TextbookMarch::kLeavesOutMissing, kByCells>
          <<<grid, kTileBlockThreads, 0, stream>>>(job, light);  // the table of textbooks is never refined
    } else {
      visitRefined([&](auto isRefined) {
        marchColors<StableMarch, Light, decltype(isRefined)::value, Voxel, kHasHoles, kByCells>
            <<<grid, kTileBlockThreads, 0, stream>>>(job, light);
      });
    }
  });
  if (heuristic && job.hasSpread) marchSpreads<Voxel, kHasHoles, kByCells><<<grid, kTileBlockThreads, 0, stream>>>(job);
  if (heuristic && job.segmentSlots > 0 && job.isDivided)
    visitLight(shading, lightVolume, [&](auto light) {
      launchWithMergers(marchRaySegments<decltype(light), Voxel, kHasHoles, kByCells>, grid, stream, job.segmentSlots, job, light);
    });
  WARPSCOPE_CUDA_CHECK_LAUNCH();
#if WARPSCOPE_COUNTERS
  handOverDeviceCounts(stream);
#endif
}

}  // namespace warpscope
