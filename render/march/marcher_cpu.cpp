// Rays in tiles on all cores; depth by the chosen heuristic's fold; packing.
// See marcher_cpu.h.
#include "render/march/marcher_cpu.h"

#include <bit>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <mutex>
#include <optional>
#include <vector>

#include "render/base/stopwatch.h"
#include "render/core/counters.h"
#include "render/core/floating_point.h"
#include "render/core/parallel.h"
#include "render/effects/clip.h"
#include "render/effects/jitter.h"
#include "render/effects/isosurface.h"
#include "render/effects/mip_batch.h"
#include "render/effects/segment_batch_source.h"
#include "render/effects/relight.h"
#include "render/effects/shading.h"
#include "render/march/compact.h"
#include "render/march/march.h"
#include "render/march/march_setup.h"
#include "render/march/ray_samples.h"
#include "render/march/ray_trace.h"
#include "render/march/segment_encoder.h"
#include "render/march/visible_blocks.h"
#include "render/march/volume_source.h"

namespace warpscope {

namespace {

constexpr uint32_t kTileSide = 32;

/// Samples along the rays of a tile, at most, where marches take turns: some milliseconds on a core.
constexpr double kMostStepsOfTile = 1u << 22;

/// As large as they may be: small ones cost little, but something.
uint32_t tileSideFor(const Volume& volume, const RenderSettings& settings) {
  const Box& bounds = volume.bounds();
  const double stepsOfRay = glm::length(bounds.upper - bounds.lower) / settings.step + 1.0;
  return static_cast<uint32_t>(std::clamp(std::sqrt(kMostStepsOfTile / stepsOfRay), 1.0, static_cast<double>(kTileSide)));
}

/// What becomes of a finished ray: its colour, and its samples and segments where some are wanted. Behind one pointer, so
/// that the loop over rays is compiled once a voxel type, not once a use.
struct FinishedRay {
  uint32_t x = 0, y = 0;
  float cosine = 1.0f;
  glm::vec4 premultiplied{0.0f};
  const RaySamples* samples = nullptr;
  const SegmentMerger* segments = nullptr;  ///< null where none are wanted
  const NormalCode* normals = nullptr;      ///< of segments, by their places; null where none are wanted
  bool isEnded = false;                     ///< hardly any light was left
  const std::vector<CountingSample>* counting = nullptr;  ///< its samples that count, where samples are wanted and a ray has one at most; null where nothing is visible
};
using OnRay = std::function<void(const FinishedRay&)>;

/// Pixels of a picture.
struct PixelArea {
  uint32_t x = 0, y = 0, width = 0, height = 0;
};
PixelArea allOf(const Camera& camera) { return {0, 0, camera.width, camera.height}; }

using DepthFunction = DepthResult (*)(const std::vector<CountingSample>&, float threshold);

/// Depth of a finished ray or part of one. `counting` holds every sample that counted: a second pass folds over them
/// again.
template <class Depth, bool kHasSecondPass>
DepthResult depthOf(const std::vector<CountingSample>& counting, float threshold) {
  if constexpr (Depth::kTwoPass) {
    FirstPass pass;
    for (const CountingSample& sample : counting) pass.add(sample);
    auto fold = Depth::start(threshold, pass.profile);
    if (!pass.decides(fold) && kHasSecondPass) {
      WARPSCOPE_COUNT(secondPasses, 1);
      for (const CountingSample& sample : counting) fold.add(sample);
    }
    return Depth::result(fold);
  } else {
    auto fold = Depth::start(threshold, ProfileFold{});
    for (const CountingSample& sample : counting) fold.add(sample);
    return Depth::result(fold);
  }
}

/// Of the same samples, whatever depth stands for them.
float spreadOf(const std::vector<CountingSample>& counting) {
  WARPSCOPE_COUNT(spreads, 1);
  MomentsFold fold;
  for (const CountingSample& sample : counting) fold.add(sample);
  return fold.result().spread;
}

DepthFunction depthFunctionOf(Heuristic heuristic, bool hasSecondPass) {
  return visitHeuristic(heuristic, [&](auto depth) -> DepthFunction {
    using Depth = decltype(depth);
    return hasSecondPass ? depthOf<Depth, true> : depthOf<Depth, false>;
  });
}

/// What stands for samples that count, and how far they are spread about it if the plan has that.
struct DepthOfSamples {
  DepthFunction depth = nullptr;
  float threshold = 0.0f;
  bool hasSpread = false;

