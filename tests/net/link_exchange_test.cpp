// Client and server over simulated links: round trips, changes while it runs, what several requests under way are worth, idle hours.
// Mirrors ClientSettings::link, Client::setLink() and Client::setDepth(). Busy machines are slower than asked for, never faster.
#include <algorithm>

#include "tests/net/exchange.h"

namespace warpscope::net {
namespace {

double msOf(Duration duration) { return std::chrono::duration<double, std::milli>(duration).count(); }

class LinkExchange : public testing::Test {
 protected:
  void connect(const char* link, uint16_t depth = 1, size_t payloadBytes = 2000, std::chrono::milliseconds heartbeat = 50ms) {
    server_.emplace(io_, ServerSettings{.scene = someScene(), .heartbeat = heartbeat, .patience = 5s});
    answering_.emplace(*server_, payloadBytes);
    client_.emplace(io_, ClientSettings{.address = server_->address(), .link = parseLinkSettings(link), .depth = depth}, witness_);
    ASSERT_TRUE(witness_.waitForConnection());
  }
  /// Of frames, from the request's leaving until all of it was there.
  double medianMs(int count) {
    std::vector<double> times;
    for (int i = 0; i < count; ++i) {
      client_->request(requestOf(++lastId_));
      EXPECT_TRUE(witness_.frameOf(lastId_));
      const std::scoped_lock lock(witness_.mutex);
      times.push_back(msOf(witness_.arrivals.back().arrivedAt - witness_.arrivals.back().sentAt));
    }
    std::ranges::nth_element(times, times.begin() + count / 2);
    return times[static_cast<size_t>(count) / 2];
  }

  const std::shared_ptr<IoThread> io_ = std::make_shared<IoThread>();
  Witness witness_;
  std::optional<Server> server_;
  std::optional<Answering> answering_;
  std::optional<Client> client_;
  uint64_t lastId_ = 0;
};

TEST_F(LinkExchange, RoundTripsTakeTheDelayAndChangesTakeEffectAtOnce) {
  connect("delay=50");
  const double far = medianMs(5);
  EXPECT_GE(far, 100.0);
  EXPECT_LT(far, 300.0);
  ASSERT_TRUE(witness_.waitFor([&] { return witness_.roundTrips.size() >= 3; }));
  {
    const std::scoped_lock lock(witness_.mutex);
    for (const Duration duration : witness_.roundTrips) EXPECT_GE(msOf(duration), 100.0);
  }
  client_->setLink({});
  const double near = medianMs(9);
  EXPECT_LT(near, 50.0);
  client_->setLink(parseLinkSettings("delay=100"));
  EXPECT_GE(medianMs(3), 200.0);
  DuplexLinkSettings wrong;
  wrong.up.delayMs = -1.0;
  EXPECT_THROW(client_->setLink(wrong), LinkSettingsError);
  EXPECT_EQ(witness_.look([&] { return witness_.scenes.size(); }), 1u) << "all that in one connection";
}

TEST_F(LinkExchange, ADelayLongerThanPatienceIsNoSilence) {
  server_.emplace(io_, ServerSettings{.scene = someScene(), .heartbeat = 50ms, .patience = 600ms});
  client_.emplace(io_, ClientSettings{.address = server_->address(), .link = parseLinkSettings("delay=700")}, witness_);
  ASSERT_TRUE(witness_.waitForConnection());
  EXPECT_FALSE(witness_.waitFor([&] { return !witness_.isConnected(); }, 1500ms));
}

TEST_F(LinkExchange, SeveralUnderWayAreWorthTheDelay) {
  connect("delay=50", kMaxDepth);
  const auto framesInASecond = [&](uint16_t depth) {
    client_->setDepth(depth);
    size_t before;
    {
      const std::scoped_lock lock(witness_.mutex);
      before = witness_.frames.size();
    }
    for (const TimePoint begin = now(); secondsSince(begin) < 1.0; std::this_thread::sleep_for(2ms)) client_->request(requestOf(++lastId_));
    const std::scoped_lock lock(witness_.mutex);
    return witness_.frames.size() - before;
  };
  const size_t one = framesInASecond(1);
  std::this_thread::sleep_for(150ms);
  const size_t eight = framesInASecond(8);
  RecordProperty("depth1", static_cast<int>(one));
  RecordProperty("depth8", static_cast<int>(eight));
  std::cout << one << " frames a second with one under way, " << eight << " with eight, over a round trip of 100 ms\n";
  EXPECT_GE(one, 4u);
  EXPECT_LE(one, 10u);
  EXPECT_LE(eight, 80u);
  EXPECT_GE(eight, 4 * one);
  EXPECT_EQ(witness_.look([&] { return witness_.scenes.size(); }), 1u);
}

TEST_F(LinkExchange, IdleConnectionsStay) {
  server_.emplace(io_, ServerSettings{.scene = someScene(), .heartbeat = 40ms, .patience = 800ms});
  client_.emplace(io_, ClientSettings{.address = server_->address()}, witness_);
  ASSERT_TRUE(witness_.waitForConnection());
  EXPECT_FALSE(witness_.waitFor([&] { return !witness_.isConnected(); }, 2s));
  const std::scoped_lock lock(witness_.mutex);
  EXPECT_GE(witness_.roundTrips.size(), 10u);
  EXPECT_EQ(server_->requests().clientCount(), 1u);
}

TEST_F(LinkExchange, BusyConnectionsMeasureRoundTripsToo) {
  connect("none", 1, 100'000, 20ms);
  for (const TimePoint begin = now(); secondsSince(begin) < 0.5;) {
    client_->request(requestOf(++lastId_));
    ASSERT_TRUE(witness_.frameOf(lastId_));
  }
  const std::scoped_lock lock(witness_.mutex);
  EXPECT_GE(witness_.roundTrips.size(), 5u);
}

TEST_F(LinkExchange, TheNewestOfABurstIsAnsweredOverAPoorLink) {
  connect("delay=5,jitter=3,loss=2%", 2, 20'000);
  for (lastId_ = 1; lastId_ <= 1000; ++lastId_) client_->request(requestOf(lastId_));
  const std::optional<Frame> frame = witness_.frameOf(1000);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->payload, Bytes(20'000, static_cast<std::byte>(1000)));
  EXPECT_LT(answering_->count, 100);
}

}  // namespace
}  // namespace warpscope::net
