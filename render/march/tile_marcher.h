// The rays of a picture, tile by tile on all cores of the CPU: each marched, and what it found turned into what is sent of it.
// Whole rays, or the pieces of them that a relay brings (ray_relay.h). The loop along a ray is march.h's.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "render/base/error.h"
#include "render/base/memory_limit.h"
#include "render/core/counters.h"
#include "render/core/crew.h"
#include "render/core/floating_point.h"
#include "render/core/parallel.h"
#include "render/effects/clip.h"
#include "render/effects/gradient.h"
#include "render/effects/jitter.h"
#include "render/effects/mip_batch.h"
#include "render/effects/relight.h"
#include "render/effects/shading.h"
#include "render/march/depth_of_samples.h"
#include "render/march/frame_normals.h"
#include "render/march/march.h"
#include "render/march/march_setup.h"
#include "render/march/ray_relay.h"
#include "render/march/visible_blocks.h"
#include "render/march/waiting_rays.h"

namespace warpscope {

/// The samples that `Source` has to look at for what lies between the depths.
template <class Source>
SampleSpan spanFor(const VisibleDepths& depths, float cosine, const RayLattice& lattice) {
  if constexpr (requires { Source::kTakesWholeRays; }) return {0, lattice.count};
  const SampleSpan span = samplesBetween(depths, cosine, lattice);
  // What lies between two samples, or an end of the ray and one, may have either of them on the far side of the depths.
  if constexpr (requires { typename Source::Setup; })
    return {std::max(span.begin - 2, 0), std::min(span.end + 2, lattice.count)};
  return span;
}

/// What is asked of a picture's rays.
struct RayJob {
  const Camera& camera;
  PixelArea area;  ///< of the picture; where there is a relay, its tiles say which
  const PixelGrid& pixels;
  const RenderSettings& settings;
  const SampleSettings* sample;  ///< how samples are found; null where colours alone are wanted
  const std::stop_token& stop;
  OnRay onRay;
  RayRelay* relay = nullptr;  ///< of pieces; null: rays are marched whole
  const SampleRule* rule = nullptr;  ///< how segments are sent; null where they are wanted as they are
};

template <class Voxel>
const VolumeView<Voxel>& volumeOf(const VolumeView<Voxel>& view) {
  return view;
}
template <class Voxel, class Setup>
const VolumeView<Voxel>& volumeOf(const ModeView<Voxel, Setup>& view) {
  return view.volume;
}

/// Rays from a source of this kind. What it is made of must stay.
template <class Source, class View, class Light>
class TileMarcher {
 public:
  TileMarcher(const View& view, const Light& light, const MarchedVolume& marched, const EffectPlan& plan, const std::optional<VisibleBlocks>& blocks, const RayJob& job)
      : view_(view),
        light_(light),
        blocks_(blocks),
        job_(job),
        limits_(limitsOf(job.settings, plan)),
        clip_(prepareClip(job.settings.effects.clip, *marched.volume, job.camera)),
        isClipped_(plan.has(PlanStage::clip)),
        isDivided_(job.sample != nullptr && plan.has(PlanStage::severalSamples)) {
    if (plan.has(PlanStage::jitter)) jitter_ = jitterFor(job.settings);
    if (job.sample == nullptr) return;
    depthOfSamples_ = {depthFunctionOf(job.sample->heuristic, plan.has(PlanStage::secondPass)), job.sample->threshold, plan.has(PlanStage::spread)};
    if (plan.has(PlanStage::raySegments)) waiting_.mostSegments = job.sample->segments;
    folded_.heuristic = job.sample->heuristic;
    isFolded_ = !isDivided_ && hasOnePass(job.sample->heuristic);
    if constexpr (requires { light.setup.isLit; }) hasNormals_ = waiting_.mostSegments > 0 && dependsOnEye(light.setup);
    waiting_.rule = job.rule;
    if (hasNormals_ && job.relay == nullptr && job.rule != nullptr) waiting_.normalAt = [this](const MarchedRay& ray, float t) { return normalAt(job_.pixels.ray(ray.finished.x, ray.finished.y).ray, t); };
    waiting_.onMerged = [this](MarchedRay& ray) { ray.handed != nullptr ? finishPiece(ray) : job_.onRay(ray.finished); };
  }

