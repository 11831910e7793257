// Some rows of a frame's picture (or, for frames without order, some samples) as bytes: the unit that is packed and
// unpacked at once. A pixel's samples are layers: its first belongs to layer 0, the next to layer 1. Each layer is
// packed by itself (layer_packer.h).
//
// A band's bytes:
// - samples (4), strays (4): samples that have no place in the order of pixels and are sent as they are; a hash of all
//   samples (8)
// - strays, if there are any: band_strays.h
// - if the band has rows, sections (zstd_section.h) whose lengths follow from what came before: which pixels have
//   samples, a bit each, each row changed by the row above; behind a flag (1), how many further ones each of these has
// - for each layer, from the front: layer_packer.h; the colours of strays are with those of the first
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "render/codec/band_layers.h"
#include "render/codec/codec.h"
#include "render/codec/pixel_path.h"

namespace warpscope {

/// More strays no band has; and no fewer bytes than its head.
inline constexpr size_t kMaxBandStrays = size_t{1} << 20;
inline constexpr size_t kLeastBandBytes = 16;

/// Which part of the picture a band is. Without rows: no part of it, all samples are strays.
struct BandRows {
  Placement placement = Placement::loose;
  uint32_t first = 0;
  uint32_t count = 0;
};

/// Whether every sample has a pixel, of its own and after the one before.
bool isAscending(std::span<const uint32_t> pixels);

/// Packs and unpacks bands, one at a time; keeps its buffers.
class BandPacker {
 public:
  BandPacker();
  ~BandPacker();
  BandPacker(BandPacker&&) noexcept;

  /// Appends the band whose samples are [begin, end) of the frame. pixels[i] is the pixel of sample i (row times width
  /// plus column), which must be in the band, not before the one of the sample before, and at most kMaxLayers times the
  /// same; kNoSample for strays. Where the frame has layers, a pixel's samples are those of one ray.
  void pack(const SampleFrame& frame, const BandRows& rows, size_t begin, size_t end, std::span<const uint32_t> pixels,
            const CodecSettings& settings, std::vector<std::byte>& out);

  /// Fills samples and colours, which say how many there must be, and as many layers, or none if the frame does not say
  /// such. The frame gives camera, quantisation, settings.
  DecodeError unpack(std::span<const std::byte> bytes, const SampleFrame& frame, const BandRows& rows,
                     ColorCoding coding, std::span<PackedSample> samples, std::span<Rgba8> colors,
                     std::span<uint8_t> layers);

 private:
  struct Buffers;
  std::unique_ptr<Buffers> buffers_;
};

}  // namespace warpscope
