// Who has the device, and which tiles go there.
// See piece_marcher_cuda.h. Several threads, each with a stream of its own (piece_worker.h): while one's rays are marched others pack and unpack theirs.
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
#include "render/march/device_cells.h"
#include "render/march/device_table.h"
#include "render/march/device_volume.h"
#include "render/march/frame_normals.h"
#include "render/march/march_setup.h"
#include "render/march/marcher_cuda.h"
#include "render/march/piece_launch.h"
#include "render/march/piece_worker.h"
#include "render/march/relay_share.h"
#include "render/march/streamed_marcher.h"
#include "render/volume/kept_slices.h"

namespace warpscope {
namespace {

/// Tiles whose rays are marched by one launch, at most.
constexpr size_t kMostTiles = 16;
constexpr unsigned kMostWorkers = 8;
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
    cells_.reset();
    brick_.reset();
    brick_.emplace(marched->volume, marched->scale);
    brickOf_ = marched;
    return *brick_;
  }
  /// Value ranges of the brick's volume. Throws DeviceError.
  const DeviceCells& cells() {
    if (!cells_) cells_.emplace(brickOf_->macrocells);
    return *cells_;
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
  std::optional<DeviceCells> cells_;  // likewise, once they are asked for
  cuda::DeviceBuffer<float> noise_;
  std::vector<std::unique_ptr<PieceWorker>> workers_;
};

class CudaPieceMarcher final : public PieceMarcher {
 public:
  /// Asks nothing of the device, which may have failed.
  CudaPieceMarcher(MarchedVolumePtr marched, std::shared_ptr<PieceDevice> device)
      : marched_(std::move(marched)), onHost_(makePieceMarcher(marched_)), device_(std::move(device)) {}

  void setLightCopy(const ProxyPtr& copy) override {
    const std::scoped_lock lock(device_->mutex);
    onHost_->setLightCopy(copy);
    lightKey_.clear();
  }

  void marchPieces(const Camera& camera, const RenderSettings& settings, const SampleSettings* sample, RayRelay& relay, const std::stop_token& stop) override {
    const std::scoped_lock lock(device_->mutex);
    const Volume& volume = *marched_->volume;
    requireMarchable(volume, camera, settings);
    if (sample != nullptr) validate(*sample);
    if (const std::string reason = whyNotInPieces(settings); !reason.empty()) throw UsageError(reason);
    const std::shared_ptr<const BakedTransfer> baked = marched_->bakedFor(settings);
    const EffectPlan plan = planFor(*marched_, *baked, baked->visibleCells, settings, sample != nullptr ? std::optional(*sample) : std::nullopt);
    const auto onHost = [&] { onHost_->marchPieces(camera, settings, sample, relay, stop); };
    if (device_->hasFailed() || !plan.has(PlanStage::march)) return onHost();
    PieceFrame frame{camera, settings, sample, relay, plan, {}, pixelsFor(volume, camera, settings), makeVolumeView<uint8_t>(*marched_), limitsOf(settings, plan), {}, shadingFor(*marched_, camera, settings, plan), {}};
    try {
      prepare(frame, baked, stop);
    } catch (const DeviceError& error) {
      device_->leave(error);
      return onHost();
    }
    if (sample != nullptr) {
      frame.rule = sampleRuleFor(volume, camera, *sample);
      frame.depthOfSamples = {depthFunctionOf(sample->heuristic, plan.has(PlanStage::secondPass)), sample->threshold, plan.has(PlanStage::spread)};
      if (plan.has(PlanStage::raySegments)) frame.mostSegments = sample->segments;
      frame.mostParts = plan.has(PlanStage::severalSamples) ? sample->samplesPerRay : 1;
      frame.listsSamples = frame.mostParts > 1 || !hasOnePass(sample->heuristic);
      frame.hasNormals = wantsNormals(*marched_, camera, settings, plan);
    }
    visitKeptVoxels(volume.type(), volume.statistics().nonFinite > 0, [&]<class Voxel, bool kHasHoles>() {
      const PieceJob<Voxel> job = jobFor<Voxel>(frame);
      const auto launchAny = [&](const PieceRays& rays, const PartedRays& parted, cudaStream_t stream) {
        PieceJob<Voxel> own = job;
        static_cast<PieceRays&>(own) = rays;
        own.parted = parted;
        launch<Voxel, kHasHoles>(own, frame, stream);
      };
      marchAll(frame,
               {[&](const PieceRays& rays, cudaStream_t stream) { launchAny(rays, {}, stream); },
                [&](const PartedRays& rays, cudaStream_t stream) { launchAny({}, rays, stream); },
                [&](const LitPlace* places, uint32_t count, NormalCode* normals, cudaStream_t stream) {
                  launchPieceNormals<Voxel, kHasHoles>(job, frame.shading, places, count, normals, stream);
                }},
               stop);
    });
    if (stop.stop_requested()) throw OperationCancelled();
  }

