// Counting, sorting, and back. Loops read and write through locals only: what they write cannot be what they read then.
// See band_layers.h.
#include "render/codec/band_layers.h"

#include <algorithm>

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
  uint32_t* const pixelOf = covered_.data();
  uint8_t* const behindOf = behind_.data();
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
    last = pixel;
  }
  covered_.resize(found);
  behind_.resize(found);
  return deepest > 0;
}

void BandLayers::begin(std::span<const uint32_t> columns, std::span<const uint32_t> rows, uint32_t width,
                       std::span<const uint8_t> further, size_t samples) {
  layer_ = 0;
  covered_.resize(columns.size());
  for (size_t j = 0; j < columns.size(); ++j) covered_[j] = rows[j] * width + columns[j];
  behind_.assign(further.begin(), further.end());
  samples_.resize(samples);
  colors_.resize(samples);
  begins_[0] = 0;
}

bool BandLayers::goBehind(const MaskShape& shape) {
  size_t left = 0;
  for (size_t j = 0; j < covered_.size(); ++j) {
    covered_[left] = covered_[j];
    const uint8_t more = behind_[j];
    behind_[left] = static_cast<uint8_t>(more - 1);
    left += more > 0;
  }
  covered_.resize(left);
  behind_.resize(left);
  mask_.assign(shape.size(), 0);
  setBits(covered_, shape, mask_);
  ++layer_;
  return left > 0;
}

void BandLayers::sort(std::span<const uint32_t> pixels, std::span<const PackedSample> samples,
                      std::span<const Rgba8> colors) {
  const size_t count = pixels.size();
  samples_.resize(count);
  colors_.resize(count);
  std::array<size_t, kMaxLayers + 1> sizes{};
  for (const uint8_t deepest : behind_) ++sizes[deepest];
  for (size_t layer = kMaxLayers; layer-- > 0;) sizes[layer] += sizes[layer + 1];  // pixels that are at least as deep
  begins_[0] = 0;
  for (size_t layer = 0; layer < kMaxLayers; ++layer) begins_[layer + 1] = begins_[layer] + sizes[layer];
  std::array<size_t, kMaxLayers + 1> next = begins_;
  PackedSample* const sorted = samples_.data();
  Rgba8* const sortedColors = colors_.data();
  const PackedSample* const sample = samples.data();
  const Rgba8* const color = colors.data();
  uint32_t last = kNoSample, rank = 0;
  for (size_t i = 0; i < count; ++i) {
    const uint32_t pixel = pixels[i];
    rank = pixel != last ? 0 : rank + 1;
    const size_t place = next[rank]++;
    sorted[place] = sample[i];
    sortedColors[place] = color[i];
    last = pixel;
  }
}

void BandLayers::put(std::span<const PackedSample> samples, std::span<const Rgba8> colors) {
  const auto to = static_cast<std::ptrdiff_t>(begins_[layer_]);
  std::copy(samples.begin(), samples.end(), samples_.begin() + to);
  std::copy_n(colors.begin(), samples.size(), colors_.begin() + to);
  begins_[layer_ + 1] = begins_[layer_] + samples.size();
}

void BandLayers::unsort(std::span<const uint8_t> further, std::span<PackedSample> samples, std::span<Rgba8> colors,
                        std::span<uint8_t> layers) const {
  std::array<size_t, kMaxLayers + 1> next = begins_;
  size_t at = 0;
  for (const uint32_t more : further)
    for (uint32_t rank = 0; rank <= more; ++rank, ++at) {
      const size_t place = next[rank]++;
      samples[at] = samples_[place];
      colors[at] = colors_[place];
      if (!layers.empty()) layers[at] = static_cast<uint8_t>(rank);
    }
}

}  // namespace warpscope
