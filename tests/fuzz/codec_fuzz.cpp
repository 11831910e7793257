// Payloads made up by libFuzzer: whatever they hold, decoding answers with a sentence or with as many samples as were asked for.
// The first bytes choose format, samples a ray, camera, planes and count; the hash is put right, so that what lies behind it is reached.
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "render/codec/bytes.h"
#include "render/codec/codec.h"

namespace {

using namespace warpscope;

/// A frame that a fuzzer can describe in a few bytes.
SampleFrame headFrom(ByteReader& reader) {
  SampleFrame head;
  head.camera.eye = {3.0f, 2.0f, 40.0f};
  head.camera.width = 1u + reader.take<uint8_t>();
  head.camera.height = 1u + reader.take<uint8_t>();
  head.quantization = {{glm::vec3(-8.0f), glm::vec3(8.0f)}, 1.0f, 24.0f, 0x1p-13f};
  const auto choices = reader.take<uint8_t>();
  head.settings.sample.radiusPolicy = static_cast<RadiusPolicy>((choices & 7) % kRadiusPolicies.size());
  if (choices & 8) head.settings.render.step = 0.01f;
  if (choices & 16) head.quantization.bounds.upper.x = -8.0f;
  if (choices & 32) head.planes.push_back({std::string(kLayerPlane), PlaneElement::uint8, {}});
  if (choices & 64) head.planes.push_back({"future", PlaneElement::uint16, {}});
  if (choices & 128) head.planes.push_back({std::string(kExtentPlane), PlaneElement::float32, {}});
  return head;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  ByteReader reader(std::as_bytes(std::span(data, size)));
  const auto first = reader.take<uint8_t>();
  const auto format = static_cast<uint8_t>(first & 1);
  SampleFrame frame = headFrom(reader);
  frame.settings.sample.samplesPerRay = 1 + (first >> 1 & 7);
  if (first & 16) frame.camera.width *= 40;
  const size_t count = reader.take<uint16_t>();
  std::vector<std::byte> payload;
  appendLittle(payload, format);
  appendLittle(payload, uint64_t{0});
  const std::span<const std::byte> rest = reader.take(reader.left());
  payload.insert(payload.end(), rest.begin(), rest.end());
  sealPayload(payload);

  static FrameCodec codec;  // its buffers are used again, as in a session
  const DecodeError error = codec.decode(payload, count, frame, {size_t{1} << 16, size_t{1} << 20});
  if (error && error->empty()) std::abort();
  const size_t expected = error ? 0 : count;
  if (frame.samples.size() != expected || frame.colors.size() != expected) std::abort();
  for (const SamplePlane& plane : frame.planes) {
    if (plane.values.size() != expected * bytesOf(plane.element)) std::abort();
    if (!error && !isKnown(plane.name, plane.element)) std::abort();
  }
  const std::span<const uint8_t> layers = frame.layers();
  const SampleGrid grid = frame.grid();
  for (size_t i = 0; i < frame.size(); ++i) {
    const PackedSample sample = frame.samples[i];
    if (columnOf(sample) >= frame.camera.width || rowOf(sample) >= frame.camera.height) std::abort();
    const bool isNext = i == 0 || layers.empty() || layers[i] == 0;
    if (i > 0 && (isNext ? pixelKey(sample) <= pixelKey(frame.samples[i - 1]) : pixelKey(sample) != pixelKey(frame.samples[i - 1]))) std::abort();
    const glm::vec3 center = unpackPosition(sample, grid);
    for (int axis = 0; axis < 3; ++axis)
      if (!(center[axis] >= grid.bounds.lower[axis] && center[axis] <= grid.bounds.upper[axis])) std::abort();
  }
  for (size_t i = 0; i < layers.size(); ++i)
    if (layers[i] >= frame.settings.sample.samplesPerRay || (layers[i] != 0 && (i == 0 || layers[i] != layers[i - 1] + 1)))
      std::abort();
  return 0;
}
