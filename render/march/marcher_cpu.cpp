// Rays in tiles on all cores; depth by the chosen heuristic's fold; packing.
// See marcher_cpu.h.
#include "render/march/marcher_cpu.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <vector>

#include "render/base/stopwatch.h"
#include "render/core/counters.h"
#include "render/core/crew.h"
#include "render/core/floating_point.h"
#include "render/core/parallel.h"
#include "render/effects/clip.h"
#include "render/effects/isosurface.h"
#include "render/effects/mip_batch.h"
#include "render/effects/relight.h"
#include "render/effects/segment_batch_source.h"
#include "render/march/march_setup.h"
#include "render/march/ray_trace.h"
#include "render/march/tile_marcher.h"
#include "render/march/volume_source.h"

namespace warpscope {

namespace {

constexpr uint32_t kTileSide = 32;

/// Samples along the rays of a tile, at most, where marches take turns: some milliseconds on a core; and where they stand back, and others wait for their pieces: less than one.
constexpr double kMostStepsOfTile = 1u << 22, kMostStepsOfShortTile = 1u << 17;

/// As large as they may be: small ones cost little, but something.
uint32_t tileSideFor(const Volume& volume, const RenderSettings& settings, const TurnsOfJob& turns) {
  const bool standsBack = Crew::ofThisThread() != nullptr;
  if (!standsBack && !turns.areLimited()) return kTileSide;
  const Box& bounds = volume.bounds();
  const double stepsOfRay = glm::length(bounds.upper - bounds.lower) / settings.step + 1.0;
  return static_cast<uint32_t>(std::clamp(std::sqrt((standsBack ? kMostStepsOfShortTile : kMostStepsOfTile) / stepsOfRay), 1.0, static_cast<double>(kTileSide)));
}

PixelArea allOf(const Camera& camera) { return {0, 0, camera.width, camera.height}; }

/// Writes the values of all places of `to` as `from` has them, in whose volume there are `perVoxel` voxels along the edges of one of the other's.
void resample(const LightVolume& from, const glm::vec3& perVoxel, const LightVolume& to, uint16_t* values, const std::stop_token& stop) {
  const auto columns = static_cast<size_t>(to.dims.x), rows = static_cast<size_t>(to.dims.y), channels = static_cast<size_t>(to.channels);
  parallelForRanges(rows * static_cast<size_t>(to.dims.z), 16, stop, [&](size_t beginRow, size_t endRow) {
    for (size_t i = beginRow * columns; i < endRow * columns; ++i) {
      const glm::vec3 index(static_cast<float>(i % columns), static_cast<float>(i / columns % rows), static_cast<float>(i / columns / rows));
      const glm::vec3 place = (index * to.edge + 0.5f) * perVoxel - 0.5f;  // voxels' centres have whole numbers
      for (size_t channel = 0; channel < channels; ++channel)
        values[i * channels + channel] = LightVolume::valueOf(from.at(static_cast<int>(channel), {place.x, place.y, place.z}));
    }
  });
}

/// visitVoxelType(), but where tests count what a march does: those have volumes of two types, which takes the compiler a quarter of the time.
template <class F>
decltype(auto) visitMarchedType(VoxelType type, F&& f) {
#if defined(WARPSCOPE_TWO_VOXEL_TYPES)
  if (type == VoxelType::uint8) return f(uint8_t{});
  if (type == VoxelType::float32) return f(float{});
  throw std::logic_error("this march knows voxels of uint8 and float32 alone");
#else
  return visitVoxelType(type, std::forward<F>(f));
#endif
}

class CpuMarcher final : public Marcher, public RayTracer, public HostPieceMarcher {
 public:
  CpuMarcher(MarchedVolumePtr marched, TurnsPtr turns) : marched_(std::move(marched)), turns_(std::move(turns)) {}

