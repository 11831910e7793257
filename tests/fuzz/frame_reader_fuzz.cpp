// A whole conversation made up by libFuzzer: what a client reads of a server and a server of a client, in pieces, until it ends.
// The first byte: bit 0 says which side reads, bit 1 leaves the greeting out. Then see memory_stream.h.
#include <cstdint>
#include <cstdlib>

#include "net/reading.h"
#include "tests/fuzz/memory_stream.h"

namespace {

using namespace warpscope::net;

constexpr Duration kPatience = std::chrono::hours(1);
constexpr uint64_t kLastId = 8;

void require(bool condition) {
  if (!condition) std::abort();
}

/// As a server session does: ids have to grow.
class Server final : public FromClient {
 public:
  bool onRequest(const FrameRequest& request) override {
    if (request.id <= lastId_) return false;
    lastId_ = request.id;
    return true;
  }
  void onPing(uint64_t) override {}

 private:
  uint64_t lastId_ = 0;
};

/// As a client with some requests under way.
class Client final : public FromServer {
 public:
  explicit Client(size_t inputBytes) : inputBytes_(inputBytes) {}

  std::string faultOf(const FrameHead& head, uint64_t payloadBytes) override {
    require(payloadBytes <= kMaxFrameBytes);
    return faultOf(head.id);
  }
  std::string faultOf(const Failure& failure) override { return faultOf(failure.id); }
  void onFrame(Frame frame, TimePoint) override {
    require(frame.head.id == lastId_);
    require(frame.head.planes.size() <= kMaxPlanes && frame.head.settings.size() <= kMaxSettings);
    // Memory follows what has come, not what was announced.
    require(frame.payload.size() <= inputBytes_ && frame.payload.capacity() <= 2 * inputBytes_ + kPieceBytes);
  }
  void onFailure(const Failure& failure) override { require(failure.id == lastId_ && failure.sentence.size() < kMaxFailureBytes); }
  void onPing(uint64_t) override {}
  void onPong(uint64_t) override {}
  void onBusy(uint16_t) override {}
  void onProcesses(std::vector<ProcessFields>) override {}

 private:
  std::string faultOf(uint64_t id) {
    if (id <= lastId_ || id > kLastId) return "nobody waits for it";
    lastId_ = id;
    return {};
  }

  const size_t inputBytes_;
  uint64_t lastId_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  static asio::io_context io(1);
  const bool isServer = data[0] & 1, isGreeted = data[0] & 2;
  const FuzzedPeer peer(std::span(data, size).subspan(1));
  runOnBytes(io, [&]() -> Awaitable<void> {
    Channel channel(std::make_unique<MemoryStream>(io.get_executor(), peer.bytes, peer.pieces), kPatience);
    const TimePoint deadline = std::chrono::steady_clock::now() + kPatience;
    if (isServer) {
      if (!isGreeted) co_await receiveClientHello(channel.stream(), deadline);
      Server server;
      co_await readClient(channel, server);
    } else {
      if (!isGreeted) co_await receiveServerHello(channel.stream(), deadline);
      const SceneFields scene = co_await readFirstScene(channel);
      require(!scene.views.empty() && scene.views.size() <= kMaxViews && scene.settings.size() <= kMaxSettings);
      Client client(peer.bytes.size());
      co_await readServer(channel, kMaxFrameBytes, client);
    }
  });
  return 0;
}
