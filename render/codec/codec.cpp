// The registry of formats, and what payloads of all formats share.
// See codec.h. A new format is one file pair and one line here.
#include "render/codec/codec.h"

#include <algorithm>
#include <limits>

#include "render/base/error.h"
#include "render/codec/bytes.h"
#include "render/codec/frame_order.h"
#include "render/codec/packed_codec.h"
#include "render/codec/payload_hash.h"
#include "render/codec/plane_coding.h"
#include "render/codec/proxy_coding.h"
#include "render/codec/raw_codec.h"
#include "render/codec/segment_coding.h"
#include "render/codec/tiled/tiled_codec.h"
#include "render/core/freed_memory.h"
#include "render/core/picture_size.h"

namespace warpscope {
namespace {

constexpr CodecDescriptor kCodecs[] = {
    {PayloadFormat::raw, makeRawCodec, mostRawBytes, mostRawPlaneBytes},
    {PayloadFormat::packed, makePackedCodec, mostPackedBytes, mostPackedPlaneBytes},
    {PayloadFormat::tiled, makeTiledCodec, mostTiledBytes, mostTiledPlaneBytes, true, true},
};

const CodecDescriptor& descriptorOf(PayloadFormat format) {
  const auto found = std::ranges::find(kCodecs, format, &CodecDescriptor::format);
  if (found == std::end(kCodecs)) throw UsageError("there is no payload format " + std::to_string(static_cast<int>(format)));
  return *found;
}

/// Planes of numbers are coded on the host.
bool mayBeAway(const SampleFrame& frame, PayloadFormat format) { return descriptorOf(format).isForDevices && std::ranges::all_of(frame.planes, isImplied); }

/// However a frame ends, nothing of it is under way any more.
class Begun {
 public:
  explicit Begun(TiledCoder& coder) : coder_(coder) {}
  ~Begun() { coder_.endBegun(); }
  Begun(const Begun&) = delete;
  Begun& operator=(const Begun&) = delete;

