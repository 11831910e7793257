// What servers can do to a client: broken, wrong, cut, repeated and missing messages; and how it comes back.
// Mirrors net/client.h. The servers are bare sockets.
#include <algorithm>
#include <map>
#include <random>

#include "tests/net/exchange.h"

namespace warpscope::net {
namespace {

class FaultsClient : public testing::Test {
 protected:
  void connect(ClientSettings settings = {}) {
    settings.address = listener_.address();
    client_.emplace(io_, settings, witness_);
  }
  /// The sentence that a client ends with which has been greeted, asked for frame 1, and was sent `bytes`.
  std::string sentenceAfter(const Bytes& bytes, uint64_t maxFrameBytes = kMaxFrameBytes, ConnectionPhase phase = ConnectionPhase::waiting) {
    Witness witness;
    Client client(io_, {.address = listener_.address(), .maxFrameBytes = maxFrameBytes}, witness);
    BareSocket socket = greetedServer(listener_);
    client.request(requestOf(1));
    EXPECT_TRUE(nextRequest(socket));
    EXPECT_TRUE(socket.send(bytes));
    return witness.sentenceWhen(phase);
  }

  /// Until the client's pause before it connects again is over. `count`: of the pauses up to this one.
  void passPause(size_t count) {
    ASSERT_TRUE(witness_.waitFor([&] { return witness_.countOf(ConnectionPhase::waiting) == count; }));
    const TimePoint next = witness_.look([&] { return *witness_.states.back().next; });
    clock_.advance(next - clock_.now());
  }

