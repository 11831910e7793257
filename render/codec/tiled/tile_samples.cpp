// Shapes and layers of samples. Loops over values read and write through locals only: what they write cannot be what they read then.
// See tile_samples.h.
#include "render/codec/tiled/tile_samples.h"

#include <algorithm>

#include "render/codec/color_differences.h"
#include "render/codec/place_differences.h"
#include "render/codec/radius_prediction.h"
#include "render/codec/summed_hash.h"
#include "render/codec/tiled/covered_bits.h"
#include "render/codec/tiled/sheet_colors.h"
#include "render/codec/tiled/tile_making.h"
#include "render/codec/tokens.h"

namespace warpscope {
namespace {

size_t planeOf(SampleNumbers plane) { return static_cast<size_t>(plane); }

/// Each row changed by the row above.
void putMask(const TileLayer& front, const TileRect& rect, TransferVector<uint8_t>& changes) {
  const uint32_t rowBytes = rect.maskRowBytes();
  changes.resize(size_t{rowBytes} * rect.height);
  for (uint32_t y = 0; y < rect.height; ++y)
    for (uint32_t byte = 0; byte < rowBytes; ++byte) changes[size_t{y} * rowBytes + byte] = static_cast<uint8_t>(front.maskOf(y) >> 8 * byte);
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

/// f(number of the first element, where it is among the frame's samples, how many follow one another there) of what a tile has of a layer. `firsts`: where rays with
/// several samples begin; others have one each, row by row.
template <class F>
void forEachStretch(bool hasLayers, std::span<const uint32_t> firsts, uint32_t layer, std::span<const RowPart> rows, const F& f) {
  if (hasLayers) {
    for (size_t k = 0; k < firsts.size(); ++k) f(k, firsts[k] + layer, size_t{1});
    return;
  }
  size_t k = 0;
  for (const RowPart& part : rows) {
    f(k, part.begin, size_t{part.end - part.begin});
    k += part.end - part.begin;
  }
}

/// Differences of radius codes: from what the rule says, or where there is none from those beside.
void putRadii(const RadiusPrediction& radius, std::span<const NeighborRun> runs, std::span<const PackedSample> samples, const Rgba8* colors, int32_t* slots, uint32_t* out) {
  if (radius.isSame()) {
    const auto same = static_cast<int32_t>(radius.same());
    const PackedSample* const sample = samples.data();
    for (size_t k = 0; k < samples.size(); ++k) out[k] = zigzag(static_cast<int32_t>(radiusCode(sample[k])) - same);
    return;
  }
  if (!radius.isAsBefore()) {
    for (size_t k = 0; k < samples.size(); ++k)
      out[k] = zigzag(static_cast<int32_t>(radiusCode(samples[k])) - static_cast<int32_t>(radius(samples[k], colors[k], 0)));
    return;
  }
  for (size_t k = 0; k < samples.size(); ++k) slots[k + 1] = static_cast<int32_t>(radiusCode(samples[k]));
  putNumbers(runs, slots, out);
}

void takeRadii(const RadiusPrediction& radius, std::span<const NeighborRun> runs, const uint32_t* differences, const Rgba8* colors, int32_t* slots,
               std::span<PackedSample> samples) {
  PackedSample* const sample = samples.data();
  const auto codeFrom = [differences](uint32_t likely, size_t k) { return (likely + static_cast<uint32_t>(unzigzag(differences[k]))) & kRadiusCodeMax; };
  if (radius.isSame()) {
    const uint32_t same = radius.same();
    for (size_t k = 0; k < samples.size(); ++k) sample[k] = withRadiusCode(sample[k], codeFrom(same, k));
  } else if (!radius.isAsBefore()) {
    for (size_t k = 0; k < samples.size(); ++k) sample[k] = withRadiusCode(sample[k], codeFrom(radius(sample[k], colors[k], 0), k));
  } else {
    makeFromNeighbors(runs, making(slots, [&](size_t k, int32_t west, int32_t north, int32_t northWest) {
      const uint32_t code = codeFrom(static_cast<uint32_t>(predicted(west, north, northWest)), k);
      sample[k] = withRadiusCode(sample[k], code);
      return static_cast<int32_t>(code);
    }));
  }
}

}  // namespace

void TileSamples::goBehind() {
  const std::span<const uint32_t> kept = layer_.kept();
  for (size_t k = 0; k < kept.size(); ++k) at_[k] = at_[kept[k]];
  at_.resize(kept.size());
  paths_.narrow(kept);
}

/// Of each pixel; and, of rays that may have several, where those of each begin.
void TileSamples::countSamples(const SampleFrame& frame, const TileRect& rect, std::span<const RowPart> rows, bool hasLayers) {
  counts_.assign(rect.pixels(), 0);
  at_.clear();
  const PackedSample* const samples = frame.samples.data();
  uint8_t* counts = counts_.data();
  for (const RowPart& part : rows) {
    if (hasLayers) {
      for (uint32_t i = part.begin; i < part.end; ++i)
        if (counts[columnOf(samples[i]) - rect.x0]++ == 0) at_.push_back(i);
    } else if (part.end - part.begin == rect.width) {
      std::fill_n(counts, rect.width, uint8_t{1});
    } else {
      for (uint32_t i = part.begin; i < part.end; ++i) counts[columnOf(samples[i]) - rect.x0] = 1;
    }
    counts += rect.width;
  }
}

uint64_t TileSamples::pack(const SampleFrame& frame, Placement placement, const TileRect& rect, std::span<const RowPart> rows, SheetTile& tile) {
  const bool hasLayers = !frame.layers().empty();
  const std::span<const RowPart> ownRows = rows.first(rect.height);
  countSamples(frame, rect, ownRows, hasLayers);
  const SheetForm form = sampleForm(hasLayers);
  tile.layerCount = 0;
  layer_.begin(rect, counts_);
  putMask(layer_, rect, tile.shapes[0]);
  if (layer_.size() == 0) {
    tile.shapes[1].clear();
    return 0;
  }
  if (hasLayers) {
    tile.shapes[1].resize(layer_.size());
    uint8_t before = 0;
    for (size_t k = 0; k < layer_.size(); ++k) {
      const auto further = static_cast<uint8_t>(counts_[layer_.pixelOf(k)] - 1);
      tile.shapes[1][k] = further ^ before;
      before = further;
    }
  }
  paths_.aim(frame, placement, layer_.columns(), layer_.rows());
  const RadiusPrediction radius(frame);
  uint64_t hash = 0;
  for (uint32_t l = 0;; ++l) {
    const size_t size = layer_.size();
    samples_.resize(size);
    places_.resize(size);
    codes_.resize(size);
    startColors(slots_, size);
    fine_.resize(size + 1);
    fine_[0] = 0;
    forEachStretch(hasLayers, at_, l, ownRows, [&](size_t k, uint32_t at, size_t count) {
      std::copy_n(frame.samples.data() + at, count, samples_.data() + k);
      std::copy_n(frame.colors.data() + at, count, slots_.data() + 1 + k);
      hash += placedHashes(0, count, [own = samples_.data() + k](size_t i) { return own[i]; }, at);
    });
    paths_.locate(samples_, places_);
    paths_.place(places_, codes_);
    SheetLayer& planes = planes_;
    planes.resize(form, size);
    putPlaces(paths_.fineScale(), layer_.runs(), places_, fine_.data(), planes.number(planeOf(SampleNumbers::place)).data());
    {
      uint32_t* const difference = planes.number(planeOf(SampleNumbers::depth)).data();
      const PackedSample* const sample = samples_.data();
      const uint32_t* const likely = codes_.data();
      for (size_t k = 0; k < size; ++k) difference[k] = zigzag(static_cast<int32_t>(depthCode(sample[k])) - static_cast<int32_t>(likely[k]));
    }
    putRadii(radius, layer_.runs(), samples_, slots_.data() + 1, fine_.data(), planes.number(planeOf(SampleNumbers::radius)).data());
    putColors(slots_, layer_.runs(), size, differences_, differencesIn<SampleBytes>(planes));
    tile.addLayer(planes);
    if (!layer_.goBehind()) return hash;
    goBehind();
  }
}

bool TileSamples::takeShapes(const SheetReader& reader, uint32_t tile, const TileRect& rect, bool hasLayers, uint32_t most, AnsReader& stream, std::span<uint8_t> counts) {
  const uint32_t streams = reader.streams(tile);
  if (streams == 0) {
    stream = AnsReader();
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

std::optional<uint64_t> TileSamples::unpack(const SheetReader& reader, uint32_t tile, const TileRect& rect, std::span<const uint8_t> counts,
                                            std::span<const RowPart> rows, Placement placement, size_t front, SampleFrame& frame,
                                            std::span<uint8_t> layers) {
  const uint32_t streams = reader.streams(tile);
  if (streams == 0) return 0;
  layer_.begin(rect, counts);
  const bool hasLayers = !layers.empty();
  const std::span<const RowPart> ownRows = rows.first(rect.height);
  at_.clear();
  if (hasLayers) findFirsts(counts, rect, rows, at_);
  paths_.aim(frame, placement, layer_.columns(), layer_.rows());
  const RadiusPrediction radius(frame);
  uint64_t hash = 0;
  for (uint32_t l = 0; l < streams; ++l) {
    const size_t size = layer_.size();
    SheetLayer& planes = l == 0 ? fronts_[front] : planes_;
    if (l > 0) {
      AnsReader stream = reader.stream(tile, l);
      if (!reader.takeLayer(stream, l, size, planes)) return std::nullopt;
    }
    places_.resize(size);
    codes_.resize(size);
    slots_.resize(size + 1);
    fine_.resize(size + 1);
    samples_.resize(size);
    slots_[0] = 0;
    fine_[0] = 0;
    const uint32_t* const ofPlaces = planes.number(planeOf(SampleNumbers::place)).data();
    differences_.resize(size);
    joinDifferences(differencesIn<SampleBytes>(planes), size, differences_.data());
    makeFromNeighbors(layer_, makingTilePlaces(paths_.fineScale(), ofPlaces, fine_.data(), places_.data()), makingTileColors(differences_.data(), slots_.data()));
    paths_.place(places_, codes_);
    {
      const uint32_t* const difference = planes.number(planeOf(SampleNumbers::depth)).data();
      const uint32_t *const likely = codes_.data(), *const column = layer_.columns().data(), *const row = layer_.rows().data();
      PackedSample* const sample = samples_.data();
      for (size_t k = 0; k < size; ++k) {
        const uint32_t code = (likely[k] + static_cast<uint32_t>(unzigzag(difference[k]))) & kDepthCodeMax;
        sample[k] = packCodes(column[k], row[k], code, 0);
      }
    }
    takeRadii(radius, layer_.runs(), planes.number(planeOf(SampleNumbers::radius)).data(), slots_.data() + 1, fine_.data(), samples_);
    forEachStretch(hasLayers, at_, l, ownRows, [&](size_t k, uint32_t at, size_t count) {
      std::copy_n(samples_.data() + k, count, frame.samples.data() + at);
      std::copy_n(slots_.data() + 1 + k, count, frame.colors.data() + at);
      hash += placedHashes(0, count, [own = samples_.data() + k](size_t i) { return own[i]; }, at);
      if (hasLayers) std::fill_n(layers.data() + at, count, static_cast<uint8_t>(l));
    });
    if (l + 1 == streams) break;
    layer_.goBehind();
    goBehind();
  }
  return hash;
}

}  // namespace warpscope
