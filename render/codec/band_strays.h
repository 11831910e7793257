// Samples of a band that have no place in the order of its pixels: they are sent as they are, beside those on pixels'
// paths.
//
// Bytes, if there are any: sections (zstd_section.h) of which samples are strays, a bit each; strays, byte by byte: all
// lowest bytes first; their places along their rays if the frame says such (kLayerPlane), a byte each. Their colours
// are with those of the first layer.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/codec/bytes.h"
#include "render/codec/codec.h"
#include "render/march/sample_frame.h"

namespace warpscope {

/// Keeps its buffers.
class BandStrays {
 public:
  /// None.
  void clear();
  /// The `count` samples from `begin` on, all of them.
  void takeAll(const SampleFrame& frame, size_t begin, size_t count);
  /// Those of the samples from `begin` on whose pixel is kNoSample. The others are onPath(), pathColors(), pathPixels()
  /// then.
  void takeOut(const SampleFrame& frame, size_t begin, std::span<const uint32_t> pixels);

  size_t size() const { return samples_.size(); }
  std::span<const Rgba8> colors() const { return colors_; }
  std::span<const PackedSample> onPath() const { return onPath_; }
  std::span<const Rgba8> pathColors() const { return pathColors_; }
  std::span<const uint32_t> pathPixels() const { return pathPixels_; }

  void append(std::vector<std::byte>& out);

  /// The strays of a band of `count` samples, `strayCount` of them; `hasLayers`: the frame says places along rays.
  DecodeError take(ByteReader& reader, size_t count, size_t strayCount, bool hasLayers);
  void setColors(std::span<const Rgba8> colors) { colors_.assign(colors.begin(), colors.end()); }
  /// Room for the samples on paths, for merge().
  std::span<PackedSample> roomOnPath(size_t count);
  std::span<Rgba8> roomForColors(size_t count);
  /// Puts strays and the samples on paths where they belong. `layers`, if not empty, begins with those of the samples
  /// on paths.
  void merge(std::span<PackedSample> samples, std::span<Rgba8> colors, std::span<uint8_t> layers) const;

 private:
  TransferVector<PackedSample> samples_, onPath_;
  TransferVector<Rgba8> colors_, pathColors_;
  TransferVector<uint32_t> pathPixels_;
  TransferVector<uint8_t> isStray_, layers_, bytes_;
};

}  // namespace warpscope