 private:
  /// What the device has to have. Throws DeviceError, OperationCancelled.
  void prepare(PieceFrame& frame, const std::shared_ptr<const BakedTransfer>& baked, const std::stop_token& stop) {
    const RenderSettings& settings = frame.settings;
    brick_ = &device_->brickOf(marched_);
    brick_->provide(rowsOf(frame.relay.block(), settings, marched_->volume->geometry()), stop);
    noise_ = device_->noise();
    workers_ = device_->workers();
    if (baked != baked_) bake(baked);
    if (settings.effects.mode == RenderMode::mip) {
      greatest_ = mipFor(*marched_, baked->table, frame.plan);
      if (greatest_.highest != nullptr) greatest_.highest = device_->cells().highest(), greatest_.lowest = device_->cells().lowest();
    }
    if (!frame.plan.has(PlanStage::lightVolume)) return;
    const FoundLight light = onHost_->findLight(frame.camera, settings, stop);
    frame.lightVolume = light.volume;
    if (light.volume.channels == 0) return;
    if (light.key != lightKey_) {
      lightKey_.clear();
      lightValues_.upload({light.volume.values, light.volume.places() * static_cast<size_t>(light.volume.channels)}, device_->stream());
      WARPSCOPE_CUDA_CHECK(cudaStreamSynchronize(device_->stream()));
      lightKey_ = light.key;
    }
    frame.lightVolume.values = lightValues_.data();
  }

  void bake(const std::shared_ptr<const BakedTransfer>& baked) {
    baked_ = nullptr;
    const cudaStream_t stream = device_->stream();
    table_.upload(baked->table, stream);
    emptyDistances_.upload(baked->emptyDistances, stream);
    baked->hasSegments() ? segments_.upload(baked->segments, stream) : segments_.clear();
    WARPSCOPE_CUDA_CHECK(cudaStreamSynchronize(stream));
    baked_ = baked;
  }

  template <class Voxel, bool kHasHoles>
  void launch(const PieceJob<Voxel>& job, const PieceFrame& frame, cudaStream_t stream) const {
    switch (frame.settings.effects.mode) {
      case RenderMode::composite:
        if constexpr (!kHasHoles)
          if (frame.plan.has(PlanStage::segments) && baked_->hasSegments()) return launchSegmentPieces(job, segments_.lookup(), frame.shading, frame.lightVolume, stream);
        return launchPieces<Voxel, kHasHoles>(job, frame.shading, frame.lightVolume, stream);
      case RenderMode::mip: return launchMipPieces<Voxel, kHasHoles>(job, greatest_, stream);
      case RenderMode::isosurface: return launchIsosurfacePieces<Voxel, kHasHoles>(job, baked_->surfaces, frame.shading, stream);
    }
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
  void marchAll(const PieceFrame& frame, const PieceLaunches& launches, const std::stop_token& stop) {
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
      std::unique_ptr<RelayedTile> next;
      const auto takeNext = [&] { next = stop.stop_requested() ? nullptr : frame.relay.take(); };
      for (takeNext(); next; next ? void() : takeNext()) {
        Tiles tiles;  // that are on the same way
        const bool isAgain = next->isAgain;
        do {
          device_->hasFailed() ? giveToHost(std::move(next)) : tiles.push_back(std::move(next));
          next = tiles.size() < kMostTiles ? frame.relay.takeReady() : nullptr;
        } while (next && next->isAgain == isAgain);
        if (tiles.empty()) continue;
        const auto from = std::chrono::steady_clock::now();
        bool isMarched = false;
        try {
          isMarched = worker.march(frame, tiles, launches);
        } catch (const DeviceError& error) {
          device_->leave(error);
        }
        const auto part = (std::chrono::steady_clock::now() - from) / static_cast<int64_t>(tiles.size());  // of what all took, a tile's
        auto begin = from;
        for (std::unique_ptr<RelayedTile>& one : tiles) {
          one->isByDevice = isMarched;
          one->taken = begin;
          begin += part;
          if (isMarched) one->done = begin;
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
  const std::unique_ptr<HostPieceMarcher> onHost_;
  const std::shared_ptr<PieceDevice> device_;  // whose mutex is that of what follows
  DeviceBrick* brick_ = nullptr;
  const float* noise_ = nullptr;
  std::span<const std::unique_ptr<PieceWorker>> workers_;
  std::shared_ptr<const BakedTransfer> baked_;  // that the next three are for
  DeviceTable table_;
  DeviceSegmentTable segments_;
  cuda::DeviceBuffer<uint8_t> emptyDistances_;
  MipSetup greatest_;            // of the frame that is marched, where that is its mode
  std::vector<float> lightKey_;  // of what the following are for; empty: nothing
  cuda::DeviceBuffer<uint16_t> lightValues_;
};

}  // namespace

MarcherPtr makeFittingCudaMarcher(VolumePtr volume, TransferFunction transferFunction) {
  const int slices = slicesOnDevice(*volume), all = static_cast<int>(volume->dims().z), kept = static_cast<int>(slicesKept(*volume));
  if (slices == all) return makeCudaMarcher(std::move(volume), std::move(transferFunction));
  return makeStreamedMarcher(std::make_shared<const MarchedVolume>(std::move(volume), std::move(transferFunction)), makeCudaPieces(false, {}),
                             {.slices = std::min(slices, kept), .rayBytes = limitedShare(), .isForAll = kept < all});
}

PieceMaker makeCudaPieces(bool mayFallBack, std::function<void(const std::string& reason)> onFallback) {
  const auto device = std::make_shared<PieceDevice>(mayFallBack, std::move(onFallback));
  return {[device](MarchedVolumePtr marched) { return std::make_unique<CudaPieceMarcher>(std::move(marched), device); },
          [device] { return device->hasFailed() ? Backend::cpu : Backend::cuda; }, roomOnDevice()};
}

}  // namespace warpscope
