// Some rows of a frame's picture as bytes: the unit that is packed and unpacked at once. A pixel's samples are layers: its first belongs to layer 0, the next to layer 1. Each layer is
// packed by itself (layer_packer.h).
//
// A band's bytes:
// - samples (4); a hash of all samples (8)
// - sections (zstd_section.h) whose lengths follow from what came before: which pixels have samples, a bit each, each
//   row changed by the row above; behind a flag (1), how many further ones each of these has
// - for each layer, from the front: layer_packer.h
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "render/codec/band_layers.h"
#include "render/codec/codec.h"
#include "render/codec/pixel_path.h"

namespace warpscope {

/// No band has fewer bytes than its head.
inline constexpr size_t kLeastBandBytes = 12;

/// Samples in one pixel of such a frame, at most.
size_t mostLayers(const SampleFrame& frame);

/// Which part of the picture a band is: `count` rows, at least 1.
struct BandRows {
  Placement placement = Placement::depth;
  uint32_t first = 0;
  uint32_t count = 0;
};

/// Packs and unpacks bands, one at a time; keeps its buffers.
class BandPacker {
 public:
  BandPacker();
  ~BandPacker();
  BandPacker(BandPacker&&) noexcept;

  /// The most bytes of a band with so many samples, of which a pixel has at most `layers`.
  static uint64_t mostBytes(uint32_t width, uint32_t rows, uint64_t samples, uint64_t layers, ColorCoding coding);

  /// Appends the band whose samples are [begin, end) of the frame: those in its rows, of a frame that codec.h takes.
  void pack(const SampleFrame& frame, const BandRows& rows, size_t begin, size_t end, const CodecSettings& settings,
            ByteVector& out);

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
