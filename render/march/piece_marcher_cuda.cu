// Tiles as batches: what their rays have met goes to the device, what they have met then comes back.
// See piece_marcher_cuda.h. Several threads, each with a stream of its own: while one's rays are marched others pack and unpack theirs.
#include "render/march/piece_marcher_cuda.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <memory_resource>
#include <mutex>
#include <optional>
#include <span>
#include <thread>
#include <vector>

#include "render/base/error.h"
#include "render/cuda/pinned_memory.h"
#include "render/march/depth_of_samples.h"
#include "render/march/device_table.h"
#include "render/march/device_volume.h"
#include "render/march/frame_normals.h"
#include "render/march/march_setup.h"
#include "render/march/marcher_cuda.h"
#include "render/march/piece_launch.h"
#include "render/march/relay_share.h"
#include "render/march/streamed_marcher.h"

namespace warpscope {
namespace {

/// Tiles whose rays are marched by one launch, at most.
constexpr size_t kMostTiles = 16;
/// Rays that are packed side by side are those of such a block of pixels, as far as they are still under way: they go the same way.
constexpr uint32_t kBlockWidth = 8, kBlockHeight = 4;
constexpr unsigned kMostWorkers = 8;
/// Samples that count, of the rays of a launch, where a heuristic wants them listed: of more the CPU marches the tiles. 24 MiB of each thread's.
constexpr uint32_t kListedRoom = 1u << 20;

/// What a picture's rays have in common.
struct PieceFrame {
  const Camera& camera;
  const RenderSettings& settings;
  const SampleSettings* sample;
  RayRelay& relay;
  EffectPlan plan;
  SampleRule rule;
  PixelGrid pixels;
  RayLimits limits;
  DepthOfSamples depthOfSamples;
  ShadingSetup shading;
  bool hasNormals = false;
  bool listsSamples = false;  ///< that count; else they are folded
  int mostSegments = 0;
};

using Tiles = std::vector<std::unique_ptr<RelayedTile>>;

/// A thread's memory, here and on the device.
class PieceWorker {
 public:
  /// Marches the tiles' rays; they are as they were if it throws, or if it is false: then more samples count than there is room for. `launch(rays, stream)` starts the kernel.
  template <class Launch>
  bool march(const PieceFrame& frame, Tiles& tiles, const Launch& launch) {
    pack(frame, tiles);
    if (rays_.empty()) return true;
    PieceRays job;
    job.count = static_cast<uint32_t>(rays_.size());
    deviceRays_.upload(rays_, stream_);
    deviceMet_.upload(met_, stream_);
    deviceResults_.reserve(rays_.size());
    deviceLeft_.reserve(rays_.size());
    WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(leftCount_.data(), 0, sizeof(uint32_t), stream_));
    job.rays = deviceRays_.data();
    job.met = deviceMet_.data();
    job.results = deviceResults_.data();
    job.left = deviceLeft_.data();
    job.leftCount = leftCount_.data();
    const bool hasSegments = frame.mostSegments > 0;
    if (hasSegments) {
      deviceMetSegments_.upload(metSegments_, stream_);
      deviceLeftSegments_.reserve(rays_.size());
      job.metSegments = deviceMetSegments_.data();
      job.leftSegments = deviceLeftSegments_.data();
    }
    if (frame.listsSamples) {
      deviceListed_.reserve(kListedRoom);
      WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(listedCount_.data(), 0, sizeof(uint32_t), stream_));
      job.listed = deviceListed_.data();
      job.listedRoom = kListedRoom;
      job.listedCount = listedCount_.data();
    }
    launch(job, stream_);
    fetch(deviceResults_, results_, rays_.size(), PieceResult{});
    WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(hostCount_.data(), leftCount_.data(), sizeof(uint32_t), cudaMemcpyDeviceToHost, stream_));
    if (frame.listsSamples) WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(hostListedCount_.data(), listedCount_.data(), sizeof(uint32_t), cudaMemcpyDeviceToHost, stream_));
    stream_.synchronize();
    const size_t listed = frame.listsSamples ? *hostListedCount_ : 0;
    if (listed > kListedRoom) return false;
    fetch(deviceListed_, listed_, listed, ListedSample{});
    fetch(deviceLeft_, left_, *hostCount_, RelayedState{});
    if (hasSegments) fetch(deviceLeftSegments_, leftSegments_, *hostCount_, SegmentMerger(mergerRoomFor(frame.mostSegments)));
    stream_.synchronize();
    for (const auto& [ray, sample] : std::span(listed_).first(listed)) places_[ray].tile->rays[places_[ray].ray].counting.push_back(sample);
    unpack(frame);
    return true;
  }

 private:
  struct Place {
    RelayedTile* tile;
    uint32_t ray;
  };

  /// The first `count` of them, once the stream has got there. `none`: what takes the place of others.
  template <class T>
  void fetch(const cuda::DeviceBuffer<T>& from, std::pmr::vector<T>& to, size_t count, const T& none) {
    if (to.size() < count) to.resize(count, none);
    if (count > 0) WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(to.data(), from.data(), count * sizeof(T), cudaMemcpyDeviceToHost, stream_));
  }

  void pack(const PieceFrame& frame, Tiles& tiles) {
    rays_.clear(), met_.clear(), metSegments_.clear(), places_.clear();
    for (const std::unique_ptr<RelayedTile>& tile : tiles) {
      if (tile->segments.empty() && frame.mostSegments > 0) tile->segments.assign(tile->rays.size(), SegmentMerger(mergerRoomFor(frame.mostSegments)));
      tile->goesTwice = frame.hasNormals;
      const PixelArea& area = tile->area;
      for (uint32_t row = 0; row < area.height; row += kBlockHeight)
        for (uint32_t column = 0; column < area.width; column += kBlockWidth)
          for (uint32_t y = row; y < std::min(row + kBlockHeight, area.height); ++y)
            for (uint32_t x = column; x < std::min(column + kBlockWidth, area.width); ++x) packRay(*tile, y * area.width + x, {area.x + x, area.y + y, -1, tile->isLast});
    }
  }
  void packRay(RelayedTile& tile, uint32_t place, PieceRay ray) {
    const RelayedRay& handed = tile.rays[place];
    if (handed.isDone) return;
    if (handed.state.hasMet()) {
      ray.met = static_cast<int32_t>(met_.size());
      met_.push_back(handed.state);
      if (!tile.segments.empty()) metSegments_.push_back(tile.segments[place]);
    }
    rays_.push_back(ray);
    places_.push_back({&tile, place});
  }

  void unpack(const PieceFrame& frame) {
    for (size_t i = 0; i < rays_.size(); ++i) {
      const auto& [tile, place] = places_[i];
      const PieceResult& result = results_[i];
      RelayedRay& handed = tile->rays[place];
      handed.isDone = result.isDone;
      if (result.met < 0) continue;
      handed.state = left_[static_cast<size_t>(result.met)];
      if (frame.mostSegments > 0) tile->segments[place].take(leftSegments_[static_cast<size_t>(result.met)]);
      if (handed.isDone && !tile->goesTwice) finish(frame, rays_[i], handed, *tile, place);
    }
  }
  void finish(const PieceFrame& frame, const PieceRay& ray, const RelayedRay& handed, RelayedTile& tile, uint32_t place) {
    FinishedRay finished{ray.x, ray.y};
    finished.tile = &tile;
    finished.cosine = frame.pixels.ray(ray.x, ray.y).cosine;
    finished.premultiplied = handed.state.color.premultiplied();
    finished.isEnded = handed.state.color.transmittance.value() < frame.limits.stopBelow;
    if (frame.mostSegments > 0) finished.segments = &tile.segments[place];
    if (frame.sample != nullptr) findSampleOf(handed, frame.depthOfSamples, frame.sample->heuristic, finished.premultiplied, found_);
    finished.samples = &found_;
    tile.keep(finished, frame.sample, frame.hasNormals, frame.rule, frame.pixels);
  }

  cuda::Stream stream_;
  std::pmr::vector<PieceRay> rays_{cuda::pinnedMemory()};
  std::pmr::vector<RelayedState> met_{cuda::pinnedMemory()};
  std::pmr::vector<SegmentMerger> metSegments_{cuda::pinnedMemory()};
  std::pmr::vector<PieceResult> results_{cuda::pinnedMemory()};
  std::pmr::vector<RelayedState> left_{cuda::pinnedMemory()};
  std::pmr::vector<SegmentMerger> leftSegments_{cuda::pinnedMemory()};
  std::pmr::vector<ListedSample> listed_{cuda::pinnedMemory()};
  std::vector<Place> places_;  // of each ray
  RaySamples found_;
  cuda::DeviceBuffer<PieceRay> deviceRays_;
  cuda::DeviceBuffer<RelayedState> deviceMet_, deviceLeft_;
  cuda::DeviceBuffer<SegmentMerger> deviceMetSegments_, deviceLeftSegments_;
  cuda::DeviceBuffer<PieceResult> deviceResults_;
  cuda::DeviceBuffer<ListedSample> deviceListed_;
  cuda::DeviceBuffer<uint32_t> leftCount_{1}, listedCount_{1};
  cuda::PinnedValue<uint32_t> hostCount_, hostListedCount_;
};

