// The segments of a frame's rays as tiles, for the format `tiled`: see segment_coding.h for what is predicted from what.
//
// Bytes: hash of all but colours (8); tiles (tiled_sheet.h). Shape: the byte of each ray, changed by the one to the left, in the first column by the one above. Planes of a
// layer: differences of the borders at which segments begin and end from their prediction, of depth codes from those of the borders; opacity, green, red, blue; where
// there are normals, both of their parts.
#pragma once

#include <memory>

#include "render/codec/codec.h"
#include "render/codec/pixel_path.h"

namespace warpscope {

/// The most bytes of so many segments, at most `layers` of a pixel.
uint64_t mostTiledSegmentBytes(const Camera& camera, uint64_t segments, uint64_t layers);

/// Whoever finds it differ has not the segments that were sent.
inline constexpr const char* kOtherSegments =
    "the segments are not those that were sent: other camera or settings than the sender's, or a machine that rounds differently";

/// Keeps its buffers; one thread at a time, and works on all cores itself.
class TiledSegments {
 public:
  TiledSegments();
  ~TiledSegments();

  /// Appends the frame's segments, which are consistent.
  void append(ByteVector& out, const SampleFrame& frame, Placement placement);
  /// Fills the frame's segments, at most `most`, and a ray for each of its pixels. Whatever the bytes, they are consistent then (segment_coding.h).
  DecodeError take(ByteReader& reader, Placement placement, bool hasNormals, size_t most, SampleFrame& frame);

 private:
  struct Buffers;
  const std::unique_ptr<Buffers> buffers_;
};

}  // namespace warpscope
