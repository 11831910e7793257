// A server that greets as it should and then does what its test wants: lies, floods, drips. For tests of everything
// that takes a server's frames: net::Client, the sources and marchers behind it, and the program. Raw bytes over
// loopback; connections are served side by side, each in a thread of its own.
#pragma once

#include <functional>
#include <list>

#include "tests/net/exchange.h"

namespace warpscope::net {

/// An answer's head with what was asked for, as an honest server repeats it, and no samples.
inline FrameHead echoOf(const FrameRequest& request) {
  FrameHead head;
  head.id = request.id;
  head.wanted = request.wanted;
  head.camera = request.camera;
  head.settings = request.settings;
  head.codec = request.codec;
  head.requestSentAtNs = request.sentAtNs;
  return head;
}

class AdversarialServer {
 public:
  /// Whether the connection goes on; told the request.
  using Answer = std::function<bool(BareSocket& to, const FrameRequest& request)>;

  AdversarialServer(SceneFields scene, Answer answer)
      : scene_(std::move(scene)),
        answer_(std::move(answer)),
        thread_([this](const std::stop_token& stop) { accept(stop); }) {}

  Address address() const { return listener_.address(); }
  std::string url() const { return "warp://127.0.0.1:" + std::to_string(listener_.port()); }
  /// Connections so far: a client that has been lied to does not come back.
  int connections() const { return connections_; }

 private:
  void accept(const std::stop_token& stop) {
    std::list<std::jthread> sessions;
    while (!stop.stop_requested()) {
      BareSocket socket = listener_.accept(20ms);
      if (!socket.isOpen()) continue;
      ++connections_;
      sessions.emplace_back([this, shared = std::make_shared<BareSocket>(std::move(socket))](
                                const std::stop_token& end) { serve(*shared, end); });
    }
  }
  void serve(BareSocket& socket, const std::stop_token& stop) const {
    if (!readClientHello(socket.receive(kClientHelloBytes))) return;
    ServerHello hello;
    hello.heartbeatMs = 1000;
    hello.patienceMs = 10'000;
    socket.send(toBytes(hello) + sceneMessage(scene_));
    while (!stop.stop_requested()) {
      const std::optional<BareSocket::Message> message = receive(socket, stop);
      if (!message) return;
      if (message->type == MessageType::ping) socket.send(beatMessage(MessageType::pong, *readBeat(message->body)));
      if (message->type != MessageType::request) continue;
      const std::optional<FrameRequest> request = readRequest(message->body);
      if (!request || !answer_(socket, *request)) return;
    }
  }
  /// Nothing when the client is gone, or the test at its end.
  static std::optional<BareSocket::Message> receive(BareSocket& socket, const std::stop_token& stop) {
    pollfd waiting{socket.handle(), POLLIN, 0};
    while (!stop.stop_requested())
      if (::poll(&waiting, 1, 20) > 0) return socket.receiveMessage(5s);
    return std::nullopt;
  }

  const SceneFields scene_;
  const Answer answer_;
  BareListener listener_;
  std::atomic<int> connections_ = 0;
  std::jthread thread_;
};

/// The most memory that was resident at a time since it was made.
class PeakMemory {
 public:
  PeakMemory() { std::ofstream("/proc/self/clear_refs") << "5"; }

  /// Beyond what was resident when it was made; nothing where the system does not tell.
  std::optional<size_t> grownBytes() const {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
      if (line.starts_with("VmHWM:")) return std::max(before_, size_t{1024} * std::stoul(line.substr(6))) - before_;
    return std::nullopt;
  }

 private:
  const size_t before_ = memoryBytes();
};

}  // namespace warpscope::net
