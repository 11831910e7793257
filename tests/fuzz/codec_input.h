// What codec_fuzz is given: a frame in a few bytes, and a payload for it. codec_fuzz_seeds writes the same.
// The bytes: format; samples a ray less one (3 bits), whether the picture is wide; segments; proxy; width and height less one; choices; count (2); the payload
// behind its head.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "render/codec/bytes.h"
#include "render/codec/codec.h"
#include "render/codec/payload_hash.h"

namespace warpscope {

struct CodecInput {
  SampleFrame head;
  size_t count = 0;
  ByteVector payload;  ///< its hash is right, so that what lies behind it is reached
};

inline constexpr uint32_t kWider = 40;              ///< times, of a wide picture
inline constexpr int kFuzzedProxy = 16;             ///< voxels along the copy's longest edge, at most

/// Of every fuzzed frame.
inline const SampleQuantization kFuzzedQuantization{{glm::vec3(-8.0f), glm::vec3(8.0f)}, 1.0f, 24.0f, 0x1p-13f};
inline const glm::vec3 kFuzzedEye(3.0f, 2.0f, 40.0f);

inline CodecInput readCodecInput(std::span<const std::byte> bytes) {
  ByteReader reader(bytes);
  CodecInput input;
  SampleFrame& head = input.head;
  const PayloadFormat format = kPayloadFormats[reader.take<uint8_t>() % kPayloadFormats.size()].value;
  const auto along = reader.take<uint8_t>();
  head.settings.sample.samplesPerRay = 1 + (along & 7);
  head.settings.sample.segments = reader.take<uint8_t>() % (static_cast<int>(kSegmentsRange.highest) + 1);
  head.settings.sample.proxy = reader.take<uint8_t>() % (kFuzzedProxy + 1);
  head.camera.eye = kFuzzedEye;
  head.camera.width = (1u + reader.take<uint8_t>()) * ((along & 8) != 0 ? kWider : 1u);
  head.camera.height = 1u + reader.take<uint8_t>();
  head.quantization = kFuzzedQuantization;
  const auto choices = reader.take<uint8_t>();
  head.settings.sample.radiusPolicy = static_cast<RadiusPolicy>((choices & 7) % kRadiusPolicies.size());
  if (choices & 8) head.settings.render.step = 0.01f;
  if (choices & 16) head.quantization.bounds.upper.x = -8.0f;
  if (choices & 32) head.planes.push_back({std::string(kLayerPlane), PlaneElement::uint8, {}});
  if (choices & 64) head.planes.push_back({"future", PlaneElement::uint16, {}});
  if (choices & 128) head.planes.push_back({std::string(kExtentPlane), PlaneElement::float32, {}});
  input.count = reader.take<uint16_t>();
  appendLittle(input.payload, static_cast<uint8_t>(format));
  appendLittle(input.payload, uint64_t{0});
  const std::span<const std::byte> rest = reader.take(reader.left());
  input.payload.insert(input.payload.end(), rest.begin(), rest.end());
  sealPayload(input.payload);
  return input;
}

/// What readCodecInput() makes that frame and that payload of.
inline ByteVector codecInput(const SampleFrame& frame, PayloadFormat format, std::span<const std::byte> payload) {
  ByteVector bytes;
  const auto append = [&bytes](auto value) { appendLittle(bytes, static_cast<uint8_t>(value)); };
  append(format);
  append(frame.settings.sample.samplesPerRay - 1);
  append(frame.settings.sample.segments);
  append(frame.settings.sample.proxy);
  append(frame.camera.width - 1);
  append(frame.camera.height - 1);
  append(static_cast<unsigned>(frame.settings.sample.radiusPolicy) | (frame.plane(kLayerPlane) ? 32u : 0u) | (frame.plane("future") ? 64u : 0u) |
         (frame.plane(kExtentPlane) ? 128u : 0u));
  appendLittle(bytes, static_cast<uint16_t>(frame.size()));
  const auto rest = payload.subspan(kPayloadHeadBytes);
  bytes.insert(bytes.end(), rest.begin(), rest.end());
  return bytes;
}

}  // namespace warpscope
