// A device that keeps what it decodes, without one: what it holds is a HeldFrame.
#pragma once

#include "render/base/error.h"
#include "render/codec/tiled/tiled_coder.h"
#include "tests/held_frame.h"

namespace warpscope {

/// Codes as the host does. If it is to fail, it does so at samples, when it has taken segments.
class StayingCoder final : public TiledCoder {
 public:
  explicit StayingCoder(bool fails = false) : fails_(fails) {}

  void appendSamples(ByteVector& out, const SampleFrame& frame, Placement placement) override { host_->appendSamples(out, frame, placement); }
  void appendSegments(ByteVector& out, const SampleFrame& frame, Placement placement) override { host_->appendSegments(out, frame, placement); }
  DecodeError takeSegments(ByteReader& reader, Placement placement, bool hasNormals, size_t most, SampleFrame& frame) override {
    const DecodeError error = host_->takeSegments(reader, placement, hasNormals, most, frame);
    if (place_ == DecodedPlace::device) kept_ = std::exchange(frame.segments, {});
    return error;
  }
  DecodeError takeSamples(ByteReader& reader, Placement placement, size_t count, SampleFrame& frame) override {
    if (fails_) throw DeviceError("unplugged");
    const DecodeError error = host_->takeSamples(reader, placement, count, frame);
    if (error || place_ == DecodedPlace::host) return error;
    frame.segments = std::exchange(kept_, {});
    frame = leftOnDevice(frame);
    return error;
  }
  void setPlace(DecodedPlace place) override { place_ = place; }
  void forget() override {}

 private:
  const bool fails_;
  DecodedPlace place_ = DecodedPlace::host;
  FrameSegments kept_;
  const TiledCoderPtr host_ = makeHostTiledCoder();
};

}  // namespace warpscope
