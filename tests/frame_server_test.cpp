// What strangers' requests may take: time in turns, memory from a budget, and what is given back; with heavy clients, slow readers and honest ones.
// Mirrors app/frames/frame_server.h.
#include "app/frames/frame_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

#include "app/frames/coarsening.h"
#include "app/frames/frame_fetch.h"
#include "app/frames/remote_frame_source.h"
#include "app/frames/remote_marcher.h"
#include "app/frames/wire_fields.h"
#include "headless.h"
#include "render/base/error.h"
#include "render/core/parallel.h"
#include "tests/held_frame.h"
#include "tests/marcher_around.h"
#include "tests/net/exchange.h"

namespace warpscope {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;

std::string refusalOf(Marcher& marcher, const Camera& camera, const MarchSettings& settings) {
  try {
    marcher.march(camera, settings);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no refusal";
}

class FrameServerTest : public ::testing::Test {
 protected:
  FrameServer& serve(ServeLimits limits, const net::ServerSettings& settings = {}) {
    return serve(limits, makeMarcher(Backend::cpu, scene_.volume, scene_.transferFunction, {}), settings);
  }
  FrameServer& serve(ServeLimits limits, MarcherPtr marcher, const net::ServerSettings& settings = {}) {
    server_ = std::make_unique<FrameServer>(io_, scene_, std::move(marcher), settings, limits);
    return *server_;
  }
  MarcherPtr client() {
    net::ClientSettings settings;
    settings.address = server_->address();
    CodecSettings raw;
    raw.format = PayloadFormat::raw;
    return makeRemoteMarcher(io_, settings, raw, 60s);
  }
  Camera camera(uint32_t width, uint32_t height) const { return makeCamera(scene_, scene_.views.front(), width, height); }
  /// More than any machine does in a test.
  MarchSettings endless() const {
    MarchSettings settings = scene_.march;
    settings.render.step = 0.001f;
    settings.render.skipEmpty = settings.render.terminateEarly = false;
    return settings;
  }

  const std::shared_ptr<net::IoThread> io_ = std::make_shared<net::IoThread>();
  Scene scene_ = [] {
    Scene scene = smallScene("shells");
    scene.march = neededBy({}, scene.march);  // samples alone
    return scene;
  }();
  std::unique_ptr<FrameServer> server_;
};

TEST_F(FrameServerTest, HeavyClientsHoldUpNobody) {
  const auto begun = std::make_shared<std::atomic<int>>(0);
  serve({.work = 1h}, std::make_shared<BegunMarcher>(makeMarcher(Backend::cpu, scene_.volume, scene_.transferFunction, {}), begun));
  std::vector<std::jthread> heavy;
  for (int i = 0; i < 15; ++i)
    heavy.emplace_back([this](const std::stop_token& stop) {
      EXPECT_THROW(client()->march(camera(512, 512), endless(), stop), OperationCancelled);
    });
  ASSERT_TRUE(net::comesTrue([&] { return *begun == 15; })) << *begun;
  const MarcherPtr honest = client();
  honest->march(camera(64, 48), scene_.march);  // it is connected
  double slowest = 0.0;
  for (int i = 0; i < 10; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    const SampleFrame frame = honest->march(camera(64, 48), scene_.march);
    slowest = std::max(slowest, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    EXPECT_GT(frame.size(), 0u);
  }
  RecordProperty("slowestMs", std::to_string(1e3 * slowest));
  EXPECT_LT(slowest, 2.0) << "a turn comes after 15 slices of 8 ms";
  for (std::jthread& client : heavy) client.request_stop();
}

TEST_F(FrameServerTest, AMarchThatTakesTooLongIsRefusedWithWhatWouldFit) {
  serve({.work = 50ms});
  const MarcherPtr client = this->client();
  EXPECT_THAT(refusalOf(*client, camera(512, 512), endless()),
              AllOf(HasSubstr("512x512 at a step of 0.001 takes longer than the 0.05 s of marching that the server gives a request"), HasSubstr("would fit, or ")));
  EXPECT_GT(client->march(camera(32, 24), scene_.march).size(), 0u) << "the connection goes on";
}

TEST_F(FrameServerTest, AFrameThatTakesTooMuchMemoryIsRefusedWithWhatWouldFit) {
  serve({.memoryBytes = size_t{256} << 20});
  const MarcherPtr client = this->client();
  EXPECT_THAT(refusalOf(*client, camera(1024, 1024), scene_.march), AllOf(HasSubstr("1024x1024 takes about 41 MiB"), HasSubstr("at most 16 MiB"), HasSubstr("would fit")));
  EXPECT_GT(client->march(camera(600, 600), scene_.march).size(), 0u);
}

/// Holds the first march of pictures of that width back until it is let go.
class HeldBackMarcher final : public MarcherAround {
 public:
  struct Gate {
    std::atomic<bool> hasBegun = false, isOpen = false;
  };
  static constexpr uint32_t kWidth = 65;
  HeldBackMarcher(MarcherPtr inner, std::shared_ptr<Gate> gate) : MarcherAround(std::move(inner)), gate_(std::move(gate)) {}

  SampleFrame march(const Camera& camera, const MarchSettings& settings, const std::stop_token& stop) override {
    if (camera.width == kWidth) gate_->hasBegun = true;
    while (camera.width == kWidth && !gate_->isOpen && !stop.stop_requested()) std::this_thread::sleep_for(1ms);
    return inner_->march(camera, settings, stop);
  }

 protected:
  MarcherPtr around(MarcherPtr inner) const override { return std::make_shared<HeldBackMarcher>(std::move(inner), gate_); }

 private:
  const std::shared_ptr<Gate> gate_;
};

TEST_F(FrameServerTest, TheAnswerToWhatWasGivenUpIsNotTheNextOnes) {
  const auto gate = std::make_shared<HeldBackMarcher::Gate>();
  serve({}, std::make_shared<HeldBackMarcher>(makeMarcher(Backend::cpu, scene_.volume, scene_.transferFunction, {}), gate));
  const MarcherPtr client = this->client();
  {
    std::jthread given([&](const std::stop_token& stop) {
      EXPECT_THROW(client->march(camera(HeldBackMarcher::kWidth, 40), scene_.march, stop), OperationCancelled);
    });
    ASSERT_TRUE(net::comesTrue([&] { return gate->hasBegun.load(); }, 20s));
    given.request_stop();
  }
  std::jthread opening([&] {
    std::this_thread::sleep_for(100ms);  // until the next one has been asked for
    gate->isOpen = true;
  });
  const SampleFrame frame = client->march(camera(64, 48), scene_.march);
  EXPECT_EQ(frame.camera.width, 64u);
}

/// Looks where its loops run.
class WatchedMarcher final : public MarcherAround {
 public:
  WatchedMarcher(MarcherPtr inner, std::shared_ptr<std::atomic<int>> nice) : MarcherAround(std::move(inner)), nice_(std::move(nice)) {}

  SampleFrame march(const Camera& camera, const MarchSettings& settings, const std::stop_token& stop) override {
    parallelForRanges(8, 1, [&](size_t, size_t) { *nice_ = getpriority(PRIO_PROCESS, static_cast<id_t>(gettid())); });
    return inner_->march(camera, settings, stop);
  }

 private:
  MarcherPtr around(MarcherPtr inner) const override { return std::make_shared<WatchedMarcher>(std::move(inner), nice_); }

  const std::shared_ptr<std::atomic<int>> nice_;
};

TEST_F(FrameServerTest, ItsOwnProcessGoesFirst) {
  const int here = getpriority(PRIO_PROCESS, static_cast<id_t>(gettid()));
  if (here >= 19) GTEST_SKIP() << "nothing stands behind nice 19";
  const auto nice = std::make_shared<std::atomic<int>>(here - 1);
  const auto watched = std::make_shared<WatchedMarcher>(makeMarcher(Backend::cpu, scene_.volume, scene_.transferFunction, {}), nice);
  server_ = std::make_unique<FrameServer>(io_, scene_, watched, net::ServerSettings{});
  EXPECT_GT(client()->march(camera(64, 48), scene_.march).size(), 0u);
  EXPECT_GT(*nice, here);
  server_ = std::make_unique<FrameServer>(io_, scene_, watched, net::ServerSettings{}, ServeLimits{});
  EXPECT_GT(client()->march(camera(64, 48), scene_.march).size(), 0u);
  EXPECT_EQ(*nice, here) << "a server of its own has nobody to let go first";
}

/// Leaves frames on a device that fails before anybody reads them.
class LosingMarcher final : public MarcherAround {
 public:
  LosingMarcher(MarcherPtr inner, std::shared_ptr<std::atomic<int>> lost) : MarcherAround(std::move(inner)), lost_(std::move(lost)) {}

  SampleFrame marchToCode(const Camera& camera, const MarchSettings& settings, const std::stop_token& stop) override {
    ++*lost_;
    return leftOnDevice(inner_->march(camera, settings, stop), true);
  }

 private:
  MarcherPtr around(MarcherPtr inner) const override { return std::make_shared<LosingMarcher>(std::move(inner), lost_); }

  const std::shared_ptr<std::atomic<int>> lost_;
};

TEST_F(FrameServerTest, AFrameThatIsLostWithItsDeviceIsMarchedOnceMore) {
  const auto lost = std::make_shared<std::atomic<int>>(0);
  const MarcherPtr marcher = makeMarcher(Backend::cpu, scene_.volume, scene_.transferFunction, {});
  server_ = std::make_unique<FrameServer>(io_, scene_, std::make_shared<LosingMarcher>(marcher, lost), net::ServerSettings{}, ServeLimits{});
  net::ClientSettings settings;
  settings.address = server_->address();
  CodecSettings tiled;
  tiled.format = PayloadFormat::tiled;
  const SampleFrame expected = marcher->march(camera(64, 48), scene_.march), got = makeRemoteMarcher(io_, settings, tiled, 60s)->march(camera(64, 48), scene_.march);
  EXPECT_EQ(*lost, 1);
  EXPECT_EQ(got.samples, expected.samples);
  EXPECT_EQ(got.colors, expected.colors);
}

TEST_F(FrameServerTest, AMovingCameraIsMarchedCoarserWhereThatIsWantedAndInFullAtRest) {
  serve({});
  net::ClientSettings settings;
  settings.address = server_->address();
  const std::shared_ptr<FrameSource> source = connectFrameSource(io_, settings, [] {}, {}).source;
  TransportSettings transport;
  transport.server.movingMs = 1;  // less than any march of so fine a step takes
  source->setTransport(transport);
  MarchSettings fine = scene_.march;
  fine.render.step = 0.01f;
  fine.render.skipEmpty = fine.render.terminateEarly = false;
  const FrameFetch fetch = fetchFrom(source);
  const auto stepOf = [&](uint32_t height) { return fetch(camera(256, height), fine, {}).frame->settings.render.step; };
  EXPECT_EQ(stepOf(200), 0.01f) << "nobody knows yet whether it moves";
  EXPECT_GT(stepOf(201), 0.011f);
  EXPECT_GT(stepOf(202), 0.011f);
  EXPECT_EQ(stepOf(202), 0.01f) << "refined";
  transport.server.movingMs = 0;
  source->setTransport(transport);
  EXPECT_EQ(stepOf(203), 0.01f);
}

TEST_F(FrameServerTest, WhereCoarseIsNotEnoughDearEffectsGoUntilTheCameraRests) {
  serve({});
  net::ClientSettings settings;
  settings.address = server_->address();
  const std::shared_ptr<FrameSource> source = connectFrameSource(io_, settings, [] {}, {}).source;
  TransportSettings transport;
  transport.server.movingMs = 1;
  source->setTransport(transport);
  MarchSettings lit = scene_.march;
  lit.render.step = 0.05f;
  lit.render.effects.shading.strength = 1.0f;
  lit.render.effects.lights = parseLights("camera:1,1,1", "it");
  lit.render.effects.shadows.strength = 1.0f;
  const FrameFetch fetch = fetchFrom(source);
  const auto marchedAt = [&](uint32_t height) { return fetch(camera(128, height), lit, {}).frame->settings; };
  EXPECT_EQ(marchedAt(100), lit);
  for (uint32_t height = 101; height < 108; ++height) marchedAt(height);
  const MarchSettings moving = marchedAt(108);
  EXPECT_TRUE(isCoarsened(lit, moving));
  EXPECT_EQ(moving.render.effects.shadows.strength, 0.0f);
  EXPECT_EQ(moving.render.effects.shading.strength, 0.0f);
  EXPECT_EQ(marchedAt(108), lit) << "refined";
}

TEST_F(FrameServerTest, SpreadsOfDepthTravelAsTheyWereMarched) {
  serve({});
  net::ClientSettings settings;
  settings.address = server_->address();
  const std::shared_ptr<FrameSource> source = connectFrameSource(io_, settings, [] {}, {}).source;
  const FrameFetch fetch = fetchFrom(source);
  MarchSettings asked = scene_.march;
  asked.sample.sendsSpread = true;
  const MarcherPtr marcher = makeMarcher(Backend::cpu, scene_.volume, scene_.transferFunction, {});
  for (const int samplesPerRay : {1, 3}) {
    asked.sample.samplesPerRay = samplesPerRay;
    const ServedFrame served = fetch(camera(90, 80), asked, {});
    const SampleFrame expected = marcher->march(camera(90, 80), asked);
    ASSERT_NE(served.frame->plane(kSpreadPlane), nullptr);
    EXPECT_EQ(*served.frame->plane(kSpreadPlane), *expected.plane(kSpreadPlane));
  }
}

TEST_F(FrameServerTest, AProcessorThatOthersUseTakesAsMuchLongerAsItSays) {
  serve({});
  net::ClientSettings settings;
  settings.address = server_->address();
  const std::shared_ptr<FrameSource> source = connectFrameSource(io_, settings, [] {}, {}).source;
  const FrameFetch fetch = fetchFrom(source);
  const auto msAtServer = [](const ServedFrame& served) {
    const FrameLatency& took = served.latency;
    return took.marchMs + took.compactMs + took.copyMs + took.encodeMs;
  };
  const ServedFrame alone = fetch(camera(300, 300), scene_.march, {});
  double aloneMs = msAtServer(alone);  // the first march finds its memory cold
  for (int i = 0; i < 2; ++i) aloneMs = std::min(aloneMs, msAtServer(fetch(camera(300, 300), scene_.march, {})));
  TransportSettings transport;
  transport.server.loadPercent = 90;
  source->setTransport(transport);
  const ServedFrame loaded = fetch(camera(300, 300), scene_.march, {});
  const double atServerMs = msAtServer(loaded);
  EXPECT_GE(millisecondsBetween(loaded.requestedAt, loaded.arrivedAt), atServerMs) << "it says that it took longer than it did";
  EXPECT_GT(atServerMs, 2.0 * aloneMs) << "10 times, but for what else is at work here";
  EXPECT_EQ(loaded.frame->settings, alone.frame->settings);
  EXPECT_THAT(loaded.frame->samples, testing::ElementsAreArray(alone.frame->samples));
}

TEST_F(FrameServerTest, SlowReadersTakeNoMoreThanThereIs) {
  constexpr size_t kMemory = size_t{512} << 20;
  serve({.memoryBytes = kMemory});
  net::FrameRequest request;
  request.camera = toFields(camera(680, 680));
  request.settings = toFields(scene_.march);
  request.wanted = net::Wanted::picture;
  request.codec = toFields(CodecSettings{});
  const size_t before = net::memoryBytes();
  std::vector<net::BareSocket> slow;
  for (int i = 0; i < 64; ++i) {  // all places there are
    net::BareSocket socket = net::BareSocket::connect(server_->port(), 4096, i < 40 ? 1 : 2);
    net::ClientHello hello;
    hello.depth = 16;
    socket.send(net::toBytes(hello));
    for (request.id = 1; request.id <= 16; ++request.id) socket.send(net::requestMessage(request));
    slow.push_back(std::move(socket));
  }
  size_t most = 0;
  // Until it is a test of something, however busy the machine is, and for 5 s.
  for (int i = 0; i < 100 || (i < 1200 && most <= before + kMemory / 4); ++i) {
    most = std::max(most, net::memoryBytes());
    std::this_thread::sleep_for(50ms);
  }
  const MarcherPtr honest = client();
  EXPECT_GT(honest->march(camera(64, 48), scene_.march).size(), 0u);
  most = std::max(most, net::memoryBytes());
  RecordProperty("mostMiB", std::to_string((most - before) >> 20));
  if (!net::kIsSanitized) {
    EXPECT_GT(most, before + kMemory / 4) << "so that it is a test of something";
    EXPECT_LT(most, before + kMemory + (size_t{64} << 20)) << "besides, sockets and threads";
  }
}

TEST_F(FrameServerTest, WhatALargeFrameTookIsGivenBack) {
  net::ServerSettings patient;
  patient.patience = 60s;  // a client that says nothing while it waits is not left: how long the frame takes is not asked here
  serve({}, patient);
  net::FrameRequest request;
  const auto served = [&](uint32_t side) {  // its bytes are dropped here as they come
    net::BareSocket socket = net::greetedClientAt(server_->port());
    request.id = 1;
    request.camera = toFields(camera(side, side));
    request.settings = toFields(scene_.march);
    request.codec = toFields(CodecSettings{});
    socket.send(net::requestMessage(request));
    return socket.skipFrame(60s);
  };
  ASSERT_TRUE(served(64));
  const size_t before = net::memoryBytes();
  ASSERT_TRUE(served(3000));
  if (net::kIsSanitized) GTEST_SKIP() << "sanitizers keep freed memory";
  EXPECT_TRUE(net::comesTrue([&] { return net::memoryBytes() < before + (size_t{32} << 20); }, 20s)) << (net::memoryBytes() - before) / 1048576 << " MiB more";
}

}  // namespace
}  // namespace warpscope
