// Writes payloads for codec_fuzz to begin with, into the folder codec_fuzz in the folder that is its argument.
// Frames of made-up samples in the fuzzer's own cameras, in every format, with and without planes, segments and a copy of the volume.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include "tests/frame_samples.h"
#include "tests/fuzz/codec_input.h"
#include "tests/layered_frames.h"

namespace warpscope {
namespace {

/// False if the fuzzer would read something else of it than the frame.
bool writeSeed(const std::filesystem::path& path, const SampleFrame& frame, const CodecSettings& settings) {
  const ByteVector seed = codecInput(frame, settings.format, FrameCodec().encode(frame, settings));
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(seed.data()), static_cast<std::streamsize>(seed.size()));
  const CodecInput input = readCodecInput(seed);
  SampleFrame again = input.head;
  const DecodeError error = FrameCodec().decode(input.payload, input.count, again);
  if (error) std::fprintf(stderr, "%s: %s\n", path.c_str(), error->c_str());
  return !error && again.samples == frame.samples && again.segments.rays == frame.segments.rays && again.segments.depths == frame.segments.depths;
}

/// Adds segments, `most` in a pixel, and a copy of the volume.
void addSegmentsAndProxy(SampleFrame& frame, int most, std::mt19937& random) {
  frame.settings.sample.segments = most;
  for (size_t pixel = 0; pixel < size_t{frame.camera.width} * frame.camera.height; ++pixel) {
    const int count = static_cast<int>(random() % static_cast<uint32_t>(most + 1));
    frame.segments.rays.push_back({count, random() % 2 == 0});
    uint32_t end = static_cast<uint32_t>(random() % 1000);
    for (int i = 0; i < count; ++i) {
      const uint32_t begin = end + static_cast<uint32_t>(random() % 2) * 4096;
      end = begin + static_cast<uint32_t>(random() % 8192);
      frame.segments.depths.push_back({begin, end});
      frame.segments.colors.push_back(random());
      if (most % 2 == 0) frame.segments.normals.push_back(static_cast<NormalCode>(random()));
    }
  }
  VolumeGeometry geometry;
  geometry.dims = {5, 4, 3};
  auto voxels = std::make_shared<std::vector<uint8_t>>(5 * 4 * 3);
  for (uint8_t& voxel : *voxels) voxel = static_cast<uint8_t>(random());
  const void* const data = voxels->data();
  Proxy proxy;
  proxy.volume = std::make_shared<const Volume>("copy", VoxelType::uint8, geometry, std::move(voxels), data);
  proxy.function = {{{0.0, glm::vec3(0.2f), 0.0f}, {255.0, glm::vec3(1.0f), 0.5f}}};
  frame.settings.sample.proxy = 5;
  frame.proxy = std::make_shared<const Proxy>(std::move(proxy));
}

/// One in `oneIn` pixels has samples, `layers` at most; some depths are anything. Several have planes, some of these segments as well.
SampleFrame madeUp(uint32_t width, uint32_t height, uint32_t oneIn, uint32_t layers, bool isOnSteps, uint32_t seed) {
  std::mt19937 random(seed);
  SampleFrame frame;
  frame.camera.eye = kFuzzedEye;
  frame.camera.width = width;
  frame.camera.height = height;
  frame.quantization = kFuzzedQuantization;
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
  if (seed % 3 != 0) addSegmentsAndProxy(frame, 1 + static_cast<int>(seed % 5), random);
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
  bool areAllRead = true;
  for (const auto& format : kPayloadFormats)
    for (const auto& coding : kColorCodings)
      for (const uint32_t side : {1u, 9u, 40u})
        for (const uint32_t oneIn : {1u, 7u})
          for (const uint32_t layers : {1u, 3u}) {
            const SampleFrame frame = madeUp(side, side + 3, oneIn, layers, number / 2 % 2 == 0, number);
            areAllRead = writeSeed(to / std::to_string(number++), frame, {format.value, coding.value, 80}) && areAllRead;
          }
  if (!areAllRead) std::fprintf(stderr, "codec_fuzz would read other frames than these\n");
  return areAllRead ? 0 : 1;
}