  DepthResult operator()(const std::vector<CountingSample>& counting) const {
    DepthResult result = depth(counting, threshold);
    if (hasSpread) result.spread = spreadOf(counting);
    return result;
  }
};

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

/// The ray's segments into its pixel's places; their number.
RaySegmentCount storeSegments(const SampleRule& rule, const FinishedRay& ray, DenseSegments& dense, size_t pixel) {
  if (ray.segments == nullptr) return {};
  const SegmentEncoder encoder(ColorTables::instance(), rule.quantization, ray.cosine, !dense.normals.empty());
  const size_t first = pixel * static_cast<size_t>(dense.slots);
  const SegmentSlots slots{dense.depths.data() + first, dense.colors.data() + first, dense.normals.empty() ? nullptr : dense.normals.data() + first};
  return storeSegments(*ray.segments, ray.isEnded, encoder, slots, [&](int i) { return ray.normals != nullptr ? ray.normals[i] : NormalCode{0}; });
}

class CpuMarcher final : public Marcher, public RayTracer {
 public:
  CpuMarcher(MarchedVolumePtr marched, TurnsPtr turns) : marched_(std::move(marched)), turns_(std::move(turns)) {}

  SampleFrame march(const Camera& camera, const MarchSettings& settings, const std::stop_token& stop) override {
    const std::scoped_lock lock(mutex_);
    requireMarchable(*marched_->volume, camera, settings);
    const SampleRule rule = sampleRuleFor(*marched_->volume, camera, settings.sample);
    SampleFrame frame = emptyFrame(*marched_->volume, camera, settings, rule);

    const auto marchStart = std::chrono::steady_clock::now();
    const auto slots = static_cast<size_t>(settings.sample.samplesPerRay);
    const size_t places = size_t{camera.width} * camera.height * slots;
    denseSamples_.resize(places);
    denseColors_.resize(places);
    denseSpreads_.resize(settings.sample.sendsSpread ? places : 0);
    const PixelGrid pixels = makePixelGrid(camera, rule.quantization.nearDepth);
    DenseSegments& segments = denseSegments_;
    segments.resize(size_t{camera.width} * camera.height, settings.sample.segments, wantsNormals(camera, settings));
    forEachRay(camera, allOf(camera), pixels, settings.render, &settings.sample, stop, [&](const FinishedRay& ray) {
      const size_t pixel = size_t{ray.y} * camera.width + ray.x;
      const int found = ray.samples != nullptr ? ray.samples->size() : 0;
      for (size_t slot = 0; slot < slots; ++slot) {
        const size_t place = pixel * slots + slot;
        denseSamples_[place] = 0;
        if (static_cast<int>(slot) >= found) continue;
        const RaySample& sample = (*ray.samples)[static_cast<int>(slot)];
        denseSamples_[place] = packRaySample(rule, pixels, ray.x, ray.y, ray.cosine, sample.depth, sample.color.a);
        denseColors_[place] = ColorTables::instance().encode(sample.color);
        if (!denseSpreads_.empty()) denseSpreads_[place] = sample.depth.spread;
      }
      if (segments.slots > 0) segments.rays[pixel] = storeSegments(rule, ray, segments, pixel);
    });
    frame.timings.marchMs = millisecondsSince(marchStart);

    const auto compactStart = std::chrono::steady_clock::now();
    compact(denseSamples_, denseColors_, denseSpreads_, slots, frame);
    if (segments.slots > 0) compact(segments, frame.segments);
    if (settings.sample.proxy > 0) frame.proxy = marched_->proxyFor(settings.sample.proxy, stop);
    frame.timings.compactMs = millisecondsSince(compactStart);
    return frame;
  }

  void render(const Camera& camera, const RenderSettings& settings, Image<glm::vec4>& image,
              const std::stop_token& stop) override {
    const std::scoped_lock lock(mutex_);
    requireMarchable(*marched_->volume, camera, settings);
    image.resize(camera.width, camera.height);
    const PixelGrid pixels = pixelsFor(*marched_->volume, camera, settings);
    forEachRay(camera, allOf(camera), pixels, settings, nullptr, stop, [&](const FinishedRay& ray) { image(ray.x, ray.y) = ray.premultiplied; });
  }

