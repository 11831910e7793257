// Payloads made up by libFuzzer: whatever they hold, decoding answers with a sentence or with as many samples as were asked for.
// codec_input.h says what the bytes are.
#include <cstdint>
#include <cstdlib>
#include <span>

#include "render/codec/segment_coding.h"
#include "tests/fuzz/codec_input.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace warpscope;
  const CodecInput input = readCodecInput(std::as_bytes(std::span(data, size)));
  SampleFrame frame = input.head;

  static FrameCodec codec;  // its buffers are used again, as in a session
  const DecodeError error = codec.decode(input.payload, input.count, frame, {size_t{1} << 16, size_t{1} << 20, size_t{1} << 20});
  if (error && error->empty()) std::abort();
  const size_t expected = error ? 0 : input.count;
  if (frame.samples.size() != expected || frame.colors.size() != expected) std::abort();
  for (const SamplePlane& plane : frame.planes) {
    if (plane.values.size() != expected * bytesOf(plane.element)) std::abort();
    if (!error && !isKnown(plane.name, plane.element)) std::abort();
  }
  const SampleSettings& settings = frame.settings.sample;
  if (error ? !frame.segments.empty() || frame.proxy : whyInconsistentSegments(frame) || (settings.proxy > 0) != (frame.proxy != nullptr)) std::abort();
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
    if (layers[i] >= settings.samplesPerRay || (layers[i] != 0 && (i == 0 || layers[i] != layers[i - 1] + 1)))
      std::abort();
  return 0;
}
