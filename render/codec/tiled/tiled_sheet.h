// A picture's tiles as bytes, for samples and segments alike: what a tile says of its pixels (shapes), then layers of values in planes: numbers, whose size varies
// (tokens.h), and bytes. Every plane of every layer has one model for the whole picture (ans_model.h); every layer of a tile is one stream (ans_lanes.h), so
// that as many of them can be read at once. A tile's first stream begins with its shapes.
//
// Bytes: layers (1); models of shapes, then of each layer's planes; for each tile how many streams it has (1), where none says that all its shapes are zeros and it has no
// layers; of each stream its length (4); streams.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "render/codec/codec.h"
#include "render/codec/tiled/ans_lanes.h"
#include "render/codec/tiled/tile_grid.h"
#include "render/core/transfer_vector.h"

namespace warpscope {

/// What there is of one thing in such a picture.
struct SheetForm {
  uint32_t shapes = 1;  ///< 1 or 2
  uint32_t numbers = 0, bytes = 0;  ///< planes of a layer

  WARPSCOPE_HD constexpr uint32_t planes() const { return numbers + bytes; }
};

/// A layer of a tile: planes one after the other.
struct SheetLayer {
  size_t size = 0;  ///< values of each plane
  TransferVector<uint32_t> numbers;
  TransferVector<uint8_t> bytes;

  void resize(const SheetForm& form, size_t count) {
    size = count;
    numbers.resize(count * form.numbers);
    bytes.resize(count * form.bytes);
  }
  std::span<uint32_t> number(size_t plane) { return {numbers.data() + plane * size, size}; }
  std::span<const uint32_t> number(size_t plane) const { return {numbers.data() + plane * size, size}; }
  std::span<uint8_t> byte(size_t plane) { return {bytes.data() + plane * size, size}; }
  std::span<const uint8_t> byte(size_t plane) const { return {bytes.data() + plane * size, size}; }
};

/// The same as it is written: tokens of numbers, and the numbers of planes whose tokens leave something open.
struct WrittenLayer {
  size_t size = 0;
  TransferVector<uint8_t> tokens, bytes;
  TransferVector<uint32_t> numbers;

  /// Takes the bytes away.
  void take(SheetLayer& layer);
  std::span<const uint8_t> token(size_t plane) const { return {tokens.data() + plane * size, size}; }
  std::span<const uint8_t> byte(size_t plane) const { return {bytes.data() + plane * size, size}; }
  /// Anything where all the plane's tokens are below kDirectTokens.
  std::span<const uint32_t> number(size_t plane) const { return {numbers.data() + plane * size, size}; }
};

struct SheetTile {
  std::array<TransferVector<uint8_t>, 2> shapes;
  uint32_t layerCount = 0;
  std::vector<WrittenLayer> layers;  ///< at least layerCount: those behind are kept for the next picture

  /// The next one. Takes the bytes away.
  void addLayer(SheetLayer& layer) {
    if (layerCount == layers.size()) layers.emplace_back();
    layers[layerCount++].take(layer);
  }
};

/// The most bytes of such a picture with so many values a plane in all, of at most `layers` layers.
uint64_t mostSheetBytes(const SheetForm& form, const TileGrid& grid, uint64_t shapeSymbols, uint64_t values, uint64_t layers);

/// Appends the tiles of a grid, of at most 255 layers.
void appendSheet(ByteVector& out, const SheetForm& form, std::span<const SheetTile> tiles);

/// What bytes say before their streams are read.
struct SheetHead {
  SheetForm form;
  uint32_t layers = 0;
  std::vector<AnsModel> models;  ///< of shapes, then of each layer's planes
  std::vector<uint32_t> starts;  ///< of each tile's streams, and the end
  std::vector<std::span<const std::byte>> streams;  ///< one behind the other

  uint32_t streamsOf(uint32_t tile) const { return starts[tile + 1] - starts[tile]; }
  /// Reads all that is left. The bytes must stay.
  DecodeError take(ByteReader& reader, const SheetForm& theForm, uint32_t tiles, uint32_t mostLayers);
};
/// The same as bytes, but for the streams, whose lengths are given.
void appendSheetHead(ByteVector& out, uint32_t layers, std::span<const AnsModel> models, std::span<const uint8_t> streamsOfTiles, std::span<const uint32_t> lengths);

class SheetReader {
 public:
  /// As SheetHead::take.
  DecodeError begin(ByteReader& reader, const SheetForm& form, uint32_t tiles, uint32_t mostLayers);

  /// That models are there for.
  uint32_t layers() const { return head_.layers; }
  uint32_t streams(uint32_t tile) const { return head_.streamsOf(tile); }
  /// A layer below streams().
  AnsReader stream(uint32_t tile, uint32_t layer) const { return AnsReader(head_.streams[head_.starts[tile] + layer]); }

  const AnsReaderModel& shape(uint32_t plane) const { return models_[plane]; }
  /// Of a layer below streams() of any tile.
  const AnsReaderModel& number(uint32_t layer, uint32_t plane) const { return models_[head_.form.shapes + layer * head_.form.planes() + plane]; }
  const AnsReaderModel& byte(uint32_t layer, uint32_t plane) const { return number(layer, head_.form.numbers + plane); }
  /// Reads the planes of a layer that has `size` values; the stream is where they begin. False if the stream does not end behind them, or is damaged, or
  /// the sheet has no such layer.
  bool takeLayer(AnsReader& stream, uint32_t layer, size_t size, SheetLayer& planes) const;
  /// The same of the front layers of two tiles at once; false if either is.
  bool takeFronts(const std::array<AnsReader*, 2>& streams, const std::array<size_t, 2>& sizes, std::array<SheetLayer, 2>& planes) const;

 private:
  SheetHead head_;
  std::vector<AnsReaderModel> models_;
};

}  // namespace warpscope
