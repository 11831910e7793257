// Scenes that are served: over loopback by the program itself, and as somebody else's, whose voxels never come here.
// Mirrors app/frames/scene_connection.h, frame_server.h, remote_frame_source.h and remote_marcher.h.
#include "app/frames/scene_connection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <semaphore>
#include <thread>
#include <utility>

#include "app/frames/backend.h"
#include "app/frames/frame_server.h"
#include "app/frames/wire_fields.h"
#include "headless.h"
#include "net/wire.h"
#include "render/base/error.h"
#include "render/codec/proxy_coding.h"
#include "tests/marcher_around.h"
#include "tests/net/exchange.h"

namespace warpscope {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

TransportSettings lossless() {
  TransportSettings transport;
  transport.codec.color = ColorCoding::lossless;
  return transport;
}

/// A server of a small scene, as `serve` starts it.
class HostingTest : public ::testing::Test {
 protected:
  HostingTest() : scene_(smallScene("shells")), marcher_(makeMarcher(Backend::cpu, scene_.volume, scene_.transferFunction)) {
    scene_.background = {0.25f, 0.5f, 0.75f};
    restart({});
  }
  void restart(net::ServerSettings settings) {
    server_.reset();
    server_ = std::make_unique<FrameServer>(io_, scene_, marcher_, std::move(settings));
  }
  /// With a marcher that counts the marches it has begun.
  std::shared_ptr<std::atomic<int>> restartCounted() {
    const auto begun = std::make_shared<std::atomic<int>>(0);
    marcher_ = std::make_shared<BegunMarcher>(marcher_, begun);
    restart({});
    return begun;
  }
  ConnectedScene connect(const TransportSettings& transport = lossless()) {
    return connectScene(io_, server_->address(), transport, [this] { news_.release(); }, {});
  }
  std::optional<ServedFrame> next(FrameSource& source) {
    const auto deadline = std::chrono::steady_clock::now() + seconds(30);
    while (std::chrono::steady_clock::now() < deadline) {
      if (std::optional<ServedFrame> served = source.tryTake()) return served;
      news_.try_acquire_for(milliseconds(100));
    }
    return std::nullopt;
  }
  Camera camera(double turnDeg = 0.0) const {
    View view = scene_.views.front();
    view.angleDeg += turnDeg;
    return makeCamera(scene_, view, 72, 56);
  }

  const std::shared_ptr<net::IoThread> io_ = std::make_shared<net::IoThread>();
  /// A frame knows where its volume is, as the scene has it.
  void expectSamePlace(const VolumeGeometry& geometry) const {
    const VolumeGeometry& own = scene_.volume->geometry();
    EXPECT_EQ(geometry.dims, own.dims);
    EXPECT_EQ(geometry.spacing, own.spacing);
    EXPECT_EQ(geometry.origin, own.origin);
    EXPECT_EQ(geometry.direction, own.direction);
  }