  SampleFrame march(const Camera& camera, const MarchSettings& settings, const std::stop_token& stop) override {
    const std::scoped_lock lock(mutex_);
    requireMarchable(*marched_->volume, camera, settings);
    const SampleRule rule = sampleRuleFor(*marched_->volume, camera, settings.sample);
    SampleFrame frame = emptyFrame(*marched_->volume, camera, settings, rule);

    const auto marchStart = std::chrono::steady_clock::now();
    const PixelGrid pixels = makePixelGrid(camera, rule.quantization.nearDepth);
    dense_.resize(size_t{camera.width} * camera.height, settings.sample, wantsNormals(camera, settings));
    forEachRay({camera, allOf(camera), pixels, settings.render, &settings.sample, stop,
                [&](const FinishedRay& ray) { dense_.put(size_t{ray.y} * camera.width + ray.x, ray, rule, pixels); }, nullptr, &rule});
    frame.timings.marchMs = millisecondsSince(marchStart);

    const auto compactStart = std::chrono::steady_clock::now();
    compact(dense_.samples, dense_.colors, dense_.spreads, dense_.slots, frame);
    if (dense_.segments.slots > 0) compact(dense_.segments, frame.segments);
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
    forEachRay({camera, allOf(camera), pixels, settings, nullptr, stop, [&](const FinishedRay& ray) { image(ray.x, ray.y) = ray.premultiplied; }});
  }

  void marchPieces(const Camera& camera, const RenderSettings& settings, const SampleSettings* sample, RayRelay& relay, const std::stop_token& stop) override {
    const std::scoped_lock lock(mutex_);
    const Volume& volume = *marched_->volume;
    requireMarchable(volume, camera, settings);
    if (sample != nullptr) validate(*sample);
    if (const std::string reason = whyNotInPieces(settings); !reason.empty()) throw UsageError(reason);
    const bool hasNormals = sample != nullptr && wantsNormals(camera, {settings, *sample});
    const SampleRule rule = sample != nullptr ? sampleRuleFor(volume, camera, *sample) : SampleRule{};
    const PixelGrid pixels = sample != nullptr ? makePixelGrid(camera, rule.quantization.nearDepth) : pixelsFor(volume, camera, settings);
    forEachRay({camera, allOf(camera), pixels, settings, sample, stop, [&](const FinishedRay& ray) { ray.tile->keep(ray, sample, hasNormals, rule, pixels); }, &relay, &rule});
  }

  void setLightCopy(const ProxyPtr& copy) override {
    const std::scoped_lock lock(mutex_);
    copy_ = std::make_unique<CpuMarcher>(std::make_shared<const MarchedVolume>(copy->volume, functionOfCodes(*copy)), nullptr);
    lightKey_.clear();
  }

  FoundLight findLight(const Camera& camera, const RenderSettings& settings, const std::stop_token& stop) override {
    const std::scoped_lock lock(mutex_);
    const LightVolume light = ownLight(camera, settings, stop);
    return {light, copy_ ? copy_->lightKey_ : lightKey_};
  }

  RayTrace trace(const Camera& camera, const MarchSettings& settings, const glm::uvec2& pixel, const std::stop_token& stop) override {
    const std::scoped_lock lock(mutex_);
    requireMarchable(*marched_->volume, camera, settings);
    requireWholeRays(*marched_->volume);
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
    forEachRay({camera, {pixel.x, pixel.y, 1, 1}, pixels, settings.render, &sample, stop, [&](const FinishedRay& ray) {
      if (ray.counting != nullptr) trace.samples = *ray.counting;
      if (ray.segments != nullptr)
        for (int i = ray.segments->first(); i != SegmentList::kNone; i = ray.segments->behind(i)) trace.segments.push_back((*ray.segments)[i]);
      trace.isEnded = ray.isEnded;
      trace.color = ray.premultiplied;
    }});
    for (const NamedValue<Heuristic>& heuristic : kHeuristics)
      trace.depths.push_back(
          {heuristic.value, trace.samples.empty() ? DepthResult{} : depthFunctionOf(heuristic.value, true)(trace.samples, settings.sample.threshold)});
    return trace;
  }