/// What marchers of all functions share: one of them marches at a time.
class PieceDevice {
 public:
  PieceDevice(bool mayFallBack, std::function<void(const std::string&)> onFallback) : mayFallBack_(mayFallBack), onFallback_(std::move(onFallback)) {}

  bool hasFailed() const { return hasFailed_; }
  /// Of whoever catches `error`. Rethrows it where that is not for the CPU to make up for.
  void leave(const DeviceError& error) {
    if (!mayFallBack_) throw;
    if (!hasFailed_.exchange(true) && onFallback_) onFallback_(error.what());
  }

  /// Of who marches, as all that follows is.
  std::mutex mutex;

  /// The volume's, by the values' scale. Throws DeviceError.
  DeviceBrick& brickOf(const MarchedVolumePtr& marched) {
    if (brick_ && brickOf_->volume == marched->volume && brickOf_->macrocells.sharesRangesWith(marched->macrocells)) return *brick_;
    brick_.reset();
    brick_.emplace(marched->volume, marched->scale);
    brickOf_ = marched;
    return *brick_;
  }
  const float* noise() {
    if (noise_.data() == nullptr) {
      noise_.upload(blueNoise(), stream_);
      stream_.synchronize();
    }
    return noise_.data();
  }
  cudaStream_t stream() const { return stream_; }
  std::span<const std::unique_ptr<PieceWorker>> workers() {
    const unsigned count = std::clamp(std::thread::hardware_concurrency(), 2u, kMostWorkers);
    while (workers_.size() < count) workers_.push_back(std::make_unique<PieceWorker>());
    return workers_;
  }

