// The colours of one layer of a band's samples as bytes.
// Alpha: differences from its prediction. Red, green, blue without loss: the same, green's difference taken off the others'. With loss: as a
// JPEG image of the area that the layer covers.
//
// Bytes: section of alpha, one byte a sample; with loss the JPEG's length (4) and the JPEG, else sections of green, red, blue.
#pragma once

#include <span>
#include <vector>

#include "render/codec/band_layout.h"
#include "render/codec/bytes.h"
#include "render/codec/codec.h"

namespace warpscope {

/// Keeps its buffers. Colours: of the samples in the layout's order.
class ColorPlaneCoder {
 public:
  /// The most bytes that append() appends for all layers of a band together, of which there are `layers` with `samples`.
  static uint64_t mostBytes(uint32_t width, uint32_t rows, uint64_t samples, uint64_t layers, ColorCoding coding);

  /// `firstRow` is the band's; `mask` is what the layout was built from, `rowBytes` a row.
  void append(ByteVector& out, const BandLayout& layout, uint32_t firstRow, std::span<const uint8_t> mask, uint32_t rowBytes,
              std::span<const Rgba8> colors, const CodecSettings& settings);

  /// Fills `colors`.
  DecodeError take(ByteReader& reader, const BandLayout& layout, uint32_t firstRow, ColorCoding coding, std::span<Rgba8> colors);

 private:
  TransferVector<uint8_t> alpha_, green_, red_, blue_;
  TransferVector<Rgba8> slots_;  // colours, one place on
  TransferVector<Rgba8> differences_;
  TransferVector<Rgba8> picture_;
};

}  // namespace warpscope
