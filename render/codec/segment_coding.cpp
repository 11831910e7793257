// Bands of layers of segments.
// See segment_coding.h.
#include "render/codec/segment_coding.h"

#include <algorithm>
#include <atomic>

#include "render/base/error.h"
#include "render/base/shared_pool.h"
#include "render/codec/color_plane_coder.h"
#include "render/codec/picture_bands.h"
#include "render/codec/segment_band.h"
#include "render/codec/tiled/tiled_coder.h"
#include "render/codec/tiled/tiled_segments.h"
#include "render/codec/zstd_section.h"
#include "render/core/parallel.h"
#include "render/march/ray_pieces.h"

namespace warpscope {
namespace {

constexpr size_t kSegmentsHeadBytes = 3, kListedBytes = 8;
constexpr size_t kCheckedRays = size_t{1} << 14;  // at once
constexpr uint64_t kRawSegmentBytes = sizeof(SegmentDepths) + sizeof(Rgba8);

MaskShape shapeOf(const PictureBands& bands, const Camera& camera, size_t band) { return {camera.width, bands.firstRow(band), bands.rowCount(band)}; }

uint64_t hashOf(const FrameSegments& segments) {
  uint64_t hash = hashBytes(std::as_bytes(std::span(segments.rays)), 1);
  hash = hashBytes(std::as_bytes(std::span(segments.depths)), hash);
  return hashBytes(std::as_bytes(std::span(segments.normals)), hash);
}

/// Where each band's segments begin among all, and where the last one's end. Rays are known.
std::vector<size_t> beginsOf(const PictureBands& bands, const SampleFrame& frame) {
  if (bands.count() == 0) return {0};
  return segmentStarts(frame.segments.rays, size_t{frame.camera.width} * bands.rowCount(0));  // every band but the last has as many rows
}

/// What bytes say before all else.
struct SegmentsHead {
  Placement placement = Placement::depth;
  ColorCoding color = ColorCoding::lossless;
  bool hasNormals = false;
};

DecodeError takeHead(ByteReader& reader, const SampleFrame& frame, SegmentsHead& head) {
  head.placement = static_cast<Placement>(reader.take<uint8_t>());
  head.color = static_cast<ColorCoding>(reader.take<uint8_t>());
  const auto hasNormals = reader.take<uint8_t>();
  head.hasNormals = hasNormals == 1;
  if (reader.ranOut()) return "the segments end before their head does";
  if ((head.placement != Placement::depth && head.placement != kBorders) || nameOf(head.color) == "?" || hasNormals > 1) return "the segments have an unknown head";
  if (head.placement != Placement::depth && !hasLattice(frame)) return "the segments need a usable camera and step";
  return std::nullopt;
}

void appendRaw(ByteVector& out, const FrameSegments& segments) {
  const size_t start = out.size();
  out.resize(start + segments.sizeBytes());
  std::byte* at = out.data() + start;
  for (const RaySegmentCount ray : segments.rays) *at++ = static_cast<std::byte>(ray.bits());
  for (size_t i = 0; i < segments.size(); ++i, at += kRawSegmentBytes) {
    storeLittle(at, segments.depths[i].begin);
    storeLittle(at + 4, segments.depths[i].end);
    storeLittle(at + 8, segments.colors[i]);
  }
  for (const NormalCode normal : segments.normals) {
    storeLittle(at, normal);
    at += sizeof(NormalCode);
  }
}

DecodeError takeRaw(ByteReader& reader, bool hasNormals, size_t most, SampleFrame& frame) {
  FrameSegments& segments = frame.segments;
  const std::span<const std::byte> rays = reader.take(segments.rays.size());
  if (reader.ranOut()) return "the segments end within what rays have";
  for (size_t i = 0; i < rays.size(); ++i) segments.rays[i] = RaySegmentCount::ofBits(std::to_integer<uint8_t>(rays[i]));
  const size_t count = countOf(segments.rays);
  if (count > most) return "the frame has more segments than are allowed";
  if (reader.left() != count * (kRawSegmentBytes + (hasNormals ? sizeof(NormalCode) : 0))) return "the segments have another length than their rays say";
  segments.depths.resize(count);
  segments.colors.resize(count);
  segments.normals.resize(hasNormals ? count : 0);
  for (size_t i = 0; i < count; ++i) {
    segments.depths[i].begin = reader.take<uint32_t>();
    segments.depths[i].end = reader.take<uint32_t>();
    segments.colors[i] = reader.take<Rgba8>();
  }
  for (NormalCode& normal : segments.normals) normal = reader.take<NormalCode>();
  return std::nullopt;
}

}  // namespace

SegmentCoder::SegmentCoder(TiledCoderPtr coder) : bands_(SharedPool<SegmentBand>::ofProcess()), tiled_(std::move(coder)) {}
SegmentCoder::~SegmentCoder() { forget(); }
void SegmentCoder::forget() { bands_->forget(); }

uint64_t mostSegmentBytes(const Camera& camera, const MarchSettings& marched, const CodecSettings& settings) {
  if (marched.sample.segments == 0) return 0;
  const uint64_t pixels = uint64_t{camera.width} * camera.height, layers = static_cast<uint64_t>(marched.sample.segments), segments = pixels * layers;
  const uint64_t raw = kSegmentsHeadBytes + pixels + segments * (kRawSegmentBytes + sizeof(NormalCode));
  if (settings.format == PayloadFormat::raw) return raw;
  if (settings.format == PayloadFormat::tiled) return kSegmentsHeadBytes + mostTiledSegmentBytes(camera, segments, layers);
  const PictureBands bands(camera);
  constexpr uint64_t kTokens = 4, kNormals = 2;
  uint64_t bytes = kSegmentsHeadBytes + sizeof(uint64_t);
  for (size_t band = 0; band < bands.count(); ++band) {
    const uint64_t rows = shapeOf(bands, camera, band).rowCount, own = rows * camera.width * layers;
    bytes += kListedBytes + kSectionHeadBytes + rows * camera.width + layers * ((kTokens + 1 + kNormals) * kSectionHeadBytes + sizeof(uint32_t) + 1) +
             own * (kTokens + kNormals) + (own * SegmentBand::kMostBits + 7) / 8 + ColorPlaneCoder::mostBytes(camera.width, static_cast<uint32_t>(rows), own, layers, settings.color);
  }
  return bytes;
}

DecodeError whyInconsistentSegments(const SampleFrame& frame) {
  const FrameSegments& segments = frame.segments;
  const int most = frame.settings.sample.segments;
  const size_t pixels = size_t{frame.camera.width} * frame.camera.height;
  if (segments.rays.size() != (most > 0 ? pixels : 0)) return "a frame must say of each pixel how many segments it has if its settings ask for some, else of none";
  const std::vector<size_t> starts = segmentStarts(segments.rays, kCheckedRays);
  if (starts.back() != segments.size()) return "a frame must have as many segments as its pixels say";
  if (segments.colors.size() != segments.size()) return "a frame must have a colour for each segment";
  if (!segments.normals.empty() && segments.normals.size() != segments.size()) return "a frame must have a normal for each segment, or none";
  std::atomic<bool> areTooMany = false, areOutOfOrder = false;
  parallelForRanges(starts.size() - 1, 1, [&](size_t begin, size_t end) {
    const auto rays = std::span(segments.rays).subspan(begin * kCheckedRays, std::min(end * kCheckedRays, segments.rays.size()) - begin * kCheckedRays);
    size_t at = starts[begin];
    for (const RaySegmentCount ray : rays) {
      if (ray.count() > most || (ray.bits() & kUnusedRayBits) != 0) areTooMany = true;
      uint32_t last = 0;
      for (int i = 0; i < ray.count(); ++i, ++at) {
        const SegmentDepths& depths = segments.depths[at];
        if (depths.begin < last || depths.end < depths.begin || depths.end > kDepthCodeMax) areOutOfOrder = true;
        last = depths.end;
      }
    }
  });
  if (areTooMany) return "a pixel of a frame has more segments than its settings ask for";
  if (areOutOfOrder) return kDisorderedSegments;
  return std::nullopt;
}

void requireConsistentSegments(const SampleFrame& frame) {
  if (DecodeError error = whyInconsistentSegments(frame)) throw InputError(*error);
}

Placement SegmentCoder::begin(const SampleFrame& frame, const CodecSettings& settings) {
  const Placement placement = settings.format == PayloadFormat::raw ? Placement::depth : borderPlacementOf(frame);
  if (settings.format == PayloadFormat::tiled) tiled_->beginToAppendSegments(frame, placement);
  return placement;
}

void SegmentCoder::append(ByteVector& out, const SampleFrame& frame, const CodecSettings& settings, Placement placement) {
  const FrameSegments& segments = frame.segments;
  appendLittle(out, static_cast<uint8_t>(placement));
  appendLittle(out, static_cast<uint8_t>(settings.color));
  const bool hasNormals = frame.isAway ? frame.device->hasNormals() : !segments.normals.empty();
  appendLittle(out, static_cast<uint8_t>(hasNormals ? 1 : 0));
  if (settings.format == PayloadFormat::raw) return appendRaw(out, segments);
  if (settings.format == PayloadFormat::tiled) return tiled_->appendSegments(out, frame, placement);
  const PictureBands bands(frame.camera);
  const std::vector<size_t> begins = beginsOf(bands, frame);
  std::vector<ByteVector> packed(bands.count());
  parallelForRanges(bands.count(), 1, [&](size_t from, size_t to) {
    const auto own = bands_->take();
    for (size_t band = from; band < to; ++band)
      own->pack(frame, placement, shapeOf(bands, frame.camera, band), begins[band], settings, packed[band]);
  });
  appendLittle(out, hashOf(segments));
  for (const ByteVector& band : packed) appendLittle(out, static_cast<uint32_t>(band.size()));
  for (const ByteVector& band : packed) out.insert(out.end(), band.begin(), band.end());
}

void SegmentCoder::beginToTake(std::span<const std::byte> bytes, PayloadFormat format, size_t most, const SampleFrame& frame) {
  ByteReader reader(bytes);
  SegmentsHead head;
  if (format == PayloadFormat::tiled && !takeHead(reader, frame, head)) tiled_->beginToTakeSegments(reader, head.placement, head.hasNormals, most, frame);
}

DecodeError SegmentCoder::take(std::span<const std::byte> bytes, PayloadFormat format, size_t most, SampleFrame& frame) {
  FrameSegments& segments = frame.segments;
  segments = {};
  ByteReader reader(bytes);
  SegmentsHead head;
  if (DecodeError error = takeHead(reader, frame, head)) return error;
  const Placement placement = head.placement;
  const ColorCoding coding = head.color;
  const bool hasNormals = head.hasNormals;
  if (format == PayloadFormat::tiled) return tiled_->takeSegments(reader, placement, hasNormals, most, frame);
  segments.rays.resize(size_t{frame.camera.width} * frame.camera.height);
  if (format == PayloadFormat::raw) {
    if (DecodeError error = takeRaw(reader, hasNormals, most, frame)) return error;
    return whyInconsistentSegments(frame);
  }
  const PictureBands bands(frame.camera);
  const auto hash = reader.take<uint64_t>();
  std::vector<ByteReader> readers;
  std::vector<size_t> lengths;
  for (size_t band = 0; band < bands.count(); ++band) lengths.push_back(reader.take<uint32_t>());
  if (reader.ranOut()) return "the segments end within their list of bands";
  for (const size_t length : lengths) readers.emplace_back(reader.take(length));
  if (reader.ranOut() || reader.left() > 0) return "the bands of the segments have other lengths than their list says";
  std::vector<DecodeError> errors(bands.count());
  parallelForRanges(bands.count(), 1, [&](size_t from, size_t to) {
    const auto own = bands_->take();
    for (size_t band = from; band < to; ++band) {
      const MaskShape shape = shapeOf(bands, frame.camera, band);
      const auto rays = std::span(segments.rays).subspan(size_t{shape.firstRow} * shape.width, size_t{shape.rowCount} * shape.width);
      if (!own->takeRays(readers[band], shape, rays)) errors[band] = "what rays have of segments is damaged";
    }
  });
  const auto firstError = [&]() -> DecodeError {
    for (const DecodeError& error : errors)
      if (error) return error;
    return std::nullopt;
  };
  if (DecodeError error = firstError()) return error;
  for (const RaySegmentCount ray : segments.rays)
    if (ray.count() > frame.settings.sample.segments) return "a pixel of a frame has more segments than its settings ask for";
  const std::vector<size_t> begins = beginsOf(bands, frame);
  const size_t count = begins.back();
  if (count > most) return "the frame has more segments than are allowed";
  segments.depths.resize(count);
  segments.colors.resize(count);
  segments.normals.resize(hasNormals ? count : 0);
  parallelForRanges(bands.count(), 1, [&](size_t from, size_t to) {
    const auto own = bands_->take();
    for (size_t band = from; band < to; ++band) {
      errors[band] = own->unpack(readers[band], placement, shapeOf(bands, frame.camera, band), coding, begins[band], frame);
      if (!errors[band] && (readers[band].ranOut() || readers[band].left() > 0)) errors[band] = "a band of segments is longer or shorter than it should be";
    }
  });
  if (DecodeError error = firstError()) return error;
  if (hashOf(segments) != hash) return kOtherSegments;
  return whyInconsistentSegments(frame);
}

}  // namespace warpscope
