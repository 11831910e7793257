// Client and server over simulated links: round trips, changes while it runs, what several requests under way are worth, idle hours.
// Mirrors ClientSettings::link, Client::setLink() and Client::setDepth(). In virtual time, so that they are exact.
#include <algorithm>

#include "tests/net/exchange.h"

namespace warpscope::net {
namespace {

class LinkExchange : public testing::Test {
 protected:
  /// Leaving takes the way there and back.
  void TearDown() override {
    if (client_) time_.passDuring([&] { client_.reset(); });
  }

  void connect(const char* link, uint16_t depth = 1, size_t payloadBytes = 2000, std::chrono::milliseconds heartbeat = 10min,
               std::chrono::milliseconds patience = 30min) {
    server_.emplace(io_, ServerSettings{.scene = someScene(), .heartbeat = heartbeat, .patience = patience});
    answering_.emplace(*server_, payloadBytes);
    client_.emplace(io_, ClientSettings{.address = server_->address(), .link = parseLinkSettings(link), .depth = depth}, witness_);
    ASSERT_TRUE(time_.passUntil([&] { return witness_.look([&] { return witness_.isConnected(); }); }));
    settle(*io_);
  }
  /// Of a frame, from the request's leaving until all of it was there.
  Duration roundTrip() {
    client_->request(requestOf(++lastId_));
    EXPECT_TRUE(time_.passUntil([&] { return witness_.look([&] { return !witness_.frames.empty() && witness_.frames.back().head.id == lastId_; }); }));
    return witness_.look([&] { return witness_.arrivals.back().arrivedAt - witness_.arrivals.back().sentAt; });
  }
  /// Exactly, unless the kernel hands a message over in two parts while time passes; never less.
  void expectRoundTrip(Duration expected) {
    Duration least = roundTrip();
    for (int i = 0; i < 100 && least > expected; ++i) least = std::min(least, roundTrip());
    EXPECT_EQ(least, expected);
  }
  /// Passes so many heartbeats, each of which the other side answers before the next one.
  void passBeats(int count, Duration heartbeat) {
    for (int i = 0; i < count; ++i) {
      const size_t before = witness_.look([&] { return witness_.roundTrips.size(); });
      time_.pass(heartbeat);
      ASSERT_TRUE(witness_.waitFor([&] { return witness_.roundTrips.size() > before; })) << "beat " << i;
    }
  }

  VirtualClock clock_;
  const std::shared_ptr<IoThread> io_ = std::make_shared<IoThread>(clock_);
  const PassingTime time_{clock_, io_};
  Witness witness_;
  std::optional<Server> server_;
  std::optional<Answering> answering_;
  std::optional<Client> client_;
  uint64_t lastId_ = 0;
};

TEST_F(LinkExchange, RoundTripsTakeTheDelayAndChangesTakeEffectAtOnce) {
  connect("delay=50");
  expectRoundTrip(100ms);
  ASSERT_TRUE(time_.passUntil([&] { return witness_.look([&] { return !witness_.roundTrips.empty(); }); }));
  EXPECT_GE(witness_.look([&] { return witness_.roundTrips.front(); }), 100ms) << "the heartbeat's";
  client_->setLink({});
  expectRoundTrip(0ms);
  client_->setLink(parseLinkSettings("delay=100"));
  expectRoundTrip(200ms);
  DuplexLinkSettings wrong;
  wrong.up.delayMs = -1.0;
  EXPECT_THROW(client_->setLink(wrong), LinkSettingsError);
  EXPECT_EQ(witness_.look([&] { return witness_.scenes.size(); }), 1u) << "all that in one connection";
}

TEST_F(LinkExchange, TheDelayComesOnTopOfThePatienceForConnecting) {
  server_.emplace(io_, ServerSettings{.scene = someScene(), .heartbeat = 10min, .patience = 30min});
  client_.emplace(io_, ClientSettings{.address = server_->address(), .link = parseLinkSettings("delay=400"), .connectPatience = 300ms}, witness_);
  EXPECT_TRUE(time_.passUntil([&] { return witness_.look([&] { return witness_.isConnected() || witness_.isIn(ConnectionPhase::waiting); }); }));
  EXPECT_TRUE(witness_.look([&] { return witness_.isConnected(); }));
}

TEST_F(LinkExchange, ADelayLongerThanPatienceIsNoSilence) {
  connect("delay=950", 1, 2000, 150ms, 1000ms);  // there and back
  ASSERT_TRUE(time_.passUntil([&] { return witness_.look([&] { return !witness_.roundTrips.empty(); }); }));
  passBeats(100, 150ms);
  EXPECT_EQ(witness_.look([&] { return witness_.countOf(ConnectionPhase::waiting); }), 0u);
  EXPECT_TRUE(witness_.look([&] { return witness_.isConnected(); }));
}

/// The delay is on the way there, so that nothing but the requests' arrival takes time.
TEST_F(LinkExchange, SeveralUnderWayAreWorthTheDelay) {
  connect("up.delay=100", kMaxDepth);
  const auto framesInASecond = [&](uint16_t depth) {
    client_->setDepth(depth);
    const TimePoint end = clock_.now() + 1s;
    const size_t before = witness_.look([&] { return witness_.frames.size(); });
    size_t asked = 0;
    while (clock_.now() < end) {
      for (int i = 0; i < depth; ++i) {
        client_->request(requestOf(++lastId_));
        settle(*io_);  // it is sent, and not replaced by the next one
      }
      asked += depth;
      EXPECT_TRUE(time_.jumpTo(100ms));
      EXPECT_TRUE(witness_.waitFor([&] { return witness_.frames.size() == before + asked; })) << "all of them after one delay";
    }
    return witness_.look([&] { return witness_.frames.size() - before; });
  };
  EXPECT_EQ(framesInASecond(1), 10u);
  EXPECT_EQ(framesInASecond(8), 80u);
  EXPECT_EQ(witness_.look([&] { return witness_.scenes.size(); }), 1u);
}

TEST_F(LinkExchange, IdleConnectionsStay) {
  connect("none", 1, 2000, 40ms, 1000ms);
  ASSERT_TRUE(witness_.waitFor([&] { return !witness_.roundTrips.empty(); })) << "one at once";
  passBeats(500, 40ms);
  const std::scoped_lock lock(witness_.mutex);
  EXPECT_EQ(witness_.countOf(ConnectionPhase::waiting), 0u);
  EXPECT_TRUE(witness_.isConnected());
  EXPECT_EQ(witness_.roundTrips.size(), 501u) << "one each 40 ms";
  EXPECT_EQ(server_->requests().clientCount(), 1u);
}

TEST_F(LinkExchange, BusyConnectionsMeasureRoundTripsToo) {
  connect("none", 1, 100'000, 20ms);
  for (int i = 0; i < 25; ++i) {
    client_->request(requestOf(++lastId_));
    ASSERT_TRUE(witness_.frameOf(lastId_));
    passBeats(1, 20ms);
  }
}

TEST_F(LinkExchange, TheNewestOfABurstIsAnsweredOverAPoorLink) {
  connect("delay=5,jitter=3,loss=2%", 2, 20'000);
  for (lastId_ = 1; lastId_ <= 1000; ++lastId_) client_->request(requestOf(lastId_));
  ASSERT_TRUE(time_.passUntil([&] { return witness_.look([&] { return !witness_.frames.empty() && witness_.frames.back().head.id == 1000; }); }));
  EXPECT_EQ(witness_.frameOf(1000)->payload, Bytes(20'000, static_cast<std::byte>(1000)));
  EXPECT_LT(answering_->count, 100);
}

}  // namespace
}  // namespace warpscope::net
