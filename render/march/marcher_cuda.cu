// March, compact, copy: one stream, and no allocation once the buffers have their size.
// See marcher_cuda.h. Compaction: CUB's DeviceSelect (single pass, order kept; Merrill, Garland 2016, decoupled look-back).
#include "render/march/marcher_cuda.h"

#include <thrust/iterator/counting_iterator.h>
#include <thrust/iterator/transform_iterator.h>
#include <thrust/iterator/zip_iterator.h>
#include <cub/device/device_reduce.cuh>
#include <cub/device/device_select.cuh>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <mutex>
#include <optional>

#include "render/base/error.h"
#include "render/core/visible_bins.h"
#include "render/march/cuda_frame.h"
#include "render/march/device_cells.h"
#include "render/march/device_octants.h"
#include "render/march/device_probes.h"
#include "render/march/device_segments.h"
#include "render/march/device_table.h"
#include "render/march/device_volume.h"
#include "render/march/frame_normals.h"
#include "render/march/march_launch.h"
#include "render/march/march_setup.h"

namespace warpscope {
namespace {

/// Rays between looks at the stop token.
constexpr uint32_t kRaysPerLaunch = 1u << 22;
/// Samples along the rays of a launch, at most, where marches take turns: some milliseconds.
constexpr double kMostStepsOfLaunch = 1u << 28;

/// Places of a light volume between looks at the stop token.
constexpr size_t kPlacesPerLaunch = 1u << 19;

/// Of a place.
struct IsKept {
  __host__ __device__ bool operator()(PackedSample sample) const { return radiusCode(sample) != 0; }
};

struct HoldsSample {
  template <class SampleAndColor>
  __device__ bool operator()(const SampleAndColor& element) const {
    return IsKept{}(thrust::get<0>(element));
  }
};

/// How many of a ray's samples are in front of the one at a place.
struct LayerOfPlace {
  uint32_t slots;
  __host__ __device__ uint8_t operator()(uint64_t place) const { return static_cast<uint8_t>(place % slots); }
};

/// Of a cell, by its distance to what is visible.
struct IsVisible {
  __host__ __device__ uint32_t operator()(uint8_t distance) const { return distance == 0 ? 1 : 0; }
};

class CudaMarcher final : public Marcher {
 public:
  CudaMarcher(MarchedVolumePtr marched, std::shared_ptr<const DeviceVolume> deviceVolume,
              std::shared_ptr<const DeviceCells> deviceCells, std::shared_ptr<const DeviceOctants> octants, TurnsPtr turns)
      : marched_(std::move(marched)),
        deviceVolume_(std::move(deviceVolume)),
        deviceCells_(std::move(deviceCells)),
        octants_(std::move(octants)),
        turns_(std::move(turns)) {
    colorTables_.upload({&ColorTables::instance(), 1}, stream_);
    stream_.synchronize();
  }

  SampleFrame march(const Camera& camera, const MarchSettings& settings, const std::stop_token& stop) override {
    const std::scoped_lock lock(mutex_);
    Found made = marchHere(camera, settings, GoesTo::host, stop);
    copyStart_.record(stream_);
    made.found->copyTo(made.frame, stream_, copied_);
    made.frame.timings.copyMs = copied_.millisecondsSince(copyStart_);
    return std::move(made.frame);
  }

  SampleFrame marchToCode(const Camera& camera, const MarchSettings& settings, const std::stop_token& stop) override {
    const std::scoped_lock lock(mutex_);
    Found made = marchHere(camera, settings, GoesTo::coder, stop);
    if (made.found->sizes().hasLayers) made.frame.planes.push_back({std::string(kLayerPlane), PlaneElement::uint8, {}});
    if (made.found->sizes().hasSpreads) made.frame.planes.push_back({std::string(kSpreadPlane), PlaneElement::float32, {}});
    made.frame.device = std::move(made.found);
    made.frame.isAway = true;
    return std::move(made.frame);
  }