  RayTrace trace(const Camera& camera, const MarchSettings& settings, const glm::uvec2& pixel, const std::stop_token& stop) override {
    const std::scoped_lock lock(mutex_);
    requireMarchable(*marched_->volume, camera, settings);
    if (pixel.x >= camera.width || pixel.y >= camera.height) throw UsageError("the pixel is outside of the picture");
    SampleSettings sample = settings.sample;
    sample.samplesPerRay = 1;  // all that count are wanted, as one
    const SampleRule rule = sampleRuleFor(*marched_->volume, camera, sample);
    const PixelGrid pixels = makePixelGrid(camera, rule.quantization.nearDepth);
    const PixelRay through = pixels.ray(pixel.x, pixel.y);
    RayTrace trace;
    trace.ray = through.ray;
    trace.cosine = through.cosine;
    const ClipSetup clip = prepareClip(settings.render.effects.clip, *marched_->volume, camera);
    const RayInterval inside = exceptionsExpected([&] {
      return intersectBox(reciprocalOf(trace.ray.origin, trace.ray.direction), clip.bounds, 0.0f, std::numeric_limits<float>::infinity());
    });
    const RayInterval shown = clipped(clip, trace.ray, inside);
    trace.begin = shown.tNear;
    trace.end = shown.isMiss() ? shown.tNear : shown.tFar;
    trace.places = placesAlong(*marched_->volume, marched_->transferFunction, trace.ray, trace.begin, trace.end, settings.render.step);
    forEachRay(camera, {pixel.x, pixel.y, 1, 1}, pixels, settings.render, &sample, stop, [&](const FinishedRay& ray) {
      if (ray.counting != nullptr) trace.samples = *ray.counting;
      if (ray.segments != nullptr)
        for (int i = ray.segments->first(); i != SegmentMerger::kNone; i = ray.segments->behind(i)) trace.segments.push_back((*ray.segments)[i]);
      trace.isEnded = ray.isEnded;
      trace.color = ray.premultiplied;
    });
    for (const NamedValue<Heuristic>& heuristic : kHeuristics)
      trace.depths.push_back(
          {heuristic.value, trace.samples.empty() ? DepthResult{} : depthFunctionOf(heuristic.value, true)(trace.samples, settings.sample.threshold)});
    return trace;
  }

  const VolumePtr& volume() const override { return marched_->volume; }
  Backend backend() const override { return Backend::cpu; }
  MarcherCapabilities capabilities() const override { return {}; }
  std::optional<EffectPlan> plan(const RenderSettings& settings, const std::optional<SampleSettings>& sample) const override {
    requireFitting(*marched_->volume, settings);
    const std::shared_ptr<const BakedTransfer> baked = marched_->bakedFor(settings);
    return planFor(*marched_, *baked, baked->visibleCells, settings, sample);
  }
  using Marcher::twin;
  MarcherPtr twin(TurnsPtr turns) const override { return std::make_shared<CpuMarcher>(marched_, std::move(turns)); }
  MarcherPtr withTransferFunction(TransferFunction function) const override {
    return std::make_shared<CpuMarcher>(std::make_shared<const MarchedVolume>(*marched_, std::move(function)), turns_);
  }

 private:
  /// Calls `f` with whether voxels that are not finite have to be left out: std::true_type or std::false_type.
  template <class Voxel, class F>
  static void visitHoles(const EffectPlan& plan, F&& f) {
    if (std::is_floating_point_v<Voxel> && plan.has(PlanStage::missingVoxels))
      f(std::bool_constant<std::is_floating_point_v<Voxel>>{});
    else
      f(std::false_type{});
  }

  /// What there is to do; baked_ is then what it takes.
  EffectPlan bakedPlan(const RenderSettings& settings, const std::optional<SampleSettings>& sample) {
    if (!baked_ || !baked_->isFor(settings)) baked_ = marched_->bakedFor(settings);
    return planFor(*marched_, *baked_, baked_->visibleCells, settings, sample);
  }