  TileMarcher(const TileMarcher&) = delete;  // what waits calls this one
  TileMarcher& operator=(const TileMarcher&) = delete;

  /// All of the job's area, in tiles of at most `side` pixels. Throws as parallelForTiles() does.
  void march(uint32_t side, TurnsOfJob& turns) const {
    const PixelArea& area = job_.area;
    parallelForTiles(area.width, area.height, side, job_.stop, turns,
                     [&](uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) { marchTile({area.x + x0, area.y + y0, x1 - x0, y1 - y0}, nullptr); });
  }

  /// The relay's tiles, as they come. Throws OperationCancelled if the job's token is set.
  void marchRelayed() const {
    parallelForRanges(Crew::usualSize(), 1, [&](size_t, size_t) {
      try {
        while (std::unique_ptr<RelayedTile> tile = job_.relay->take()) {
          if (tile->segments.empty() && waiting_.mostSegments > 0) tile->segments.assign(tile->rays.size(), SegmentMerger(mergerRoomFor(waiting_.mostSegments)));
          tile->isDivided = isDivided_;
          tile->goesTwice = isDivided_ || hasNormals_;
          marchTile(tile->area, tile.get());
          job_.relay->handOn(std::move(tile));
        }
      } catch (...) {
        job_.relay->close();  // others wait for tiles
        throw;
      }
    });
    if (job_.stop.stop_requested()) throw OperationCancelled();
  }

 private:
  void marchTile(const PixelArea& tile, RelayedTile* relayed) const {
    WaitingRays rays(waiting_);
    // Rows may take seconds: a tile is not waited for.
    for (uint32_t y = tile.y; y < tile.y + tile.height && !job_.stop.stop_requested(); ++y) {
      Crew::pauseForBreaks();
      for (uint32_t x = tile.x; x < tile.x + tile.width; ++x) {
        if (relayed != nullptr && (relayed->ray(x, y).isDone || job_.stop.stop_requested())) continue;  // others wait for who is stopped
        keepWithinMemoryLimit();
        marchPixel(x, y, rays, relayed);
      }
    }
    rays.finish();
  }