  VirtualClock clock_;
  BareListener listener_;
  Witness witness_;
  const std::shared_ptr<IoThread> io_ = std::make_shared<IoThread>(clock_);
  const PassingTime time_{clock_, io_};
  std::optional<Client> client_;
};

TEST_F(FaultsClient, LengthsThatCannotBeEndTheConnection) {
  for (const uint32_t length : {0u, static_cast<uint32_t>(kLeastFrameHeadBytes) - 1, static_cast<uint32_t>(kMaxFrameBytes) + 1, 0xffffffffu})
    EXPECT_THAT(sentenceAfter(headOf(MessageType::frame, length)), HasSubstr("announced a frame of " + std::to_string(length) + " bytes"));
  EXPECT_THAT(sentenceAfter(headOf(MessageType::frame, 1001), 1000), HasSubstr("announced a frame of 1001 bytes"));
  for (const uint32_t length : {static_cast<uint32_t>(kMaxFailureBytes) + 1, 0x80000000u, 0xffffffffu})
    EXPECT_THAT(sentenceAfter(headOf(MessageType::failure, length)), HasSubstr("where 4096 are the most"));
  EXPECT_THAT(sentenceAfter(headOf(MessageType::failure, 0)), HasSubstr("sent a damaged message"));
  for (const uint32_t length : {9u, 0xffffffffu}) EXPECT_THAT(sentenceAfter(headOf(MessageType::ping, length)), HasSubstr("where 8 are the most"));
  EXPECT_THAT(sentenceAfter(headOf(MessageType::pong, 0)), HasSubstr("sent a damaged heartbeat"));
}

TEST_F(FaultsClient, ScenesThatAreNoneEndTheConnection) {
  const std::vector<std::pair<Bytes, std::string>> cases{
      {headOf(MessageType::scene, 0), "sent a damaged scene"},
      {headOf(MessageType::scene, kMaxSceneBytes + 1), "where 65536 are the most"},
      {headOf(MessageType::scene, 0xffffffff), "where 65536 are the most"},
      {headOf(MessageType::scene, 300) + Bytes(300), "sent a damaged scene"},
      {wholeFrame(1, 10), "did not begin with its scene"},
      {beatMessage(MessageType::ping, 1), "did not begin with its scene"},
      {Bytes(100, std::byte{0xee}), "sent what is no message"},
  };
  for (const auto& [bytes, sentence] : cases) {
    Witness witness;
    Client client(io_, {.address = listener_.address()}, witness);
    BareSocket socket = listener_.accept();
    ASSERT_EQ(socket.receive(kClientHelloBytes).size(), kClientHelloBytes);
    const Bytes greeting = welcomeBytes();
    socket.send(Bytes(greeting.begin(), greeting.begin() + kServerHelloBytes) + bytes);
    EXPECT_THAT(witness.sentenceWhen(ConnectionPhase::waiting), HasSubstr(sentence));
    EXPECT_TRUE(witness.scenes.empty());
  }
}

TEST_F(FaultsClient, LengthsAloneTakeNoMemory) {
  connect();
  BareSocket socket = greetedServer(listener_);
  client_->request(requestOf(1));
  ASSERT_TRUE(nextRequest(socket));
  const size_t before = memoryBytes();
  // The answer to the ping says that it reads what comes behind.
  ASSERT_TRUE(socket.send(beatMessage(MessageType::ping, 77) + frameMessage(net::headOf(1), kMaxFrameBytes - kLeastFrameHeadBytes) + Bytes(100'000)));
  const std::optional<Bytes> pong = socket.receiveBody(MessageType::pong);
  ASSERT_TRUE(pong && readBeat(*pong) == 77u);
  settle(*io_);
  if (kIsSanitized) GTEST_SKIP() << "sanitizers keep freed memory";
  EXPECT_LT(memoryBytes(), before + (4 << 20)) << "what is announced is not allocated before it comes";
}

TEST_F(FaultsClient, FramesThatNobodyAskedForEndItForGood) {
  const std::string wanted = "answered something else than it was asked: nobody waits for frame ";
  const auto refusalAfter = [&](const Bytes& bytes) { return sentenceAfter(bytes, kMaxFrameBytes, ConnectionPhase::refused); };
  EXPECT_THAT(refusalAfter(wholeFrame(2, 10)), HasSubstr(wanted));
  EXPECT_THAT(refusalAfter(wholeFrame(0, 10)), HasSubstr(wanted));
  EXPECT_THAT(refusalAfter(failureMessage({2, "no"})), HasSubstr(wanted));
  EXPECT_THAT(refusalAfter(wholeFrame(1, 10) + wholeFrame(1, 10)), HasSubstr(wanted)) << "twice";
  EXPECT_THAT(refusalAfter(wholeFrame(1, 10) + failureMessage({1, "no"})), HasSubstr(wanted));
  // Before its payload has come, of which there could be much.
  EXPECT_THAT(refusalAfter(frameMessage(net::headOf(2), kMaxFrameBytes - kLeastFrameHeadBytes)), HasSubstr(wanted));
}

TEST_F(FaultsClient, AnswersInAnotherOrderEndItForGood) {
  connect({.depth = 2});
  BareSocket socket = greetedServer(listener_, 2);
  client_->request(requestOf(1));
  ASSERT_TRUE(nextRequest(socket));
  client_->request(requestOf(2));
  ASSERT_TRUE(nextRequest(socket));
  socket.send(wholeFrame(2, 10) + wholeFrame(1, 10));
  EXPECT_THAT(witness_.sentenceWhen(ConnectionPhase::refused), HasSubstr("nobody waits for frame 1"));
  EXPECT_EQ(witness_.frames.size(), 1u);
}

TEST_F(FaultsClient, OfSeveralThatWereNotAnsweredTheNewestAloneIsAskedAgain) {
  connect({.depth = 3});
  BareSocket socket = greetedServer(listener_, 3);
  for (uint64_t id = 1; id <= 3; ++id) {
    client_->request(requestOf(id));
    ASSERT_TRUE(nextRequest(socket));
  }
  socket.reset();
  passPause(1);
  BareSocket again = greetedServer(listener_, 3);
  const std::optional<FrameRequest> request = nextRequest(again);
  ASSERT_TRUE(request);
  EXPECT_EQ(request->id, 3u);
  client_->request(requestOf(4));
  const std::optional<FrameRequest> next = nextRequest(again);
  ASSERT_TRUE(next);
  EXPECT_EQ(next->id, 4u) << "neither 1 nor 2, nor 3 twice";
  again.send(wholeFrame(3, 10) + wholeFrame(4, 10));
  EXPECT_TRUE(witness_.frameOf(4));
}

TEST_F(FaultsClient, MessagesOfTheWrongDirectionEndTheConnection) {
  const std::string wanted = "sent a message that servers do not send";
  EXPECT_THAT(sentenceAfter(requestMessage(requestOf(1))), HasSubstr(wanted));
  EXPECT_THAT(sentenceAfter(sceneMessage(someScene())), HasSubstr(wanted)) << "once is enough";
}

TEST_F(FaultsClient, GarbageEndsTheConnection) {
  std::mt19937 random(13);
  for (int round = 0; round < 40; ++round) {
    Bytes garbage(kMessageHeadBytes + random() % 3000);
    for (std::byte& byte : garbage) byte = static_cast<std::byte>(random() | 1);  // the zeros of a head are none then
    EXPECT_THAT(sentenceAfter(garbage), HasSubstr("sent what is no message"));
  }
}

TEST_F(FaultsClient, GreetingsCutAtAnyByteAreTriedAgain) {
  connect();
  const Bytes greeting = welcomeBytes();
  for (size_t size = 0; size < greeting.size(); ++size) {
    BareSocket socket = listener_.accept();
    ASSERT_TRUE(socket.isOpen()) << "came no more after " << size;
    ASSERT_EQ(socket.receive(kClientHelloBytes).size(), kClientHelloBytes);
    socket.send(ByteView(greeting).first(size));
    size % 2 == 0 ? socket.reset() : socket.close();
    passPause(size + 1);
  }
  {
    const std::scoped_lock lock(witness_.mutex);
    EXPECT_EQ(witness_.countOf(ConnectionPhase::connected), 0u);
    EXPECT_EQ(witness_.countOf(ConnectionPhase::refused), 0u);
  }
  const BareSocket socket = greetedServer(listener_);
  EXPECT_TRUE(witness_.waitForConnection());
}

TEST_F(FaultsClient, FramesCutAtAnyByteAreAskedForAgain) {
  connect();
  client_->request(requestOf(7));
  const Bytes frame = wholeFrame(7, 20);
  const size_t before = openFiles();
  for (size_t size = 0; size < frame.size(); ++size) {
    BareSocket socket = greetedServer(listener_);
    ASSERT_TRUE(socket.isOpen());
    const std::optional<FrameRequest> request = nextRequest(socket);
    ASSERT_TRUE(request) << size;
    ASSERT_EQ(request->id, 7u);
    socket.send(ByteView(frame).first(size));
    size % 2 == 0 ? socket.close() : socket.reset();
    passPause(size + 1);
  }
  EXPECT_TRUE(witness_.look([&] { return witness_.frames.empty(); }));
  BareSocket socket = greetedServer(listener_);
  ASSERT_TRUE(nextRequest(socket));
  socket.send(frame);
  ASSERT_TRUE(witness_.frameOf(7));
  EXPECT_EQ(witness_.frames.size(), 1u);
  EXPECT_LE(openFiles(), before + 2);
}

TEST_F(FaultsClient, ServersThatFallSilentAreLeft) {
  connect();
  BareSocket socket = greetedServer(listener_, 1, 50, 1000);
  ASSERT_TRUE(witness_.waitForConnection());
  ASSERT_TRUE(time_.isAwaited(1000ms));
  time_.pass(999ms);
  EXPECT_TRUE(witness_.look([&] { return witness_.isConnected(); })) << "not before its patience ends";
  time_.pass(1ms);
  EXPECT_THAT(witness_.sentenceWhen(ConnectionPhase::waiting), HasSubstr("waiting for a message"));
}

TEST_F(FaultsClient, ServersThatStopInTheMiddleOfAFrameAreLeft) {
  connect({.firstPause = 1h, .longestPause = 1h});
  BareSocket socket = greetedServer(listener_, 1, 250, 1000);
  client_->request(requestOf(1));
  ASSERT_TRUE(nextRequest(socket));
  const Bytes frame = wholeFrame(1, 1000);
  socket.send(ByteView(frame).first(300));
  time_.jump(200ms);
  socket.send(ByteView(frame).subspan(300, 300));
  ASSERT_TRUE(time_.isAwaited(1000ms)) << "it has read of that";
  time_.pass(2000ms);  // what it read a little later counts from then
  EXPECT_THAT(witness_.sentenceWhen(ConnectionPhase::waiting), testing::StartsWith("a message (127.0.0.1:"));
}

TEST_F(FaultsClient, SlowFramesAreNoSilence) {
  connect();
  BareSocket socket = greetedServer(listener_, 1, 300, 1000);
  client_->request(requestOf(1));
  ASSERT_TRUE(nextRequest(socket));
  settle(*io_);
  const Bytes frame = wholeFrame(1, 1000);
  for (size_t at = 0; at < frame.size(); at += 50) {  // 7.2 s
    ASSERT_TRUE(socket.send(ByteView(frame).subspan(at, std::min<size_t>(50, frame.size() - at))));
    ASSERT_TRUE(time_.isAwaited(1000ms)) << "it has read of that";
    time_.jump(300ms);
    ASSERT_TRUE(socket.receiveBody(MessageType::ping));
    settle(*io_);
  }
  EXPECT_TRUE(witness_.frameOf(1));
}

TEST_F(FaultsClient, HeartbeatsAreAnsweredAndOnesOwnAreMeasured) {
  connect();
  BareSocket socket = greetedServer(listener_, 1, 30, 5000);
  socket.send(beatMessage(MessageType::ping, 1234) + beatMessage(MessageType::pong, 1) + beatMessage(MessageType::pong, ~uint64_t{0}));
  // The answer, and the client's own first one, in any order.
  std::map<MessageType, Bytes> beats;
  for (int i = 0; i < 2; ++i) {
    std::optional<BareSocket::Message> message = socket.receiveMessage();
    ASSERT_TRUE(message);
    beats[message->type] = std::move(message->body);
  }
  ASSERT_TRUE(beats.contains(MessageType::pong) && beats.contains(MessageType::ping));
  EXPECT_EQ(readBeat(beats[MessageType::pong]), 1234u);
  EXPECT_TRUE(witness_.look([&] { return witness_.roundTrips.empty(); })) << "pongs for what was never sent measure nothing";
  time_.jump(7ms);
  for (size_t i = 0; i < 5; ++i) {
    time_.jump(23ms);
    const std::optional<Bytes> ping = socket.receiveBody(MessageType::ping);
    ASSERT_TRUE(ping) << "one each interval";
    time_.jump(7ms);
    socket.send(beatMessage(MessageType::pong, *readBeat(*ping)) + beatMessage(MessageType::pong, *readBeat(*ping)));
    ASSERT_TRUE(witness_.waitFor([&] { return witness_.roundTrips.size() == i + 1; }));
  }
  const std::scoped_lock lock(witness_.mutex);
  EXPECT_EQ(witness_.roundTrips, std::vector<Duration>(5, 7ms)) << "once each";
}

TEST_F(FaultsClient, IsToldOfProcesses) {
  connect();
  BareSocket socket = greetedServer(listener_);
  client_->request(requestOf(1));
  ASSERT_TRUE(nextRequest(socket));
  const std::vector<ProcessFields> processes(3, ProcessFields{.tiles = 7});
  socket.send(processesMessage(processes) + processesMessage({}) + wholeFrame(1, 10));
  ASSERT_TRUE(witness_.frameOf(1));
  EXPECT_EQ(witness_.look([&] { return witness_.processes; }), (std::vector<std::vector<ProcessFields>>{processes, {}}));
  EXPECT_THAT(sentenceAfter(headOf(MessageType::processes, kMaxProcessesBytes + 1)), HasSubstr("where 131074 are the most"));
  EXPECT_THAT(sentenceAfter(headOf(MessageType::processes, 3) + Bytes(3)), HasSubstr("sent a damaged message"));
}

TEST_F(FaultsClient, WhoWaitsIsToldOfABusyServer) {
  connect();
  BareSocket socket = greetedServer(listener_);
  socket.send(busyMessage(9));  // nothing is waited for yet
  socket.send(beatMessage(MessageType::ping, 1));
  ASSERT_TRUE(socket.receiveBody(MessageType::pong)) << "it has read that";
  client_->request(requestOf(1));
  ASSERT_TRUE(nextRequest(socket));
  socket.send(busyMessage(0) + busyMessage(63) + busyMessage(65535) + wholeFrame(1, 10));
  ASSERT_TRUE(witness_.frameOf(1));
  EXPECT_EQ(witness_.look([&] { return witness_.busyWith; }), (std::vector<uint16_t>{0, 63, 65535}));
  EXPECT_THAT(sentenceAfter(headOf(MessageType::busy, 3)), HasSubstr("where 2 are the most"));
  EXPECT_THAT(sentenceAfter(headOf(MessageType::busy, 1) + Bytes(1)), HasSubstr("sent a damaged message"));
}

TEST_F(FaultsClient, OfABurstOnlyTheNewestIsAsked) {
  connect({.depth = 2});
  BareSocket socket = greetedServer(listener_, 2);
  ASSERT_TRUE(witness_.waitForConnection());
  for (uint64_t id = 1; id <= 1000; ++id) client_->request(requestOf(id));
  client_->request(requestOf(500));  // not newer: passed over
  uint64_t last = 0;
  int asked = 0;
  std::deque<uint64_t> underWay;
  while (last != 1000) {
    const std::optional<FrameRequest> request = nextRequest(socket);
    ASSERT_TRUE(request);
    ASSERT_GT(request->id, last);
    last = request->id;
    underWay.push_back(last);
    ++asked;
    ASSERT_LE(underWay.size(), 2u) << "no more than agreed";
    if (underWay.size() < 2) continue;
    EXPECT_FALSE(nextRequest(socket, 30ms)) << "two are under way";
    ASSERT_TRUE(socket.send(wholeFrame(underWay.front(), 10)));
    underWay.pop_front();
  }
  for (const uint64_t id : underWay) socket.send(wholeFrame(id, 10));
  ASSERT_TRUE(witness_.frameOf(1000));
  EXPECT_LT(asked, 100);
  EXPECT_EQ(witness_.frames.size(), static_cast<size_t>(asked));
  EXPECT_FALSE(nextRequest(socket, 30ms));
}

TEST_F(FaultsClient, RequestsThatWereReplacedNeedNoAnswer) {
  connect({.depth = 3});
  BareSocket socket = greetedServer(listener_, 3);
  for (uint64_t id = 1; id <= 3; ++id) {
    client_->request(requestOf(id));
    ASSERT_TRUE(nextRequest(socket));
  }
  socket.send(wholeFrame(3, 10));
  ASSERT_TRUE(witness_.frameOf(3));
  for (uint64_t id = 4; id <= 6; ++id) {  // there is room for three again
    client_->request(requestOf(id));
    ASSERT_TRUE(nextRequest(socket));
  }
}

TEST_F(FaultsClient, DepthsAreBroughtIntoTheirRange) {
  connect({.depth = 0, .maxFrameBytes = 0});
  BareSocket socket = listener_.accept();
  const std::optional<ClientHello> hello = readClientHello(socket.receive(kClientHelloBytes));
  ASSERT_TRUE(hello);
  EXPECT_EQ(hello->depth, 1);
  EXPECT_EQ(hello->maxFrameBytes, kLeastFrameHeadBytes);
}

TEST_F(FaultsClient, MoreDepthTakesAnotherConnectionAtOnce) {
  connect({.depth = 1});
  BareSocket first = greetedServer(listener_);
  ASSERT_TRUE(witness_.waitForConnection());
  client_->setDepth(4);
  EXPECT_EQ(first.end(), BareSocket::End::clean);
  first.close();
  BareSocket second = listener_.accept();
  ASSERT_TRUE(second.isOpen());
  const std::optional<ClientHello> hello = readClientHello(second.receive(kClientHelloBytes));
  ASSERT_TRUE(hello);
  EXPECT_EQ(hello->depth, 4);
  second.send(welcomeBytes(2));  // less than it wanted
  ASSERT_TRUE(witness_.waitFor([&] { return witness_.scenes.size() == 2; }));
  client_->setDepth(2);
  client_->setDepth(3);
  EXPECT_FALSE(listener_.accept(100ms).isOpen()) << "what the server did not grant it will not grant again";
  EXPECT_EQ(witness_.look([&] { return witness_.countOf(ConnectionPhase::waiting); }), 0u);
}

TEST_F(FaultsClient, PausesGrowAreJitteredAndCapped) {
  const uint16_t nobody = BareListener().port();
  Client client(io_, {.address = {{"127.0.0.1", nobody}, {}}, .firstPause = 20ms, .longestPause = 160ms}, witness_);
  for (size_t count = 1; count <= 8; ++count) passPause(count);
  ASSERT_TRUE(witness_.waitFor([&] { return witness_.countOf(ConnectionPhase::waiting) == 9; }));
  const std::scoped_lock lock(witness_.mutex);
  std::vector<double> shares;
  double most = 20.0;
  for (const ConnectionState& state : witness_.states) {
    if (state.phase != ConnectionPhase::waiting) continue;
    EXPECT_EQ(state.attempts, static_cast<int>(shares.size()) + 1);
    EXPECT_THAT(state.sentence, HasSubstr("cannot connect to 127.0.0.1:" + std::to_string(nobody)));
    ASSERT_TRUE(state.next);
    const double pauseMs = std::chrono::duration<double, std::milli>(*state.next - state.since).count();
    EXPECT_GE(pauseMs, most / 2.0 - 1e-6);
    EXPECT_LE(pauseMs, most);
    shares.push_back(pauseMs / most);
    most = std::min(2.0 * most, 160.0);
  }
  const auto [least, greatest] = std::ranges::minmax(shares);
  EXPECT_GT(greatest - least, 0.01) << "the same share each time is no jitter";
}

TEST_F(FaultsClient, PausesGrowAlsoWhileServersGreetAndBreakOff) {
  connect({.firstPause = 10ms, .longestPause = 10s});
  for (int i = 0; i < 5; ++i) {
    BareSocket socket = greetedServer(listener_);
    ASSERT_TRUE(socket.isOpen());
    ASSERT_TRUE(witness_.waitFor([&] { return witness_.scenes.size() == static_cast<size_t>(i) + 1; }));
    socket.close();
    if (i < 4) passPause(static_cast<size_t>(i) + 1);
  }
  const auto lastPause = [&] {
    return std::chrono::duration<double, std::milli>(*witness_.states.back().next - witness_.states.back().since).count();
  };
  ASSERT_TRUE(witness_.waitFor([&] { return witness_.isIn(ConnectionPhase::waiting) && witness_.countOf(ConnectionPhase::waiting) == 5; }));
  EXPECT_GE(witness_.look(lastPause), 80.0);
  passPause(5);
  // One that was of use starts anew.
  BareSocket socket = greetedServer(listener_);
  client_->request(requestOf(1));
  ASSERT_TRUE(nextRequest(socket));
  socket.send(wholeFrame(1, 10));
  ASSERT_TRUE(witness_.frameOf(1));
  socket.close();
  ASSERT_TRUE(witness_.waitFor([&] { return witness_.isIn(ConnectionPhase::waiting); }));
  EXPECT_LE(witness_.look(lastPause), 10.0);
}

TEST_F(FaultsClient, ConnectingNowCutsThePauseShort) {
  const uint16_t nobody = BareListener().port();
  Client client(io_, {.address = {{"127.0.0.1", nobody}, {}}, }, witness_);
  client.connectNow();  // in another phase: nothing
  ASSERT_TRUE(witness_.waitFor([&] { return witness_.isIn(ConnectionPhase::waiting); }));
  Server server(io_, {.listen = {"127.0.0.1", nobody}, .scene = someScene()});
  client.connectNow();
  EXPECT_TRUE(witness_.waitForConnection());
}

TEST_F(FaultsClient, OnceOnlyMeansOnce) {
  connect({.connectsAgain = false});
  greetedServer(listener_).close();
  EXPECT_FALSE(witness_.sentenceWhen(ConnectionPhase::refused).empty());
  EXPECT_FALSE(listener_.accept(50ms).isOpen());
}

}  // namespace
}  // namespace warpscope::net