  const VolumePtr& volume() const override { return marched_->volume; }
  Backend backend() const override { return Backend::cpu; }
  MarcherCapabilities capabilities() const override { return {}; }
  std::optional<EffectPlan> plan(const RenderSettings& settings, const std::optional<SampleSettings>& sample) const override {
    return planFor(*marched_, settings, sample);
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
  void forEachRay(const RayJob& job) {
    const Camera& camera = job.camera;
    const RenderSettings& settings = job.settings;
    const EffectPlan plan = bakedPlan(settings, job.sample != nullptr ? std::optional(*job.sample) : std::nullopt);
    if (!plan.has(PlanStage::march)) {
      if (job.relay != nullptr) return skipRelayed(*job.relay);
      const PixelArea& area = job.area;
      for (uint32_t y = area.y; y < area.y + area.height; ++y)
        for (uint32_t x = area.x; x < area.x + area.width; ++x) job.onRay({x, y});
      return;
    }
    const std::optional<VisibleBlocks> blocks = plan.has(PlanStage::skipping) ? std::optional(visibleBlocks(camera, job.pixels)) : std::nullopt;
    const Volume& volume = *marched_->volume;
    visitMarchedType(volume.type(), [&](auto voxelTag) {
      using Voxel = decltype(voxelTag);
      const VolumeView<Voxel> view = viewFor<Voxel>(plan);
      if (settings.effects.mode == RenderMode::mip) {
        const MipSetup greatest = mipFor(*marched_, baked_->table, plan);
        return visitHoles<Voxel>(plan, [&]<class HasHoles>(HasHoles) {
          marchTiles<MipBatchSource<Voxel, HasHoles::value>>(ModeView<Voxel, MipSetup>{view, greatest}, Unlit{}, plan, blocks, job);
        });
      }
      if (settings.effects.mode == RenderMode::isosurface)
        return visitLight(shadingFor(*marched_, camera, settings, plan), [&](const auto& light) {
          visitHoles<Voxel>(plan, [&]<class HasHoles>(HasHoles) {
            marchTiles<IsosurfaceSource<Voxel, HasHoles::value, false>>(ModeView<Voxel, IsosurfaceSetup>{view, baked_->surfaces}, light, plan, blocks, job);
          });
        });
      const LightVolume lightVolume = filledLightVolume(view, camera, settings, plan, job.stop);
      if (plan.has(PlanStage::segments) && baked_->hasSegments())
        return visitLight(shadingFor(*marched_, camera, settings, plan), lightVolume, [&](const auto& light) {
          const SegmentLookup segments = baked_->segments.lookup();
          marchTiles<SegmentBatchSource<Voxel>>(ModeView<Voxel, SegmentLookup>{view, segments}, light, plan, blocks, job);
        });
      visitLight(shadingFor(*marched_, camera, settings, plan), lightVolume, [&](const auto& light) {
        visitMarchArithmetic(settings.arithmetic, [&]<class March>(March) {
          visitHoles<Voxel>(plan, [&]<class HasHoles>(HasHoles) {
            marchTiles<VolumeSource<Voxel, HasHoles::value && March::kLeavesOutMissing, March>>(view, light, plan, blocks, job);
          });
        });
      });
    });
  }

  /// Where nothing is visible at all.
  static void skipRelayed(RayRelay& relay) {
    while (std::unique_ptr<RelayedTile> tile = relay.take()) {
      for (RelayedRay& ray : tile->rays) ray.isDone = true;
      relay.handOn(std::move(tile));
    }
  }

  /// Of a volume that is not all at hand, or spread over ranks: what arrives in its coarse copy, which all of them have, at places of a grid over the volume. `channels`: at most.
  LightVolume lightOfCopy(int channels, const Camera& camera, const RenderSettings& settings, const std::stop_token& stop) {
    if (!copy_) throw std::logic_error("there is no copy of the volume to find its light in");
    const glm::uvec3 dims = marched_->volume->dims(), copied = copy_->marched_->volume->dims();
    if (dims == copied) return copy_->ownLight(camera, settings, stop);
    const glm::vec3 perVoxel = glm::vec3(copied) / glm::vec3(dims);  // voxels of the copy
    const float most = std::max({perVoxel.x, perVoxel.y, perVoxel.z});
    // Not closer together than the copy's voxels, which have no more to say, nor many more than those are.
    LightVolume own = lightVolumeLayout(dims, channels, std::max(settings.effects.shadows.gridEdge, 1.0f / most));
    constexpr size_t kMostPlaces = size_t{2} * kLightCopyEdge * kLightCopyEdge * kLightCopyEdge;
    while (own.places() > kMostPlaces) own = lightVolumeLayout(dims, channels, own.edge + 1.0f);
    // In the copy so far apart that each that is read of it is one that it has found out (isUnread()): what reads the volume's grid is at most two of its edges away.
    RenderSettings ofCopy = settings;
    ofCopy.effects.shadows.gridEdge = std::max(1.0f, 2.0f * own.edge * most - 1.0f);
    const LightVolume light = copy_->ownLight(camera, ofCopy, stop);
    if (light.channels == 0) return light;
    if (light.channels != channels) own = lightVolumeLayout(dims, light.channels, own.edge);
    std::ranges::copy(light.ofLight, own.ofLight);
    own.ofAmbient = light.ofAmbient;
    own.shadowStrength = light.shadowStrength;
    own.occlusionStrength = light.occlusionStrength;
    own.radius = light.radius;
    if (copy_->lightKey_ != lightKey_) {
      lightKey_.clear();  // what follows may be stopped
      lightValues_.resize(own.places() * static_cast<size_t>(own.channels));
      resample(light, perVoxel, own, lightValues_.data(), stop);
      lightKey_ = copy_->lightKey_;
    }
    own.values = lightValues_.data();
    return own;
  }
  LightVolume ownLight(const Camera& camera, const RenderSettings& settings, const std::stop_token& stop) {
    const EffectPlan plan = bakedPlan(settings, std::nullopt);
    return visitMarchedType(marched_->volume->type(), [&]<class Voxel>(Voxel) { return filledLightVolume(viewFor<Voxel>(plan), camera, settings, plan, stop); });
  }

  /// Of the volume, as the plan has rays look at it.
  template <class Voxel>
  VolumeView<Voxel> viewFor(const EffectPlan& plan) const {
    VolumeView<Voxel> view = makeVolumeView<Voxel>(*marched_);
    view.voxels = marched_->volume->voxelsAs<Voxel>();
    view.transfer = baked_->table.lookup();
    view.transfer.isRefined = plan.has(PlanStage::refinement);
    view.cells.distances = plan.has(PlanStage::skipping) ? baked_->emptyDistances.data() : nullptr;
    return view;
  }

  /// What arrives of the lights: of the last picture, or found out anew.
  template <class Voxel>
  LightVolume filledLightVolume(const VolumeView<Voxel>& view, const Camera& camera, const RenderSettings& settings, const EffectPlan& plan,
                                const std::stop_token& stop) {
    LightVolumeJob job = lightVolumeFor(*marched_, camera, settings, plan);
    if (job.volume.channels == 0) return job.volume;
    if (copy_ || marched_->volume->ranks()) return lightOfCopy(job.volume.channels, camera, settings, stop);
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

  /// warpscope::wantsNormals(), by the plan of a frame of these settings.
  bool wantsNormals(const Camera& camera, const MarchSettings& settings) {
    return settings.sample.segments > 0 && warpscope::wantsNormals(*marched_, camera, settings.render, bakedPlan(settings.render, settings.sample));
  }

  template <class Source, class View, class Light>
  void marchTiles(const View& view, const Light& light, const EffectPlan& plan, const std::optional<VisibleBlocks>& blocks, const RayJob& job) const {
    const TileMarcher<Source, View, Light> tiles(view, light, *marched_, plan, blocks, job);
    if (job.relay != nullptr) return tiles.marchRelayed();
    TurnsOfJob turns(turns_.get());
    tiles.march(tileSideFor(*marched_->volume, job.settings, turns), turns);
  }

  const MarchedVolumePtr marched_;
  const TurnsPtr turns_;

  std::mutex mutex_;  // of everything below
  std::shared_ptr<const BakedTransfer> baked_;
  std::shared_ptr<const BakedTransfer> surfaceOf_;  // whose surface that is
  std::vector<Box> surface_;
  std::vector<float> lightKey_;        // of what the following are for; empty: nothing
  std::vector<uint16_t> lightValues_;
  std::unique_ptr<CpuMarcher> copy_;   // where not all of the volume is at hand, once light is to be found in it
  DenseRays dense_;
};

}  // namespace

std::unique_ptr<HostPieceMarcher> makePieceMarcher(MarchedVolumePtr marched) { return std::make_unique<CpuMarcher>(std::move(marched), nullptr); }

std::unique_ptr<RayTracer> makeRayTracer(VolumePtr volume, TransferFunction transferFunction) {
  return std::make_unique<CpuMarcher>(std::make_shared<MarchedVolume>(std::move(volume), std::move(transferFunction)), nullptr);
}

MarcherPtr makeCpuMarcher(VolumePtr volume, TransferFunction transferFunction) {
  return makeCpuMarcherOf(std::make_shared<const MarchedVolume>(std::move(volume), std::move(transferFunction)), nullptr);
}
MarcherPtr makeCpuMarcherOf(MarchedVolumePtr marched, TurnsPtr turns) { return std::make_shared<CpuMarcher>(std::move(marched), std::move(turns)); }

}  // namespace warpscope
