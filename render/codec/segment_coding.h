// The segments of a frame's rays as bytes, for every format.
//
// Raw: for each pixel its byte (frame_segments.h), then for each segment its two depth codes and its colour (4 bytes each), then, where there are some, their
// normals (2 each).
// Tiled: tiled_segments.h.
// Packed: bands of rows, each by itself, a band in layers: the first segment of every pixel, then the second ... Where segments begin and end is predicted from
// the same of the pixels beside: borders of the ray's steps as the marcher has them (pixel_path.h), or depth codes where rays are not those; a segment that
// begins where the one in front ends takes next to nothing. Colours: color_plane_coder.h. Normals: differences of both of their parts.
// Before all: what a byte says of the rest (how depths are placed, how colours travel, whether there are normals).
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "render/base/shared_pool.h"
#include "render/codec/codec.h"
#include "render/march/pixel_places.h"

namespace warpscope {

/// The most bytes that a format takes for the segments of a frame with that camera and those settings, whatever they are; 0 where the settings ask for
/// none.
uint64_t mostSegmentBytes(const Camera& camera, const MarchSettings& marched, const CodecSettings& settings);

/// Nothing where the segments are what frame_segments.h says, and no more in a pixel than the settings ask for. A frame whose settings ask for some has a count for
/// each pixel of its picture.
DecodeError whyInconsistentSegments(const SampleFrame& frame);
/// Throws InputError with that.
void requireConsistentSegments(const SampleFrame& frame);
inline constexpr const char* kDisorderedSegments = "the segments of a pixel must be near to far";

class SegmentBand;

/// One thread at a time, and works on all cores itself. Buffers are those of all coders.
class SegmentCoder {
 public:
  explicit SegmentCoder(TiledCoderPtr coder);
  ~SegmentCoder();

  /// Comes before append() of the same: a device may begin with it, and what else there is of the frame be begun as well. Returns how borders are placed.
  Placement begin(const SampleFrame& frame, const CodecSettings& settings);
  /// Appends the frame's segments, which are consistent, to a payload.
  void append(ByteVector& out, const SampleFrame& frame, const CodecSettings& settings, Placement placement);

  /// Comes before take() of the same, whether they are whole or not. The bytes must stay until then.
  void beginToTake(std::span<const std::byte> bytes, PayloadFormat format, size_t most, const SampleFrame& frame);
  /// Fills the frame's segments, at most `most`; its camera (whose picture has a usable size), quantisation and settings are known.
  DecodeError take(std::span<const std::byte> bytes, PayloadFormat format, size_t most, SampleFrame& frame);

  /// Gives back all buffers that are not in use at the moment, other coders' as well: they may have grown for this one.
  void forget();

 private:
  const std::shared_ptr<SharedPool<SegmentBand>> bands_;
  const TiledCoderPtr tiled_;
};

}  // namespace warpscope
