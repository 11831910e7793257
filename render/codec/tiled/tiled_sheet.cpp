// Models, streams.
// See tiled_sheet.h.
#include "render/codec/tiled/tiled_sheet.h"

#include <algorithm>
#include <mutex>

#include "render/codec/tiled/symbol_counts.h"
#include "render/codec/tokens.h"
#include "render/core/parallel.h"

namespace warpscope {
namespace {

using Counts = std::array<uint32_t, kAnsSymbols>;

bool hasStreams(const SheetTile& tile) {
  return tile.layerCount > 0 || std::ranges::any_of(tile.shapes, [](const auto& shape) { return std::ranges::any_of(shape, [](uint8_t symbol) { return symbol != 0; }); });
}

/// Of a tile, model by model.
void countSymbolsOf(const SheetForm& form, const SheetTile& tile, std::span<SymbolCounts> counts) {
  if (!hasStreams(tile)) return;
  for (uint32_t shape = 0; shape < form.shapes; ++shape) counts[shape].add(tile.shapes[shape]);
  for (uint32_t l = 0; l < tile.layerCount; ++l) {
    const WrittenLayer& layer = tile.layers[l];
    SymbolCounts* own = counts.data() + form.shapes + size_t{l} * form.planes();
    for (uint32_t plane = 0; plane < form.numbers; ++plane) own++->add(layer.token(plane));
    for (uint32_t plane = 0; plane < form.bytes; ++plane) own++->add(layer.byte(plane));
  }
}

/// Of all models in their order.
std::vector<Counts> countSymbols(const SheetForm& form, std::span<const SheetTile> tiles, uint32_t layers) {
  std::vector<Counts> all(form.shapes + size_t{layers} * form.planes());
  std::mutex mutex;
  constexpr size_t kFewTiles = 16;  // that are not worth counts of their own
  parallelForRanges(tiles.size(), kFewTiles, [&](size_t begin, size_t end) {
    std::vector<SymbolCounts> own(all.size());
    for (const SheetTile& tile : tiles.subspan(begin, end - begin)) countSymbolsOf(form, tile, own);
    const std::scoped_lock lock(mutex);
    for (size_t model = 0; model < all.size(); ++model) own[model].addTo(all[model]);
  });
  return all;
}

/// The streams of one tile, one behind the other.
struct PackedTile {
  ByteVector bytes;
  std::vector<uint32_t> lengths;