  void render(const Camera& camera, const RenderSettings& settings, Image<glm::vec4>& image, const std::stop_token& stop) override {
    const std::scoped_lock lock(mutex_);
    requireMarchable(*marched_->volume, camera, settings);
    const size_t pixels = size_t{camera.width} * camera.height;
    image_.reserve(pixels);
    image.resize(camera.width, camera.height);
    bake(settings, std::nullopt);
    if (plan_->has(PlanStage::march))
      launch(camera, settings, stop, nullptr, nullptr, nullptr);
    else
      WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(image_.data(), 0, pixels * sizeof(glm::vec4), stream_));
    WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(image.data(), image_.data(), pixels * sizeof(glm::vec4), cudaMemcpyDeviceToHost, stream_));
    stream_.synchronize();
    if (stop.stop_requested()) throw OperationCancelled();
  }

  const VolumePtr& volume() const override { return marched_->volume; }
  Backend backend() const override { return Backend::cuda; }
  MarcherCapabilities capabilities() const override {
    return {.pace = MarchPace::followsCamera, .volume = VolumePlace::here, .judging = JudgePlace::cudaDevice};
  }
  std::optional<EffectPlan> plan(const RenderSettings& settings, const std::optional<SampleSettings>& sample) const override {
    return planFor(*marched_, settings, sample);
  }
  using Marcher::twin;
  MarcherPtr twin(TurnsPtr turns) const override {
    return std::make_shared<CudaMarcher>(marched_, deviceVolume_, deviceCells_, octants_, std::move(turns));
  }
  MarcherPtr withTransferFunction(TransferFunction function) const override {
    auto marched = std::make_shared<const MarchedVolume>(*marched_, std::move(function));
    // What the device holds depends on the values' scale alone.
    if (marched->macrocells.sharesRangesWith(marched_->macrocells))
      return std::make_shared<CudaMarcher>(std::move(marched), deviceVolume_, deviceCells_, octants_, turns_);
    return makeFor(std::move(marched), turns_);
  }
  static MarcherPtr makeFor(MarchedVolumePtr marched, TurnsPtr turns) {
    auto deviceVolume = std::make_shared<const DeviceVolume>(*marched->volume, marched->scale);
    auto deviceCells = std::make_shared<const DeviceCells>(marched->macrocells);
    auto octants = std::make_shared<const DeviceOctants>(*deviceVolume, marched->scale);
    return std::make_shared<CudaMarcher>(std::move(marched), std::move(deviceVolume), std::move(deviceCells), std::move(octants), std::move(turns));
  }