 private:
  const bool mayFallBack_;
  const std::function<void(const std::string&)> onFallback_;
  std::atomic<bool> hasFailed_ = false;
  cuda::Stream stream_;
  MarchedVolumePtr brickOf_;
  std::optional<DeviceBrick> brick_;
  cuda::DeviceBuffer<float> noise_;
  std::vector<std::unique_ptr<PieceWorker>> workers_;
};

class CudaPieceMarcher final : public PieceMarcher {
 public:
  /// Asks nothing of the device, which may have failed.
  CudaPieceMarcher(MarchedVolumePtr marched, std::shared_ptr<PieceDevice> device)
      : marched_(std::move(marched)), onHost_(makePieceMarcher(marched_)), device_(std::move(device)) {}

  void setLightCopy(const ProxyPtr& copy) override { onHost_->setLightCopy(copy); }

  void marchPieces(const Camera& camera, const RenderSettings& settings, const SampleSettings* sample, RayRelay& relay, const std::stop_token& stop) override {
    const std::scoped_lock lock(device_->mutex);
    const Volume& volume = *marched_->volume;
    requireMarchable(volume, camera, settings);
    if (sample != nullptr) validate(*sample);
    if (const std::string reason = whyNotInPieces(settings); !reason.empty()) throw UsageError(reason);
    const std::shared_ptr<const BakedTransfer> baked = marched_->bakedFor(settings);
    const EffectPlan plan = planFor(*marched_, *baked, baked->visibleCells, settings, sample != nullptr ? std::optional(*sample) : std::nullopt);
    const auto onHost = [&] { onHost_->marchPieces(camera, settings, sample, relay, stop); };
    if (device_->hasFailed() || !isForDevice(settings, plan, *baked)) return onHost();
    try {
      prepare(relay.block(), settings, baked, stop);
    } catch (const DeviceError& error) {
      device_->leave(error);
      return onHost();
    }
    PieceFrame frame{camera, settings, sample, relay, plan, {}, pixelsFor(volume, camera, settings), limitsOf(settings, plan), {}, shadingFor(*marched_, camera, settings, plan)};
    if (sample != nullptr) {
      frame.rule = sampleRuleFor(volume, camera, *sample);
      frame.depthOfSamples = {depthFunctionOf(sample->heuristic, plan.has(PlanStage::secondPass)), sample->threshold, plan.has(PlanStage::spread)};
      if (plan.has(PlanStage::raySegments)) frame.mostSegments = sample->segments;
      frame.listsSamples = !hasOnePass(sample->heuristic);
      frame.hasNormals = wantsNormals(*marched_, camera, settings, plan);
    }
    visitKeptVoxels(volume.type(), volume.statistics().nonFinite > 0, [&]<class Voxel, bool kHasHoles>() {
      const PieceJob<Voxel> job = jobFor<Voxel>(frame);
      marchAll(frame, stop, [&](const PieceRays& rays, cudaStream_t stream) {
        PieceJob<Voxel> own = job;
        static_cast<PieceRays&>(own) = rays;
        launchPieces<Voxel, kHasHoles>(own, frame.shading, stream);
      });
    });
    if (stop.stop_requested()) throw OperationCancelled();
  }

