// Some rows of a frame's picture (or, for frames without order, some samples) as bytes: the unit that is packed and unpacked at once.
// Packing predicts what it can from the neighbours to the left and above: the median of both and of the plane through them (LOCO-I,
// Weinberger, Seroussi, Sapiro 2000).
//
// A band's bytes:
//   samples (4), strays (4): samples that have no place in the order of pixels and are sent as they are; a hash of all samples (8)
//   sections (zstd_section.h), of lengths that follow from what came before:
//     which samples are strays, if any; strays, byte by byte: all lowest bytes first
//     which pixels have samples, a bit each, each row changed by the row above; how many further ones each of these has (a flag (1) before)
//     tokens of the differences of places from their prediction; what their positions differ in from the place's (a byte, kExact..kEscape);
//     tokens of the differences of radius codes
//   the tokens' bits, and 54 bits for each position that is escaped: length (4) and a section
//   alpha and colour: color_planes.h
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "render/codec/codec.h"
#include "render/codec/pixel_path.h"

namespace warpscope {

/// More samples than this no band has, and no fewer bytes than its head.
inline constexpr size_t kMaxBandSamples = size_t{1} << 20;
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
  /// must be in the band, not before the one of the sample before, and at most 256 times the same; kNoSample for strays.
  void pack(const SampleFrame& frame, const BandRows& rows, size_t begin, size_t end, std::span<const uint32_t> pixels,
            const CodecSettings& settings, std::vector<std::byte>& out);

  /// Fills samples and colours, which say how many there must be: at most kMaxBandSamples. The frame gives camera, quantisation, settings.
  DecodeError unpack(std::span<const std::byte> bytes, const SampleFrame& frame, const BandRows& rows, ColorCoding coding,
                     std::span<PackedSample> samples, std::span<Rgba8> colors);

 private:
  struct Buffers;
  std::unique_ptr<Buffers> buffers_;
};

}  // namespace warpscope
