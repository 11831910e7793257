// One layer of a band as bytes: at most one sample in each pixel. It is packed like a picture of its own: a sample is
// predicted from those to the left and above, by the median of both and of the plane through them (LOCO-I, Weinberger,
// Seroussi, Sapiro 2000).
//
// Bytes:
// - sections (zstd_section.h): tokens of the differences of places from their prediction, of depth codes from those of
//   their places, of radius codes from those that are likely
// - bits of places, depth codes, radii: length (4) and a section
// - alpha and colour (color_plane_coder.h)
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/codec/band_layers.h"
#include "render/codec/color_plane_coder.h"
#include "render/codec/pixel_path.h"
#include "render/codec/place_tokens.h"

namespace warpscope {

/// Keeps its buffers. `mask` says which pixels the layer covers.
class LayerPacker {
 public:
  /// The most bytes that append() appends for all layers of a band together, of which there are `layers` with `samples`.
  static uint64_t mostBytes(const MaskShape& shape, uint64_t samples, uint64_t layers, ColorCoding coding);

  /// `samples` are of the mask's pixels, in their order; `colors` are theirs.
  void append(ByteVector& out, const SampleFrame& frame, Placement placement, const MaskShape& shape,
              std::span<const uint8_t> mask, std::span<const PackedSample> samples, std::span<const Rgba8> colors,
              const CodecSettings& settings);

  /// Fills samples() and colors().
  DecodeError take(ByteReader& reader, const SampleFrame& frame, Placement placement, const MaskShape& shape,
                   std::span<const uint8_t> mask, ColorCoding coding);
  std::span<const PackedSample> samples() const { return positions_; }
  std::span<const Rgba8> colors() const { return colors_; }
  std::span<const uint32_t> columns() const { return layout_.columns; }
  std::span<const uint32_t> rows() const { return layout_.rows; }

 private:
  /// Makes positions_ of the layout's pixels and depthCodes_, changed as depthTokens_ say.
  void takePositions(BitReader& bits);

  TransferVector<PackedSample> positions_;
  TransferVector<Rgba8> colors_;
  TransferVector<uint8_t> tokens_, depthTokens_, radiusTokens_, bitBytes_;
  TransferVector<int32_t> places_;
  TransferVector<uint32_t> depthCodes_, differences_;
  BandLayout layout_;
  PixelPaths paths_;
  PlaceTokens placeTokens_;
  ColorPlaneCoder colorCoder_;
};

}  // namespace warpscope