 private:
  static bool isForDevice(const RenderSettings& settings, const EffectPlan& plan, const BakedTransfer& baked) {
    return plan.has(PlanStage::march) && settings.effects.mode == RenderMode::composite && !plan.has(PlanStage::lightVolume) &&
           !(plan.has(PlanStage::segments) && baked.hasSegments()) && !plan.has(PlanStage::severalSamples);
  }

  /// What the device has to have. Throws DeviceError, OperationCancelled.
  void prepare(const CellBlock& block, const RenderSettings& settings, const std::shared_ptr<const BakedTransfer>& baked, const std::stop_token& stop) {
    brick_ = &device_->brickOf(marched_);
    brick_->provide(rowsOf(block, settings, marched_->volume->geometry()), stop);
    noise_ = device_->noise();
    workers_ = device_->workers();
    if (baked == baked_) return;
    table_.upload(baked->table, device_->stream());
    emptyDistances_.upload(baked->emptyDistances, device_->stream());
    WARPSCOPE_CUDA_CHECK(cudaStreamSynchronize(device_->stream()));
    baked_ = baked;
  }

  template <class Voxel>
  PieceJob<Voxel> jobFor(const PieceFrame& frame) const {
    PieceJob<Voxel> job;
    job.view = makeVolumeView<Voxel>(*marched_);
    job.view.voxels = brick_->voxelsAs<Voxel>();
    job.view.transfer = table_.lookup();
    job.view.transfer.isRefined = frame.plan.has(PlanStage::refinement);
    if (frame.plan.has(PlanStage::skipping)) job.view.cells.distances = emptyDistances_.data();
    job.clip = prepareClip(frame.settings.effects.clip, *marched_->volume, frame.camera);
    if (frame.plan.has(PlanStage::jitter)) {
      job.jitter = jitterFor(frame.settings);
      job.jitter.noise = noise_;
    }
    job.pixels = frame.pixels;
    job.block = frame.relay.block();
    job.step = frame.settings.step;
    job.limits = frame.limits;
    job.isClipped = frame.plan.has(PlanStage::clip);
    if (frame.sample == nullptr) return job;
    job.wantsSamples = true;
    job.hasSpread = frame.plan.has(PlanStage::spread);
    job.depth.heuristic = frame.sample->heuristic;
    job.threshold = frame.sample->threshold;
    job.segmentSlots = frame.mostSegments;
    return job;
  }

