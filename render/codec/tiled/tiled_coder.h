// Who makes tiles of frames for the format `tiled`: the host or a device. The bytes are the same.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "render/codec/codec.h"
#include "render/codec/payload_hash.h"
#include "render/codec/pixel_path.h"

namespace warpscope {

/// Keeps its buffers; one thread at a time, and works on all cores, or all of a device, itself.
class TiledCoder {
 public:
  virtual ~TiledCoder() = default;

  /// Appends the samples and colours of a frame that codec.h takes to a payload, from whose first byte `out` is: tiled_samples.h.
  virtual void appendSamples(ByteVector& out, const SampleFrame& frame, Placement placement) = 0;
  /// Fills `count` samples and colours of the frame, and kLayerPlane if it has that. All else of it is known.
  virtual DecodeError takeSamples(ByteReader& reader, Placement placement, size_t count, SampleFrame& frame) = 0;

  /// Likewise the frame's segments, which are consistent: tiled_segments.h.
  virtual void appendSegments(ByteVector& out, const SampleFrame& frame, Placement placement) = 0;
  /// Fills the frame's segments, at most `most`, and a ray for each of its pixels. Whatever the bytes, they are consistent then (segment_coding.h).
  virtual DecodeError takeSegments(ByteReader& reader, Placement placement, bool hasNormals, size_t most, SampleFrame& frame) = 0;

  /// Where what is taken from now on is to stay. DecodedPlace::device is a wish: takeSamples() says whether it came true (SampleFrame::isAway), for samples and segments together.
  virtual void setPlace(DecodedPlace) {}

  /// Say that what appends or takes the same will be called, of what a reader is at, after what else there is of the frame: a device may begin with that meanwhile. The frame
  /// and the bytes, which may be damaged, must stay until then, or until endBegun().
  virtual void beginToAppendSegments(const SampleFrame&, Placement) {}
  virtual void beginToAppendSamples(const SampleFrame&, Placement) {}
  virtual void beginToTakeSegments(ByteReader, Placement, bool /*hasNormals*/, size_t /*most*/, const SampleFrame&) {}
  virtual void beginToTakeSamples(ByteReader, Placement, size_t /*count*/, const SampleFrame&) {}
  /// An empty payload with room for so many bytes, in memory in which appending is quickest. No DeviceError.
  virtual ByteVector roomFor(size_t bytes) {
    ByteVector payload;
    payload.reserve(bytes);
    return payload;
  }
  /// Words of payloads that were appended since this was called last, or endBegun(), and are added up already.
  virtual std::vector<SummedWords> takeSummed() { return {}; }
  /// Nothing is to come of what was begun and is not done.
  virtual void endBegun() {}

  /// Gives back buffers.
  virtual void forget() = 0;
};

using TiledCoderPtr = std::shared_ptr<TiledCoder>;

TiledCoderPtr makeHostTiledCoder();

/// Works with `makeFirst()`, which is called when something is first coded, and, from the first DeviceError on, its making included, on the host. `onFallback` (may be empty) is told the reason once.
TiledCoderPtr makeFallbackTiledCoder(std::function<TiledCoderPtr()> makeFirst, std::function<void(const std::string& reason)> onFallback);

}  // namespace warpscope
