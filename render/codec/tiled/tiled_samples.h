// The samples of frames as tiles, on all cores of the host.
//
// Bytes: hash of the samples (8); tiles (tiled_sheet.h). Shapes: which pixels have samples, a bit each, each row of bytes changed by the one above; where the frame has
// kLayerPlane, how many further samples each of these has, changed by the one before. Planes of a layer: differences of places along rays (pixel_path.h) from
// their prediction, of depth codes from those of their places, of radius codes; opacity, green, red, blue (color_differences.h).
#pragma once

#include <memory>

#include "render/codec/codec.h"
#include "render/codec/pixel_path.h"
#include "render/codec/tiled/tile_grid.h"

namespace warpscope {

/// Samples of a ray of such a frame, at most.
size_t mostTiledLayers(const SampleFrame& frame);
/// The tiles of a frame: none without samples.
TileGrid tiledGridOf(const SampleFrame& frame, size_t samples);
/// The most bytes of so many samples.
uint64_t mostTiledSampleBytes(const SampleFrame& frame, uint64_t count);
inline constexpr const char* kOtherNumbers = "the tiles of the payload have other numbers of samples than the frame";
/// Whoever finds it differ has not the samples that were sent.
inline constexpr const char* kOtherSamples =
    "the samples are not those that were sent: other camera or settings than the sender's, or a machine that rounds differently";

/// Keeps its buffers; one thread at a time.
class TiledSamples {
 public:
  TiledSamples();
  ~TiledSamples();

  void append(ByteVector& out, const SampleFrame& frame, Placement placement);
  /// Fills `count` samples and colours of the frame, and kLayerPlane if it has that.
  DecodeError take(ByteReader& reader, Placement placement, size_t count, SampleFrame& frame);

 private:
  struct Buffers;
  const std::unique_ptr<Buffers> buffers_;
};

}  // namespace warpscope