  Scene scene_;
  MarcherPtr marcher_;
  std::unique_ptr<FrameServer> server_;
  std::counting_semaphore<> news_{0};
};

TEST_F(HostingTest, TheServersSceneMakesTheSameCameras) {
  const ConnectedScene loaded = connect();
  EXPECT_EQ(loaded.scene.volume, nullptr);
  EXPECT_EQ(loaded.scene.name, scene_.name);
  EXPECT_EQ(loaded.scene.title, scene_.title);
  EXPECT_EQ(loaded.scene.views, scene_.views);
  EXPECT_EQ(loaded.scene.march, scene_.march);
  EXPECT_EQ(loaded.scene.background, scene_.background);
  for (const View& view : scene_.views)
    EXPECT_EQ(makeCamera(loaded.scene, view, 640, 480), makeCamera(scene_, view, 640, 480));
}

TEST_F(HostingTest, FramesAreTheMarchersBitForBit) {
  const ConnectedScene loaded = connect();
  uint64_t id = 0;
  ProxyPtr copy;
  for (const auto& heuristic : kHeuristics) {
    MarchSettings settings = scene_.march;
    settings.sample.heuristic = heuristic.value;
    loaded.source->post({++id, camera(), settings}, std::chrono::steady_clock::now());
    const std::optional<ServedFrame> served = next(*loaded.source);
    ASSERT_TRUE(served && served->frame) << (served ? served->error : "nothing came");
    const SampleFrame truth = marcher_->march(camera(), settings);
    EXPECT_EQ(served->requestId, id);
    EXPECT_TRUE(served->frame->samples == truth.samples) << heuristic.name;
    EXPECT_TRUE(served->frame->colors == truth.colors) << heuristic.name;
    EXPECT_EQ(served->frame->camera, truth.camera);
    EXPECT_EQ(served->frame->settings, truth.settings);
    EXPECT_EQ(served->frame->quantization, truth.quantization);
    EXPECT_GT(served->bytes.samples, 0u);
    EXPECT_GT(served->bytes.segments, 0u);
    EXPECT_LT(served->bytes.ofFrame(), truth.sizeBytes());
    EXPECT_EQ(served->bytes.proxy, id == 1 ? proxyBytesOf(*truth.proxy) : 0u) << "it came with the first";
    ASSERT_TRUE(served->frame->proxy);
    EXPECT_EQ(std::exchange(copy, served->frame->proxy), id == 1 ? nullptr : copy) << "one object";
    expectSamePlace(served->frame->geometry);
    EXPECT_GT(served->latency.marchMs, 0.0);
    EXPECT_GT(served->latency.encodeMs, 0.0);
    EXPECT_GT(served->latency.decodeMs, 0.0);
  }
}

/// Frames that are under way when another size of copy is asked for are not left without one.
TEST_F(HostingTest, EveryFrameHasTheCopyThatItWasAskedWith) {
  const ConnectedScene loaded = connect();
  TransportSettings transport;
  transport.depth = 3;
  loaded.source->setTransport(transport);
  MarchSettings settings = scene_.march;
  uint64_t id = 0;
  std::map<uint64_t, int> asked;
  const auto post = [&](int longest) {
    settings.sample.proxy = asked[++id] = longest;
    loaded.source->post({id, camera(), settings}, std::chrono::steady_clock::now());
  };
  const auto takeUpTo = [&](uint64_t last) {
    for (uint64_t taken = 0; taken < last;) {
      const std::optional<ServedFrame> served = next(*loaded.source);
      ASSERT_TRUE(served && served->frame) << (served ? served->error : "nothing came");
      taken = served->requestId;
      ASSERT_TRUE(served->frame->proxy) << taken;
      EXPECT_EQ(served->frame->settings.sample.proxy, asked[taken]);
      const glm::uvec3& dims = served->frame->proxy->volume->dims();
      EXPECT_EQ(static_cast<int>(std::max({dims.x, dims.y, dims.z})), asked[taken]);
    }
  };
  post(12);
  takeUpTo(1);
  post(12), post(12), post(6);
  takeUpTo(4);
  post(6);
  takeUpTo(5);
}

TEST_F(HostingTest, SeveralSamplesARayComeAsTheMarcherFoundThem) {
  const ConnectedScene loaded = connect();
  MarchSettings settings = scene_.march;
  settings.sample.samplesPerRay = 4;
  loaded.source->post({1, camera(), settings}, std::chrono::steady_clock::now());
  const std::optional<ServedFrame> served = next(*loaded.source);
  ASSERT_TRUE(served && served->frame) << (served ? served->error : "nothing came");
  const SampleFrame truth = marcher_->march(camera(), settings);
  EXPECT_FALSE(truth.layers().empty());
  EXPECT_TRUE(served->frame->samples == truth.samples);
  EXPECT_TRUE(served->frame->colors == truth.colors);
  EXPECT_TRUE(served->frame->planes == truth.planes);
}

TEST_F(HostingTest, GroundTruthIsTheMarchersBitForBit) {
  const ConnectedScene loaded = connect();
  // Its volume is the server's: nobody here may count on it, or on pictures that follow the camera.
  EXPECT_EQ(loaded.display->capabilities(),
            (MarcherCapabilities{MarchPace::afterRest, VolumePlace::elsewhere, JudgePlace::host, FunctionChange::refused}));
  EXPECT_THROW(loaded.display->withTransferFunction(scene_.transferFunction), UsageError);
  EXPECT_EQ(loaded.display->volume(), nullptr);
  Image<glm::vec4> here, there;
  marcher_->render(camera(10.0), scene_.march.render, here);
  loaded.display->render(camera(10.0), scene_.march.render, there);
  EXPECT_TRUE(here == there);
  const SampleFrame frame = loaded.display->march(camera(), scene_.march);
  EXPECT_TRUE(frame.samples == marcher_->march(camera(), scene_.march).samples);
  expectSamePlace(frame.geometry);
  EXPECT_THROW(loaded.display->twin()->render(Camera{}, scene_.march.render, there), InputError);
}

TEST_F(HostingTest, ASimulatedLinkShowsInTheTimes) {
  TransportSettings transport = lossless();
  transport.link.up.delayMs = 40.0;
  transport.link.down.delayMs = 80.0;
  const ConnectedScene loaded = connect(transport);
  const auto posted = std::chrono::steady_clock::now();
  loaded.source->post({1, camera(), scene_.march}, posted);
  const std::optional<ServedFrame> served = next(*loaded.source);
  ASSERT_TRUE(served && served->frame);
  EXPECT_GE(served->latency.wireMs, 119.0);
  EXPECT_GE(served->latency.totalMs(), served->latency.wireMs);
  EXPECT_LE(served->latency.totalMs(), millisecondsBetween(posted, served->arrivedAt) + 1e-6) << "no stage is longer than it was";
}

TEST_F(HostingTest, ARequestThatCannotBeMarchedIsASentence) {
  const ConnectedScene loaded = connect();
  Camera broken = camera();
  broken.eye.x = std::numeric_limits<float>::quiet_NaN();
  loaded.source->post({1, broken, scene_.march}, std::chrono::steady_clock::now());
  const std::optional<ServedFrame> served = next(*loaded.source);
  ASSERT_TRUE(served);
  EXPECT_FALSE(served->frame);
  EXPECT_NE(served->error.find("camera"), std::string::npos) << served->error;
  MarchSettings endless = scene_.march;
  endless.render.step = 0.0f;
  loaded.source->post({2, camera(), endless}, std::chrono::steady_clock::now());
  const std::optional<ServedFrame> second = next(*loaded.source);
  ASSERT_TRUE(second);
  EXPECT_FALSE(second->error.empty());
}

TEST_F(HostingTest, FramesComeAgainWhenTheServerDoes) {
  const ConnectedScene loaded = connect();
  const net::HostPort where = server_->address().where;
  loaded.source->post({1, camera(), scene_.march}, std::chrono::steady_clock::now());
  ASSERT_TRUE(next(*loaded.source));
  restart({.listen = where});
  loaded.source->post({2, camera(5.0), scene_.march}, std::chrono::steady_clock::now());
  const std::optional<ServedFrame> served = next(*loaded.source);
  ASSERT_TRUE(served && served->frame);
  EXPECT_EQ(served->requestId, 2u);
  EXPECT_TRUE(loaded.source->status().isConnected);
}

TEST_F(HostingTest, AnotherSceneAtTheSameAddressIsSaidNotShown) {
  const ConnectedScene loaded = connect();
  const net::HostPort where = server_->address().where;
  scene_ = smallScene("block");
  marcher_ = makeMarcher(Backend::cpu, scene_.volume, scene_.transferFunction);
  restart({.listen = where});
  loaded.source->post({1, camera(), scene_.march}, std::chrono::steady_clock::now());
  const std::optional<ServedFrame> served = next(*loaded.source);
  ASSERT_TRUE(served);
  EXPECT_NE(served->error.find("another scene"), std::string::npos) << served->error;
}

TEST_F(HostingTest, NobodyThereAndAWrongTokenAreSentences) {
  const net::Address gone = server_->address();
  restart({.identity = net::makeIdentity(), .token = net::Token::random()});
  net::Address wrong = server_->address();
  wrong.credentials->token = net::Token::random();
  try {
    connectScene(io_, wrong, {}, [] {}, {});
    FAIL() << "the token was accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("does not accept this token"), std::string::npos) << error.what();
    EXPECT_EQ(std::string(error.what()).find(wrong.credentials->token.text()), std::string::npos);
  }
  server_.reset();
  std::stop_source stop;
  std::jthread stopper([&] {
    std::this_thread::sleep_for(milliseconds(200));
    stop.request_stop();
  });
  EXPECT_THROW(connectScene(io_, gone, {}, [] {}, stop.get_token()), OperationCancelled);  // it went on trying
}

TEST_F(HostingTest, EndsInTheMiddleOfAMarch) {
  const std::shared_ptr<std::atomic<int>> begun = restartCounted();
  const ConnectedScene loaded = connect();
  MarchSettings slow = scene_.march;
  slow.render.step = 0.001f;
  const Camera large = makeCamera(scene_, scene_.views.front(), 2048, 2048);
  loaded.source->post({1, large, slow}, std::chrono::steady_clock::now());
  ASSERT_TRUE(net::comesTrue([&] { return *begun == 1; }));
  const auto began = std::chrono::steady_clock::now();
  server_.reset();
  EXPECT_LT(std::chrono::steady_clock::now() - began, seconds(2));
}

TEST_F(HostingTest, NobodyWaitsForTheMarchOfAClientThatLeft) {
  const std::shared_ptr<std::atomic<int>> begun = restartCounted();
  const ConnectedScene patient = connect();
  {
    const ConnectedScene leaving = connect();
    MarchSettings slow = scene_.march;
    slow.render.step = 0.001f;
    leaving.source->post({1, makeCamera(scene_, scene_.views.front(), 4096, 4096), slow}, std::chrono::steady_clock::now());
    ASSERT_TRUE(net::comesTrue([&] { return *begun == 1; }));
  }
  const auto began = std::chrono::steady_clock::now();
  patient.source->post({1, camera(), scene_.march}, began);
  const std::optional<ServedFrame> served = next(*patient.source);
  ASSERT_TRUE(served && served->frame);
  EXPECT_LT(std::chrono::steady_clock::now() - began, seconds(5));  // the other march takes far longer
}

}  // namespace
}  // namespace warpscope
