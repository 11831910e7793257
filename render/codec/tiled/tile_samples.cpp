// Shapes and layers of samples. Loops over values read and write through locals only: what they write cannot be what they read then.
// See tile_samples.h.
#include "render/codec/tiled/tile_samples.h"

#include <algorithm>

#include "render/codec/color_differences.h"
#include "render/codec/place_differences.h"
#include "render/codec/radius_prediction.h"
#include "render/codec/tiled/covered_bits.h"
#include "render/codec/tiled/sheet_colors.h"
#include "render/codec/tokens.h"

namespace warpscope {
namespace {

size_t planeOf(SampleNumbers plane) { return static_cast<size_t>(plane); }

/// Each row changed by the row above.
void putMask(std::span<const uint8_t> counts, const TileRect& rect, TransferVector<uint8_t>& changes) {
  const uint32_t rowBytes = rect.maskRowBytes();
  changes.resize(size_t{rowBytes} * rect.height);
  for (uint32_t y = 0; y < rect.height; ++y)
    for (uint32_t byte = 0; byte < rowBytes; ++byte)
      changes[size_t{y} * rowBytes + byte] = static_cast<uint8_t>(coveredBits(counts.data() + size_t{y} * rect.width + 8 * byte, std::min(rect.width - 8 * byte, 8u)));
  for (size_t i = changes.size(); i-- > rowBytes;) changes[i] ^= changes[i - rowBytes];
}

/// Sets counts to 1 or 0. False if the mask has bits outside.
bool takeMask(std::span<uint8_t> changes, const TileRect& rect, std::span<uint8_t> counts) {
  const uint32_t rowBytes = rect.maskRowBytes(), unused = 8 * rowBytes - rect.width;
  for (size_t i = rowBytes; i < changes.size(); ++i) changes[i] ^= changes[i - rowBytes];
  for (uint32_t y = 0; y < rect.height; ++y) {
    const uint8_t* const row = changes.data() + size_t{y} * rowBytes;
    if (row[rowBytes - 1] >> (8 - unused) != 0) return false;
    for (uint32_t byte = 0; byte < rowBytes; ++byte) spreadBits(row[byte], counts.data() + size_t{y} * rect.width + 8 * byte, std::min(rect.width - 8 * byte, 8u));
  }
  return true;
}

/// Differences of radius codes: from what the rule says, or where there is none from those beside.
void putRadii(const RadiusPrediction& radius, std::span<const Neighbors> neighbors, std::span<const PackedSample> samples, const Rgba8* colors, int32_t* slots, uint32_t* out) {
  if (!radius.isAsBefore()) {
    for (size_t k = 0; k < samples.size(); ++k)
      out[k] = zigzag(static_cast<int32_t>(radiusCode(samples[k])) - static_cast<int32_t>(radius(samples[k], colors[k], 0)));
    return;
  }
  for (size_t k = 0; k < samples.size(); ++k) slots[k + 1] = static_cast<int32_t>(radiusCode(samples[k]));
  for (size_t k = 0; k < samples.size(); ++k) out[k] = zigzag(slots[k + 1] - predictedSlot(slots, neighbors[k]));
}

void takeRadii(const RadiusPrediction& radius, std::span<const Neighbors> neighbors, const uint32_t* differences, const Rgba8* colors, int32_t* slots,
               std::span<PackedSample> samples) {
  for (size_t k = 0; k < samples.size(); ++k) {
    const auto likely = radius.isAsBefore() ? static_cast<uint32_t>(predictedSlot(slots, neighbors[k])) : radius(samples[k], colors[k], 0);
    const uint32_t code = (likely + static_cast<uint32_t>(unzigzag(differences[k]))) & kRadiusCodeMax;
    slots[k + 1] = static_cast<int32_t>(code);
    samples[k] = withRadiusCode(samples[k], code);
  }
}

}  // namespace

void TileSamples::goBehind() {
  const std::span<const uint32_t> kept = layer_.kept();
  for (size_t k = 0; k < kept.size(); ++k) at_[k] = at_[kept[k]];
  at_.resize(kept.size());
  paths_.narrow(kept);
}

void TileSamples::pack(const SampleFrame& frame, Placement placement, const TileRect& rect, std::span<const RowPart> rows, SheetTile& tile) {
  counts_.assign(rect.pixels(), 0);
  at_.clear();
  for (uint32_t y = 0; y < rect.height; ++y)
    for (uint32_t i = rows[y].begin; i < rows[y].end; ++i) {
      uint8_t& count = counts_[size_t{y} * rect.width + columnOf(frame.samples[i]) - rect.x0];
      if (count++ == 0) at_.push_back(i);
    }
  const bool hasLayers = !frame.layers().empty();
  const SheetForm form = sampleForm(hasLayers);
  tile.layerCount = 0;
  putMask(counts_, rect, tile.shapes[0]);
  if (at_.empty()) {
    tile.shapes[1].clear();
    return;
  }
  layer_.begin(rect, counts_);
  if (hasLayers) {
    tile.shapes[1].resize(layer_.size());
    uint8_t before = 0;
    for (size_t k = 0; k < layer_.size(); ++k) {
      const auto further = static_cast<uint8_t>(counts_[layer_.pixels()[k]] - 1);
      tile.shapes[1][k] = further ^ before;
      before = further;
    }
  }
  paths_.aim(frame, placement, layer_.columns(), layer_.rows());
  const RadiusPrediction radius(frame);
  for (uint32_t l = 0;; ++l) {
    const size_t size = layer_.size();
    samples_.resize(size);
    places_.resize(size);
    codes_.resize(size);
    slots_.resize(size + 1);
    fine_.resize(size + 1);
    slots_[0] = 0;
    fine_[0] = 0;
    for (size_t k = 0; k < size; ++k) {
      samples_[k] = frame.samples[at_[k] + l];
      slots_[k + 1] = frame.colors[at_[k] + l];
    }
    paths_.locate(samples_, places_);
    paths_.place(places_, codes_);
    SheetLayer& planes = tile.addLayer();
    planes.resize(form, size);
    putPlaces(paths_.fineScale(), layer_.neighbors().data(), places_, fine_.data(), planes.number(planeOf(SampleNumbers::place)).data());
    {
      const std::span<uint32_t> differences = planes.number(planeOf(SampleNumbers::depth));
      for (size_t k = 0; k < size; ++k) differences[k] = zigzag(static_cast<int32_t>(depthCode(samples_[k])) - static_cast<int32_t>(codes_[k]));
    }
    putRadii(radius, layer_.neighbors(), samples_, slots_.data() + 1, fine_.data(), planes.number(planeOf(SampleNumbers::radius)).data());
    putColors(slots_.data(), layer_.neighbors().data(), size, differencesIn<SampleBytes>(planes));
    if (!layer_.goBehind()) return;
    goBehind();
  }
}

bool TileSamples::takeShapes(const SheetReader& reader, uint32_t tile, const TileRect& rect, bool hasLayers, uint32_t most, AnsReader& stream, std::span<uint8_t> counts) {
  const uint32_t streams = reader.streams(tile);
  if (streams == 0) {
    std::ranges::fill(counts, uint8_t{0});
    return true;
  }
  stream = reader.stream(tile, 0);
  symbols_.resize(size_t{rect.maskRowBytes()} * rect.height);
  stream.takeBytes(reader.shape(0), symbols_);
  if (!takeMask(symbols_, rect, counts)) return false;
  uint32_t deepest = 0;
  for (const uint8_t count : counts) deepest = std::max<uint32_t>(deepest, count);
  if (hasLayers) {
    size_t covered = 0;
    for (const uint8_t count : counts) covered += count;
    symbols_.resize(covered);
    stream.takeBytes(reader.shape(1), symbols_);
    size_t k = 0;
    uint8_t further = 0;
    for (uint8_t& count : counts) {
      if (count == 0) continue;
      further ^= symbols_[k++];
      if (further >= most) return false;
      count = static_cast<uint8_t>(1 + further);
      deepest = std::max<uint32_t>(deepest, count);
    }
  }
  return deepest == streams && deepest <= reader.layers();
}

bool TileSamples::unpack(const SheetReader& reader, uint32_t tile, const TileRect& rect, std::span<const uint8_t> counts, std::span<const RowPart> rows,
                         Placement placement, AnsReader& stream, SampleFrame& frame, std::span<uint8_t> layers) {
  const uint32_t streams = reader.streams(tile);
  if (streams == 0) return true;
  layer_.begin(rect, counts);
  findFirsts(counts, rect, rows, at_);
  paths_.aim(frame, placement, layer_.columns(), layer_.rows());
  const RadiusPrediction radius(frame);
  for (uint32_t l = 0; l < streams; ++l) {
    const size_t size = layer_.size();
    AnsReader behind;
    if (l > 0) behind = reader.stream(tile, l);
    if (!reader.takeLayer(l > 0 ? behind : stream, l, size, planes_)) return false;
    places_.resize(size);
    codes_.resize(size);
    slots_.resize(size + 1);
    fine_.resize(size + 1);
    samples_.resize(size);
    slots_[0] = 0;
    fine_[0] = 0;
    const std::span<const uint32_t> ofPlaces = planes_.number(planeOf(SampleNumbers::place));
    takePlaces(paths_.fineScale(), layer_.neighbors().data(), [ofPlaces](size_t k) { return ofPlaces[k]; }, fine_.data(), places_);
    paths_.place(places_, codes_);
    {
      const std::span<const uint32_t> differences = planes_.number(planeOf(SampleNumbers::depth));
      for (size_t k = 0; k < size; ++k) {
        const uint32_t code = (codes_[k] + static_cast<uint32_t>(unzigzag(differences[k]))) & kDepthCodeMax;
        samples_[k] = packCodes(layer_.columns()[k], layer_.rows()[k], code, 0);
      }
    }
    takeColors(differencesIn<SampleBytes>(planes_), layer_.neighbors().data(), size, slots_.data());
    takeRadii(radius, layer_.neighbors(), planes_.number(planeOf(SampleNumbers::radius)).data(), slots_.data() + 1, fine_.data(), samples_);
    for (size_t k = 0; k < size; ++k) {
      frame.samples[at_[k] + l] = samples_[k];
      frame.colors[at_[k] + l] = slots_[k + 1];
    }
    if (!layers.empty())
      for (size_t k = 0; k < size; ++k) layers[at_[k] + l] = static_cast<uint8_t>(l);
    if (l + 1 == streams) break;
    layer_.goBehind();
    goBehind();
  }
  return true;
}

}  // namespace warpscope