  void marchPixel(uint32_t x, uint32_t y, WaitingRays& rays, RelayedTile* relayed) const {
    constexpr VisibleDepths kEverything{0.0f, std::numeric_limits<float>::infinity()};
    if (relayed == nullptr || relayed->ray(x, y).state.next == 0) WARPSCOPE_COUNT(rays, 1);
    RelayedRay* const handed = relayed != nullptr ? &relayed->ray(x, y) : nullptr;
    MarchedRay& own = rays.next();
    FinishedRay& finished = own.finished = FinishedRay{x, y};
    finished.tile = relayed;
    own.handed = handed;
    const VisibleDepths depths = blocks_ ? blocks_->at(x, y) : kEverything;
    if (depths.isEmpty()) {
      if (handed != nullptr) handed->isDone = true;
      job_.onRay(finished);
      return;
    }
    const PixelRay pixel = job_.pixels.ray(x, y);
    const Ray& ray = pixel.ray;
    // Parallel to slabs, and in their planes: box.h says what comes of 1 / 0 and 0 * infinity.
    const RayInterval inside = exceptionsExpected(
        [&] { return intersectBox(reciprocalOf(ray.origin, ray.direction), clip_.bounds, 0.0f, std::numeric_limits<float>::infinity()); });
    if (isClipped_) WARPSCOPE_COUNT(clippedRays, 1);
    RayPath path{ray, makeLattice(isClipped_ ? clipped(clip_, ray, inside) : inside, job_.settings.step)};
    path.lattice.t0 += jitter_.shiftOf(x, y);
    SampleSpan span = spanFor<Source>(depths, pixel.cosine, path.lattice);
    if (handed != nullptr) {
      const SampleSpan ofBlock = exceptionsExpected([&] { return samplesWithin(job_.relay->block(), volumeOf(view_), ray, path.lattice); });  // hardly any direction
      span = {std::max({span.begin, ofBlock.begin, handed->state.next}), std::min(span.end, ofBlock.end)};
      handed->state.next = std::max(ofBlock.end, handed->state.next);
      if (span.begin >= span.end && !relayed->isLast && !relayed->isAgain) return;
    }
    Source source = exceptionsExpected([&] { return Source(view_, ray, path.lattice); });  // reciprocals again
    finished.cosine = pixel.cosine;
    own.lattice = path.lattice;
    if constexpr (std::is_same_v<typename Source::March, StableMarch>)
      if (handed != nullptr) return relayed->isAgain ? marchAgain(path, span, source, own) : marchPiece(path, span, source, rays);
    std::vector<CountingSample>& counting = rays.counting();
    counting.clear();
    const auto sink = [&](const CountingSample& met) {
      if (job_.sample != nullptr) counting.push_back(met);
    };
    SegmentBatchMerger::Ray* segments = nullptr;
    if constexpr (std::is_same_v<typename Source::March, StableMarch>) {
      segments = rays.begin();
      SegmentedColor<StableMarch, SegmentBatchMerger::Ray> color(segments, path.lattice);
      marchSpan(path, span, source, color, sink, finished);
    } else {
      GatheredColor<typename Source::March> color;
      marchSpan(path, span, source, color, sink, finished);
    }
    if (job_.rule == nullptr) {
      own.counting = counting;
      finished.counting = &own.counting;
    }
    own.found.clear();
    if (job_.sample != nullptr && !counting.empty()) {
      if (!isDivided_ || counting.size() == 1)
        own.found.add({depthOfSamples_(counting), finished.premultiplied});
      else if constexpr (std::is_same_v<typename Source::March, StableMarch>)  // as march() makes sure
        findParts(path, counting, own.found);
    }
    finished.samples = &own.found;
    if (segments == nullptr) return job_.onRay(finished);
    segments->endGroup();
    rays.add();
  }

  template <class Color, class Sink>
  void marchSpan(const RayPath& path, const SampleSpan& span, Source& source, Color& color, const Sink& sink, FinishedRay& finished) const {
    marchRay(path, span.begin, span.end, source, light_, limits_, color, [&](const CountingSample& met) {
      sink(met);
      return true;
    });
    finished.premultiplied = color.premultiplied();
    finished.isEnded = color.transmittance.value() < limits_.stopBelow;
  }

  /// A piece of a ray that a relay has brought, behind those that are marched; what it comes to if it is the last.
  void marchPiece(const RayPath& path, const SampleSpan& span, Source& source, WaitingRays& rays) const {
    MarchedRay& own = rays.next();
    FinishedRay& finished = own.finished;
    RelayedRay& handed = *own.handed;
    RelayedTile& tile = *finished.tile;
    RelayedState& state = handed.state;
    SegmentBatchMerger::Ray* const segments = rays.beginHanded();
    SegmentedColor<StableMarch, SegmentBatchMerger::Ray> color(segments, path.lattice);
    static_cast<RayColor&>(color) = state.color;
    const auto sink = [&](const CountingSample& met) {
      if (job_.sample == nullptr) return;
      if (!isFolded_) return handed.counting.push_back(met);
      if (!std::exchange(state.hasCounted, true)) state.fold = folded_.start(depthOfSamples_.threshold, {});
      state.fold.add(met);
      if (depthOfSamples_.hasSpread) state.moments.add(met);
    };
    if constexpr (requires { Source::kTakesWholeRays; }) {
      state.greatest = source.find(span.begin, span.end, state.greatest);
      if (tile.isLast)
        passGreatest(state.greatest, source.view().transfer, limits_, color, [&](const CountingSample& met) {
          sink(met);
          return true;
        });
      finished.premultiplied = color.premultiplied();
    } else {
      marchSpan(path, span, source, color, sink, finished);
    }
    state.color = color;
    handed.isDone = finished.isEnded || tile.isLast;
    if (segments != nullptr) {
      if (handed.isDone) segments->endGroup();
      return rays.add();
    }
    if (handed.isDone && !tile.goesTwice) finishPiece(own);
  }

