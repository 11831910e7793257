// Layers of segments.
// See segment_band.h.
#include "render/codec/segment_band.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "render/codec/place_differences.h"
#include "render/codec/zstd_section.h"

namespace warpscope {
namespace {

/// Where colours are coded with loss opacities are rounded to every sixth code, but for nearly none and nearly all: by 3/255 of their root, as JPEG rounds colours.
constexpr uint32_t kOpacityCodes = 6, kLeastRounded = 8, kMostRounded = 249;

/// How large a layer's errors may be as they are seen, against those of a picture of its own; all layers' together; and by how much coarser its colours may be at most, since from another side more
/// of it is seen. What other numbers are worth: tests/bench.
constexpr double kSeenError = 0.7, kSeenErrors = 1.4, kCoarsest = 5.0;

/// The quality whose steps are so many times as coarse. Libjpeg's scale of its tables, in percent: 5000 / q below 50, else 200 - 2 q.
int coarser(int quality, double factor) {
  const double percent = (quality < 50 ? 5000.0 / quality : 200.0 - 2.0 * quality) * factor;
  return std::clamp(static_cast<int>(std::lround(percent > 100.0 ? 5000.0 / percent : 100.0 - 0.5 * percent)), 1, quality);
}

}  // namespace

/// Where each ray's segments begin; how many layers there are.
int SegmentBand::startRays(std::span<const RaySegmentCount> rays) {
  starts_.resize(rays.size());
  ends_.assign(rays.size(), 0);
  through_.assign(rays.size(), 1.0f);
  int layers = 0;
  uint32_t at = 0;
  for (size_t i = 0; i < rays.size(); ++i) {
    starts_[i] = at;
    layers = std::max(layers, rays[i].count());
    at += static_cast<uint32_t>(rays[i].count());
  }
  return layers;
}

/// Makes room for the segments of a layer, and says which pixels they are of.
void SegmentBand::lay(const MaskShape& shape, std::span<const RaySegmentCount> rays, int layer) {
  mask_.assign(shape.size(), 0);
  for (uint32_t row = 0; row < shape.rowCount; ++row)
    for (uint32_t x = 0; x < shape.width; ++x)
      if (rays[size_t{row} * shape.width + x].count() > layer) mask_[size_t{row} * shape.rowBytes() + x / 8] |= static_cast<uint8_t>(1u << x % 8);
  layout_.build(shape.width, shape.firstRow, shape.rowCount, mask_);
  const size_t size = layout_.size();
  pixelOf_.resize(size);
  codes_.resize(size);
  endCodes_.resize(size);
  colors_.resize(size);
  normals_.resize(size);
  for (size_t k = 0; k < size; ++k) pixelOf_[k] = (layout_.rows[k] - shape.firstRow) * shape.width + layout_.columns[k];
}

void SegmentBand::pack(const SampleFrame& frame, Placement placement, const MaskShape& shape, size_t begin, const CodecSettings& settings, ByteVector& out) {
  const FrameSegments& segments = frame.segments;
  const auto rays = std::span(segments.rays).subspan(size_t{shape.firstRow} * shape.width, size_t{shape.rowCount} * shape.width);
  const int layers = startRays(rays);
  bytes_.resize(rays.size());
  for (size_t i = 0; i < rays.size(); ++i) bytes_[i] = static_cast<uint8_t>(rays[i].bits() ^ (i % shape.width > 0 ? rays[i - 1].bits() : 0));
  appendSection(out, bytes_);
  for (int layer = 0; layer < layers; ++layer) {
    lay(shape, rays, layer);
    const size_t size = layout_.size();
    for (size_t k = 0; k < size; ++k) {
      const size_t segment = begin + starts_[pixelOf_[k]] + static_cast<size_t>(layer);
      codes_[k] = segments.depths[segment].begin;
      endCodes_[k] = segments.depths[segment].end;
      colors_[k] = segments.colors[segment];
      if (!segments.normals.empty()) normals_[k] = segments.normals[segment];
    }
    paths_.aim(frame, placement, layout_.columns, layout_.rows);
    bitBytes_.resize((size * kMostBits + 7) / 8 + BitWriter::kSpareBytes);
    BitWriter bits(bitBytes_.data());
    putDepths(size, layer, bits);
    for (const TransferVector<uint8_t>* tokens : {&beginTokens_, &endTokens_, &beginRests_, &endRests_}) appendSection(out, *tokens);
    const std::span<const uint8_t> written = bits.finish();
    appendLittle(out, static_cast<uint32_t>(written.size()));
    appendSection(out, written);
    colorCoder_.append(out, layout_, shape.firstRow, mask_, shape.rowBytes(), colors_, settings.color == ColorCoding::jpeg ? lossyColors(settings, layers) : settings);
    if (!segments.normals.empty()) appendNormals(size, out);
  }
}

bool SegmentBand::takeRays(ByteReader& reader, const MaskShape& shape, std::span<RaySegmentCount> rays) {
  bytes_.resize(rays.size());
  if (!takeSection(reader, bytes_)) return false;
  for (size_t row = 0; row < shape.rowCount; ++row) {
    uint8_t west = 0;
    for (size_t x = 0; x < shape.width; ++x) {
      const size_t i = row * shape.width + x;
      west = static_cast<uint8_t>(bytes_[i] ^ west);
      rays[i] = RaySegmentCount::ofBits(west);
    }
  }
  return true;
}

DecodeError SegmentBand::unpack(ByteReader& reader, Placement placement, const MaskShape& shape, ColorCoding coding, size_t begin, SampleFrame& frame) {
  FrameSegments& segments = frame.segments;
  const auto rays = std::span(std::as_const(segments.rays)).subspan(size_t{shape.firstRow} * shape.width, size_t{shape.rowCount} * shape.width);
  const int layers = startRays(rays);
  for (int layer = 0; layer < layers; ++layer) {
    lay(shape, rays, layer);
    const size_t size = layout_.size();
    paths_.aim(frame, placement, layout_.columns, layout_.rows);
    for (TransferVector<uint8_t>* tokens : {&beginTokens_, &endTokens_, &beginRests_, &endRests_}) {
      tokens->resize(size);
      if (!takeSection(reader, *tokens)) return "the depths of segments are damaged";
    }
    const auto bitLength = reader.take<uint32_t>();
    if (bitLength > (size * kMostBits + 7) / 8 + 1) return "the depths of segments have more bits than they can use";
    bitBytes_.resize(bitLength);
    if (!takeSection(reader, bitBytes_)) return "the depths of segments are damaged";
    BitReader bits(bitBytes_);
    takeDepths(size, layer, bits);
    if (bits.ranOut()) return "the depths of segments end too early";
    if (DecodeError error = colorCoder_.take(reader, layout_, shape.firstRow, coding, colors_)) return error;
    if (!segments.normals.empty() && !takeNormals(reader, size)) return "the normals of segments are damaged";
    for (size_t k = 0; k < size; ++k) {
      const size_t segment = begin + starts_[pixelOf_[k]] + static_cast<size_t>(layer);
      segments.depths[segment] = {codes_[k], endCodes_[k]};
      segments.colors[segment] = colors_[k];
      if (!segments.normals.empty()) segments.normals[segment] = normals_[k];
    }
  }
  return std::nullopt;
}

template <class F>
void SegmentBand::forEachPlace(size_t size, int layer, const F& f) {
  fine_.resize(size + 1);
  fine_[0] = 0;
  forEachBorder(paths_.fineScale(), layout_.runs, layer == 0, {places_, endPlaces_}, fine_.data(), [this](size_t k) -> int32_t& { return ends_[pixelOf_[k]]; }, f);
}

void SegmentBand::putDepths(size_t size, int layer, BitWriter& bits) {
  places_.resize(size);
  endPlaces_.resize(size);
  paths_.locateBorders(codes_, places_);
  paths_.locateBorders(endCodes_, endPlaces_);
  for (TransferVector<uint8_t>* tokens : {&beginTokens_, &endTokens_, &beginRests_, &endRests_}) tokens->resize(size);
  forEachPlace(size, layer, [&](size_t k, int32_t likely, int32_t place, bool isEnd) {
    (isEnd ? endTokens_ : beginTokens_)[k] = putToken(zigzag(wrappedDifference(place, likely)), bits);
  });
  // What the marcher's rounding and other rays' lattices make of it.
  const auto putRests = [&](const TransferVector<int32_t>& places, const TransferVector<uint32_t>& codes, TransferVector<uint8_t>& rests) {
    likely_.resize(size);
    paths_.place(places, likely_);
    for (size_t k = 0; k < size; ++k) rests[k] = putToken(zigzag(static_cast<int32_t>(codes[k] - likely_[k])), bits);
  };
  putRests(places_, codes_, beginRests_);
  putRests(endPlaces_, endCodes_, endRests_);
}

void SegmentBand::takeDepths(size_t size, int layer, BitReader& bits) {
  places_.resize(size);
  endPlaces_.resize(size);
  forEachPlace(size, layer, [&](size_t k, int32_t likely, int32_t& place, bool isEnd) {
    place = wrappedSum(likely, unzigzag(takeToken((isEnd ? endTokens_ : beginTokens_)[k], bits)));
  });
  const auto takeRests = [&](const TransferVector<int32_t>& places, TransferVector<uint32_t>& codes, const TransferVector<uint8_t>& rests) {
    paths_.place(places, codes);
    for (size_t k = 0; k < size; ++k) codes[k] = (codes[k] + static_cast<uint32_t>(unzigzag(takeToken(rests[k], bits)))) & kDepthCodeMax;
  };
  takeRests(places_, codes_, beginRests_);
  takeRests(endPlaces_, endCodes_, endRests_);
}

/// Rounds the opacities of the layer, and says how its colours are coded: the coarser the less of them is seen, through the layers in front and by their own opacity.
CodecSettings SegmentBand::lossyColors(const CodecSettings& settings, int layers) {
  double seen = 0.0;
  for (size_t k = 0; k < colors_.size(); ++k) {
    Rgba8& color = colors_[k];
    const uint32_t code = color >> 24;
    if (code >= kLeastRounded && code <= kMostRounded) color = (color & 0xffffffu) | (code + kOpacityCodes / 2) / kOpacityCodes * kOpacityCodes << 24;
    float& through = through_[pixelOf_[k]];
    const float opacity = segmentOpacity(color), light = through * opacity;
    seen += static_cast<double>(light) * static_cast<double>(light);
    through *= 1.0f - opacity;
  }
  CodecSettings own = settings;
  const double error = std::min(kSeenErrors / std::sqrt(static_cast<double>(layers)), kSeenError);
  const double mean = colors_.empty() ? 1.0 : std::sqrt(seen / static_cast<double>(colors_.size()));
  own.jpegQuality = coarser(settings.jpegQuality, std::clamp(error / std::max(mean, 1e-9), 1.0, kCoarsest));
  return own;
}

void SegmentBand::appendNormals(size_t size, ByteVector& out) {
  for (const int shift : {0, 8}) {
    bytes_.resize(size);
    fine_.resize(size + 1);
    fine_[0] = 0;
    forEachNeighbors(layout_.runs, [&](size_t k, const Neighbors& from) {
      const int32_t own = normals_[k] >> shift & 255;
      bytes_[k] = static_cast<uint8_t>(own - predictedSlot(fine_.data(), from));
      fine_[k + 1] = own;
    });
    appendSection(out, bytes_);
  }
}

bool SegmentBand::takeNormals(ByteReader& reader, size_t size) {
  std::ranges::fill(normals_, NormalCode{0});
  for (const int shift : {0, 8}) {
    bytes_.resize(size);
    if (!takeSection(reader, bytes_)) return false;
    fine_.resize(size + 1);
    fine_[0] = 0;
    makeFromNeighbors(layout_.runs, making(fine_.data(), [&](size_t k, int32_t west, int32_t north, int32_t northWest) {
      const int32_t own = (bytes_[k] + predicted(west, north, northWest)) & 255;
      normals_[k] = static_cast<NormalCode>(normals_[k] | own << shift);
      return own;
    }));
  }
  return true;
}

}  // namespace warpscope
