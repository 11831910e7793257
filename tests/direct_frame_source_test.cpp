// Frames without a network, in virtual time: when they arrive, which requests are served, what errors become.
// Mirrors app/frames/direct_frame_source.h.
#include "app/frames/direct_frame_source.h"

#include <gmock/gmock.h>

#include <atomic>
#include <mutex>
#include <semaphore>
#include <vector>

#include "app/frames/wire_fields.h"
#include "render/base/error.h"
#include "render/codec/proxy_coding.h"
#include "tests/test_volumes.h"

namespace warpscope {
namespace {

using std::chrono::milliseconds;

Clock::TimePoint at(int ms) { return Clock::TimePoint(milliseconds(ms)); }

/// A marcher that takes virtual time, less at greater steps, and finds nothing.
class StubMarcher final : public Marcher {
 public:
  StubMarcher(Clock& clock, milliseconds duration) : clock_(clock), duration_(duration) {}

  SampleFrame march(const Camera& camera, const MarchSettings& settings, const std::stop_token& stop) override {
    {
      const std::scoped_lock lock(mutex_);
      widths_.push_back(camera.width);
    }
    const double share = MarchSettings{}.render.step / static_cast<double>(settings.render.step);
    const double ms = share * static_cast<double>(duration_.count());
    if (!clock_.waitUntil(clock_.now() + durationOfMs(ms), stop)) throw OperationCancelled();
    if (fails) throw InputError("the volume is gone");
    SampleFrame frame;
    frame.camera = camera;
    frame.settings = settings;
    frame.timings.marchMs = ms;
    if (settings.sample.proxy > 0) frame.proxy = proxy;
    return frame;
  }
  void render(const Camera&, const RenderSettings&, Image<glm::vec4>&, const std::stop_token&) override {}
  const VolumePtr& volume() const override { return volume_; }
  Backend backend() const override { return Backend::cpu; }
  MarcherCapabilities capabilities() const override { return {}; }
  MarcherPtr twin(TurnsPtr) const override { return nullptr; }  // nobody asks
  MarcherPtr withTransferFunction(TransferFunction) const override { return nullptr; }  // likewise

  std::vector<uint32_t> widths() const {
    const std::scoped_lock lock(mutex_);
    return widths_;
  }
  std::atomic<bool> fails = false;
  ProxyPtr proxy;  ///< that goes with frames which ask for one

 private:
  Clock& clock_;
  const milliseconds duration_;
  const VolumePtr volume_;
  mutable std::mutex mutex_;
  std::vector<uint32_t> widths_;  // of the cameras it was asked for, which tells requests apart
};

class DirectFrameSourceTest : public ::testing::Test {
 protected:
  void post(uint64_t id) {
    FrameRequest request;
    request.id = id;
    request.camera.width = static_cast<uint32_t>(id);
    request.camera.height = 1;
    source_->post(request, clock_.now());
  }
  void setRoundTrip(milliseconds roundTrip) {
    TransportSettings transport;
    transport.link.up.delayMs = transport.link.down.delayMs = 0.5 * static_cast<double>(roundTrip.count());
    source_->setTransport(transport);
  }

  ServedFrame nextFrame() {
    news_.acquire();
    return *source_->tryTake();
  }

  VirtualClock clock_;
  std::shared_ptr<StubMarcher> marcher_ = std::make_shared<StubMarcher>(clock_, milliseconds(30));
  std::counting_semaphore<> news_{0};
  std::unique_ptr<FrameSource> source_ = makeDirectFrameSource(marcher_, clock_, [this] { news_.release(); });
};

TEST_F(DirectFrameSourceTest, AFrameTakesTheRoundTripAndTheMarch) {
  setRoundTrip(milliseconds(100));
  post(1);
  EXPECT_EQ(clock_.advanceToNextSleeper(), at(50));  // reaches the server
  EXPECT_EQ(clock_.advanceToNextSleeper(), at(80));  // marched
  EXPECT_FALSE(news_.try_acquire());
  EXPECT_EQ(clock_.advanceToNextSleeper(), at(130));  // reaches the display
  const ServedFrame served = nextFrame();
  EXPECT_EQ(served.requestId, 1u);
  EXPECT_EQ(served.requestedAt, at(0));
  EXPECT_EQ(served.arrivedAt, at(130));
  EXPECT_EQ(served.latency.wireMs, 100.0);
  ASSERT_TRUE(served.frame);
  EXPECT_EQ(served.frame->requestId, 1u);
  EXPECT_EQ(served.error, "");
}

TEST_F(DirectFrameSourceTest, WithoutDelayOnlyTheMarchTakesTime) {
  post(1);
  EXPECT_EQ(clock_.advanceToNextSleeper(), at(30));
  EXPECT_EQ(nextFrame().arrivedAt, at(30));
}

/// Passes everything on, and counts who waits.
class CountingClock final : public Clock {
 public:
  explicit CountingClock(Clock& clock) : clock_(clock) {}
  TimePoint now() const override { return clock_.now(); }
  bool waitUntil(TimePoint time, const std::stop_token& stop) override {
    ++waits;
    return clock_.waitUntil(time, stop);
  }
  std::atomic<int> waits = 0;

