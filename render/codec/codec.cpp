// The registry of formats, and what payloads of all formats share.
// See codec.h. A new format is one file pair and one line here.
#include "render/codec/codec.h"

#include "render/base/error.h"
#include "render/codec/bytes.h"
#include "render/codec/packed_codec.h"
#include "render/codec/raw_codec.h"

namespace warpscope {
namespace {

constexpr CodecDescriptor kCodecs[] = {
    {PayloadFormat::raw, makeRawCodec},
    {PayloadFormat::packed, makePackedCodec},
};

constexpr size_t kHeadBytes = 9;

/// The format is part of what is hashed.
uint64_t hashOf(std::span<const std::byte> payload) {
  return hashBytes(payload.subspan(kHeadBytes), std::to_integer<uint64_t>(payload[0]));
}

}  // namespace

std::span<const CodecDescriptor> codecRegistry() { return kCodecs; }

void validate(const CodecSettings& settings) { requireRange(static_cast<double>(settings.jpegQuality), kJpegQualityRange, "the JPEG quality"); }

void sealPayload(std::span<std::byte> payload) {
  if (payload.size() < kHeadBytes) return;
  const uint64_t hash = hashOf(payload);
  for (size_t i = 0; i < 8; ++i) payload[1 + i] = static_cast<std::byte>(hash >> 8 * i);
}

FrameCodec::FrameCodec() : codecs_(std::size(kCodecs)) {}

Codec& FrameCodec::codecFor(PayloadFormat format) {
  for (size_t i = 0; i < codecs_.size(); ++i) {
    if (kCodecs[i].format != format) continue;
    if (!codecs_[i]) codecs_[i] = kCodecs[i].make();
    return *codecs_[i];
  }
  throw UsageError("there is no payload format " + std::to_string(static_cast<int>(format)));
}

std::vector<std::byte> FrameCodec::encode(const SampleFrame& frame, const CodecSettings& settings) {
  validate(settings);
  if (frame.samples.size() != frame.colors.size()) throw InputError("a frame must have a colour for each sample");
  std::vector<std::byte> payload;
  payload.reserve(lastBytes_ + lastBytes_ / 8);
  appendLittle(payload, static_cast<uint8_t>(settings.format));
  appendLittle(payload, uint64_t{0});
  codecFor(settings.format).encode(frame, settings, payload);
  sealPayload(payload);
  lastBytes_ = payload.size();
  return payload;
}

DecodeError FrameCodec::decode(std::span<const std::byte> payload, size_t count, SampleFrame& frame, const DecodeLimits& limits) {
  frame.samples.clear();
  frame.colors.clear();
  if (payload.size() > limits.maxBytes)
    return "the payload has " + std::to_string(payload.size()) + " bytes, more than the " + std::to_string(limits.maxBytes) + " allowed";
  if (count > limits.maxSamples)
    return "the frame has " + std::to_string(count) + " samples, more than the " + std::to_string(limits.maxSamples) + " allowed";
  if (payload.size() < kHeadBytes) return "the payload ends before its head does";
  const auto format = static_cast<PayloadFormat>(payload[0]);
  if (nameOf(format) == "?") return "the payload's format " + std::to_string(static_cast<int>(format)) + " is unknown";
  ByteReader head(payload.subspan(1));
  if (head.take<uint64_t>() != hashOf(payload)) return "the payload is damaged: its bytes do not match their hash";
  DecodeError error = codecFor(format).decode(payload.subspan(kHeadBytes), count, frame);
  if (error) {
    frame.samples.clear();
    frame.colors.clear();
  }
  return error;
}

}  // namespace warpscope
