// One layer of a band as bytes: at most one sample in each pixel. It is packed like a picture of its own: a sample is
// predicted from those to the left and above, by the median of both and of the plane through them (LOCO-I, Weinberger,
// Seroussi, Sapiro 2000).
//
// Bytes, if the band has rows:
// - sections (zstd_section.h): tokens of the differences of places from their prediction; what positions differ in from
//   their places (position_deltas.h); tokens of the differences of radius codes
// - bits of places, of positions that a byte does not say, of radii: length (4) and a section
// and in any case alpha and colour (color_planes.h).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/codec/band_layers.h"
#include "render/codec/color_planes.h"
#include "render/codec/pixel_path.h"
#include "render/codec/place_tokens.h"

namespace warpscope {

/// Keeps its buffers. `mask` says which pixels the layer covers; shapes without rows have none.
class LayerPacker {
 public:
  /// `samples` are of the mask's pixels, in their order; `colors` theirs, and then those of strays.
  void append(std::vector<std::byte>& out, const SampleFrame& frame, Placement placement, const MaskShape& shape,
              std::span<const uint8_t> mask, std::span<const PackedSample> samples, std::span<const Rgba8> colors,
              const CodecSettings& settings);

  /// Fills samples() and colors(), the latter with those of so many strays behind.
  DecodeError take(ByteReader& reader, const SampleFrame& frame, Placement placement, const MaskShape& shape,
                   std::span<const uint8_t> mask, size_t strayCount, ColorCoding coding);
  std::span<const PackedSample> samples() const { return positions_; }
  std::span<const Rgba8> colors() const { return colors_; }
  std::span<const uint32_t> columns() const { return layout_.columns; }
  std::span<const uint32_t> rows() const { return layout_.rows; }

 private:
  TransferVector<PackedSample> positions_;
  TransferVector<Rgba8> colors_;
  TransferVector<uint8_t> tokens_, deltas_, radiusTokens_, bitBytes_;
  TransferVector<int32_t> places_;
  TransferVector<float> depths_;
  BandLayout layout_;
  PixelPaths paths_;
  PlaceTokens placeTokens_;
  ColorPlanes colorPlanes_;
};

}  // namespace warpscope
