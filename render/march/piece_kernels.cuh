// One ray a thread, the part of it that lies in a block: the loop of march.h with the source of volume_source_scalar.h, which looks at no sample beyond the block, or a mode's.
// The steps are those of TileMarcher::marchPiece, so that a ray may be marched here and there.
// A kernel for each light, mode and kind of voxel: heuristics, refined bins and segments are chosen at the samples, beside which memory that holds voxels but no cells takes longer. Included by the
// piece_kernels_*.cu alone.
#pragma once

#include "render/effects/segment_source.h"
#include "render/march/march_kernels.cuh"
#include "render/march/march_mode_kernels.cuh"
#include "render/march/piece_launch.h"

namespace warpscope {

/// Of modes that want nothing besides the view.
struct NoSetup {};

template <class Source, class Voxel, class Setup>
__device__ Source sourceOf(const PieceJob<Voxel>& job, const Setup& setup, const RayPath& path) {
  if constexpr (std::is_same_v<Setup, NoSetup>)
    return Source(job.view, path.ray, path.lattice);
  else
    return Source(ModeView<Voxel, Setup>{job.view, setup}, path.ray, path.lattice);
}

/// `setup`: what Source's mode wants.
template <class Source, class Setup, class Light, class Voxel>
__global__ void __launch_bounds__(kTileBlockThreads)
    marchPieces(const __grid_constant__ PieceJob<Voxel> job, const __grid_constant__ Setup setup, const __grid_constant__ Light light) {
  constexpr bool kIsGreatest = requires { Source::kTakesWholeRays; };  // which is passed where the ray ends
  const uint32_t number = blockIdx.x * kTileBlockThreads + threadIdx.x;
  if (number >= job.count) return;
  const PieceRay ray = job.rays[number];
  RelayedState state;
  SharedSegmentMerger<> segments(job.segmentSlots > 0 ? mergerRoomFor(job.segmentSlots) : 0);  // without room it has no memory, and is not used
  if (ray.met >= 0) {
    state = job.met[ray.met];
    if (job.segmentSlots > 0) segments.take(job.metSegments[ray.met]);
  }

  const RayPath path = rayThrough(job, {ray.x, ray.y});
  const SampleSpan own = samplesWithin(job.block, job.view, path.ray, path.lattice);
  const int begin = maxOf(own.begin, state.next);
  state.next = maxOf(own.end, state.next);

  bool isDone = ray.isLast, hasListed = false;
  if (begin < own.end || (kIsGreatest && ray.isLast)) {
    auto source = sourceOf<Source>(job, setup, path);
    SegmentedColor<StableMarch, SharedSegmentMerger<>> gathered(job.segmentSlots > 0 ? &segments : nullptr, path.lattice);
    static_cast<RayColor&>(gathered) = state.color;
    const auto sink = [&](const CountingSample& met) {
      if (!job.wantsSamples) return true;
      if (job.listed != nullptr) {
        hasListed = true;
        const uint32_t place = atomicAdd(job.listedCount, 1u);
        if (place < job.listedRoom) job.listed[place] = {number, 0, met};
        return place < job.listedRoom;  // else the CPU marches it again
      }
      if (!state.hasCounted) state.fold = job.depth.start(job.threshold, ProfileFold{});
      state.hasCounted = true;
      state.fold.add(met);
      if (job.hasSpread) state.moments.add(met);
      return true;
    };
    if constexpr (kIsGreatest) {
      state.greatest = source.find(begin, own.end, state.greatest);
      if (ray.isLast) passGreatest(state.greatest, job.view.transfer, job.limits, gathered, sink);
    } else {
      marchRay(path, begin, own.end, source, light, job.limits, gathered, sink);
    }
    state.color = gathered;
    isDone = isDone || gathered.transmittance.value() < job.limits.stopBelow;
  }
  const bool hasSegments = job.segmentSlots > 0 && !segments.isEmpty();
  int left = -1;
  if (state.hasMet() || hasSegments || hasListed) {
    left = static_cast<int>(atomicAdd(job.leftCount, 1u));
    job.left[left] = state;
  }
  if (job.segmentSlots > 0 && left >= 0) {
    if (isDone) segments.finish(job.segmentSlots, path.lattice);
    SegmentMerger kept(mergerRoomFor(job.segmentSlots));
    kept.take(segments);
    job.leftSegments[left] = kept;
  }
  job.results[number] = {left, isDone};
}

/// The second way of rays that are cut into parts: the steps of TileMarcher::marchAgain.
template <class Source, class Setup, class Light, class Voxel>
__global__ void __launch_bounds__(kTileBlockThreads)
    marchParted(const __grid_constant__ PieceJob<Voxel> job, const __grid_constant__ Setup setup, const __grid_constant__ Light light) {
  const uint32_t number = blockIdx.x * kTileBlockThreads + threadIdx.x;
  const PartedRays& rays = job.parted;
  if (number >= rays.count) return;
  PartedRay ray = rays.rays[number];
  const RayPath path = rayThrough(job, {ray.x, ray.y});
  const SampleSpan own = samplesWithin(job.block, job.view, path.ray, path.lattice);
  const int begin = maxOf(own.begin, ray.next);
  ray.next = maxOf(own.end, ray.next);
  if (begin < own.end && !(ray.part.piece.transmittance.value() < job.limits.stopBelow)) {
    auto source = sourceOf<Source>(job, setup, path);
    uint32_t closed = 0;
    marchParts(
        path, begin, own.end, source, light, job.limits, RayParts{ray.accumulatedEnd, rays.mostParts}, ray.part,
        [&](const CountingSample& sample) {
          const uint32_t place = atomicAdd(rays.listedCount, 1u);
          if (place < rays.listedRoom) rays.listed[place] = {number, closed, sample};
        },
        [&](const RayPiece& piece) {
          rays.closed[atomicAdd(rays.closedCount, 1u)] = {number, piece.premultiplied()};
          ++closed;
        });
  }
  rays.rays[number] = ray;
}

template <class Voxel, bool kHasHoles>
__global__ void __launch_bounds__(kTileBlockThreads)
    findPieceNormals(const __grid_constant__ PieceJob<Voxel> job, const __grid_constant__ ShadingSetup shading, const LitPlace* places, uint32_t count, NormalCode* normals) {
  const uint32_t number = blockIdx.x * kTileBlockThreads + threadIdx.x;
  if (number >= count) return;
  const LitPlace place = places[number];
  float gradient[3];
  gradientAt<false, kHasHoles>(job.view, rayThrough(job, {place.x, place.y}).ray, place.t, gradient);
  normals[number] = normalOf(shading, gradient);
}

template <class Source, class Setup, class Light, class Voxel>
void launchFrom(const PieceJob<Voxel>& job, const Setup& setup, const Light& light, cudaStream_t stream) {
  if constexpr (!requires { Source::kTakesWholeRays; })  // else there is one sample a ray
    if (job.parted.count > 0) {
      marchParted<Source><<<cuda::blocksFor(job.parted.count, kTileBlockThreads), kTileBlockThreads, 0, stream>>>(job, setup, light);
      return WARPSCOPE_CUDA_CHECK_LAUNCH();
    }
  const unsigned blocks = cuda::blocksFor(job.count, kTileBlockThreads);
  constexpr auto kernel = marchPieces<Source, Setup, Light, Voxel>;
  if (job.segmentSlots > 0)
    launchWithMergers(kernel, blocks, stream, job.segmentSlots, job, setup, light);
  else
    kernel<<<blocks, kTileBlockThreads, 0, stream>>>(job, setup, light);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
}

template <class Voxel, bool kHasHoles>
void launchPieces(const PieceJob<Voxel>& job, const ShadingSetup& shading, const LightVolume& lightVolume, cudaStream_t stream) {
  visitLight(shading, lightVolume, [&](const auto& light) { launchFrom<ScalarVolumeSource<Voxel, kHasHoles, false>>(job, NoSetup{}, light, stream); });
}

template <class Voxel, bool kHasHoles>
void launchMipPieces(const PieceJob<Voxel>& job, const MipSetup& setup, cudaStream_t stream) {
  launchFrom<MipSource<Voxel, kHasHoles, false>>(job, setup, Unlit{}, stream);
}

template <class Voxel, bool kHasHoles>
void launchIsosurfacePieces(const PieceJob<Voxel>& job, const IsosurfaceSetup& setup, const ShadingSetup& shading, cudaStream_t stream) {
  launchFrom<IsosurfaceSource<Voxel, kHasHoles, false>>(job, setup, LitIfAny{{shading}}, stream);
}

template <class Voxel>
void launchSegmentPieces(const PieceJob<Voxel>& job, const SegmentLookup& setup, const ShadingSetup& shading, const LightVolume& lightVolume, cudaStream_t stream) {
  visitLight(shading, lightVolume, [&](const auto& light) { launchFrom<SegmentSource<Voxel, false>>(job, setup, light, stream); });
}

template <class Voxel, bool kHasHoles>
void launchPieceNormals(const PieceJob<Voxel>& job, const ShadingSetup& shading, const LitPlace* places, uint32_t count, NormalCode* normals, cudaStream_t stream) {
  findPieceNormals<Voxel, kHasHoles><<<cuda::blocksFor(count, kTileBlockThreads), kTileBlockThreads, 0, stream>>>(job, shading, places, count, normals);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
}

}  // namespace warpscope