 private:
  Clock& clock_;
};

TEST_F(DirectFrameSourceTest, ALinkThatSimulatesNothingIsNotInTheWay) {
  CountingClock clock(clock_);
  const auto source = makeDirectFrameSource(marcher_, clock, [this] { news_.release(); });
  uint64_t id = 0;
  const auto waitsWith = [&](std::string_view link) {
    TransportSettings transport;
    transport.link = net::parseLinkSettings(link);
    source->setTransport(transport);
    const int before = clock.waits;
    FrameRequest request;
    request.id = ++id;
    source->post(request, clock_.now());
    while (!news_.try_acquire()) clock_.advanceToNextSleeper(clock_.now() + std::chrono::seconds(1));
    const std::optional<ServedFrame> served = source->tryTake();
    EXPECT_TRUE(served && served->frame);
    return clock.waits - before;
  };
  EXPECT_EQ(waitsWith("none"), 0);
  EXPECT_EQ(waitsWith("up.delay=10"), 1);
  EXPECT_EQ(waitsWith("down.delay=10"), 1);
  EXPECT_EQ(waitsWith("down.rate=40M,up.rate=40M"), 2);
  EXPECT_EQ(waitsWith("none"), 0) << "again";
}

TEST_F(DirectFrameSourceTest, ANarrowLinkTakesItsTimeForTheBytes) {
  TransportSettings transport;
  net::FrameRequest request;
  request.settings = toFields(MarchSettings{});
  transport.link.up.rateBitPerS = 8.0 * static_cast<double>(net::requestMessage(request).size()) * 100;  // a request takes 10 ms
  source_->setTransport(transport);
  post(1);
  EXPECT_NEAR(millisecondsBetween(at(0), clock_.advanceToNextSleeper()), 10.0, 0.01);
}

TEST_F(DirectFrameSourceTest, OneIsInFlightOneIsPendingAndTheNewestWins) {
  setRoundTrip(milliseconds(100));
  post(1);
  EXPECT_EQ(clock_.advanceToNextSleeper(), at(50));
  EXPECT_EQ(clock_.advanceToNextSleeper(), at(80));  // 1 is on its way back
  for (uint64_t id = 2; id <= 50; ++id) post(id);    // sent at 80
  EXPECT_EQ(clock_.advanceToNextSleeper(), at(130));
  EXPECT_EQ(nextFrame().requestId, 1u);
  // 50 was sent at 80 and reached the server at 130, while that was busy: it is marched at once.
  EXPECT_EQ(clock_.advanceToNextSleeper(), at(160));
  EXPECT_EQ(clock_.advanceToNextSleeper(), at(210));
  EXPECT_EQ(nextFrame().requestId, 50u);
  EXPECT_THAT(marcher_->widths(), ::testing::ElementsAre(1u, 50u));
}

TEST_F(DirectFrameSourceTest, AMovingCameraIsMarchedCoarserWhereThatIsWantedAndInFullAtRest) {
  TransportSettings transport;
  transport.server.movingMs = 10;
  source_->setTransport(transport);
  const auto ask = [&](uint64_t id, float eye) {
    FrameRequest request;
    request.id = id;
    request.camera.eye.x = eye;
    request.camera.width = request.camera.height = 100;
    source_->post(request, clock_.now());
    clock_.advanceToNextSleeper();
    return nextFrame();
  };
  const ServedFrame first = ask(1, 1.0f);
  EXPECT_EQ(first.frame->settings, MarchSettings{}) << "nobody knows yet whether it moves";
  EXPECT_EQ(first.arrivedAt, at(30));
  const ServedFrame moving = ask(2, 2.0f);
  EXPECT_FLOAT_EQ(moving.frame->settings.render.step, 1.5f);
  EXPECT_NEAR(millisecondsBetween(at(40), moving.arrivedAt), 0.0, 0.01);
  EXPECT_FLOAT_EQ(ask(3, 3.0f).frame->settings.render.step, 1.5f);
  EXPECT_EQ(ask(4, 3.0f).frame->settings, MarchSettings{});
  EXPECT_FLOAT_EQ(ask(5, 4.0f).frame->settings.render.step, 1.5f);
  source_->setTransport({});
  EXPECT_EQ(ask(6, 5.0f).frame->settings, MarchSettings{});
}

TEST_F(DirectFrameSourceTest, AProcessorThatOthersUseTakesLongerAndOneThatNobodyUsesDoesNot) {
  TransportSettings transport;
  transport.server.loadPercent = 75;
  source_->setTransport(transport);
  post(1);
  EXPECT_EQ(clock_.advanceToNextSleeper(), at(30));   // marched
  EXPECT_EQ(clock_.advanceToNextSleeper(), at(120));  // by a quarter of the processor
  const ServedFrame loaded = nextFrame();
  EXPECT_EQ(loaded.arrivedAt, at(120));
  EXPECT_EQ(loaded.latency.marchMs, 120.0);
  EXPECT_EQ(loaded.latency.wireMs, 0.0);
  source_->setTransport({});
  post(2);
  EXPECT_EQ(clock_.advanceToNextSleeper(), at(150));
  EXPECT_EQ(nextFrame().arrivedAt, at(150));
}

TEST_F(DirectFrameSourceTest, ALoadedServerIsPacedByWhatItsFramesTake) {
  TransportSettings transport;
  transport.server = {.movingMs = 30, .loadPercent = 50};
  source_->setTransport(transport);
  for (uint64_t id = 1; id <= 3; ++id) {
    FrameRequest request;
    request.id = id;
    request.camera.eye.x = static_cast<float>(id);
    request.camera.width = request.camera.height = 100;
    source_->post(request, clock_.now());
    clock_.advanceToNextSleeper();
    clock_.advanceToNextSleeper();
    EXPECT_FLOAT_EQ(nextFrame().frame->settings.render.step, id == 1 ? 0.5f : 1.0f);  // the first took 60 ms
  }
}

TEST_F(DirectFrameSourceTest, TheCopyOfTheVolumeCrossesTheLinkOnce) {
  const auto volume = makeTestVolume(VoxelType::uint8, {16, 16, 16}, [](const glm::ivec3& at) { return static_cast<double>(at.x * 7 % 11 + at.y * 5 % 13 + at.z); });
  const TransferFunction function{{{0.0, glm::vec3(1.0f), 0.5f}}};
  marcher_->proxy = std::make_shared<const Proxy>(makeProxy(*volume, function, 16));
  TransportSettings transport;
  transport.link.down.rateBitPerS = 80000.0;
  source_->setTransport(transport);
  const auto ask = [&](uint64_t id, int proxy) {
    FrameRequest request;
    request.id = id;
    request.settings.sample.proxy = proxy;
    const Clock::TimePoint askedAt = clock_.now();
    source_->post(request, askedAt);
    clock_.advanceToNextSleeper();  // marched
    clock_.advanceToNextSleeper();  // arrived
    const ServedFrame served = nextFrame();
    return std::pair(served.bytes, millisecondsBetween(askedAt, served.arrivedAt));
  };
  const auto [firstBytes, firstMs] = ask(1, 16);
  EXPECT_EQ(firstBytes.proxy, proxyBytesOf(*marcher_->proxy));
  const auto [secondBytes, secondMs] = ask(2, 16);
  EXPECT_EQ(secondBytes, FrameBytes{});
  EXPECT_NEAR(firstMs - secondMs, 0.1 * static_cast<double>(firstBytes.proxy), 1.0);
  EXPECT_EQ(ask(3, 0).first.proxy, 0u);
  EXPECT_EQ(ask(4, 16).first.proxy, 0u) << "it is there";
  marcher_->proxy = std::make_shared<const Proxy>(makeProxy(*volume, function, 8));
  EXPECT_EQ(ask(5, 8).first.proxy, proxyBytesOf(*marcher_->proxy)) << "that is another one";
}

TEST_F(DirectFrameSourceTest, ErrorsArriveAsText) {
  marcher_->fails = true;
  post(1);
  clock_.advanceToNextSleeper();
  const ServedFrame served = nextFrame();
  EXPECT_EQ(served.requestId, 1u);
  EXPECT_FALSE(served.frame);
  EXPECT_EQ(served.error, "the volume is gone");
}

TEST_F(DirectFrameSourceTest, ClosesWhileWaitingForTheLinkOrTheMarch) {
  setRoundTrip(milliseconds(100));
  post(1);
  clock_.advanceToNextSleeper();  // now it marches, or will
  source_.reset();
  source_ = makeDirectFrameSource(marcher_, clock_, [this] { news_.release(); });
  setRoundTrip(std::chrono::seconds(20));
  post(2);
  source_.reset();
  EXPECT_FALSE(news_.try_acquire());
}

}  // namespace
}  // namespace warpscope
