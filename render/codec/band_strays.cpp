// Out of the order of pixels, and back.
// See band_strays.h.
#include "render/codec/band_strays.h"

#include "render/codec/zstd_section.h"

namespace warpscope {
namespace {

constexpr size_t kWordBytes = sizeof(PackedSample);

}  // namespace

void BandStrays::clear() {
  samples_.clear();
  colors_.clear();
  layers_.clear();
  isStray_.clear();
}

void BandStrays::takeAll(const SampleFrame& frame, size_t begin, size_t count) {
  const auto copied = [begin, count](const auto& from, auto& to) {
    const auto first = from.begin() + static_cast<std::ptrdiff_t>(begin);
    to.assign(first, first + static_cast<std::ptrdiff_t>(count));
  };
  copied(frame.samples, samples_);
  copied(frame.colors, colors_);
  layers_.clear();
  if (const std::span<const uint8_t> layers = frame.layers(); !layers.empty()) copied(layers, layers_);
  isStray_.assign((count + 7) / 8, 0);
  for (size_t i = 0; i < count; ++i) isStray_[i / 8] |= static_cast<uint8_t>(1u << i % 8);
}

void BandStrays::takeOut(const SampleFrame& frame, size_t begin, std::span<const uint32_t> pixels) {
  const size_t count = pixels.size();
  const std::span<const uint8_t> layers = frame.layers();
  clear();
  onPath_.resize(count);
  pathColors_.resize(count);
  pathPixels_.resize(count);
  isStray_.assign((count + 7) / 8, 0);
  size_t placed = 0;
  for (size_t i = 0; i < count; ++i) {
    if (pixels[i] == kNoSample) {
      isStray_[i / 8] |= static_cast<uint8_t>(1u << i % 8);
      samples_.push_back(frame.samples[begin + i]);
      colors_.push_back(frame.colors[begin + i]);
      if (!layers.empty()) layers_.push_back(layers[begin + i]);
      continue;
    }
    onPath_[placed] = frame.samples[begin + i];
    pathColors_[placed] = frame.colors[begin + i];
    pathPixels_[placed++] = pixels[i];
  }
  onPath_.resize(placed);
  pathColors_.resize(placed);
  pathPixels_.resize(placed);
}

void BandStrays::append(std::vector<std::byte>& out) {
  if (samples_.empty()) return;
  appendSection(out, isStray_);
  bytes_.resize(samples_.size() * kWordBytes);
  for (size_t byte = 0; byte < kWordBytes; ++byte)
    for (size_t i = 0; i < samples_.size(); ++i)
      bytes_[byte * samples_.size() + i] = static_cast<uint8_t>(samples_[i] >> 8 * byte);
  appendSection(out, bytes_);
  if (!layers_.empty()) appendSection(out, layers_);
}

DecodeError BandStrays::take(ByteReader& reader, size_t count, size_t strayCount, bool hasLayers) {
  clear();
  if (strayCount == 0) return std::nullopt;
  layers_.resize(hasLayers ? strayCount : 0);
  isStray_.resize((count + 7) / 8);
  bytes_.resize(strayCount * kWordBytes);
  if (!takeSection(reader, isStray_) || !takeSection(reader, bytes_))
    return "a band's samples without place are damaged";
  if (hasLayers && !takeSection(reader, layers_)) return "the layers of a band's samples without place are damaged";
  size_t marked = 0;
  for (size_t i = 0; i < count; ++i) marked += isStray_[i / 8] >> i % 8 & 1;
  if (marked != strayCount) return "a band's samples without place are not as many as it says";
  samples_.assign(strayCount, PackedSample{0});
  for (size_t byte = 0; byte < kWordBytes; ++byte)
    for (size_t i = 0; i < strayCount; ++i)
      samples_[i] |= static_cast<uint64_t>(bytes_[byte * strayCount + i]) << 8 * byte;
  return std::nullopt;
}

std::span<PackedSample> BandStrays::roomOnPath(size_t count) {
  onPath_.resize(count);
  return onPath_;
}

std::span<Rgba8> BandStrays::roomForColors(size_t count) {
  pathColors_.resize(count);
  return pathColors_;
}

void BandStrays::merge(std::span<PackedSample> samples, std::span<Rgba8> colors, std::span<uint8_t> layers) const {
  // From the end: layers on paths move to where they belong within the same memory.
  size_t path = onPath_.size(), stray = samples_.size();
  for (size_t i = samples.size(); i-- > 0;) {
    const bool isStray = isStray_[i / 8] >> i % 8 & 1;
    --(isStray ? stray : path);
    samples[i] = isStray ? samples_[stray] : onPath_[path];
    colors[i] = isStray ? colors_[stray] : pathColors_[path];
    if (!layers.empty()) layers[i] = isStray ? layers_[stray] : layers[path];
  }
}

}  // namespace warpscope
