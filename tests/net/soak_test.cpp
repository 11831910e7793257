// Many clients for a long time over links that fail in every way: every frame is right, nothing grows, nobody is lost.
// WARPSCOPE_SOAK_S says how long, in seconds (5). Faults: simulated links, and a proxy that cuts, resets, slices and holds back.
#include <cstdlib>
#include <iostream>
#include <random>

#include "tests/net/exchange.h"

namespace warpscope::net {
namespace {

/// Between clients and a server: each connection lives for a time by chance, bytes pass in slices by chance, some wait.
class FaultyProxy {
 public:
  FaultyProxy(uint16_t target, uint32_t seed, std::chrono::milliseconds longestLife)
      : target_(target), random_(seed), longestLife_(longestLife), thread_([this](const std::stop_token& stop) { run(stop); }) {}

  Address address() const { return listener_.address(); }
  int cuts() const { return cuts_; }

 private:
  struct Line {
    BareSocket client, server;
    TimePoint end;
  };

  void run(const std::stop_token& stop) {
    std::vector<Line> lines;
    while (!stop.stop_requested()) {
      if (BareSocket client = listener_.accept(lines.empty() ? 20ms : 0ms); client.isOpen()) {
        const auto life = std::chrono::milliseconds(random_() % static_cast<unsigned long>(longestLife_.count()));
        lines.push_back({std::move(client), BareSocket::connect(target_, 16 << 10), now() + life});
      }
      std::vector<pollfd> waiting;
      for (const Line& line : lines) {
        waiting.push_back({line.client.handle(), POLLIN, 0});
        waiting.push_back({line.server.handle(), POLLIN, 0});
      }
      ::poll(waiting.data(), waiting.size(), 5);
      for (size_t i = 0; i < lines.size(); ++i) {
        const bool isOver = now() > lines[i].end;
        if (!isOver && (waiting[2 * i].revents == 0 || pass(lines[i].client, lines[i].server)) &&
            (waiting[2 * i + 1].revents == 0 || pass(lines[i].server, lines[i].client)))
          continue;
        if (isOver) ++cuts_;
        if (random_() % 2 == 0) {
          lines[i].client.reset();
          lines[i].server.reset();
        }
        lines[i].client.close();
        lines[i].server.close();
      }
      std::erase_if(lines, [](const Line& line) { return !line.client.isOpen(); });
    }
  }

  /// False at an end.
  bool pass(BareSocket& from, BareSocket& to) {
    std::array<std::byte, 16384> piece;
    if (random_() % 16 == 0) return true;  // later
    const size_t most = random_() % 4 == 0 ? 1 + random_() % 50 : piece.size();
    const ssize_t got = ::recv(from.handle(), piece.data(), most, MSG_DONTWAIT);
    if (got < 0 && errno == EAGAIN) return true;
    return got > 0 && to.send(ByteView(piece).first(static_cast<size_t>(got)), 2s);
  }