  /// Finds samples where `sample` says how; colours alone if it is null.
  void forEachRay(const Camera& camera, const PixelArea& area, const PixelGrid& pixels, const RenderSettings& settings,
                  const SampleSettings* sample, const std::stop_token& stop, const OnRay& onRay) {
    const EffectPlan plan = bakedPlan(settings, sample != nullptr ? std::optional(*sample) : std::nullopt);
    if (!plan.has(PlanStage::march)) {
      for (uint32_t y = area.y; y < area.y + area.height; ++y)
        for (uint32_t x = area.x; x < area.x + area.width; ++x) onRay({x, y});
      return;
    }
    const std::optional<VisibleBlocks> blocks = plan.has(PlanStage::skipping) ? std::optional(visibleBlocks(camera, pixels)) : std::nullopt;
    const Volume& volume = *marched_->volume;
    visitVoxelType(volume.type(), [&](auto voxelTag) {
      using Voxel = decltype(voxelTag);
      VolumeView<Voxel> view = makeVolumeView<Voxel>(*marched_);
      view.voxels = volume.voxelsAs<Voxel>();
      view.transfer = baked_->table.lookup();
      view.transfer.isRefined = plan.has(PlanStage::refinement);
      view.cells.distances = plan.has(PlanStage::skipping) ? baked_->emptyDistances.data() : nullptr;
      if (settings.effects.mode == RenderMode::mip) {
        const MipSetup greatest = mipFor(*marched_, baked_->table, plan);
        return visitHoles<Voxel>(plan, [&]<class HasHoles>(HasHoles) {
          marchTiles<MipBatchSource<Voxel, HasHoles::value>>(ModeView<Voxel, MipSetup>{view, greatest}, Unlit{}, camera, area, pixels, settings, plan, blocks, sample,
                                                             stop, onRay);
        });
      }
      if (settings.effects.mode == RenderMode::isosurface)
        return visitLight(shadingFor(*marched_, camera, settings, plan), [&](const auto& light) {
          visitHoles<Voxel>(plan, [&]<class HasHoles>(HasHoles) {
            marchTiles<IsosurfaceSource<Voxel, HasHoles::value, false>>(ModeView<Voxel, IsosurfaceSetup>{view, baked_->surfaces}, light, camera, area, pixels,
                                                                        settings, plan, blocks, sample, stop, onRay);
          });
        });
      const LightVolume lightVolume = filledLightVolume(view, camera, settings, plan, stop);
      if (plan.has(PlanStage::segments) && baked_->hasSegments())
        return visitLight(shadingFor(*marched_, camera, settings, plan), lightVolume, [&](const auto& light) {
          const SegmentLookup segments = baked_->segments.lookup();
          marchTiles<SegmentBatchSource<Voxel>>(ModeView<Voxel, SegmentLookup>{view, segments}, light, camera, area, pixels, settings, plan, blocks, sample, stop,
                                                onRay);
        });
      visitLight(shadingFor(*marched_, camera, settings, plan), lightVolume, [&](const auto& light) {
        visitMarchArithmetic(settings.arithmetic, [&]<class March>(March) {
          visitHoles<Voxel>(plan, [&]<class HasHoles>(HasHoles) {
            marchTiles<VolumeSource<Voxel, HasHoles::value && March::kLeavesOutMissing, March>>(view, light, camera, area, pixels, settings, plan, blocks, sample,
                                                                                                stop, onRay);
          });
        });
      });
    });
  }

  /// What arrives of the lights: of the last picture, or found out anew.
  template <class Voxel>
  LightVolume filledLightVolume(const VolumeView<Voxel>& view, const Camera& camera, const RenderSettings& settings, const EffectPlan& plan,
                                const std::stop_token& stop) {
    LightVolumeJob job = lightVolumeFor(*marched_, camera, settings, plan);
    if (job.volume.channels == 0) return job.volume;
    if (std::vector<float> key = lightVolumeKey(job, settings, plan); key != lightKey_) {
      lightKey_.clear();  // what follows may be stopped
      lightValues_.resize(job.volume.places() * static_cast<size_t>(job.volume.channels));
      const size_t length = static_cast<size_t>(job.volume.dims.x);
      const auto fill = [&](size_t row) {
        visitHoles<Voxel>(plan, [&]<class HasHoles>(HasHoles) {
          for (size_t i = row * length; i < (row + 1) * length; ++i) fillPlace<VolumeSource<Voxel, HasHoles::value>>(job, view, i, lightValues_.data());
        });
      };
      TurnsOfJob turns(turns_.get());
      const auto columns = static_cast<uint32_t>(job.volume.dims.y);
      parallelForTiles(columns, static_cast<uint32_t>(job.volume.dims.z), 2, stop, turns, [&](uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) {
        for (uint32_t y = y0; y < y1; ++y)
          for (uint32_t x = x0; x < x1; ++x) fill(size_t{y} * columns + x);
      });
      lightKey_ = std::move(key);
    }
    job.volume.values = lightValues_.data();
    return job.volume;
  }

