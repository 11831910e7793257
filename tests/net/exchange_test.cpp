// Client and server together over loopback: greeting, requests, answers, and connecting again.
// Mirrors net/client.h and net/server.h.
#include <gtest/gtest.h>

#include <condition_variable>
#include <mutex>
#include <thread>

#include "net/client.h"
#include "net/server.h"

namespace warpscope::net {
namespace {

using namespace std::chrono_literals;

SceneFields someScene() {
  SceneFields scene;
  scene.name = "scene";
  scene.dims = {4, 5, 6};
  scene.views.push_back({10.0, 20.0, 1.5, 0.0, 0.0});
  return scene;
}

/// Keeps what a client is told, and lets a test wait for it.
class Witness final : public ClientEvents {
 public:
  void onState(const ConnectionState& state) override { note([&] { states.push_back(state); }); }
  void onScene(const SceneFields& scene) override { note([&] { scenes.push_back(scene); }); }
  void onFrame(Frame frame, const FrameArrival&) override { note([&] { frames.push_back(std::move(frame)); }); }
  void onFailure(const Failure& failure) override { note([&] { failures.push_back(failure); }); }

  template <class Condition>
  bool waitFor(Condition condition, Duration patience = 10s) {
    std::unique_lock lock(mutex);
    return changed.wait_for(lock, patience, condition);
  }
  bool isConnected() const { return !states.empty() && states.back().phase == ConnectionPhase::connected; }
  bool isRefused() const { return !states.empty() && states.back().phase == ConnectionPhase::refused; }

  std::mutex mutex;
  std::condition_variable changed;
  std::vector<ConnectionState> states;
  std::vector<SceneFields> scenes;
  std::vector<Frame> frames;
  std::vector<Failure> failures;

 private:
  template <class F>
  void note(F&& f) {
    {
      const std::scoped_lock lock(mutex);
      f();
    }
    changed.notify_all();
  }
};

/// Answers every request with a payload of so many bytes, all of them the request's id.
class Answering {
 public:
  Answering(Server& server, size_t payloadBytes)
      : thread_([&server, payloadBytes](const std::stop_token& stop) {
          while (const std::optional<RequestJob> job = server.requests().take(stop)) {
            FrameHead head;
            head.id = job->request.id;
            head.camera = job->request.camera;
            server.answer(job->client, head, Bytes(payloadBytes, static_cast<std::byte>(job->request.id)));
          }
        }) {}

 private:
  std::jthread thread_;
};

TEST(Exchange, ScenesRequestsAndFramesArrive) {
  const auto io = std::make_shared<IoThread>();
  Server server(io, {.scene = someScene()});
  const Answering answering(server, 200'000);
  Witness witness;
  Client client(io, {.address = server.address()}, witness);
  ASSERT_TRUE(witness.waitFor([&] { return witness.isConnected(); }));
  ASSERT_EQ(witness.scenes.size(), 1u);
  EXPECT_EQ(witness.scenes[0], someScene());
  for (uint64_t id = 1; id <= 5; ++id) {
    FrameRequest request;
    request.id = id;
    request.camera.width = 100 + static_cast<uint32_t>(id);
    client.request(request);
    ASSERT_TRUE(witness.waitFor([&] { return witness.frames.size() == id; }));
    EXPECT_EQ(witness.frames.back().head.id, id);
    EXPECT_EQ(witness.frames.back().head.camera.width, 100 + id);
    EXPECT_EQ(witness.frames.back().payload, Bytes(200'000, static_cast<std::byte>(id)));
  }
}

TEST(Exchange, TlsWithTheRightTokenWorksAndWithAWrongOneIsRefused) {
  const auto io = std::make_shared<IoThread>();
  Server server(io, {.identity = makeIdentity(), .token = Token::random(), .scene = someScene()});
  {
    Witness witness;
    Client client(io, {.address = server.address()}, witness);
    EXPECT_TRUE(witness.waitFor([&] { return witness.isConnected(); }));
  }
  Address other = server.address();
  other.credentials->token = Token::random();
  Witness witness;
  Client client(io, {.address = other}, witness);
  ASSERT_TRUE(witness.waitFor([&] { return witness.isRefused(); }));
  EXPECT_NE(witness.states.back().sentence.find("does not accept this token"), std::string::npos) << witness.states.back().sentence;
}

TEST(Exchange, AClientConnectsAgainAndAsksAgain) {
  const auto io = std::make_shared<IoThread>();
  auto server = std::make_unique<Server>(io, ServerSettings{.scene = someScene()});
  const Address address = server->address();
  Witness witness;
  Client client(io, {.address = address, .firstPause = 10ms, .longestPause = 50ms}, witness);
  ASSERT_TRUE(witness.waitFor([&] { return witness.isConnected(); }));
  FrameRequest request;
  request.id = 7;
  client.request(request);
  std::this_thread::sleep_for(20ms);
  server.reset();
  ASSERT_TRUE(witness.waitFor([&] { return !witness.isConnected(); }));
  server = std::make_unique<Server>(io, ServerSettings{.listen = address.where, .scene = someScene()});
  const Answering answering(*server, 10);
  ASSERT_TRUE(witness.waitFor([&] { return witness.frames.size() == 1; }));
  EXPECT_EQ(witness.frames[0].head.id, 7u);
}

}  // namespace
}  // namespace warpscope::net
