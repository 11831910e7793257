// The places of a band's samples as tokens and bits: how they differ from what their neighbours make likely.
// Prediction: see band_layout.h.
#pragma once

#include <cstdint>
#include <span>

#include "render/codec/band_layout.h"
#include "render/codec/pixel_path.h"
#include "render/codec/tokens.h"

namespace warpscope {

/// Keeps its buffers. `paths` and `layout` are of the same samples, of which there are as many as places and tokens.
class PlaceTokens {
 public:
  void put(const PixelPaths& paths, const BandLayout& layout, std::span<const int32_t> places, std::span<uint8_t> tokens, BitWriter& bits);
  /// Fills `places`, whatever the tokens are.
  void take(const PixelPaths& paths, const BandLayout& layout, std::span<const uint8_t> tokens, BitReader& bits, std::span<int32_t> places);

 private:
  TransferVector<int32_t> fine_;  // by slots, whose first is nobody's
  TransferVector<uint32_t> codes_;
};

}  // namespace warpscope
