// The samples of a band's pixels in layers: sample k of each pixel belongs to layer k. Layers are gone through from the
// front.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "render/core/sample.h"
#include "render/core/transfer_vector.h"
#include "render/march/march_settings.h"

namespace warpscope {

/// No band has more: as many as a ray may have samples. Each costs a decoder about as much as the first, however few
/// bytes say that it is there.
inline constexpr auto kMaxLayers = static_cast<size_t>(kSamplesPerRayRange.highest);

/// The rows of a picture that a mask has bits for, one for each pixel, the lowest first, whole bytes a row.
struct MaskShape {
  uint32_t width = 0;
  uint32_t firstRow = 0;
  uint32_t rowCount = 0;

  uint32_t rowBytes() const { return (width + 7) / 8; }
  size_t size() const { return size_t{rowBytes()} * rowCount; }
};

/// Sets the bits of pixels (row times width plus column) that rise.
void setBits(std::span<const uint32_t> pixels, const MaskShape& shape, std::span<uint8_t> mask);

/// Keeps its buffers. `pixels` are the picture's: row times width plus column.
class BandLayers {
 public:
  /// Begins with the front layer of samples whose pixels these are; none is before the one in front of it, and none
  /// more than kMaxLayers times the same. True if a pixel has further samples.
  bool begin(std::span<const uint32_t> pixels);
  /// The same, from the pixels that the front layer covers and how many further samples each of them has. Of as many
  /// samples in all.
  void begin(std::span<const uint32_t> columns, std::span<const uint32_t> rows, uint32_t width,
             std::span<const uint8_t> further, size_t samples);

  /// The pixels that the layer at work covers, and how many samples each has behind it.
  std::span<const uint32_t> covered() const { return covered_; }
  std::span<const uint8_t> behind() const { return behind_; }
  /// Of the layer at work, unless it is the front one.
  std::span<const uint8_t> mask() const { return mask_; }
  /// Goes on to the next layer: leaves out the pixels that have no sample there. False if no pixel is left.
  bool goBehind(const MaskShape& shape);

  /// Sorts samples into layers, while the front layer is at work. `pixels` are theirs.
  void sort(std::span<const uint32_t> pixels, std::span<const PackedSample> samples, std::span<const Rgba8> colors);
  /// What the layer at work has of them.
  std::span<const PackedSample> samples() const {
    return std::span(samples_).subspan(begins_[layer_], covered_.size());
  }
  std::span<const Rgba8> colors() const { return std::span(colors_).subspan(begins_[layer_], covered_.size()); }

  /// Keeps what the layer at work has.
  void put(std::span<const PackedSample> samples, std::span<const Rgba8> colors);
  /// Gives all layers' samples back in the order of pixels, and which layer each is of, unless `layers` is empty.
  void unsort(std::span<const uint8_t> further, std::span<PackedSample> samples, std::span<Rgba8> colors,
              std::span<uint8_t> layers) const;

 private:
  size_t layer_ = 0;
  TransferVector<uint32_t> covered_;
  TransferVector<uint8_t> behind_, mask_;
  // Layer after layer, and where each begins.
  TransferVector<PackedSample> samples_;
  TransferVector<Rgba8> colors_;
  std::array<size_t, kMaxLayers + 1> begins_{};
};

}  // namespace warpscope
