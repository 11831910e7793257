// Writes what handshake_fuzz, message_fuzz and frame_reader_fuzz begin with, into folders of their names in the folder that is its argument.
// Honest greetings, messages and conversations.
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "net/messages.h"

namespace {

using namespace warpscope::net;

Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}
Bytes byte(int value) { return {static_cast<std::byte>(value)}; }
Bytes bodyOf(const Bytes& message) { return {message.begin() + kMessageHeadBytes, message.end()}; }

struct Writer {
  void operator()(const char* fuzzer, const Bytes& bytes) {
    const std::filesystem::path to = std::filesystem::path(folder) / fuzzer;
    std::filesystem::create_directories(to);
    std::ofstream file(to / std::to_string(number++), std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }

  const char* folder;
  int number = 0;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: net_fuzz_seeds FOLDER\n");
    return 2;
  }
  Writer write{argv[1]};
  ClientHello clientHello;
  const Bytes plain = toBytes(clientHello);
  clientHello.token = Token({1, 2, 3});
  ServerHello serverHello;
  serverHello.heartbeatMs = 2000;
  serverHello.patienceMs = 10000;
  for (const Bytes& hello : {plain, toBytes(clientHello), toBytes(serverHello)}) {
    write("handshake_fuzz", byte(0) + hello);
    write("handshake_fuzz", byte(2) + byte(1) + byte(0) + hello);
  }

  SceneFields scene;
  scene.name = "fish";
  scene.title = "A fish";
  scene.views.resize(2);
  scene.settings = {{"step", "0.5"}, {"heuristic", "gradient"}, {"samplesPerRay", "4"}};
  FrameRequest first, second;
  first.settings = scene.settings;
  first.id = 1;
  second.id = 2;
  FrameHead head;
  head.id = 1;
  head.settings = scene.settings;
  head.planes = {{"layer", 0}, {"extent", 2}, {"future", 200}};
  const Bytes failure = failureMessage({2, "sorry"}), beat = beatMessage(MessageType::ping, 7), pong = beatMessage(MessageType::pong, 7);
  const Bytes frame = frameMessage(head, 100) + Bytes(100, std::byte{7});
  Bytes anyHead;
  append(anyHead, {MessageType::frame, 1000});
  write("message_fuzz", byte(0) + anyHead);
  write("message_fuzz", byte(1) + bodyOf(sceneMessage(scene)));
  write("message_fuzz", byte(2) + bodyOf(requestMessage(first)));
  write("message_fuzz", byte(3) + bodyOf(frameMessage(head, 0)));
  write("message_fuzz", byte(4) + bodyOf(failure));
  write("message_fuzz", byte(5) + bodyOf(busyMessage(3)));
  const Bytes processes = processesMessage(std::vector<ProcessFields>(2));
  write("message_fuzz", byte(6) + bodyOf(processes));
  write("message_fuzz", byte(7) + bodyOf(beat));

  const Bytes said = sceneMessage(scene) + beat + busyMessage(3) + processes + frame + pong + failure;
  const Bytes asked = beat + requestMessage(first) + requestMessage(second) + pong;
  for (const Bytes& pieces : {byte(0), byte(3) + byte(5) + byte(0) + byte(200)}) {
    write("frame_reader_fuzz", byte(0) + pieces + toBytes(serverHello) + said);
    write("frame_reader_fuzz", byte(1) + pieces + plain + asked);
    write("frame_reader_fuzz", byte(2) + pieces + said);
    write("frame_reader_fuzz", byte(3) + pieces + asked);
  }
  return 0;
}
