// The samples of one tile as what a sheet has of it, and back.
// The planes are described in tiled_samples.h.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "render/codec/pixel_path.h"
#include "render/codec/tiled/tile_layer.h"
#include "render/codec/tiled/tile_rows.h"
#include "render/codec/tiled/tiled_sheet.h"

namespace warpscope {

enum class SampleNumbers : uint32_t { place, depth, radius, count };
enum class SampleBytes : uint32_t { alpha, green, red, blue, count };

/// Of the samples of a frame with or without kLayerPlane.
constexpr SheetForm sampleForm(bool hasLayers) {
  return {hasLayers ? 2u : 1u, static_cast<uint32_t>(SampleNumbers::count), static_cast<uint32_t>(SampleBytes::count)};
}

/// One tile at a time; keeps its buffers.
class TileSamples {
 public:
  /// Fills what the sheet has of the tile. `rows`: of each of its rows. The frame's samples are in order (frame_order.h).
  /// Returns what these add to their hash (summed_hash.h).
  uint64_t pack(const SampleFrame& frame, Placement placement, const TileRect& rect, std::span<const RowPart> rows, SheetTile& tile);

  /// Fills `counts` (samples of each pixel) from the tile's shapes, which the stream begins with. False if they are none of a tile whose pixels have at most `most`
  /// samples, and which has so many streams.
  bool takeShapes(const SheetReader& reader, uint32_t tile, const TileRect& rect, bool hasLayers, uint32_t most, AnsReader& stream, std::span<uint8_t> counts);
  /// Reads what the front layers of two tiles have, for unpack(). Streams are behind their shapes. False if one is damaged.
  bool takeFronts(const SheetReader& reader, const std::array<AnsReader*, 2>& streams, const std::array<size_t, 2>& sizes) { return reader.takeFronts(streams, sizes, fronts_); }
  /// Fills the tile's samples and colours, and their layers unless there is no room for any. `front`: which of the two it is that takeFronts() was given. Returns what
  /// the samples add to their hash; nothing if a stream is damaged.
  std::optional<uint64_t> unpack(const SheetReader& reader, uint32_t tile, const TileRect& rect, std::span<const uint8_t> counts,
                                 std::span<const RowPart> rows, Placement placement, size_t front, SampleFrame& frame,
                                 std::span<uint8_t> layers);

 private:
  void countSamples(const SampleFrame& frame, const TileRect& rect, std::span<const RowPart> rows, bool hasLayers);
  void goBehind();

  TileLayer layer_;
  PixelPaths paths_;
  std::array<SheetLayer, 2> fronts_;
  SheetLayer planes_;
  TransferVector<uint8_t> counts_, symbols_;
  TransferVector<uint32_t> at_;  // of each element of the layer, its ray's first sample among the frame's; none where rays have one each
  TransferVector<PackedSample> samples_;
  TransferVector<Rgba8> slots_, differences_;
  TransferVector<int32_t> places_, fine_;
  TransferVector<uint32_t> codes_;
};

}  // namespace warpscope
