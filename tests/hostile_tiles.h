// Payloads of the format `tiled` that say what random damage hardly says.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "render/codec/payload_hash.h"
#include "render/codec/tiled/ans_model.h"
#include "tests/codec_frames.h"

namespace warpscope {

struct HostilePayload {
  std::string what;
  SampleFrame head;
  size_t count = 0;  ///< samples that it says it has
  std::string sentence;  ///< that refuses it, before its models are looked for
  ByteVector payload;
};

/// Sheets without layers, whose only tile has one all the same: there are no models to read it with.
inline std::vector<HostilePayload> tilesWithoutModels() {
  std::array<uint32_t, kAnsSymbols> ones{}, zeros{};
  ones[1] = 1;
  zeros[0] = 1;
  const auto appendSheet = [&](ByteVector& out, bool hasFurther) {
    appendLittle(out, uint64_t{0});  // hash
    appendLittle(out, uint8_t{0});   // layers
    AnsModel::ofCounts(ones).append(out);  // the pixel has something
    if (hasFurther) AnsModel::ofCounts(zeros).append(out);
    appendLittle(out, uint8_t{1});   // streams
    appendLittle(out, uint32_t{0});  // the stream's length
  };
  const SampleFrame frame = framedPixels(1, 1, {0});
  std::vector<HostilePayload> all;
  for (const bool hasLayers : {false, true}) {
    HostilePayload& samples = all.emplace_back(HostilePayload{hasLayers ? "samples in layers" : "samples", headOf(frame), 1, "the tiles' numbers of samples are damaged", {}});
    if (hasLayers) samples.head.planes.push_back({std::string(kLayerPlane), PlaneElement::uint8, {}});
    samples.head.settings.sample.samplesPerRay = 8;
    appendLittle(samples.payload, static_cast<uint8_t>(PayloadFormat::tiled));
    appendLittle(samples.payload, uint64_t{0});
    if (hasLayers) appendLittle(samples.payload, uint32_t{0});
    appendLittle(samples.payload, static_cast<uint8_t>(Placement::depth));
    appendSheet(samples.payload, hasLayers);
    sealPayload(samples.payload);
  }
  HostilePayload& segments = all.emplace_back(HostilePayload{"segments", headOf(frame), 0, "what rays have of segments is damaged", {}});
  segments.head.settings.sample.segments = 4;
  ByteVector part{static_cast<std::byte>(Placement::depth), std::byte{0}, std::byte{0}};  // no loss, no normals
  appendSheet(part, false);
  appendLittle(segments.payload, static_cast<uint8_t>(PayloadFormat::tiled));
  appendLittle(segments.payload, uint64_t{0});
  appendLittle(segments.payload, static_cast<uint32_t>(part.size()));
  segments.payload.insert(segments.payload.end(), part.begin(), part.end());
  sealPayload(segments.payload);
  return all;
}

}  // namespace warpscope
