// The segments of one tile as what a sheet has of them, and back.
// The planes are described in tiled_segments.h.
#pragma once

#include <span>

#include "render/codec/pixel_path.h"
#include "render/codec/tiled/tile_layer.h"
#include "render/codec/tiled/tile_rows.h"
#include "render/codec/tiled/tiled_sheet.h"

namespace warpscope {

enum class SegmentNumbers : uint32_t { begin, end, beginRest, endRest, count };
enum class SegmentBytes : uint32_t { alpha, green, red, blue, normalLow, normalHigh, count };

constexpr SheetForm segmentForm(bool hasNormals) {
  return {1, static_cast<uint32_t>(SegmentNumbers::count), static_cast<uint32_t>(hasNormals ? SegmentBytes::count : SegmentBytes::normalLow)};
}

/// One tile at a time; keeps its buffers.
class TileSegments {
 public:
  /// Fills what the sheet has of the tile. `rows`: where its rows' segments are among all.
  void pack(const SampleFrame& frame, Placement placement, const TileRect& rect, std::span<const RowPart> rows, SheetTile& tile);

  /// Fills the frame's rays of the tile from its shape, which the stream begins with. False if they have more than `most` segments, or another number of layers than
  /// the tile has streams.
  bool takeRays(const SheetReader& reader, uint32_t tile, const TileRect& rect, int most, AnsReader& stream, SampleFrame& frame);
  /// Fills the tile's segments, for which there is room. `stream` is behind the shape. False if a stream is damaged.
  bool unpack(const SheetReader& reader, uint32_t tile, const TileRect& rect, std::span<const RowPart> rows, Placement placement, AnsReader& stream, SampleFrame& frame);

 private:
  void begin(const SampleFrame& frame, Placement placement, const TileRect& rect, std::span<const RowPart> rows);
  void startLayer();
  bool goBehind();
  void putBorders(SheetLayer& planes, bool isFront);
  void takeBordersAndColors(SheetLayer& planes, bool isFront);

  TileLayer layer_;
  PixelPaths paths_;
  SheetLayer planes_;
  TransferVector<uint8_t> counts_;
  TransferVector<uint32_t> at_;  // of each element of the layer, its ray's first segment among the frame's
  TransferVector<int32_t> ends_;  // of each, where the segment in front ends
  TransferVector<uint32_t> codes_, endCodes_, likely_;
  TransferVector<int32_t> places_, endPlaces_;
  TransferVector<int32_t> fine_, endFine_;  // slots: of where they begin, or of the gaps in front of them; of where they end
  TransferVector<Rgba8> slots_, differences_;
};

}  // namespace warpscope