  BareListener listener_;
  const uint16_t target_;
  std::mt19937 random_;
  const std::chrono::milliseconds longestLife_;
  std::atomic<int> cuts_ = 0;
  std::jthread thread_;
};

/// What a frame for an id holds, so that any byte lost, doubled or swapped shows.
Bytes payloadOf(uint64_t id) {
  std::minstd_rand random(static_cast<uint32_t>(id * 2654435761u % 2147483646u + 1));
  Bytes bytes(1000 + random() % 60'000);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random() >> 8);
  return bytes;
}

/// Asks for the next frame when one comes, and checks each.
class Checking final : public ClientEvents {
 public:
  void onState(const ConnectionState& state) override {
    if (state.phase == ConnectionPhase::connected) ++connections;
    if (state.phase == ConnectionPhase::refused) ++refusals;
    if (state.phase == ConnectionPhase::waiting) {
      const std::scoped_lock lock(mutex);
      lastSentence = state.sentence;
    }
  }
  void onScene(const SceneFields& scene) override { wrong += !(scene == someScene()); }
  std::string faultOf(const FrameHead&, uint64_t) override { return {}; }
  void onFrame(Frame frame, const FrameArrival& arrival) override {
    ++frames;
    bytes += frame.payload.size();
    wrong += frame.payload != payloadOf(frame.head.id);
    wrong += frame.head.id <= lastId || frame.head.requestSentAtNs == 0;
    wrong += arrival.requestedAt > arrival.sentAt || arrival.sentAt > arrival.beganAt || arrival.beganAt > arrival.arrivedAt;
    lastId = frame.head.id;
    lastFrameAt = now().time_since_epoch().count();
  }
  void onFailure(const Failure&) override { ++wrong; }
  void onRoundTrip(Duration) override { ++roundTrips; }

  std::atomic<int> connections = 0, refusals = 0, wrong = 0, roundTrips = 0;
  std::atomic<uint64_t> frames = 0, bytes = 0, lastId = 0;
  std::atomic<Duration::rep> lastFrameAt = 0;
  std::mutex mutex;
  std::string lastSentence;
};

double soakSeconds() {
  const char* const text = std::getenv("WARPSCOPE_SOAK_S");
  return text != nullptr ? std::max(2.0, std::atof(text)) : 5.0;
}

TEST(Soak, ManyClientsOverBadLinks) {
  alarm(static_cast<unsigned>(soakSeconds()) + 300);  // ends the process if it hangs
  const double duration = soakSeconds();
  const size_t filesBefore = openFiles();
  {
    const auto io = std::make_shared<IoThread>();
    Notes notes;
    Server server(io, {.scene = someScene(), .clients = {16, 16}, .heartbeat = 100ms, .patience = 3s});
    std::jthread answering([&](const std::stop_token& stop) {
      while (const std::optional<RequestJob> job = server.requests().take(stop)) {
        FrameHead head = headOf(job->request.id);
        head.requestSentAtNs = job->request.sentAtNs;
        server.answer(job->client, head, payloadOf(job->request.id));
      }
    });
    FaultyProxy proxy(server.port(), 17, 2000ms);
    struct Kind {
      const char* link;
      bool isThroughProxy;
    };
    // The first two are healthy: they have to stay connected all the time.
    constexpr std::array<Kind, 8> kKinds{{{"none", false},
                                          {"delay=20", false},
                                          {"delay=10,jitter=normal:5,loss=2%", false},
                                          {"delay=5,rate=20M", false},
                                          {"delay=5,outage=200/~1000", false},
                                          {"none", true},
                                          {"delay=10,jitter=5", true},
                                          {"delay=2,loss=5%,outage=100/500", true}}};
    std::array<Checking, kKinds.size()> checks;
    std::vector<std::unique_ptr<Client>> clients;
    for (size_t i = 0; i < kKinds.size(); ++i) {
      ClientSettings settings;
      settings.address = kKinds[i].isThroughProxy ? proxy.address() : server.address();
      settings.link = parseLinkSettings(kKinds[i].link);
      settings.link.up.seed = settings.link.down.seed = i + 1;
      settings.depth = static_cast<uint16_t>(1 + i % 4);
      settings.firstPause = 10ms;
      settings.longestPause = 200ms;
      clients.push_back(std::make_unique<Client>(io, settings, checks[i]));
    }
    const TimePoint begin = now();
    uint64_t id = 0;
    size_t middle = 0, greatest = 0;
    double sinceLook = 0.0;
    while (secondsSince(begin) < duration) {
      ++id;
      FrameRequest request = requestOf(id);
      for (const auto& client : clients) client->request(request);
      if (id % 500 == 0) clients[3]->setLink(parseLinkSettings(id % 1000 == 0 ? "delay=5,rate=20M" : "delay=30,jitter=10"));
      std::this_thread::sleep_for(4ms);
      const double past = secondsSince(begin);
      if (past < sinceLook + 0.25) continue;
      sinceLook = past;
      // What is resident jumps about with frames in flight: the greatest of each half is compared.
      (past < duration / 2.0 ? middle : greatest) = std::max(past < duration / 2.0 ? middle : greatest, memoryBytes());
    }
    for (const auto& client : clients) client->request(requestOf(id + 1));
    uint64_t frames = 0, bytes = 0;
    for (size_t i = 0; i < kKinds.size(); ++i) {
      EXPECT_TRUE(comesTrue([&] { return checks[i].lastId == id + 1; }, 20s)) << "client " << i << " was lost";
      EXPECT_EQ(checks[i].wrong, 0) << "client " << i;
      EXPECT_EQ(checks[i].refusals, 0) << "client " << i;
      EXPECT_GT(checks[i].frames, 10u) << "client " << i;
      frames += checks[i].frames;
      bytes += checks[i].bytes;
      const std::scoped_lock lock(checks[i].mutex);
      std::cout << "client " << i << " (" << kKinds[i].link << (kKinds[i].isThroughProxy ? ", proxy" : "") << "): " << checks[i].frames
                << " frames, " << checks[i].connections << " connections, " << checks[i].roundTrips << " heartbeats, last end: '"
                << checks[i].lastSentence << "'\n";
    }
    for (const size_t healthy : {0, 1}) {
      EXPECT_EQ(checks[healthy].connections, 1) << checks[healthy].lastSentence;
      // One each 100 ms, unless the machine has other things to do; a long run has quiet hours too.
      EXPECT_GE(checks[healthy].roundTrips, static_cast<int>((duration >= 60.0 ? 0.7 : 0.1) * duration / 0.1));
    }
    EXPECT_GT(proxy.cuts(), 0);
    std::cout << frames << " frames, " << bytes / 1'000'000 << " MB in " << secondsSince(begin) << " s, " << proxy.cuts()
              << " connections cut; resident at most " << middle / 1024 << " KiB in the first half, " << greatest / 1024
              << " KiB in the second\n";
    // Too short a run still warms up, and sanitizers keep what was freed.
    if (duration >= 60.0 && !kIsSanitized) {
      EXPECT_LT(static_cast<double>(greatest), 1.05 * static_cast<double>(middle));
    }
  }
  EXPECT_TRUE(comesTrue([&] { return openFiles() == filesBefore; }));
}

}  // namespace
}  // namespace warpscope::net
