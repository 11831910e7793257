// On the host, and on a device as long as it works.
// See tiled_coder.h.
#include "render/codec/tiled/tiled_coder.h"

#include <optional>
#include <utility>

#include "render/base/error.h"
#include "render/codec/frame_order.h"
#include "render/codec/tiled/tiled_samples.h"
#include "render/codec/tiled/tiled_segments.h"

namespace warpscope {
namespace {

/// One that was away has not been looked at by the codec.
template <class Work>
void withFrameHere(const SampleFrame& frame, const Work& work) {
  if (!frame.isAway) return work(frame);
  const SampleFrame here = onHost(frame);
  requireConsistent(here);
  work(here);
}

class HostTiledCoder final : public TiledCoder {
 public:
  void appendSamples(ByteVector& out, const SampleFrame& frame, Placement placement) override {
    withFrameHere(frame, [&](const SampleFrame& here) { samples_->append(out, here, placement); });
  }
  DecodeError takeSamples(ByteReader& reader, Placement placement, size_t count, SampleFrame& frame) override { return samples_->take(reader, placement, count, frame); }
  void appendSegments(ByteVector& out, const SampleFrame& frame, Placement placement) override {
    withFrameHere(frame, [&](const SampleFrame& here) { segments_->append(out, here, placement); });
  }
  DecodeError takeSegments(ByteReader& reader, Placement placement, bool hasNormals, size_t most, SampleFrame& frame) override {
    return segments_->take(reader, placement, hasNormals, most, frame);
  }
  void forget() override {
    samples_ = std::make_unique<TiledSamples>();
    segments_ = std::make_unique<TiledSegments>();
  }

 private:
  std::unique_ptr<TiledSamples> samples_ = std::make_unique<TiledSamples>();
  std::unique_ptr<TiledSegments> segments_ = std::make_unique<TiledSegments>();
};

class FallbackTiledCoder final : public TiledCoder {
 public:
  FallbackTiledCoder(std::function<TiledCoderPtr()> makeFirst, std::function<void(const std::string& reason)> onFallback)
      : makeFirst_(std::move(makeFirst)), onFallback_(std::move(onFallback)) {}

  void appendSamples(ByteVector& out, const SampleFrame& frame, Placement placement) override {
    append(out, [&](TiledCoder& coder) { coder.appendSamples(out, frame, placement); });
  }
  DecodeError takeSamples(ByteReader& reader, Placement placement, size_t count, SampleFrame& frame) override {
    return take(reader, frame, [&](TiledCoder& coder) {
      if (isOnHost_ && leftThere_) {  // lost with the device
        SegmentBytes again = *std::exchange(leftThere_, std::nullopt);
        if (DecodeError error = coder.takeSegments(again.reader, again.placement, again.hasNormals, again.most, frame)) return error;
      }
      return coder.takeSamples(reader, placement, count, frame);
    });
  }
  void appendSegments(ByteVector& out, const SampleFrame& frame, Placement placement) override {
    append(out, [&](TiledCoder& coder) { coder.appendSegments(out, frame, placement); });
  }
  DecodeError takeSegments(ByteReader& reader, Placement placement, bool hasNormals, size_t most, SampleFrame& frame) override {
    const SegmentBytes bytes{reader, placement, hasNormals, most};
    leftThere_.reset();
    const DecodeError error = take(reader, frame, [&](TiledCoder& coder) { return coder.takeSegments(reader, placement, hasNormals, most, frame); });
    if (!error && !isOnHost_ && place_ == DecodedPlace::device) leftThere_ = bytes;
    return error;
  }
  void setPlace(DecodedPlace place) override {
    place_ = place;
    if (coder_) coder_->setPlace(place);
  }
  void beginToAppendSegments(const SampleFrame& frame, Placement placement) override {
    begin([&](TiledCoder& coder) { coder.beginToAppendSegments(frame, placement); });
  }
  void beginToAppendSamples(const SampleFrame& frame, Placement placement) override {
    begin([&](TiledCoder& coder) { coder.beginToAppendSamples(frame, placement); });
  }
  void beginToTakeSegments(ByteReader reader, Placement placement, bool hasNormals, size_t most, const SampleFrame& frame) override {
    begin([&](TiledCoder& coder) { coder.beginToTakeSegments(reader, placement, hasNormals, most, frame); });
  }
  void beginToTakeSamples(ByteReader reader, Placement placement, size_t count, const SampleFrame& frame) override {
    begin([&](TiledCoder& coder) { coder.beginToTakeSamples(reader, placement, count, frame); });
  }
  ByteVector roomFor(size_t bytes) override {
    begin([](TiledCoder&) {});  // it is made
    return coder_->roomFor(bytes);
  }
  std::vector<SummedWords> takeSummed() override { return coder_ ? coder_->takeSummed() : std::vector<SummedWords>(); }
  void endBegun() override {
    leftThere_.reset();
    if (coder_) coder_->endBegun();
  }
  void forget() override {
    if (coder_) coder_->forget();
  }

 private:
  /// Made when something is first coded: most frames never are in tiles.
  TiledCoder& coder() {
    if (!coder_) {
      coder_ = makeFirst_();
      coder_->setPlace(place_);
    }
    return *coder_;
  }
  template <class Call>
  void begin(const Call& call) {
    try {
      call(coder());
    } catch (const DeviceError& error) {
      leave(error);
    }
  }
  template <class Call>
  void append(ByteVector& out, const Call& call) {
    const size_t size = out.size();
    try {
      call(coder());
    } catch (const DeviceError& error) {
      leave(error);
      out.resize(size);
      call(*coder_);
    }
  }
  template <class Call>
  DecodeError take(ByteReader& reader, SampleFrame& frame, const Call& call) {
    const ByteReader before = reader;
    try {
      return call(coder());
    } catch (const DeviceError& error) {
      leave(error);
      reader = before;
      // Page-locked memory may be what failed.
      if (frame.samples.empty()) frame.samples = {};
      if (frame.colors.empty()) frame.colors = {};
      return call(*coder_);
    }
  }

  void leave(const DeviceError& error) {
    coder_ = makeHostTiledCoder();
    isOnHost_ = true;
    if (onFallback_) std::exchange(onFallback_, nullptr)(error.what());
  }

  /// Of a frame's segments, in a payload that stays until endBegun().
  struct SegmentBytes {
    ByteReader reader;
    Placement placement;
    bool hasNormals;
    size_t most;
  };

  const std::function<TiledCoderPtr()> makeFirst_;
  TiledCoderPtr coder_;
  bool isOnHost_ = false;
  DecodedPlace place_ = DecodedPlace::host;
  std::optional<SegmentBytes> leftThere_;  // taken, and nowhere but on the device
  std::function<void(const std::string& reason)> onFallback_;
};

}  // namespace

TiledCoderPtr makeHostTiledCoder() { return std::make_shared<HostTiledCoder>(); }

TiledCoderPtr makeFallbackTiledCoder(std::function<TiledCoderPtr()> makeFirst, std::function<void(const std::string& reason)> onFallback) {
  return std::make_shared<FallbackTiledCoder>(std::move(makeFirst), std::move(onFallback));
}

}  // namespace warpscope
