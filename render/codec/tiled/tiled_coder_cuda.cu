// Who works at which frame.
// See tiled_coder_cuda.h.
#include "render/codec/tiled/tiled_coder_cuda.h"

#include <optional>
#include <semaphore>
#include <utility>

#include "render/base/shared_pool.h"
#include "render/codec/tiled/cuda_sample_tiles.h"
#include "render/codec/tiled/cuda_segment_tiles.h"
#include "render/codec/tiled/tiled_samples.h"
#include "render/cuda/pinned_memory.h"

namespace warpscope {
namespace {

/// Of one frame at a time. A device works at samples and at segments side by side.
struct Workspace {
  CudaSampleTiles samples;
  CudaSegmentTiles segments;
};

using WorkspacePool = SharedPool<Workspace>;

/// One of few workers, which whoever asks waits for: a frame keeps half of a device busy, as few workers keep their device memory, and threads that wait leave their core to
/// others, which those that wait for a device do not.
class CudaWorker {
 public:
  explicit CudaWorker(const std::shared_ptr<WorkspacePool>& workers) : tiles_(workers->take()) {}
  Workspace& operator*() const { return *tiles_; }
  /// Nothing is under way then, and nothing is held of what was.
  void settle() const {
    tiles_->samples.settle();
    tiles_->segments.settle();
  }

 private:
  struct Place {
    Place() { all().acquire(); }
    ~Place() { all().release(); }
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;

    static std::counting_semaphore<>& all() {
      static std::counting_semaphore<> places(kMostAtOnce);
      return places;
    }
  };
  static constexpr int kMostAtOnce = 4;

  const Place place_;  // taken before and left behind what follows
  const WorkspacePool::Lease tiles_;
};

class CudaTiledCoder final : public TiledCoder {
 public:
  CudaTiledCoder() { workers_->take(); }  // fails here if it does
  ~CudaTiledCoder() override {
    endBegun();
    cuda::giveBackPinnedMemory();
  }

  void beginToAppendSegments(const SampleFrame& frame, Placement placement) override {
    if (begunSegments_ != nullptr || (begunSamples_ != nullptr && begunSamples_ != &frame)) endBegun();
    if (!CudaSegmentTiles::takes(frame)) return;
    worker().segments.beginToAppend(frame, placement);
    begunSegments_ = &frame;
  }
  void beginToAppendSamples(const SampleFrame& frame, Placement placement) override {
    if (begunSamples_ != nullptr || (begunSegments_ != nullptr && begunSegments_ != &frame)) endBegun();
    if (!CudaSampleTiles::takes(frame)) return;
    worker().samples.beginToAppend(frame, placement);
    begunSamples_ = &frame;
  }
  void appendSamples(ByteVector& out, const SampleFrame& frame, Placement placement) override {
    if (!CudaSampleTiles::takes(frame)) return host().appendSamples(out, frame, placement);
    if (begunSamples_ != &frame) beginToAppendSamples(frame, placement);
    summed_.push_back(worker().samples.append(out));
    begunSamples_ = nullptr;
    if (begunSegments_ == nullptr) leave();
  }
  void appendSegments(ByteVector& out, const SampleFrame& frame, Placement placement) override {
    if (!CudaSegmentTiles::takes(frame)) return host().appendSegments(out, frame, placement);
    if (begunSegments_ != &frame) beginToAppendSegments(frame, placement);
    summed_.push_back(worker().segments.append(out));
    begunSegments_ = nullptr;
    if (begunSamples_ == nullptr) leave();
  }