  /// What the picture's rays can see of what is visible at all.
  VisibleBlocks visibleBlocks(const Camera& camera, const PixelGrid& pixels) {
    const Volume& volume = *marched_->volume;
    if (surfaceOf_ != baked_) {
      EmptyCells cells;
      cells.distances = baked_->emptyDistances.data();
      cells.dims = marched_->macrocells.dims();
      cells.edgeBits = std::countr_zero(static_cast<uint32_t>(marched_->macrocells.edge()));
      surface_ = visibleSurface(cells, glm::ivec3(volume.dims()));
      surfaceOf_ = baked_;
    }
    return VisibleBlocks(pixels, camera.width, camera.height, surface_, volume.bounds().lower, volume.geometry().voxelEdges());
  }

  /// Whether the light of a frame of these settings changes with the eye.
  bool wantsNormals(const Camera& camera, const MarchSettings& settings) {
    if (settings.sample.segments == 0) return false;
    const EffectPlan plan = bakedPlan(settings.render, settings.sample);
    return plan.has(PlanStage::raySegments) && dependsOnEye(shadingFor(*marched_, camera, settings.render, plan));
  }

  template <class Source, class View, class Light>
  void marchTiles(const View& view, const Light& light, const Camera& camera, const PixelArea& area, const PixelGrid& pixels,
                  const RenderSettings& settings, const EffectPlan& plan, const std::optional<VisibleBlocks>& blocks,
                  const SampleSettings* sample, const std::stop_token& stop, const OnRay& onRay) const {
    const RayLimits limits = limitsOf(settings, plan);
    const Jitter jitter = plan.has(PlanStage::jitter) ? jitterFor(settings) : Jitter{};
    const ClipSetup clip = prepareClip(settings.effects.clip, *marched_->volume, camera);
    const bool isClipped = plan.has(PlanStage::clip), isDivided = plan.has(PlanStage::severalSamples);
    DepthOfSamples depthOfSamples;
    if (sample != nullptr)
      depthOfSamples = {depthFunctionOf(sample->heuristic, plan.has(PlanStage::secondPass)), sample->threshold, plan.has(PlanStage::spread)};
    const int mostSegments = sample != nullptr && plan.has(PlanStage::raySegments) ? sample->segments : 0;
    TurnsOfJob turns(turns_.get());
    const uint32_t side = turns.areLimited() ? tileSideFor(*marched_->volume, settings) : kTileSide;
    parallelForTiles(area.width, area.height, side, stop, turns, [&](uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) {
      std::vector<CountingSample> counting;
      RaySamples found;
      SegmentMerger segments(mergerRoomFor(mostSegments));
      NormalCode normals[kMostMergerRoom];
      const VisibleDepths everything{0.0f, std::numeric_limits<float>::infinity()};
      // Rows may take seconds: a tile is not waited for.
      for (uint32_t y = area.y + y0; y < area.y + y1 && !stop.stop_requested(); ++y)
        for (uint32_t x = area.x + x0; x < area.x + x1; ++x) {
          WARPSCOPE_COUNT(rays, 1);
          const VisibleDepths depths = blocks ? blocks->at(x, y) : everything;
          if (depths.isEmpty()) {
            found.clear();
            onRay({x, y});
            continue;
          }
          const PixelRay pixel = pixels.ray(x, y);
          const Ray& ray = pixel.ray;
          // Parallel to slabs, and in their planes: box.h says what comes of 1 / 0 and 0 * infinity.
          const RayInterval inside = exceptionsExpected([&] {
            return intersectBox(reciprocalOf(ray.origin, ray.direction), clip.bounds, 0.0f, std::numeric_limits<float>::infinity());
          });
          if (isClipped) WARPSCOPE_COUNT(clippedRays, 1);
          RayPath path{ray, makeLattice(isClipped ? clipped(clip, ray, inside) : inside, settings.step)};
          path.lattice.t0 += jitter.shiftOf(x, y);
          Source source = exceptionsExpected([&] { return Source(view, ray, path.lattice); });  // reciprocals again
          counting.clear();
          FinishedRay finished{x, y, pixel.cosine};
          finished.counting = &counting;
          const SampleSpan span = spanFor<Source>(depths, pixel.cosine, path.lattice);
          const auto marchInto = [&](auto&& color) {
            marchRay(path, span.begin, span.end, source, light, limits, color, [&](const CountingSample& met) {
              if (sample != nullptr) counting.push_back(met);
              return true;
            });
            finished.premultiplied = color.premultiplied();
            finished.isEnded = color.transmittance.value() < limits.stopBelow;
          };
          if constexpr (std::is_same_v<typename Source::March, StableMarch>) {
            segments.clear();
            marchInto(SegmentedColor<StableMarch>(mostSegments > 0 ? &segments : nullptr, path.lattice));
            if (mostSegments > 0) {
              WARPSCOPE_COUNT(segmentedRays, 1);
              segments.reduceTo(mostSegments);
              finished.segments = &segments;
              if constexpr (requires { light.setup.isLit; })
                if (dependsOnEye(light.setup)) {
                  for (int i = segments.first(); i != SegmentMerger::kNone; i = segments.behind(i)) {
                    float gradient[3];
                    gradientAt<Source::kLoadsCells, Source::kLeavesOutHoles>(source.view(), ray, placeToLight(segments[i]), gradient);
                    normals[i] = normalOf(light.setup, gradient);
                  }
                  finished.normals = normals;
                }
            }
          } else {
            marchInto(GatheredColor<typename Source::March>());
          }
          const glm::vec4& premultiplied = finished.premultiplied;
          found.clear();
          if (sample != nullptr && !counting.empty()) {
            if (!isDivided || counting.size() == 1)
              found.add({depthOfSamples(counting), premultiplied});
            else if constexpr (std::is_same_v<typename Source::March, StableMarch>)  // as march() makes sure
              findParts<Source>(view, light, path, limits, sample->samplesPerRay, depthOfSamples, counting, found);
          }
          finished.samples = &found;
          onRay(finished);
        }
    });
  }

