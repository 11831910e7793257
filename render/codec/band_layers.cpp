// Counting, out of the order of pixels, and back. Loops read and write through locals only: what they write cannot be
// what they read then. See band_layers.h.
#include "render/codec/band_layers.h"

namespace warpscope {

void setBits(std::span<const uint32_t> pixels, const MaskShape& shape, std::span<uint8_t> mask) {
  const uint32_t width = shape.width, rowBytes = shape.rowBytes();
  uint8_t* const byteOf = mask.data();
  uint32_t rowStart = shape.firstRow * width;
  size_t rowAt = 0, at = 0;
  uint32_t bits = 0;  // of the byte at `at`
  for (const uint32_t pixel : pixels) {
    while (pixel - rowStart >= width) {
      rowStart += width;
      rowAt += rowBytes;
    }
    const uint32_t column = pixel - rowStart;
    const size_t byte = rowAt + column / 8;
    if (byte != at) {
      byteOf[at] |= static_cast<uint8_t>(bits);
      bits = 0;
      at = byte;
    }
    bits |= 1u << column % 8;
  }
  if (bits != 0) byteOf[at] |= static_cast<uint8_t>(bits);
}

bool BandLayers::begin(std::span<const uint32_t> pixels) {
  const size_t count = pixels.size();
  layer_ = 0;
  covered_.resize(count);
  behind_.resize(count);
  at_.resize(count);
  uint32_t* const pixelOf = covered_.data();
  uint8_t* const behindOf = behind_.data();
  uint32_t* const atOf = at_.data();
  uint32_t last = kNoSample, rank = 0, deepest = 0;
  size_t found = 0;
  for (size_t i = 0; i < count; ++i) {
    const uint32_t pixel = pixels[i];
    const bool isNext = pixel != last;
    rank = isNext ? 0 : rank + 1;
    deepest = rank > deepest ? rank : deepest;
    found += isNext;
    pixelOf[found - 1] = pixel;
    behindOf[found - 1] = static_cast<uint8_t>(rank);
    atOf[found - 1] = static_cast<uint32_t>(i) - rank;
    last = pixel;
  }
  covered_.resize(found);
  behind_.resize(found);
  at_.resize(found);
  return deepest > 0;
}

void BandLayers::begin(std::span<const uint32_t> columns, std::span<const uint32_t> rows, uint32_t width,
                       std::span<const uint8_t> further) {
  const size_t count = columns.size();
  layer_ = 0;
  covered_.resize(count);
  behind_.assign(further.begin(), further.end());
  at_.resize(count);
  uint32_t at = 0;
  for (size_t j = 0; j < count; ++j) {
    covered_[j] = rows[j] * width + columns[j];
    at_[j] = at;
    at += 1u + further[j];
  }
}

bool BandLayers::goBehind(const MaskShape& shape) {
  const size_t count = covered_.size();
  uint32_t* const pixelOf = covered_.data();
  uint8_t* const behindOf = behind_.data();
  uint32_t* const atOf = at_.data();
  size_t left = 0;
  for (size_t j = 0; j < count; ++j) {
    const uint8_t more = behindOf[j];
    pixelOf[left] = pixelOf[j];
    atOf[left] = atOf[j] + 1;
    behindOf[left] = static_cast<uint8_t>(more - 1);
    left += more > 0;
  }
  covered_.resize(left);
  behind_.resize(left);
  at_.resize(left);
  mask_.assign(shape.size(), 0);
  setBits(covered_, shape, mask_);
  ++layer_;
  return left > 0;
}

void BandLayers::gather(std::span<const PackedSample> samples, std::span<const Rgba8> colors) {
  const size_t count = at_.size();
  samples_.resize(count);
  colors_.resize(count);
  const uint32_t* const at = at_.data();
  const PackedSample* const sample = samples.data();
  const Rgba8* const color = colors.data();
  PackedSample* const itsSample = samples_.data();
  Rgba8* const itsColor = colors_.data();
  for (size_t j = 0; j < count; ++j) {
    itsSample[j] = sample[at[j]];
    itsColor[j] = color[at[j]];
  }
}

void BandLayers::scatter(std::span<const PackedSample> itsSamples, std::span<const Rgba8> itsColors,
                         std::span<PackedSample> samples, std::span<Rgba8> colors, std::span<uint8_t> layers) const {
  const size_t count = at_.size();
  const uint32_t* const at = at_.data();
  const PackedSample* const itsSample = itsSamples.data();
  const Rgba8* const itsColor = itsColors.data();
  PackedSample* const sample = samples.data();
  Rgba8* const color = colors.data();
  for (size_t j = 0; j < count; ++j) {
    sample[at[j]] = itsSample[j];
    color[at[j]] = itsColor[j];
  }
  if (layers.empty()) return;
  uint8_t* const layer = layers.data();
  for (size_t j = 0; j < count; ++j) layer[at[j]] = layer_;
}

}  // namespace warpscope
