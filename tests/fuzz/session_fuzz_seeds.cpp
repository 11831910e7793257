// Writes what client_session_fuzz begins with, into the folder of its name in the folder that is its argument.
// Honest sessions: a greeting, a scene, and frames or pictures in every format, with and without several samples a ray.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <span>

#include "app/frames/color_bytes.h"
#include "tests/frame_samples.h"
#include "tests/fuzz/client_session.h"
#include "tests/layered_frames.h"

namespace {

using namespace warpscope;
using net::Bytes;

void add(Bytes& to, std::span<const std::byte> bytes) { to.insert(to.end(), bytes.begin(), bytes.end()); }

SampleFrame madeUp(const AskedInFuzzing& asked) {
  SampleFrame frame;
  frame.camera = asked.camera;
  frame.settings = asked.settings;
  frame.quantization = {{glm::vec3(-8.0f), glm::vec3(8.0f)}, 1.0f, 24.0f, 0x1p-13f};
  std::vector<uint8_t> layers;
  for (uint32_t pixel = 0; pixel < asked.camera.width * asked.camera.height; pixel += 7)
    for (int k = 0; k < asked.settings.sample.samplesPerRay; ++k) {
      frame.samples.push_back(packCodes(pixel % asked.camera.width, pixel / asked.camera.width,
                                        1000 * pixel + static_cast<uint32_t>(k), 512));
      frame.colors.push_back(0x80000000u | pixel);
      layers.push_back(static_cast<uint8_t>(k));
    }
  if (asked.settings.sample.samplesPerRay > 1) frame.planes.push_back(layerPlane(layers));
  return frame;
}

net::SceneFields someScene() {
  net::SceneFields scene;
  scene.name = "fish";
  scene.title = "A fish";
  scene.dims = {4, 5, 6};
  scene.spacing = {1.0, 1.0, 1.0};
  scene.direction = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  scene.up = {0, 0, 1};
  scene.front = {0, 1, 0};
  scene.fovYDeg = 45.0;
  scene.views.resize(2);
  scene.settings = toFields(MarchSettings{});
  return scene;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: session_fuzz_seeds FOLDER\n");
    return 2;
  }
  const std::filesystem::path to = std::filesystem::path(argv[1]) / "client_session_fuzz";
  std::filesystem::create_directories(to);
  net::ServerHello hello;
  hello.depth = 2;
  hello.heartbeatMs = 2000;
  hello.patienceMs = 10'000;
  for (uint8_t choices = 0; choices < 32; ++choices) {
    const AskedInFuzzing asked(choices);
    Bytes said{static_cast<std::byte>(choices)};
    add(said, choices & 8 ? Bytes{std::byte{2}, std::byte{100}, std::byte{0}} : Bytes{std::byte{0}});  // pieces
    add(said, net::toBytes(hello));
    add(said, net::sceneMessage(someScene()));
    add(said, net::busyMessage(3));
    add(said, net::processesMessage(std::vector<net::ProcessFields>(2)));
    add(said, net::beatMessage(net::MessageType::ping, 5));
    net::FrameHead head;
    ByteVector payload;
    if (asked.wanted == net::Wanted::samples) {
      const SampleFrame frame = madeUp(asked);
      head = headOf(frame, asked.codec);
      payload = FrameCodec().encode(frame, asked.codec);
    } else {
      payload = encodeColors(Image<glm::vec4>(asked.camera.width, asked.camera.height));
    }
    const net::FrameRequest request = asked.request(1);
    head.id = request.id;
    head.wanted = request.wanted;
    head.camera = request.camera;
    head.settings = request.settings;
    head.codec = request.codec;
    // A seed that is refused leads nowhere.
    if (const std::string fault = faultOf(head, payload.size()); !fault.empty() || sceneFrom(someScene()).views.empty()) {
      std::fprintf(stderr, "session_fuzz_seeds: %s\n", fault.c_str());
      return 1;
    }
    add(said, net::frameMessage(head, payload.size()));
    add(said, payload);
    add(said, net::failureMessage({2, "sorry"}));
    std::ofstream file(to / std::to_string(choices), std::ios::binary);
    file.write(reinterpret_cast<const char*>(said.data()), static_cast<std::streamsize>(said.size()));
  }
  return 0;
}