 private:
  TiledCoder& coder_;
};

void clear(SampleFrame& frame) {
  frame.samples.clear();
  frame.colors.clear();
  for (SamplePlane& plane : frame.planes) plane.values.clear();
  frame.segments = {};
  frame.proxy.reset();
  frame.device.reset();
  frame.isAway = false;
}

}  // namespace

std::span<const CodecDescriptor> codecRegistry() { return kCodecs; }

bool FrameCodec::codesOnDevices(const CodecSettings& settings) { return descriptorOf(settings.format).isForDevices; }

void validate(const CodecSettings& settings) { requireRange(static_cast<double>(settings.jpegQuality), kJpegQualityRange, "the JPEG quality"); }

uint64_t mostPayloadBytes(const SampleFrame& frame, uint64_t count, const CodecSettings& settings) {
  const CodecDescriptor& codec = descriptorOf(settings.format);
  uint64_t bytes = kPayloadHeadBytes + codec.mostBytes(frame, count, settings);
  for (const SamplePlane& plane : frame.planes) bytes += sizeof(uint32_t) + codec.mostPlaneBytes(plane, count);
  const SampleSettings& sample = frame.settings.sample;
  if (sample.segments > 0) bytes += sizeof(uint32_t) + mostSegmentBytes(frame.camera, frame.settings, settings);
  if (sample.proxy > 0) bytes += sizeof(uint32_t) + mostProxyBytes(sample.proxy);
  return bytes;
}

FrameCodec::FrameCodec() : FrameCodec(makeHostTiledCoder()) {}
FrameCodec::FrameCodec(TiledCoderPtr coder) : coder_(std::move(coder)), codecs_(std::size(kCodecs)), segments_(std::make_unique<SegmentCoder>(coder_)) {}
FrameCodec::~FrameCodec() = default;
FrameCodec::FrameCodec(FrameCodec&&) noexcept = default;
FrameCodec& FrameCodec::operator=(FrameCodec&&) noexcept = default;

Codec& FrameCodec::codecFor(PayloadFormat format) {
  const CodecDescriptor& descriptor = descriptorOf(format);
  std::unique_ptr<Codec>& codec = codecs_[static_cast<size_t>(&descriptor - kCodecs)];
  if (!codec) codec = descriptor.make(coder_);
  return *codec;
}

ByteVector FrameCodec::encode(const SampleFrame& frame, const CodecSettings& settings) {
  validate(settings);
  if (frame.isAway && !mayBeAway(frame, settings.format)) return encode(onHost(frame), settings);
  if (frame.settings.sample.proxy > 0 && !frame.proxy) throw InputError("a frame whose settings ask for a copy of the volume must have one");
  if (!frame.isAway) requireConsistent(frame);
  Codec& codec = codecFor(settings.format);
  ByteVector payload;  // a device may still write to it until nothing is begun any more
  const Begun begun(*coder_);
  // Segments take longer.
  const Placement borders = frame.settings.sample.segments > 0 ? segments_->begin(frame, settings) : Placement::depth;
  codec.beginToEncode(frame);
  const size_t likely = bytes_.all() + bytes_.all() / 8;
  if (codesOnDevices(settings)) payload = coder_->roomFor(likely);
  payload.reserve(likely);
  appendLittle(payload, static_cast<uint8_t>(settings.format));
  appendLittle(payload, uint64_t{0});
  // Behind its length, which counts as well.
  const auto appendPart = [&](const std::string& what, const auto& append) {
    const size_t start = payload.size();
    appendLittle(payload, uint32_t{0});
    append();
    const size_t length = payload.size() - start - sizeof(uint32_t);
    if (length > std::numeric_limits<uint32_t>::max()) throw InputError("the frame's " + what + " is too long");
    storeLittle(payload.data() + start, static_cast<uint32_t>(length));
    return payload.size() - start;
  };
  FrameBytes bytes;
  for (const SamplePlane& plane : frame.planes) appendPart("plane \"" + plane.name + "\"", [&] { codec.encodePlane(frame, plane, payload); });
  if (frame.settings.sample.segments > 0) bytes.segments = appendPart("list of segments", [&] { segments_->append(payload, frame, settings, borders); });
  if (frame.settings.sample.proxy > 0) bytes.proxy = appendPart("copy of the volume", [&] { appendProxy(payload, *frame.proxy); });
  codec.encode(frame, settings, payload);
  sealPayload(payload, coder_->takeSummed());
  bytes.samples = payload.size() - bytes.all();
  bytes_ = bytes;
  noteNeed(frame, frame.size());
  return payload;
}

DecodeError FrameCodec::decode(std::span<const std::byte> payload, size_t count, SampleFrame& frame, const DecodeLimits& limits) {
  clear(frame);
  if (payload.size() > limits.maxBytes)
    return "the payload has " + std::to_string(payload.size()) + " bytes, more than the " + std::to_string(limits.maxBytes) + " allowed";
  if (count > limits.maxSamples)
    return "the frame has " + std::to_string(count) + " samples, more than the " + std::to_string(limits.maxSamples) + " allowed";
  const Camera& camera = frame.camera;
  if ((count > 0 || frame.settings.sample.segments > 0) && !isPictureSize(camera.width, camera.height)) return "the frame has samples but no usable picture";
  if (payload.size() < kPayloadHeadBytes) return "the payload ends before its head does";
  const auto format = static_cast<PayloadFormat>(payload[0]);
  if (nameOf(format) == "?") return "the payload's format " + std::to_string(static_cast<int>(format)) + " is unknown";
  DecodeError error = decodeParts(format, payload, count, frame, limits);
  if (error) clear(frame);
  noteNeed(frame, count);
  return error;
}

void FrameCodec::noteNeed(const SampleFrame& frame, size_t count) {
  if (!need_.exceedsRecent(size_t{frame.camera.width} * frame.camera.height + count)) return;
  for (std::unique_ptr<Codec>& codec : codecs_) codec.reset();
  segments_->forget();
  coder_->forget();
  planeBytes_ = {};
  giveBackFreedMemory();
}

DecodeError FrameCodec::takeParts(ByteReader& reader, SampleFrame& frame, Parts& parts) {
  planeBytes_.clear();
  size_t kept = 0;
  // Behind its length.
  const auto takePart = [&reader] {
    const auto length = reader.take<uint32_t>();
    return reader.take(length);
  };
  for (size_t i = 0; i < frame.planes.size(); ++i) {
    const std::span<const std::byte> bytes = takePart();
    if (reader.ranOut()) return "the payload ends within its plane \"" + frame.planes[i].name + "\"";
    if (!isKnown(frame.planes[i].name, frame.planes[i].element)) continue;
    planeBytes_.push_back(bytes);
    if (kept != i) frame.planes[kept] = std::move(frame.planes[i]);
    ++kept;
  }
  frame.planes.resize(kept);
  if (frame.settings.sample.segments > 0) {
    parts.segments = takePart();
    if (reader.ranOut()) return "the payload ends within its segments";
    parts.bytes.segments = sizeof(uint32_t) + parts.segments.size();
  }
  if (frame.settings.sample.proxy > 0) {
    parts.proxy = takePart();
    if (reader.ranOut()) return "the payload ends within its copy of the volume";
    parts.bytes.proxy = sizeof(uint32_t) + parts.proxy.size();
  }
  parts.samples = reader.take(reader.left());
  return std::nullopt;
}

DecodeError FrameCodec::decodeParts(PayloadFormat format, std::span<const std::byte> payload, size_t count, SampleFrame& frame, const DecodeLimits& limits) {
  Codec& codec = codecFor(format);
  ByteReader reader(payload.subspan(1));
  const auto hash = reader.take<uint64_t>();
  Parts parts;
  const DecodeError cut = takeParts(reader, frame, parts);
  const Begun begun(*coder_);
  const bool hasSegments = parts.bytes.segments > 0;
  if (!cut) {
    coder_->setPlace(count > 0 && mayBeAway(frame, format) ? limits.place : DecodedPlace::host);
    // Segments take longer.
    if (hasSegments) segments_->beginToTake(parts.segments, format, limits.maxSegments, frame);
    codec.beginToDecode(parts.samples, count, frame);
  }
  // While a device works, to which it does not matter what bytes are.
  if (hash != payloadHash(payload)) return "the payload is damaged: its bytes do not match their hash";
  if (cut) return cut;
  if (hasSegments)
    if (DecodeError error = segments_->take(parts.segments, format, limits.maxSegments, frame)) return error;
  frame.proxy.reset();
  if (parts.bytes.proxy > 0)
    if (DecodeError error = takeProxy(parts.proxy, frame.settings.sample.proxy, frame.proxy)) return error;
  if (DecodeError error = codec.decode(parts.samples, count, frame)) return error;
  // The others' values may be predicted along layers.
  for (const bool isLayers : {true, false})
    for (size_t i = 0; i < frame.planes.size(); ++i) {
      if ((frame.planes[i].name == kLayerPlane) != isLayers) continue;
      if (DecodeError error = codec.decodePlane(planeBytes_[i], frame, frame.planes[i])) return error;
      const int samplesPerRay = frame.settings.sample.samplesPerRay;
      const bool doCountUp = frame.isAway ? samplesPerRay >= 1 : countUp(frame.layers(), samplesPerRay);  // a device made them of how many there are
      if (isLayers && !doCountUp)
        return "the frame's layers do not count up along its rays, or its rays have more samples than it says";
    }
  if (!descriptorOf(format).ordersSamples && !areInOrder(frame)) return "the frame's samples are not in pixels of its picture, or not in the order of these";
  parts.bytes.samples = payload.size() - parts.bytes.segments - parts.bytes.proxy;
  bytes_ = parts.bytes;
  return std::nullopt;
}

}  // namespace warpscope
