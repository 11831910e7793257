// Shapes and layers of segments.
// See tile_segments.h.
#include "render/codec/tiled/tile_segments.h"

#include <algorithm>

#include "render/codec/color_differences.h"
#include "render/codec/place_differences.h"
#include "render/codec/tiled/sheet_colors.h"
#include "render/codec/tiled/tile_making.h"
#include "render/codec/tokens.h"

namespace warpscope {
namespace {

size_t planeOf(SegmentNumbers plane) { return static_cast<size_t>(plane); }
size_t planeOf(SegmentBytes plane) { return static_cast<size_t>(plane); }

/// Half of a normal's code.
struct NormalPlane {
  SegmentBytes plane;
  int shift;
};
constexpr NormalPlane kNormalPlanes[]{{SegmentBytes::normalLow, 0}, {SegmentBytes::normalHigh, 8}};

/// The rays of a row of the tile.
template <class Rays>
auto rowOfRays(Rays& rays, uint32_t pictureWidth, const TileRect& rect, uint32_t y) {
  return std::span(rays).subspan(size_t{rect.y0 + y} * pictureWidth + rect.x0, rect.width);
}

}  // namespace

void TileSegments::begin(const SampleFrame& frame, Placement placement, const TileRect& rect, std::span<const RowPart> rows) {
  counts_.resize(rect.pixels());
  for (uint32_t y = 0; y < rect.height; ++y) {
    const auto rays = rowOfRays(frame.segments.rays, frame.camera.width, rect, y);
    for (uint32_t x = 0; x < rect.width; ++x) counts_[size_t{y} * rect.width + x] = static_cast<uint8_t>(rays[x].count());
  }
  layer_.begin(rect, counts_);
  findFirsts(counts_, rect, rows, at_);
  ends_.resize(layer_.size());
  paths_.aim(frame, placement, layer_.columns(), layer_.rows());
}

/// Makes room for the layer's values.
void TileSegments::startLayer() {
  const size_t size = layer_.size();
  for (TransferVector<uint32_t>* values : {&codes_, &endCodes_, &likely_}) values->resize(size);
  for (TransferVector<int32_t>* values : {&places_, &endPlaces_}) values->resize(size);
  for (TransferVector<int32_t>* slots : {&fine_, &endFine_}) {
    slots->resize(size + 1);
    slots->front() = 0;
  }
  startColors(slots_, size);
}

bool TileSegments::goBehind() {
  if (!layer_.goBehind()) return false;
  const std::span<const uint32_t> kept = layer_.kept();
  for (size_t k = 0; k < kept.size(); ++k) {
    at_[k] = at_[kept[k]];
    ends_[k] = ends_[kept[k]];
  }
  at_.resize(kept.size());
  ends_.resize(kept.size());
  paths_.narrow(kept);
  return true;
}

void TileSegments::putBorders(SheetLayer& planes, bool isFront) {
  paths_.locateBorders(codes_, places_);
  paths_.locateBorders(endCodes_, endPlaces_);
  uint32_t* const begins = planes.number(planeOf(SegmentNumbers::begin)).data();
  if (isFront) {
    putPlaces(paths_.fineScale(), layer_.runs(), places_, fine_.data(), begins);
  } else {
    for (size_t k = 0; k < layer_.size(); ++k) fine_[k + 1] = wrappedDifference(places_[k], ends_[k]);
    putNumbers(layer_.runs(), fine_.data(), begins);
  }
  putPlaces(paths_.fineScale(), layer_.runs(), endPlaces_, endFine_.data(), planes.number(planeOf(SegmentNumbers::end)).data());
  std::ranges::copy(endPlaces_, ends_.begin());
  // What the marcher's rounding and other rays' lattices make of it.
  const auto putRests = [&](const TransferVector<int32_t>& places, const TransferVector<uint32_t>& codes, std::span<uint32_t> rests) {
    paths_.place(places, likely_);
    for (size_t k = 0; k < rests.size(); ++k) rests[k] = zigzag(static_cast<int32_t>(codes[k] - likely_[k]));
  };
  putRests(places_, codes_, planes.number(planeOf(SegmentNumbers::beginRest)));
  putRests(endPlaces_, endCodes_, planes.number(planeOf(SegmentNumbers::endRest)));
}

/// Colours as well: what is made side by side takes hardly longer than the slowest of it.
void TileSegments::takeBordersAndColors(SheetLayer& planes, bool isFront) {
  const size_t size = layer_.size();
  differences_.resize(size);
  joinDifferences(differencesIn<SegmentBytes>(planes), size, differences_.data());
  const auto colors = makingTileColors(differences_.data(), slots_.data());
  const FineScale scale = paths_.fineScale();
  const uint32_t* const ofBegins = planes.number(planeOf(SegmentNumbers::begin)).data();
  const auto ends = makingTilePlaces(scale, planes.number(planeOf(SegmentNumbers::end)).data(), endFine_.data(), endPlaces_.data());
  if (isFront) {
    makeFromNeighbors(layer_, makingTilePlaces(scale, ofBegins, fine_.data(), places_.data()), ends, colors);
  } else {
    makeFromNeighbors(layer_, makingTileNumbers(ofBegins, fine_.data()), ends, colors);
    for (size_t k = 0; k < size; ++k) places_[k] = wrappedSum(ends_[k], fine_[k + 1]);
  }
  std::ranges::copy(endPlaces_, ends_.begin());
  const auto takeRests = [&](const TransferVector<int32_t>& places, TransferVector<uint32_t>& codes, std::span<const uint32_t> rests) {
    paths_.place(places, codes);
    for (size_t k = 0; k < rests.size(); ++k) codes[k] = (codes[k] + static_cast<uint32_t>(unzigzag(rests[k]))) & kDepthCodeMax;
  };
  takeRests(places_, codes_, planes.number(planeOf(SegmentNumbers::beginRest)));
  takeRests(endPlaces_, endCodes_, planes.number(planeOf(SegmentNumbers::endRest)));
}

void TileSegments::pack(const SampleFrame& frame, Placement placement, const TileRect& rect, std::span<const RowPart> rows, SheetTile& tile) {
  const FrameSegments& segments = frame.segments;
  tile.layerCount = 0;
  TransferVector<uint8_t>& shape = tile.shapes[0];
  shape.resize(rect.pixels());
  for (uint32_t y = 0; y < rect.height; ++y) {
    const auto rays = rowOfRays(segments.rays, frame.camera.width, rect, y);
    uint8_t before = y > 0 ? rowOfRays(segments.rays, frame.camera.width, rect, y - 1)[0].bits() : 0;
    for (uint32_t x = 0; x < rect.width; ++x) {
      shape[size_t{y} * rect.width + x] = rays[x].bits() ^ before;
      before = rays[x].bits();
    }
  }
  begin(frame, placement, rect, rows);
  if (layer_.size() == 0) return;
  const SheetForm form = segmentForm(!segments.normals.empty());
  for (uint32_t l = 0;; ++l) {
    startLayer();
    const size_t size = layer_.size();
    for (size_t k = 0; k < size; ++k) {
      codes_[k] = segments.depths[at_[k] + l].begin;
      endCodes_[k] = segments.depths[at_[k] + l].end;
      slots_[k + 1] = segments.colors[at_[k] + l];
    }
    SheetLayer& planes = planes_;
    planes.resize(form, size);
    putBorders(planes, l == 0);
    putColors(slots_, layer_.runs(), size, differences_, differencesIn<SegmentBytes>(planes));
    if (!segments.normals.empty()) {
      for (size_t k = 0; k < size; ++k) slots_[k + 1] = segments.normals[at_[k] + l];
      for (const NormalPlane& half : kNormalPlanes) {
        uint8_t* const out = planes.byte(planeOf(half.plane)).data();
        forEachNeighbors(layer_.runs(), [&](size_t k, const Neighbors& from) {
          out[k] = static_cast<uint8_t>(channel(slots_[k + 1], half.shift) - predictedChannel(slots_[from.west], slots_[from.north], slots_[from.northWest], half.shift));
        });
      }
    }
    tile.addLayer(planes);
    if (!goBehind()) return;
  }
}

bool TileSegments::takeRays(const SheetReader& reader, uint32_t tile, const TileRect& rect, int most, AnsReader& stream, SampleFrame& frame) {
  const uint32_t streams = reader.streams(tile);
  counts_.assign(rect.pixels(), 0);
  if (streams > 0) {
    stream = reader.stream(tile, 0);
    stream.takeBytes(reader.shape(0), counts_);
  }
  int deepest = 0;
  uint8_t first = 0;
  for (uint32_t y = 0; y < rect.height; ++y) {
    const auto rays = rowOfRays(frame.segments.rays, frame.camera.width, rect, y);
    uint8_t before = first;
    for (uint32_t x = 0; x < rect.width; ++x) {
      before ^= counts_[size_t{y} * rect.width + x];
      rays[x] = RaySegmentCount::ofBits(before);
      deepest = std::max(deepest, rays[x].count());
      if (x == 0) first = before;
    }
  }
  // A tile of rays without segments that ended has a stream and no layers.
  return deepest <= std::min(most, static_cast<int>(reader.layers())) && static_cast<int>(streams) == (streams == 1 ? std::max(deepest, 1) : deepest);
}

bool TileSegments::unpack(const SheetReader& reader, uint32_t tile, const TileRect& rect, std::span<const RowPart> rows, Placement placement, AnsReader& stream,
                          SampleFrame& frame) {
  FrameSegments& segments = frame.segments;
  const uint32_t streams = reader.streams(tile);
  if (streams == 0) return true;
  begin(frame, placement, rect, rows);
  if (layer_.size() == 0) return stream.isSound();
  for (uint32_t l = 0; l < streams; ++l) {
    startLayer();
    const size_t size = layer_.size();
    AnsReader behind;
    if (l > 0) behind = reader.stream(tile, l);
    if (!reader.takeLayer(l > 0 ? behind : stream, l, size, planes_)) return false;
    takeBordersAndColors(planes_, l == 0);
    for (size_t k = 0; k < size; ++k) {
      segments.depths[at_[k] + l] = {codes_[k], endCodes_[k]};
      segments.colors[at_[k] + l] = slots_[k + 1];
    }
    if (!segments.normals.empty()) {
      std::ranges::fill(slots_, Rgba8{0});
      for (const NormalPlane& half : kNormalPlanes) {
        const uint8_t* const in = planes_.byte(planeOf(half.plane)).data();
        makeFromNeighbors(layer_.runs(), making(slots_.data(), [&](size_t k, Rgba8 west, Rgba8 north, Rgba8 northWest) {
          return slots_[k + 1] | static_cast<Rgba8>((in[k] + predictedChannel(west, north, northWest, half.shift)) & 255) << half.shift;
        }));
      }
      for (size_t k = 0; k < size; ++k) segments.normals[at_[k] + l] = static_cast<NormalCode>(slots_[k + 1]);
    }
    if (!goBehind()) return l + 1 == streams;
  }
  return true;
}

}  // namespace warpscope