  /// The relay's tiles, here and on the host.
  template <class Launch>
  void marchAll(const PieceFrame& frame, const std::stop_token& stop, const Launch& launch) {
    RelayShare share(frame.relay);
    std::jthread host;
    std::once_flag hostStarted;
    std::mutex troubleMutex;
    std::exception_ptr trouble;
    const auto guarded = [&](const auto& work) {
      try {
        work();
      } catch (...) {
        frame.relay.close();  // others wait for tiles
        const std::scoped_lock lock(troubleMutex);
        if (!trouble) trouble = std::current_exception();
      }
    };
    const auto giveToHost = [&](std::unique_ptr<RelayedTile> tile) {
      std::call_once(hostStarted, [&] { host = std::jthread([&] { guarded([&] { onHost_->marchPieces(frame.camera, frame.settings, frame.sample, share, stop); }); }); });
      share.give(std::move(tile));
    };
    const auto work = [&](PieceWorker& worker) {
      while (std::unique_ptr<RelayedTile> tile = stop.stop_requested() ? nullptr : frame.relay.take()) {
        Tiles tiles;
        for (; tile; tile = tiles.size() < kMostTiles ? frame.relay.takeReady() : nullptr) {
          if (device_->hasFailed() || tile->isAgain)
            giveToHost(std::move(tile));
          else
            tiles.push_back(std::move(tile));
        }
        const auto from = std::chrono::steady_clock::now();
        bool isMarched = false;
        try {
          isMarched = worker.march(frame, tiles, launch);
        } catch (const DeviceError& error) {
          device_->leave(error);
        }
        const auto to = std::chrono::steady_clock::now();
        for (std::unique_ptr<RelayedTile>& one : tiles) {
          one->isByDevice = isMarched;
          one->taken = to - (to - from) / static_cast<int64_t>(tiles.size());  // its part of what all took
          isMarched ? frame.relay.handOn(std::move(one)) : giveToHost(std::move(one));
        }
      }
    };
    {
      std::vector<std::jthread> threads;
      guarded([&] {
        for (const std::unique_ptr<PieceWorker>& worker : workers_) threads.emplace_back([&] { guarded([&] { work(*worker); }); });
      });
    }
    share.end();
    if (host.joinable()) host.join();
    if (trouble) std::rethrow_exception(trouble);
  }

  const MarchedVolumePtr marched_;
  const std::unique_ptr<PieceMarcher> onHost_;
  const std::shared_ptr<PieceDevice> device_;  // whose mutex is that of what follows
  DeviceBrick* brick_ = nullptr;
  const float* noise_ = nullptr;
  std::span<const std::unique_ptr<PieceWorker>> workers_;
  std::shared_ptr<const BakedTransfer> baked_;  // that the next two are for
  DeviceTable table_;
  cuda::DeviceBuffer<uint8_t> emptyDistances_;
};

}  // namespace

MarcherPtr makeFittingCudaMarcher(VolumePtr volume, TransferFunction transferFunction) {
  const int slices = slicesOnDevice(*volume);
  if (slices == static_cast<int>(volume->dims().z)) return makeCudaMarcher(std::move(volume), std::move(transferFunction));
  return makeStreamedMarcher(std::make_shared<const MarchedVolume>(std::move(volume), std::move(transferFunction)), makeCudaPieces(false, {}), slices);
}

PieceMaker makeCudaPieces(bool mayFallBack, std::function<void(const std::string& reason)> onFallback) {
  const auto device = std::make_shared<PieceDevice>(mayFallBack, std::move(onFallback));
  return {[device](MarchedVolumePtr marched) { return std::make_unique<CudaPieceMarcher>(std::move(marched), device); },
          [device] { return device->hasFailed() ? Backend::cpu : Backend::cuda; }, roomOnDevice()};
}

}  // namespace warpscope