  void beginToTakeSegments(ByteReader reader, Placement placement, bool hasNormals, size_t most, const SampleFrame& frame) override {
    if (begunSegments_ != nullptr || (begunSamples_ != nullptr && begunSamples_ != &frame)) endBegun();
    CudaFrame& to = held();  // says where it stays
    segmentError_ = worker().segments.beginToTake(reader, placement, hasNormals, most, frame, to, heldPlace_);
    placements_.borders = placement;
    begunSegments_ = &frame;
    mayGoOn_ = true;
  }
  void beginToTakeSamples(ByteReader reader, Placement placement, size_t count, const SampleFrame& frame) override {
    if (begunSamples_ != nullptr || (begunSegments_ != nullptr && begunSegments_ != &frame)) endBegun();
    if (tiledGridOf(frame, count).count() > 0) {
      CudaFrame& to = held();
      error_ = worker().samples.beginToTake(reader, placement, count, frame, to, heldPlace_);
      placements_.samples = placement;
      begunSamples_ = &frame;
    }
    if (begunSegments_ == &frame) goOnTakingSegments(frame);  // samples go ahead, whose way to the host is free until segments want it
  }
  DecodeError takeSamples(ByteReader& reader, Placement placement, size_t count, SampleFrame& frame) override {
    if (tiledGridOf(frame, count).count() == 0) {
      leave();  // segments without samples
      return host().takeSamples(reader, placement, count, frame);
    }
    if (begunSamples_ != &frame) beginToTakeSamples(reader, placement, count, frame);
    if (!error_) error_ = worker().samples.take(frame, held());
    if (!error_) {
      held().setPlacements(placements_);
      frame.device = std::move(held_);
      frame.isAway = heldPlace_ == DecodedPlace::device;
    }
    leave();
    return std::exchange(error_, std::nullopt);
  }
  DecodeError takeSegments(ByteReader& reader, Placement placement, bool hasNormals, size_t most, SampleFrame& frame) override {
    if (begunSegments_ != &frame) beginToTakeSegments(reader, placement, hasNormals, most, frame);
    goOnTakingSegments(frame);
    begunSegments_ = nullptr;
    if (segmentError_) return segmentError_;
    return worker().segments.take(frame, held());
  }

  void setPlace(DecodedPlace place) override { place_ = place; }

  /// Page-locked if it can be: the device copies its part there itself, to pages that were written to before. Who sends it holds them so long.
  ByteVector roomFor(size_t bytes) override {
    ByteVector payload(TransferAllocator<std::byte>(cuda::pinnedOrPlainMemory()));
    payload.reserve(bytes);
    return payload;
  }
  std::vector<SummedWords> takeSummed() override { return std::exchange(summed_, {}); }
  void endBegun() override {
    summed_.clear();
    leave();
  }
  void forget() override {
    endBegun();
    workers_->forget();
    frames_->forget();
    cuda::giveBackPinnedMemory();
  }

 private:
  TiledCoder& host() {
    if (!host_) host_ = makeHostTiledCoder();
    return *host_;
  }
  /// The frame's, until leave().
  Workspace& worker() {
    if (!worker_) worker_.emplace(workers_);
    return **worker_;
  }
  /// Once, after they were begun.
  void goOnTakingSegments(const SampleFrame& frame) {
    if (std::exchange(mayGoOn_, false) && !segmentError_) segmentError_ = worker().segments.goOnTaking(frame, held());
  }
  /// What is decoded, where techniques of the device find it.
  CudaFrame& held() {
    if (!held_) {
      held_ = std::make_shared<CudaFrame>(frames_);
      heldPlace_ = place_;
    }
    return *held_;
  }
  void leave() {
    if (worker_) worker_->settle();
    worker_.reset();
    held_.reset();
    begunSegments_ = begunSamples_ = nullptr;
    mayGoOn_ = false;
  }

  const std::shared_ptr<WorkspacePool> workers_ = WorkspacePool::ofProcess();
  const std::shared_ptr<CudaFramePool> frames_ = std::make_shared<CudaFramePool>();  // not a marcher's, whose frames have room for all that they could hold
  std::optional<CudaWorker> worker_;
  std::shared_ptr<CudaFrame> held_;  // of the frame that is read
  const SampleFrame *begunSegments_ = nullptr, *begunSamples_ = nullptr;  // whose are under way; null: nobody's
  std::vector<SummedWords> summed_;
  DecodedPlace place_ = DecodedPlace::host, heldPlace_ = DecodedPlace::host;  // of frames to come; of the one that is read
  FramePlacements placements_;        // of what is read
  bool mayGoOn_ = false;              // segments are begun, and nobody has gone on with them
  DecodeError segmentError_, error_;  // of segments and samples, while they are read
  TiledCoderPtr host_;  // of frames that are not for a device
};

}  // namespace

TiledCoderPtr makeCudaTiledCoder() { return std::make_shared<CudaTiledCoder>(); }

}  // namespace warpscope
