// The samples of a band's pixels in layers: sample k of each pixel belongs to layer k. Layers are gone through from the
// front.
#pragma once

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
  /// The same, from the pixels that the front layer covers and how many further samples each of them has.
  void begin(std::span<const uint32_t> columns, std::span<const uint32_t> rows, uint32_t width,
             std::span<const uint8_t> further);

  /// The pixels that the layer at work covers, and how many samples each has behind it.
  std::span<const uint32_t> covered() const { return covered_; }
  std::span<const uint8_t> behind() const { return behind_; }
  /// Of the layer at work, unless it is the front one.
  std::span<const uint8_t> mask() const { return mask_; }
  /// Goes on to the next layer: leaves out the pixels that have no sample there. False if no pixel is left.
  bool goBehind(const MaskShape& shape);

  /// Fills samples() and colors() with those of the layer at work, out of all, which are in the order of pixels.
  void gather(std::span<const PackedSample> samples, std::span<const Rgba8> colors);
  std::span<const PackedSample> samples() const { return samples_; }
  std::span<const Rgba8> colors() const { return colors_; }
  /// Puts those of the layer at work among all, and says which layer they are of, unless `layers` is empty.
  void scatter(std::span<const PackedSample> itsSamples, std::span<const Rgba8> itsColors,
               std::span<PackedSample> samples, std::span<Rgba8> colors, std::span<uint8_t> layers) const;

 private:
  uint8_t layer_ = 0;
  // Of the pixels that the layer covers: which they are, how many samples are behind, where the layer's is among all.
  TransferVector<uint32_t> covered_;
  TransferVector<uint8_t> behind_;
  TransferVector<uint32_t> at_;
  TransferVector<uint8_t> mask_;
  TransferVector<PackedSample> samples_;
  TransferVector<Rgba8> colors_;
};

}  // namespace warpscope