 private:
  struct Found {
    std::shared_ptr<CudaFrame> found;
    SampleFrame frame;  ///< all but what was found
  };
  enum class GoesTo { host, coder };
  /// What there is then no longer changes. For a coder there are placements.
  Found marchHere(const Camera& camera, const MarchSettings& settings, GoesTo goesTo, const std::stop_token& stop) {
    requireMarchable(*marched_->volume, camera, settings);
    const SampleRule rule = sampleRuleFor(*marched_->volume, camera, settings.sample);
    Found result{std::make_shared<CudaFrame>(frames_), emptyFrame(*marched_->volume, camera, settings, rule)};
    CudaFrameBuffers& found = result.found->buffers();
    const cuda::Settled settled(stream_);
    const int slots = settings.sample.samplesPerRay;
    const size_t pixels = size_t{camera.width} * camera.height, places = pixels * static_cast<size_t>(slots);
    denseSamples_.reserve(places);
    denseColors_.reserve(places);
    found.samples.reserve(places);
    found.colors.reserve(places);
    if (slots > 1) found.layers.reserve(places);
    const bool sendsSpread = settings.sample.sendsSpread;
    if (sendsSpread) {
      denseSpreads_.reserve(places);
      found.spreads.reserve(places);
    }

    bake(settings.render, settings.sample);
    const bool hasNormals = wantsNormals(*marched_, camera, settings.render, *plan_);
    raySegments_.reserve(pixels, settings.sample.segments, hasNormals, found);
    start_.record(stream_);
    if (!plan_->has(PlanStage::march) || !plan_->has(PlanStage::raySegments)) raySegments_.clear(found, stream_);
    if (plan_->has(PlanStage::march))
      launch(camera, settings.render, stop, &settings.sample, &rule, &found);
    else
      WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(denseSamples_.data(), 0, places * sizeof(PackedSample), stream_));
    if (sendsSpread && !plan_->has(PlanStage::spread)) WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(denseSpreads_.data(), 0, places * sizeof(float), stream_));
    marchEnd_.record(stream_);
    *counts_.data() = {};
    compact(places, slots, found);
    if (sendsSpread) compactSpreads(places, found);
    raySegments_.compact(found, &counts_.data()->segments, stream_);
    compacted_.record(stream_);
    const bool hasSegments = settings.sample.segments > 0;
    if (goesTo == GoesTo::coder) probes_.ask(pathsOf(result.frame), camera.width, found, deviceCount_.data(), hasSegments ? pixels : 0, stream_);
    stream_.synchronize();
    if (stop.stop_requested()) throw OperationCancelled();

    result.found->setSizes({.samples = counts_->samples,
                            .rays = hasSegments ? pixels : 0,
                            .segments = counts_->segments,
                            .hasLayers = slots > 1 && hasLayers(found.layers, counts_->samples),
                            .hasSpreads = sendsSpread,
                            .hasNormals = hasSegments && hasNormals});
    if (goesTo == GoesTo::coder) result.found->setPlacements(probes_.placements(counts_->segments));
    if (settings.sample.proxy > 0) result.frame.proxy = marched_->proxyFor(settings.sample.proxy, stop);
    result.frame.timings.marchMs = marchEnd_.millisecondsSince(start_);
    result.frame.timings.compactMs = compacted_.millisecondsSince(marchEnd_);
    return result;
  }

  /// What the frame's rays share, with the device's noise.
  PathGrid pathsOf(const SampleFrame& frame) {
    PathGrid paths = pathGridOf(frame, Placement::steps);
    if (paths.jitter.noise != nullptr) paths.jitter.noise = noiseHere();
    return paths;
  }
  const float* noiseHere() {
    if (noise_.data() == nullptr) noise_.upload(blueNoise(), stream_);
    return noise_.data();
  }

  /// Whether any of the samples is behind another of its ray. Waits.
  bool hasLayers(const cuda::DeviceBuffer<uint8_t>& layers, size_t count) {
    if (count == 0) return false;
    cuda::withScratch(scratch_, [&](void* memory, size_t& bytes) {
      return cub::DeviceReduce::Max(memory, bytes, layers.data(), lastLayer_.data(), static_cast<int64_t>(count), stream_);
    });
    return lastLayer_.download(1, stream_).front() > 0;
  }

  /// Makes the plan, and what it takes of the transfer function.
  void bake(const RenderSettings& settings, const std::optional<SampleSettings>& sample) {
    const bool hasSurfaces = settings.effects.mode == RenderMode::isosurface;
    const std::shared_ptr<const BakedTransfer> baked = hasSurfaces ? marched_->bakedFor(settings) : marched_->tableFor(settings);
    const bool isUploaded = bakedStep_ == settings.step && bakedArithmetic_ == settings.arithmetic && bakedIsoValues_ == baked->isoValues &&
                            segments_.isEmpty() != baked->hasSegments();
    if (!isUploaded) upload(*baked, settings);
    plan_ = planFor(*marched_, *baked, visibleCells_, settings, sample);
    surfaces_ = baked->surfaces;
    if (settings.effects.mode != RenderMode::mip) return;
    greatest_ = mipFor(*marched_, baked->table, *plan_);
    if (greatest_.highest == nullptr) return;
    greatest_.highest = deviceCells_->highest();
    greatest_.lowest = deviceCells_->lowest();
  }

  void upload(const BakedTransfer& baked, const RenderSettings& settings) {
    bakedStep_ = 0.0f;
    table_.upload(baked.table, stream_);
    baked.hasSegments() ? segments_.upload(baked.segments, stream_) : segments_.clear();
    if (baked.isoValues.size() > 0)
      uploadSurfaces(baked);
    else
      findVisible(baked);
    bakedStep_ = settings.step;
    bakedArithmetic_ = settings.arithmetic;
    bakedIsoValues_ = baked.isoValues;
  }

  /// Cells that surfaces run through are few to find, and the host's plan wants them as well.
  void uploadSurfaces(const BakedTransfer& baked) {
    uploaded(emptyDistances_, baked.emptyDistances, stream_);
    stream_.synchronize();  // `baked` goes
    visibleCells_ = baked.visibleCells;
  }

  void findVisible(const BakedTransfer& baked) {
    const std::vector<int32_t> next = nextVisibleBins(baked.visible());
    TransferLookup visibleBins = table_.lookup();
    if (baked.hasSegments()) {
      visibleBins = baked.visibleSegments.lookup();
      visibleBins.alphas = uploaded(visibleAlphas_, baked.visibleSegments.alphas, stream_);
    }
    const VisibleBins bins{visibleBins, uploaded(nextVisible_, next, stream_)};
    deviceCells_->findDistances(bins, emptyDistances_, cellScratch_, stream_);
    hasOctants_ = octants_->isKnown() && octants_->hasRoomFor(octantDistances_);
    if (hasOctants_) octants_->findDistances(bins, octantDistances_, cellScratch_, stream_);
    const auto visible = thrust::make_transform_iterator(emptyDistances_.data(), IsVisible{});
    cuda::withScratch(scratch_, [&](void* memory, size_t& bytes) {
      return cub::DeviceReduce::Sum(memory, bytes, visible, deviceCount_.data(), static_cast<int64_t>(deviceCells_->count()), stream_);
    });
    WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(count_.data(), deviceCount_.data(), sizeof(uint32_t), cudaMemcpyDeviceToHost, stream_));
    stream_.synchronize();  // `baked` goes
    visibleCells_ = *count_;
  }

  /// Without `sample` and `rule` the rays' colours go to image_, with them samples to the dense buffers.
  void launch(const Camera& camera, const RenderSettings& settings, const std::stop_token& stop, const SampleSettings* sample,
              const SampleRule* rule, CudaFrameBuffers* found) {
    const std::optional<Heuristic> heuristic = sample != nullptr ? std::optional(sample->heuristic) : std::nullopt;
    visitDeviceVoxels(*deviceVolume_, [&]<class Voxel, bool kHasHoles, bool kByCells>() {
      MarchJob<Voxel> job;
      job.view = makeVolumeView<Voxel>(*marched_);
      job.view.voxels = deviceVolume_->voxelsAs<Voxel>();
      job.view.setCells(deviceVolume_->cellsAs<Voxel>());
      job.view.transfer = table_.lookup();
      job.view.transfer.isRefined = plan_->has(PlanStage::refinement);
      if (plan_->has(PlanStage::skipping)) {
        job.view.cells.distances = emptyDistances_.data();
        // Surfaces have cells of their own.
        if (hasOctants_ && settings.effects.mode != RenderMode::isosurface) job.view.octants = octants_->cells(octantDistances_);
      }
      job.clip = prepareClip(settings.effects.clip, *marched_->volume, camera);
      if (plan_->has(PlanStage::jitter)) {
        job.jitter = jitterFor(settings);
        job.jitter.noise = noiseHere();
      }
      job.camera = camera;
      job.pixels = pixelsFor(*marched_->volume, camera, settings);
      job.step = settings.step;
      job.isClipped = plan_->has(PlanStage::clip);
      job.hasSecondPass = plan_->has(PlanStage::secondPass);
      job.isDivided = plan_->has(PlanStage::severalSamples);
      job.limits = limitsOf(settings, *plan_);
      if (sample != nullptr) {
        job.threshold = sample->threshold;
        job.slots = sample->samplesPerRay;
      }
      if (rule != nullptr) job.rule = *rule;
      job.colorTables = colorTables_.data();
      job.samples = denseSamples_.data();
      job.colors = denseColors_.data();
      job.hasSpread = plan_->has(PlanStage::spread);
      job.spreads = job.hasSpread && sample != nullptr && sample->sendsSpread ? denseSpreads_.data() : nullptr;
      job.image = image_.data();
      if (sample != nullptr && plan_->has(PlanStage::raySegments)) raySegments_.giveTo(job, *found);
      const uint32_t rows = rowsOfLaunch(camera, settings);
      const ShadingSetup shading = shadingFor(*marched_, camera, settings, *plan_);
      const LightVolume lightVolume = filledLightVolume<Voxel, kHasHoles, kByCells>(job.view, camera, settings, stop);
      const auto launchRows = [&] {
        job.firstRow = job.endRow;
        job.endRow = std::min(camera.height, job.firstRow + rows);
        switch (settings.effects.mode) {
          case RenderMode::composite:
            if constexpr (!kHasHoles)
              if (plan_->has(PlanStage::segments) && !segments_.isEmpty()) {
                launchSegments<Voxel, kByCells>(job, segments_.lookup(), shading, lightVolume, heuristic, stream_);
                break;
              }
            launchMarch<Voxel, kHasHoles, kByCells>(job, settings, shading, lightVolume, heuristic, stream_);
            break;
          case RenderMode::mip:
            launchMip<Voxel, kHasHoles, kByCells>(job, greatest_, heuristic, stream_);
            break;
          case RenderMode::isosurface:
            launchIsosurfaces<Voxel, kHasHoles, kByCells>(job, surfaces_, shading, heuristic, stream_);
            break;
        }
      };
      launchAll(stop, launchRows, [&] { return static_cast<double>(job.endRow) / camera.height; });
    });
  }

  /// Calls `launchNext` until `done()` is 1: what share of the job has been launched, 0..1. In turns where there are any. Throws OperationCancelled.
  template <class LaunchNext, class Done>
  void launchAll(const std::stop_token& stop, const LaunchNext& launchNext, const Done& done) {
    const auto isDone = [&] { return !(done() < 1.0); };
    TurnsOfJob turns(turns_.get());
    if (turns.areLimited()) {
      const auto launchUntil = [&](std::chrono::steady_clock::time_point end) {
        while (!isDone() && !stop.stop_requested() && std::chrono::steady_clock::now() < end) {
          launchNext();
          stream_.synchronize();  // a turn is the device's time
        }
        return isDone();
      };
      while (!turns.work(stop, launchUntil, done)) {
      }
      return;
    }
    while (!isDone()) {
      launchNext();
      if (isDone() || !stop.stop_possible()) continue;
      stream_.synchronize();  // else every launch would be queued before the stop is seen
      if (stop.stop_requested()) throw OperationCancelled();
    }
  }

  /// What arrives of the lights: of the last picture, or found out anew.
  template <class Voxel, bool kHasHoles, bool kByCells>
  LightVolume filledLightVolume(const VolumeView<Voxel>& view, const Camera& camera, const RenderSettings& settings, const std::stop_token& stop) {
    LightVolumeJob job = lightVolumeFor(*marched_, camera, settings, *plan_);
    if (job.volume.channels == 0) return job.volume;
    if (std::vector<float> key = lightVolumeKey(job, settings, *plan_); key != lightKey_) {
      lightKey_.clear();  // what follows may be stopped
      const size_t places = job.volume.places();
      lightValues_.reserve(places * static_cast<size_t>(job.volume.channels));
      size_t done = 0;
      const auto launchSome = [&] {
        const size_t end = std::min(places, done + kPlacesPerLaunch);
        launchLightVolume<Voxel, kHasHoles, kByCells>(job, view, done, end, lightValues_.data(), stream_);
        done = end;
      };
      launchAll(stop, launchSome, [&] { return static_cast<double>(done) / static_cast<double>(places); });
      lightKey_ = std::move(key);
    }
    job.volume.values = lightValues_.data();
    return job.volume;
  }

  uint32_t rowsOfLaunch(const Camera& camera, const RenderSettings& settings) const {
    double rays = kRaysPerLaunch;
    if (turns_) {
      const Box& bounds = marched_->volume->bounds();
      rays = std::min(rays, kMostStepsOfLaunch * settings.step / glm::length(bounds.upper - bounds.lower));
    }
    return std::max(1u, static_cast<uint32_t>(rays / camera.width));
  }

  void compact(size_t places, int slots, CudaFrameBuffers& to) {
    const auto select = [&](const auto& in, const auto& out) {
      cuda::withScratch(scratch_, [&](void* memory, size_t& bytes) {
        return cub::DeviceSelect::If(memory, bytes, in, out, deviceCount_.data(), static_cast<int64_t>(places),
                                     HoldsSample{}, stream_);
      });
      WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(&counts_.data()->samples, deviceCount_.data(), sizeof(uint32_t), cudaMemcpyDeviceToHost, stream_));
    };
    if (slots == 1) {
      select(thrust::make_zip_iterator(denseSamples_.data(), denseColors_.data()),
             thrust::make_zip_iterator(to.samples.data(), to.colors.data()));
      return;
    }
    const auto layers = thrust::make_transform_iterator(thrust::make_counting_iterator(uint64_t{0}),
                                                        LayerOfPlace{static_cast<uint32_t>(slots)});
    select(thrust::make_zip_iterator(denseSamples_.data(), denseColors_.data(), layers),
           thrust::make_zip_iterator(to.samples.data(), to.colors.data(), to.layers.data()));
  }

  /// After compact(): those of the samples that were kept.
  void compactSpreads(size_t places, CudaFrameBuffers& to) {
    const auto isKept = thrust::make_transform_iterator(denseSamples_.data(), IsKept{});
    cuda::withScratch(scratch_, [&](void* memory, size_t& bytes) {
      return cub::DeviceSelect::Flagged(memory, bytes, denseSpreads_.data(), isKept, to.spreads.data(), deviceCount_.data(), static_cast<int64_t>(places),
                                        stream_);
    });
  }

  const MarchedVolumePtr marched_;
  const std::shared_ptr<const DeviceVolume> deviceVolume_;
  const std::shared_ptr<const DeviceCells> deviceCells_;      // for the plan and for modes that look at values
  const std::shared_ptr<const DeviceOctants> octants_;        // for rays that look for what shows anything
  const TurnsPtr turns_;

  std::mutex mutex_;  // of everything below
  cuda::Stream stream_;
  cuda::Event start_, marchEnd_, compacted_, copyStart_, copied_;
  cuda::DeviceBuffer<ColorTables> colorTables_;
  float bakedStep_ = 0.0f;    // that the following are for; 0: none
  Arithmetic bakedArithmetic_ = Arithmetic::stable;  // likewise
  IsoValues bakedIsoValues_;                         // likewise
  std::optional<EffectPlan> plan_;  // of what is marched
  MipSetup greatest_;               // where that is the mode: by device memory
  IsosurfaceSetup surfaces_;
  size_t visibleCells_ = 0;
  bool hasOctants_ = false;      // octantDistances_ are found
  std::vector<float> lightKey_;  // of what the following are for; empty: nothing
  cuda::DeviceBuffer<uint16_t> lightValues_;
  DeviceTable table_;
  DeviceSegmentTable segments_;
  cuda::DeviceBuffer<float> visibleAlphas_;
  cuda::DeviceBuffer<int32_t> nextVisible_;
  cuda::DeviceBuffer<uint8_t> emptyDistances_, octantDistances_, cellScratch_;
  const std::shared_ptr<CudaFramePool> frames_ = CudaFramePool::ofProcess();
  cuda::DeviceBuffer<PackedSample> denseSamples_;
  cuda::DeviceBuffer<Rgba8> denseColors_;
  cuda::DeviceBuffer<float> denseSpreads_;
  cuda::DeviceBuffer<uint8_t> lastLayer_{1};
  DeviceSegments raySegments_;
  DeviceProbes probes_;
  cuda::DeviceBuffer<glm::vec4> image_;
  cuda::DeviceBuffer<float> noise_;  // of jitter, once there is some
  cuda::DeviceBuffer<uint32_t> deviceCount_{1};
  struct Counts {
    uint32_t samples = 0, segments = 0;
  };
  cuda::PinnedValue<Counts> counts_;  // of what the last march found
  cuda::PinnedValue<uint32_t> count_;
  cuda::Scratch scratch_;
};

}  // namespace

MarcherPtr makeCudaMarcher(VolumePtr volume, TransferFunction transferFunction) {
  return CudaMarcher::makeFor(std::make_shared<const MarchedVolume>(std::move(volume), std::move(transferFunction)),
                              nullptr);
}

}  // namespace warpscope