  /// Marches once more, part by part. `counting` has the ray's samples that count, and is used up.
  template <class Source, class View, class Light>
  static void findParts(const View& view, const Light& light, const RayPath& path, const RayLimits& limits,
                        int samplesPerRay, const DepthOfSamples& depthOfSamples,
                        std::vector<CountingSample>& counting, RaySamples& found) {
    WARPSCOPE_COUNT(dividedRays, 1);
    const RayParts parts{counting.back().accumulatedAfter(), samplesPerRay};
    counting.clear();
    Source source(view, path.ray, path.lattice);
    marchParts<RayPiece>(
        path, source, light, limits, parts, [&](const CountingSample& sample) { counting.push_back(sample); },
        [&](const RayPiece& piece) {
          found.add({depthOfSamples(counting), piece.premultiplied()});
          counting.clear();
        });
  }

  const MarchedVolumePtr marched_;
  const TurnsPtr turns_;

  std::mutex mutex_;  // of everything below
  std::shared_ptr<const BakedTransfer> baked_;
  std::shared_ptr<const BakedTransfer> surfaceOf_;  // whose surface that is
  std::vector<Box> surface_;
  std::vector<float> lightKey_;        // of what the following are for; empty: nothing
  std::vector<uint16_t> lightValues_;
  std::vector<PackedSample> denseSamples_;
  std::vector<Rgba8> denseColors_;
  std::vector<float> denseSpreads_;  // empty where nobody wants any
  DenseSegments denseSegments_;      // likewise
};

}  // namespace

std::unique_ptr<RayTracer> makeRayTracer(VolumePtr volume, TransferFunction transferFunction) {
  return std::make_unique<CpuMarcher>(std::make_shared<MarchedVolume>(std::move(volume), std::move(transferFunction)), nullptr);
}

MarcherPtr makeCpuMarcher(VolumePtr volume, TransferFunction transferFunction) {
  return std::make_shared<CpuMarcher>(std::make_shared<MarchedVolume>(std::move(volume), std::move(transferFunction)), nullptr);
}

}  // namespace warpscope
