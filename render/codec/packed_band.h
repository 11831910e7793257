// Some rows of a frame's picture (or, for frames without order, some samples) as bytes: the unit that is packed and unpacked at once.
// A pixel's samples are layers: its first belongs to layer 0, the next to layer 1. Each layer is packed like a picture of its own, so that sample
// k of a pixel is predicted from sample k of its neighbours. Prediction uses those to the left and above: the median of both and of the plane
// through them (LOCO-I, Weinberger, Seroussi, Sapiro 2000).
//
// A band's bytes:
//   samples (4), strays (4): samples that have no place in the order of pixels and are sent as they are; a hash of all samples (8)
//   sections (zstd_section.h), of lengths that follow from what came before:
//     if there are strays: which samples are; strays, byte by byte: all lowest bytes first; their places along their rays if the frame says
//     such (kLayerPlane), a byte each
//     which pixels have samples, a bit each, each row changed by the row above; how many further ones each of these has (a flag (1) before)
//   for each layer, from the front:
//     sections: tokens of the differences of places from their prediction; what their positions differ in from the place's (a byte,
//     kExact..kEscape); tokens of the differences of radius codes
//     the tokens' bits, and 54 bits for each position that is escaped: length (4) and a section
//     alpha and colour: color_planes.h; those of strays are with the first layer's
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "render/codec/codec.h"
#include "render/codec/pixel_path.h"

namespace warpscope {

/// More layers, and more strays, no band has; and no fewer bytes than its head.
inline constexpr size_t kMaxLayers = 256;
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

  /// Appends the band whose samples are [begin, end) of the frame. pixels[i] is the pixel of sample i (row times width plus column), which
  /// must be in the band, not before the one of the sample before, and at most kMaxLayers times the same; kNoSample for strays. Where the
  /// frame has layers, a pixel's samples are those of one ray.
  void pack(const SampleFrame& frame, const BandRows& rows, size_t begin, size_t end, std::span<const uint32_t> pixels,
            const CodecSettings& settings, std::vector<std::byte>& out);

  /// Fills samples and colours, which say how many there must be, and as many layers, or none if the frame does not say such. The frame gives
  /// camera, quantisation, settings.
  DecodeError unpack(std::span<const std::byte> bytes, const SampleFrame& frame, const BandRows& rows, ColorCoding coding,
                     std::span<PackedSample> samples, std::span<Rgba8> colors, std::span<uint8_t> layers);

 private:
  struct Buffers;
  std::unique_ptr<Buffers> buffers_;
};

}  // namespace warpscope
