// What clients can do to a server after the greeting: slowness, silence, broken and wrong messages, vanishing, crowds, no descriptors.
// Mirrors net/server.h. Each test ends with an honest client that is served, or with nothing left of the others.
#include <sys/resource.h>

#include <cstdlib>
#include <iostream>
#include <map>
#include <random>

#include "tests/net/exchange.h"

namespace warpscope::net {
namespace {

class FaultsServer : public testing::Test {
 protected:
  Server& serve(ServerSettings settings) {
    settings.scene = someScene();
    settings.onNote = notes_.callback();
    server_.emplace(io_, std::move(settings));
    return *server_;
  }
  bool isEmpty() {
    return comesTrue([&] { return server_->requests().clientCount() == 0; });
  }
  /// Whether a new client is greeted and its request answered; somebody has to answer.
  bool isServing() {
    BareSocket socket = greetedClient(*server_);
    socket.send(requestMessage(requestOf(1)));
    return socket.receiveBody(MessageType::frame).has_value();
  }

  VirtualClock clock_;
  Notes notes_;
  const std::shared_ptr<IoThread> io_ = std::make_shared<IoThread>(clock_);
  const PassingTime time_{clock_, io_};
  std::optional<Server> server_;
};

TEST_F(FaultsServer, AnAnswerSaysHowLongItWaitedForTheOneBefore) {
  Server& server = serve({.heartbeat = 10min, .patience = 30min});
  BareSocket slow = greetedClient(server, 2, 4096);
  ASSERT_TRUE(slow.send(requestMessage(requestOf(1)) + requestMessage(requestOf(2))));
  ASSERT_TRUE(comesTrue([&] { return server.requests().waitingCount(1) == 2; }));
  server.answer(1, net::headOf(1), Bytes(16 << 20));
  server.answer(1, net::headOf(2), Bytes());
  settle(*io_);
  clock_.advance(40ms);
  ASSERT_TRUE(slow.skipFrame());
  const std::optional<Bytes> body = slow.receiveBody(MessageType::frame);
  ASSERT_TRUE(body);
  const std::optional<FrameHead> head = readFrameHead(*body);
  ASSERT_TRUE(head);
  EXPECT_EQ(head->id, 2u);
  EXPECT_EQ(head->stages.sendMs, 40.0);
}

TEST_F(FaultsServer, SlowReadersTakeNoMemoryAndHoldUpNobody) {
  constexpr size_t kFrame = 4 << 20;
  constexpr uint16_t kDepth = 3;
  Server& server = serve({.heartbeat = 2900ms, .patience = 3s});
  std::atomic<int> slowAnswers = 0;
  std::atomic<ClientId> slowId = 0;
  std::jthread answering([&](const std::stop_token& stop) {
    while (const std::optional<RequestJob> job = server.requests().take(stop)) {
      slowAnswers += job->client == slowId;
      server.answer(job->client, net::headOf(job->request.id), Bytes(job->client == slowId ? kFrame : 1000));
    }
  });
  slowId = 1;  // the first to come
  BareSocket slow = greetedClient(server, kDepth, 4096);
  BareSocket good = greetedClient(server);
  ASSERT_TRUE(slow.isOpen() && good.isOpen());
  std::jthread asking([&](const std::stop_token& stop) {
    for (uint64_t id = 1; !stop.stop_requested() && slow.send(requestMessage(requestOf(id)), 100ms); ++id) std::this_thread::sleep_for(2ms);
  });
  const size_t before = memoryBytes();
  uint64_t id = 0;
  const auto isServed = [&] { return good.send(requestMessage(requestOf(++id))) && good.receiveBody(MessageType::frame); };
  // No time passes: who waited for the slow one's patience to end would wait for ever.
  ASSERT_TRUE(comesTrue([&] { return slowAnswers >= kDepth; }));
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(isServed()) << "held up by the slow reader";
  EXPECT_LE(slowAnswers, kDepth + 3) << "what is given out is what waits, and what the kernel took";
  if (!kIsSanitized) {
    EXPECT_LT(memoryBytes(), before + (kDepth + 5) * kFrame);
  }
  asking.request_stop();
  asking.join();
  // It goes when nothing has passed for too long, however much it says, and the other one stays. The kernel takes the last bytes in its own time.
  EXPECT_TRUE(comesTrue([&] {
    time_.jump(1s);
    return isServed() && (!slow.send(beatMessage(MessageType::pong, 1)) || server.requests().clientCount() == 1);
  }));
  EXPECT_TRUE(isServed());
  EXPECT_TRUE(notes_.has("left: sending a frame")) << notes_.all();
}

TEST_F(FaultsServer, WhoPingsAndNeverReadsIsDropped) {
  Server& server = serve({.heartbeat = 100ms, .patience = 1000ms});
  const Answering answering(server, 1 << 20);
  BareSocket socket = greetedClient(server, 1, 4096);
  const size_t before = memoryBytes();
  Bytes pings;
  for (uint64_t i = 0; i < 1000; ++i) pings = pings + beatMessage(MessageType::ping, i);
  uint64_t id = 0;
  // The kernel takes bytes in its own time, but not for ever.
  for (const TimePoint limit = now() + kHang; now() < limit && socket.send(pings) && socket.send(requestMessage(requestOf(++id)));) time_.jump(100ms);
  EXPECT_TRUE(isEmpty());
  if (!kIsSanitized) {
    EXPECT_LT(memoryBytes(), before + (32 << 20));
  }
  EXPECT_TRUE(isServing());
}

TEST_F(FaultsServer, SilentPeersAreDroppedInTime) {
  Server& server = serve({.greetingPatience = 100ms, .heartbeat = 50ms, .patience = 1000ms});
  BareSocket silent = greetedClient(server);
  ASSERT_TRUE(time_.isAwaited(1100ms));
  time_.pass(1099ms);
  EXPECT_EQ(server.requests().clientCount(), 1u) << "not before its patience ends";
  time_.pass(1ms);
  EXPECT_TRUE(silent.isEnded()) << "its heartbeats come, it answers none";
  EXPECT_TRUE(isEmpty());
  EXPECT_TRUE(notes_.has("left: waiting for a message")) << notes_.all();
}

TEST_F(FaultsServer, WhoAnswersHeartbeatsStays) {
  Server& server = serve({.heartbeat = 50ms, .patience = 1000ms});
  BareSocket socket = greetedClient(server);
  ASSERT_TRUE(socket.send(beatMessage(MessageType::ping, 1)));  // after its first message a client has the usual patience
  ASSERT_TRUE(socket.receiveBody(MessageType::pong));
  settle(*io_);
  for (int i = 0; i < 20; ++i) {
    time_.jump(50ms);
    const std::optional<Bytes> ping = socket.receiveBody(MessageType::ping);
    ASSERT_TRUE(ping);
    settle(*io_);
    ASSERT_TRUE(socket.send(beatMessage(MessageType::pong, *readBeat(*ping))));
    ASSERT_TRUE(time_.isAwaited(1000ms)) << "it has read that";
  }
}

TEST_F(FaultsServer, HalfEndedConnectionsEnd) {
  Server& server = serve({});
  BareSocket socket = greetedClient(server);
  socket.endWriting();
  EXPECT_TRUE(socket.isEnded());
  EXPECT_TRUE(isEmpty());
}

TEST_F(FaultsServer, LengthsThatCannotBeEndTheConnection) {
  Server& server = serve({});
  const Answering answering(server, 10);
  const size_t before = memoryBytes();
  for (const MessageType type : {MessageType::request, MessageType::ping, MessageType::pong})
    for (const uint32_t length : {0u, 7u, 9u, static_cast<uint32_t>(kLeastRequestBytes) - 1, static_cast<uint32_t>(kMaxRequestBytes) + 1, 1u << 30, 0x7fffffffu,
                                  0x80000000u, 0xffffffffu}) {
      BareSocket socket = greetedClient(server);
      ASSERT_TRUE(socket.isOpen());
      socket.send(headOf(type, length) + Bytes(std::min(length, 200u)));
      EXPECT_TRUE(socket.isEnded()) << static_cast<int>(type) << " of " << length;
    }
  EXPECT_TRUE(isEmpty());
  if (!kIsSanitized) {
    EXPECT_LT(memoryBytes(), before + (16 << 20));
  }
  EXPECT_TRUE(isServing());
}

TEST_F(FaultsServer, RequestsCutAtAnyByteEndTheConnection) {
  Server& server = serve({});
  const Answering answering(server, 10);
  const size_t before = openFiles();
  const Bytes request = requestMessage(requestOf(1));
  for (size_t size = 0; size < request.size(); ++size) {
    BareSocket ended = greetedClient(server), reset = greetedClient(server);
    ASSERT_TRUE(ended.isOpen() && reset.isOpen());
    ended.send(ByteView(request).first(size));
    reset.send(ByteView(request).first(size));
    ended.endWriting();
    reset.reset();
    EXPECT_TRUE(ended.isEnded()) << size;
  }
  EXPECT_TRUE(isEmpty());
  EXPECT_TRUE(comesTrue([&] { return openFiles() == before; }));
  EXPECT_EQ(answering.count, 0);
  EXPECT_TRUE(isServing());
}

TEST_F(FaultsServer, RequestsThatStopInTheMiddleEndAtTheDeadline) {
  Server& server = serve({.greetingPatience = 100ms, .heartbeat = 50ms, .patience = 1000ms});
  const Bytes request = requestMessage(requestOf(1));
  std::vector<BareSocket> sockets;
  for (const size_t size : {size_t{1}, size_t{7}, size_t{8}, size_t{9}, size_t{60}, request.size() - 1}) {
    sockets.push_back(greetedClient(server));
    sockets.back().send(ByteView(request).first(size));
  }
  // Twice: what came late counts from when it came.
  for (int i = 0; i < 2; ++i) time_.pass(1100ms);
  for (BareSocket& socket : sockets) EXPECT_TRUE(socket.isEnded());
  EXPECT_TRUE(isEmpty());
}

TEST_F(FaultsServer, IdsThatDoNotGrowEndTheConnection) {
  Server& server = serve({});
  const Answering answering(server, 10);
  for (const std::vector<uint64_t>& ids : {std::vector<uint64_t>{0}, {5, 5}, {5, 4}, {1, 2, 3, 2}, {~uint64_t{0}, 1}}) {
    BareSocket socket = greetedClient(server, 16);
    for (const uint64_t id : ids) socket.send(requestMessage(requestOf(id)));
    EXPECT_TRUE(socket.isEnded());
  }
  EXPECT_TRUE(notes_.has("sent a request out of order"));
  EXPECT_TRUE(isEmpty());
  EXPECT_TRUE(isServing());
}

TEST_F(FaultsServer, MessagesOfTheWrongDirectionEndTheConnection) {
  Server& server = serve({});
  const Answering answering(server, 10);
  const std::vector<Bytes> messages{sceneMessage(someScene()), wholeFrame(1, 100), failureMessage({1, "no"}), toBytes(ClientHello{})};
  for (const Bytes& message : messages) {
    BareSocket socket = greetedClient(server);
    socket.send(message);
    EXPECT_TRUE(socket.isEnded());
  }
  EXPECT_TRUE(notes_.has("sent a message that clients do not send"));
  EXPECT_TRUE(isServing());
}

TEST_F(FaultsServer, GarbageEndsTheConnection) {
  Server& server = serve({});
  const Answering answering(server, 10);
  std::mt19937 random(11);
  for (int round = 0; round < 60; ++round) {
    BareSocket socket = greetedClient(server);
    ASSERT_TRUE(socket.isOpen());
    Bytes garbage(1 + random() % 3000);
    for (std::byte& byte : garbage) byte = static_cast<std::byte>(random());
    // In every other round behind a head that promises a request.
    if (round % 2 == 0) garbage = headOf(MessageType::request, kLeastRequestBytes) + garbage;
    socket.send(garbage);
    socket.endWriting();
    EXPECT_TRUE(socket.isEnded());
  }
  EXPECT_TRUE(isEmpty());
  EXPECT_TRUE(isServing());
}

TEST_F(FaultsServer, VanishingInTheMiddleOfAFrameLeavesNothing) {
  Server& server = serve({});
  const Answering answering(server, 20 << 20);
  const size_t before = openFiles();
  for (int round = 0; round < 10; ++round) {
    BareSocket socket = greetedClient(server, 1, 4096);
    ASSERT_TRUE(socket.send(requestMessage(requestOf(1))));
    ASSERT_EQ(socket.receive(1000).size(), 1000u);
    round % 2 == 0 ? socket.reset() : socket.close();
  }
  EXPECT_TRUE(isEmpty());
  EXPECT_TRUE(comesTrue([&] { return openFiles() == before; }));
  EXPECT_TRUE(isServing());
}

TEST_F(FaultsServer, PeersThatVanishWithoutAWordAreDroppedInTime) {
  Server& server = serve({.greetingPatience = 100ms, .heartbeat = 50ms, .patience = 1000ms});
  BareSocket socket = greetedClient(server);
  // A socket under repair goes without a FIN, as a machine does that loses its power.
  const int on = 1;
  if (setsockopt(socket.handle(), IPPROTO_TCP, TCP_REPAIR, &on, sizeof on) != 0)
    GTEST_SKIP() << "TCP_REPAIR is not permitted here (CAP_NET_ADMIN)";
  socket.close();
  // The kernel may answer the next heartbeat with a reset, since this machine itself is still there.
  ASSERT_TRUE(time_.isAwaited(1100ms));
  time_.pass(1100ms);
  EXPECT_TRUE(isEmpty());
}

TEST_F(FaultsServer, AThousandConnectionsLeaveNothing) {
  Server& server = serve({});
  const Answering answering(server, 1000);
  const auto visit = [&](int count) {
    for (int i = 0; i < count; ++i) {
      Witness witness;
      Client client(io_, {.address = server.address()}, witness);
      ASSERT_TRUE(witness.waitForConnection());
      if (i % 10 == 0) {
        client.request(requestOf(1));
        ASSERT_TRUE(witness.frameOf(1));
      }
    }
    EXPECT_TRUE(isEmpty());
  };
  visit(200);
  const size_t filesBefore = openFiles(), memoryBefore = memoryBytes();
  visit(kIsSanitized ? 300 : 1000);
  EXPECT_TRUE(comesTrue([&] { return openFiles() == filesBefore; })) << openFiles() << " files, before " << filesBefore;
  if (!kIsSanitized) {
    EXPECT_LT(memoryBytes(), memoryBefore + (2 << 20));
  }
}

TEST_F(FaultsServer, EveryoneOfACrowdIsServedAndTheNextOneWaits) {
  Server& server = serve({.clients = {64, 64, 1h}});
  std::map<ClientId, int> served;
  std::atomic<bool> mayAnswer = false;
  std::jthread answering([&](const std::stop_token& stop) {
    comesTrue([&] { return mayAnswer.load() || stop.stop_requested(); });
    while (const std::optional<RequestJob> job = server.requests().take(stop)) {
      ++served[job->client];
      server.answer(job->client, net::headOf(job->request.id), Bytes(100));
    }
  });
  std::vector<BareSocket> crowd;
  for (int i = 0; i < 64; ++i) {
    crowd.push_back(greetedClient(server, 2));
    ASSERT_TRUE(crowd.back().isOpen());
  }
  Witness witness;
  Client next(io_, {.address = server.address()}, witness);
  EXPECT_THAT(witness.sentenceWhen(ConnectionPhase::waiting), HasSubstr("no room for another client"));
  for (uint64_t id = 1; id <= 2; ++id)
    for (BareSocket& socket : crowd) ASSERT_TRUE(socket.send(requestMessage(requestOf(id))));
  ASSERT_TRUE(comesTrue([&] {
    size_t waiting = 0;
    for (ClientId id = 1; id <= 64; ++id) waiting += server.requests().waitingCount(id);
    return waiting == 128;
  }));
  mayAnswer = true;
  for (BareSocket& socket : crowd)
    for (int i = 0; i < 2; ++i) ASSERT_TRUE(socket.receiveBody(MessageType::frame));
  crowd.pop_back();
  EXPECT_TRUE(time_.passUntil([&] { return witness.look([&] { return witness.isConnected(); }); })) << "a place is free";
  answering.request_stop();
  answering.join();
  EXPECT_EQ(served.size(), 64u);
  for (const auto& [client, count] : served) EXPECT_EQ(count, 2) << client;
}

TEST_F(FaultsServer, FramesThatAClientCannotTakeBecomeFailures) {
  Server& server = serve({});
  const Answering answering(server, 10'000);
  Witness witness;
  Client client(io_, {.address = server.address(), .maxFrameBytes = 5000}, witness);
  client.request(requestOf(1));
  ASSERT_TRUE(witness.waitFor([&] { return !witness.failures.empty(); }));
  EXPECT_EQ(witness.failures[0].id, 1u);
  EXPECT_THAT(witness.failures[0].sentence, HasSubstr("more than this client takes"));
  client.request(requestOf(2));
  ASSERT_TRUE(witness.waitFor([&] { return witness.failures.size() == 2; }));
}

TEST_F(FaultsServer, AnswersForWhoIsGoneAreDropped) {
  Server& server = serve({});
  server.answer(12345, net::headOf(1), Bytes(10));
  server.answer(12345, Failure{1, "nobody is there"});
  BareSocket socket = greetedClient(server);
  ASSERT_TRUE(socket.send(requestMessage(requestOf(1))));
  std::stop_source stop;
  const std::optional<RequestJob> job = server.requests().take(stop.get_token());
  ASSERT_TRUE(job);
  socket.close();
  EXPECT_TRUE(isEmpty());
  server.answer(job->client, net::headOf(1), Bytes(10));
  const Answering answering(server, 10);
  EXPECT_TRUE(isServing());
}

/// In a process of its own, which has no other descriptors to lose.
[[noreturn]] void runOutOfFiles() {
  const auto io = std::make_shared<IoThread>();
  Notes notes;
  Server server(io, {.scene = someScene(), .onNote = notes.callback()});
  const Answering answering(server, 10);
  BareSocket inside = greetedClient(server);
  if (!inside.isOpen()) std::_Exit(2);
  const rlimit limit{64, 64};
  if (setrlimit(RLIMIT_NOFILE, &limit) != 0) std::_Exit(3);
  std::vector<int> taken;
  for (int copy = dup(0); copy >= 0; copy = dup(0)) taken.push_back(copy);
  if (taken.empty()) std::_Exit(4);
  ::close(taken.back());
  taken.pop_back();
  BareSocket outside = BareSocket::connect(server.port());  // with the last one
  if (!outside.isOpen() || !outside.send(toBytes(ClientHello{}))) std::_Exit(5);
  if (!notes.has("no connection can be accepted")) std::_Exit(6);
  // Those inside do not notice.
  if (!inside.send(requestMessage(requestOf(1))) || !inside.receiveBody(MessageType::frame)) std::_Exit(7);
  for (const int file : taken) ::close(file);
  if (!readServerHello(outside.receive(kServerHelloBytes)) || !outside.receiveBody(MessageType::scene)) std::_Exit(8);
  if (!outside.send(requestMessage(requestOf(1))) || !outside.receiveBody(MessageType::frame)) std::_Exit(9);
  std::cerr << "served in the end\n";
  std::_Exit(0);
}

TEST(FaultsServerDeathTest, WithoutDescriptorsItWaitsAndGoesOn) {
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_EXIT(runOutOfFiles(), testing::ExitedWithCode(0), "served in the end");
}

}  // namespace
}  // namespace warpscope::net