  void pack(const SheetForm& form, const SheetTile& tile, std::span<const AnsWriterModel> models, AnsWriter& writer) {
    if (!hasStreams(tile)) return;
    for (uint32_t layer = 0; layer < std::max(tile.layerCount, 1u); ++layer) {
      writer.begin();
      if (layer < tile.layerCount) {
        const WrittenLayer& planes = tile.layers[layer];
        const AnsWriterModel* const own = models.data() + form.shapes + size_t{layer} * form.planes();
        for (uint32_t plane = form.bytes; plane-- > 0;) writer.putBytes(own[form.numbers + plane], planes.byte(plane));
        for (uint32_t plane = form.numbers; plane-- > 0;) writer.putNumbers(own[plane], planes.number(plane), planes.token(plane));
      }
      if (layer == 0)
        for (uint32_t shape = form.shapes; shape-- > 0;) writer.putBytes(models[shape], tile.shapes[shape]);
      const size_t start = bytes.size();
      writer.finish(bytes);
      lengths.push_back(static_cast<uint32_t>(bytes.size() - start));
    }
  }
};

}  // namespace

void WrittenLayer::take(SheetLayer& layer) {
  size = layer.size;
  tokens.resize(layer.numbers.size());
  numbers.resize(layer.numbers.size());
  for (size_t begin = 0; begin < tokens.size(); begin += size) {
    const auto own = std::span<const uint32_t>(layer.numbers).subspan(begin, size);
    if (findTokens(own, std::span(tokens).subspan(begin, size))) std::ranges::copy(own, numbers.begin() + static_cast<std::ptrdiff_t>(begin));
  }
  bytes.swap(layer.bytes);
}

uint64_t mostSheetBytes(const SheetForm& form, const TileGrid& grid, uint64_t shapeSymbols, uint64_t values, uint64_t layers) {
  // A state grows by at most the scale for each symbol, and a sixteenth of that: it is at least 16 times the frequency.
  constexpr uint64_t kSymbolBits = kAnsBits + 1;
  const uint64_t bits = shapeSymbols * kSymbolBits + values * (form.planes() * kSymbolBits + form.numbers * kMostTokenBits);
  const uint64_t streams = grid.count() * std::max<uint64_t>(layers, 1);
  return 1 + (form.shapes + layers * form.planes()) * AnsModel::kMostBytes + grid.count() + streams * (sizeof(uint32_t) + kAnsStateBytes) + bits / 8 + 1;
}

void appendSheet(ByteVector& out, const SheetForm& form, std::span<const SheetTile> tiles) {
  uint32_t layers = 0;
  for (const SheetTile& tile : tiles) layers = std::max(layers, tile.layerCount);
  std::vector<AnsModel> models;
  for (const Counts& counts : countSymbols(form, tiles, layers)) models.push_back(AnsModel::ofCounts(counts));

  std::vector<AnsWriterModel> writerModels(models.begin(), models.end());
  std::vector<PackedTile> packed(tiles.size());
  parallelForRanges(tiles.size(), 1, [&](size_t begin, size_t end) {
    AnsWriter writer;
    for (size_t tile = begin; tile < end; ++tile) packed[tile].pack(form, tiles[tile], writerModels, writer);
  });

  std::vector<uint8_t> streams;
  std::vector<uint32_t> lengths;
  size_t total = 0;
  for (const PackedTile& tile : packed) {
    streams.push_back(static_cast<uint8_t>(tile.lengths.size()));
    lengths.insert(lengths.end(), tile.lengths.begin(), tile.lengths.end());
    total += tile.bytes.size();
  }
  appendSheetHead(out, layers, models, streams, lengths);
  out.reserve(out.size() + total);
  for (const PackedTile& tile : packed) out.insert(out.end(), tile.bytes.begin(), tile.bytes.end());
}

void appendSheetHead(ByteVector& out, uint32_t layers, std::span<const AnsModel> models, std::span<const uint8_t> streamsOfTiles, std::span<const uint32_t> lengths) {
  appendLittle(out, static_cast<uint8_t>(layers));
  for (const AnsModel& model : models) model.append(out);
  for (const uint8_t streams : streamsOfTiles) appendLittle(out, streams);
  std::byte* at = grown(out, lengths.size_bytes());
  for (const uint32_t length : lengths) {
    storeLittle(at, length);
    at += sizeof length;
  }
}

DecodeError SheetHead::take(ByteReader& reader, const SheetForm& theForm, uint32_t tiles, uint32_t mostLayers) {
  form = theForm;
  layers = reader.take<uint8_t>();
  if (layers > mostLayers) return "the tiles have more layers than the frame's rays have";
  models.resize(form.shapes + size_t{layers} * form.planes());
  for (AnsModel& model : models)
    if (!model.take(reader)) return "a model of the tiles is damaged";
  starts.assign(1, 0);
  for (uint32_t tile = 0; tile < tiles; ++tile) {
    const auto own = reader.take<uint8_t>();
    if (own > std::max<uint32_t>(layers, 1)) return "a tile has more streams than there are layers";
    starts.push_back(starts.back() + own);
  }
  if (reader.left() / sizeof(uint32_t) < starts.back()) return "the tiles end within the list of their streams";
  ByteReader lengths(reader.take(sizeof(uint32_t) * starts.back()));
  streams.clear();
  for (uint32_t stream = 0; stream < starts.back(); ++stream) streams.push_back(reader.take(lengths.take<uint32_t>()));
  if (reader.ranOut() || reader.left() > 0) return "the streams of the tiles have other lengths than their list says";
  return std::nullopt;
}

DecodeError SheetReader::begin(ByteReader& reader, const SheetForm& form, uint32_t tiles, uint32_t mostLayers) {
  if (DecodeError error = head_.take(reader, form, tiles, mostLayers)) return error;
  models_.clear();
  for (const AnsModel& model : head_.models) models_.emplace_back(model);
  return std::nullopt;
}

bool SheetReader::takeLayer(AnsReader& stream, uint32_t layer, size_t size, SheetLayer& planes) const {
  if (size > 0 && layer >= head_.layers) return false;
  planes.resize(head_.form, size);
  for (uint32_t plane = 0; plane < head_.form.numbers && size > 0; ++plane) stream.takeNumbers(number(layer, plane), planes.number(plane));
  for (uint32_t plane = 0; plane < head_.form.bytes && size > 0; ++plane) stream.takeBytes(byte(layer, plane), planes.byte(plane));
  return stream.isSound();
}

bool SheetReader::takeFronts(const std::array<AnsReader*, 2>& streams, const std::array<size_t, 2>& sizes, std::array<SheetLayer, 2>& planes) const {
  if (sizes[0] == 0 || sizes[1] == 0) return takeLayer(*streams[0], 0, sizes[0], planes[0]) && takeLayer(*streams[1], 0, sizes[1], planes[1]);
  if (head_.layers == 0) return false;
  for (size_t i = 0; i < 2; ++i) planes[i].resize(head_.form, sizes[i]);
  for (uint32_t plane = 0; plane < head_.form.numbers; ++plane)
    AnsReader::takeNumbers(number(0, plane), *streams[0], planes[0].number(plane), *streams[1], planes[1].number(plane));
  for (uint32_t plane = 0; plane < head_.form.bytes; ++plane)
    AnsReader::takeBytes(byte(0, plane), *streams[0], planes[0].byte(plane), *streams[1], planes[1].byte(plane));
  return streams[0]->isSound() && streams[1]->isSound();
}

}  // namespace warpscope