  /// A piece of it on the second way.
  void marchAgain(const RayPath& path, const SampleSpan& span, Source& source, MarchedRay& own) const {
    FinishedRay& finished = own.finished;
    RelayedRay& handed = *own.handed;
    RelayedTile& tile = *finished.tile;
    RelayedAgain& again = tile.again[static_cast<size_t>(&handed - tile.rays.data())];
    const auto closePart = [&](const RayPiece& piece) {
      again.found.add({depthOfSamples_(handed.counting), piece.premultiplied()});
      handed.counting.clear();
    };
    if (again.isDivided) {
      const RayParts parts{again.accumulatedEnd, job_.sample->samplesPerRay};
      if (!(again.part.piece.transmittance.value() < limits_.stopBelow))
        marchParts(path, span.begin, span.end, source, light_, limits_, parts, again.part, [&](const CountingSample& sample) { handed.counting.push_back(sample); }, closePart);
      if (tile.isLast && again.part.any) closePart(again.part.piece);
    }
    if (hasNormals_) {
      const SegmentMerger& segments = own.handedSegments();
      for (int i = segments.first(); i != SegmentMerger::kNone; i = segments.behind(i)) {
        const float t = placeToLight(segments[i]);
        if (isWithin(job_.relay->block(), source.view(), path.ray, t)) again.normals[i] = normalAt(path.ray, t);
      }
    }
    if (!tile.isLast) return;
    handed.isDone = true;
    finished.premultiplied = handed.state.color.premultiplied();
    finished.isEnded = handed.state.color.transmittance.value() < limits_.stopBelow;
    if (waiting_.mostSegments > 0) own.segments.take(own.handedSegments(), hasNormals_ ? again.normals : nullptr, finished);
    if (again.isDivided) {
      finished.samples = &again.found;
      return job_.onRay(finished);
    }
    finishPiece(own);
  }

  /// A ray that has one sample at most.
  void finishPiece(MarchedRay& own) const {
    findSampleOf(*own.handed, depthOfSamples_, folded_.heuristic, own.finished.premultiplied, own.found);
    own.finished.samples = &own.found;
    job_.onRay(own.finished);
  }

  /// What light asks of the place `t` on the ray.
  NormalCode normalAt(const Ray& ray, float t) const {
    if constexpr (requires { light_.setup.isLit; }) {
      float gradient[3];
      gradientAt<Source::kLoadsCells, Source::kLeavesOutHoles>(volumeOf(view_), ray, t, gradient);
      return normalOf(light_.setup, gradient);
    }
    return {};
  }

  /// Marches once more, part by part. `counting` has the ray's samples that count, and is used up.
  void findParts(const RayPath& path, std::vector<CountingSample>& counting, RaySamples& found) const {
    WARPSCOPE_COUNT(dividedRays, 1);
    const RayParts parts{counting.back().accumulatedAfter(), job_.sample->samplesPerRay};
    counting.clear();
    Source source(view_, path.ray, path.lattice);
    marchParts<RayPiece>(
        path, source, light_, limits_, parts, [&](const CountingSample& sample) { counting.push_back(sample); },
        [&](const RayPiece& piece) {
          found.add({depthOfSamples_(counting), piece.premultiplied()});
          counting.clear();
        });
  }

  const View& view_;
  const Light& light_;
  const std::optional<VisibleBlocks>& blocks_;
  const RayJob& job_;
  const RayLimits limits_;
  const ClipSetup clip_;
  const bool isClipped_, isDivided_;
  Jitter jitter_;
  DepthOfSamples depthOfSamples_;
  WaitingRays::Job waiting_;
  bool hasNormals_ = false;  // of segments
  bool isFolded_ = false;    // samples that count are folded as they come, where rays are relayed
  AnyDepth<false> folded_;
};

}  // namespace warpscope
