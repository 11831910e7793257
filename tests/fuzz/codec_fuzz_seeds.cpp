// Writes payloads for codec_fuzz to begin with, into the folder codec_fuzz in the folder that is its argument.
// Frames of made-up samples in the fuzzer's own cameras, in every format, with and without planes.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include "render/codec/bytes.h"
#include "render/codec/codec.h"
#include "tests/frame_samples.h"
#include "tests/layered_frames.h"

namespace warpscope {
namespace {

/// As codec_fuzz reads it: format and samples a ray, width and height less one, choices, count, payload without its head.
void writeSeed(const std::filesystem::path& path, const SampleFrame& frame, const CodecSettings& settings) {
  const std::vector<std::byte> payload = FrameCodec().encode(frame, settings);
  std::vector<std::byte> seed;
  appendLittle(seed, static_cast<uint8_t>(static_cast<int>(settings.format) | (frame.settings.sample.samplesPerRay - 1) << 1));
  appendLittle(seed, static_cast<uint8_t>(frame.camera.width - 1));
  appendLittle(seed, static_cast<uint8_t>(frame.camera.height - 1));
  uint32_t choices = static_cast<uint32_t>(frame.settings.sample.radiusPolicy);
  if (frame.plane(kLayerPlane)) choices |= 32;
  if (frame.plane("future")) choices |= 64;
  if (frame.plane(kExtentPlane)) choices |= 128;
  appendLittle(seed, static_cast<uint8_t>(choices));
  appendLittle(seed, static_cast<uint16_t>(frame.size()));
  seed.insert(seed.end(), payload.begin() + 9, payload.end());
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(seed.data()), static_cast<std::streamsize>(seed.size()));
}

/// One in `oneIn` pixels has samples, `layers` at most; some depths are anything. Several have planes.
SampleFrame madeUp(uint32_t width, uint32_t height, uint32_t oneIn, uint32_t layers, bool isOnSteps, uint32_t seed) {
  std::mt19937 random(seed);
  SampleFrame frame;
  frame.camera.eye = {3.0f, 2.0f, 40.0f};
  frame.camera.width = width;
  frame.camera.height = height;
  frame.quantization = {{glm::vec3(-8.0f), glm::vec3(8.0f)}, 1.0f, 24.0f, 0x1p-13f};
  frame.settings.sample.radiusPolicy = static_cast<RadiusPolicy>(seed % kRadiusPolicies.size());
  frame.settings.sample.samplesPerRay = static_cast<int>(layers);
  std::vector<uint8_t> places;
  for (uint32_t pixel = 0; pixel < width * height; ++pixel) {
    if (random() % oneIn != 0) continue;
    for (uint32_t layer = 0, count = 1 + static_cast<uint32_t>(random()) % layers; layer < count; ++layer) {
      const float depth = 40.0f + static_cast<float>(layer) + (isOnSteps ? 0.25f : 1e-4f * static_cast<float>(random() % 10000));
      const PackedSample sample = sampleOnRay(frame, pixel, depth, 0.8f);
      const auto anyDepth = static_cast<uint64_t>(random()) << 32;
      frame.samples.push_back(random() % 50 == 0 ? anyDepth | pixelKey(sample) : sample);
      frame.colors.push_back(random());
      places.push_back(static_cast<uint8_t>(layer));
    }
  }
  if (layers == 1) return frame;
  frame.planes.push_back(layerPlane(places));
  const std::vector<uint16_t> future(frame.size(), 4711);
  const std::vector<float> extents(frame.size(), 0.5f);
  frame.planes.push_back(planeOf("future", PlaneElement::uint16, std::span<const uint16_t>(future)));
  frame.planes.push_back(planeOf(kExtentPlane, PlaneElement::float32, std::span<const float>(extents)));
  return frame;
}

}  // namespace
}  // namespace warpscope

int main(int argc, char** argv) {
  using namespace warpscope;
  if (argc != 2) {
    std::fprintf(stderr, "usage: codec_fuzz_seeds FOLDER\n");
    return 2;
  }
  const std::filesystem::path to = std::filesystem::path(argv[1]) / "codec_fuzz";
  std::filesystem::create_directories(to);
  uint32_t number = 0;
  for (const auto& format : kPayloadFormats)
    for (const auto& coding : kColorCodings)
      for (const uint32_t side : {1u, 9u, 40u})
        for (const uint32_t oneIn : {1u, 7u})
          for (const uint32_t layers : {1u, 3u}) {
            const SampleFrame frame = madeUp(side, side + 3, oneIn, layers, number / 2 % 2 == 0, number);
            writeSeed(to / std::to_string(number++), frame, {format.value, coding.value, 80});
          }
  return 0;
}
