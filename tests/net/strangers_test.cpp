// Strangers at the door and clients that take places: silence, floods, one address with many, slow readers; and who is told what.
// Mirrors net/server.h and net/places.h. Time is virtual but where a test is about how long honest clients wait.
#include <sys/resource.h>

#include <deque>

#include "tests/net/exchange.h"

namespace warpscope::net {
namespace {

class Strangers : public testing::Test {
 protected:
  Server& serve(ServerSettings settings) {
    settings.scene = someScene();
    settings.onNote = notes_.callback();
    server_.emplace(io_, std::move(settings));
    return *server_;
  }
  static std::optional<Verdict> verdictFor(BareSocket& socket) {
    const std::optional<ServerHello> answer = readServerHello(socket.receive(kServerHelloBytes));
    return answer ? std::optional(answer->verdict) : std::nullopt;
  }
  bool hasClients(size_t count) {
    return comesTrue([&] { return server_->requests().clientCount() == count; });
  }

  VirtualClock clock_;
  Notes notes_;
  const std::shared_ptr<IoThread> io_ = std::make_shared<IoThread>(clock_);
  const PassingTime time_{clock_, io_};
  std::optional<Server> server_;
};

TEST_F(Strangers, TheOldestSilentOneGoesAndHearsWhy) {
  Server& server = serve({.greetings = {4, 4}});
  std::vector<BareSocket> silent;
  for (int i = 0; i < 4; ++i) {
    silent.push_back(BareSocket::connect(server.port()));
    ASSERT_TRUE(time_.isAwaited(3s));
    time_.jump(1ms);  // so that they differ in age
  }
  BareSocket newcomer = greetedClient(server);
  EXPECT_TRUE(newcomer.isOpen());
  EXPECT_EQ(verdictFor(silent[0]), Verdict::full);
  EXPECT_EQ(silent[0].end(), BareSocket::End::clean);
  EXPECT_TRUE(notes_.has("too many connections have not shown who they are"));
  EXPECT_EQ(silent[1].end(10ms), BareSocket::End::none);
}

TEST_F(Strangers, OverTlsTheyHearAnAlert) {
  Server& server = serve({.identity = makeIdentity(), .token = Token::random(), .greetings = {1, 1}});
  BareSocket silent = BareSocket::connect(server.port());
  ASSERT_TRUE(time_.isAwaited(3s));
  const BareSocket newcomer = BareSocket::connect(server.port());
  const Bytes alert = silent.receive(7);
  ASSERT_EQ(alert.size(), 7u);
  EXPECT_EQ(alert[0], std::byte{21}) << "an alert";
  EXPECT_EQ(alert[6], std::byte{90}) << "user canceled";
  EXPECT_EQ(silent.end(), BareSocket::End::clean);
}

TEST_F(Strangers, AClientThatHearsTheAlertSaysThatThereIsNoRoom) {
  BareListener listener;
  Address address = listener.address();
  address.credentials = Credentials{{}, Token::random()};
  Witness witness;
  Client client(io_, {.address = address}, witness);
  BareSocket socket = listener.accept();
  EXPECT_FALSE(socket.receive(5).empty());
  const std::array<uint8_t, 7> alert{21, 3, 3, 0, 2, 2, 90};
  socket.send(std::as_bytes(std::span(alert)));
  socket.endWriting();
  EXPECT_THAT(witness.sentenceWhen(ConnectionPhase::waiting), HasSubstr("has no room for another"));
}

TEST_F(Strangers, TheFirstByteIsDueSoon) {
  Server& server = serve({.firstBytePatience = 500ms, .greetingPatience = 10s});
  BareSocket silent = BareSocket::connect(server.port());
  ASSERT_TRUE(time_.jumpTo(500ms));
  EXPECT_TRUE(silent.isEnded());
  EXPECT_TRUE(notes_.has("waiting for the first byte")) << notes_.all();
  BareSocket slow = BareSocket::connect(server.port());
  slow.send(ByteView(toBytes(ClientHello{})).first(1));
  ASSERT_TRUE(time_.isAwaited(10s)) << "the rest has longer";
  time_.jump(9s);
  EXPECT_EQ(slow.end(10ms), BareSocket::End::none);
}

TEST_F(Strangers, OneAddressDoesNotTakeAllPlaces) {
  Server& server = serve({.greetings = {8, 4}});
  std::vector<BareSocket> flood;
  for (int i = 0; i < 3; ++i) flood.push_back(BareSocket::connect(server.port(), 0, 2));
  BareSocket other = BareSocket::connect(server.port(), 0, 3);
  ASSERT_TRUE(other.isOpen());
  for (int i = 0; i < 30; ++i) flood.push_back(BareSocket::connect(server.port(), 0, 2));
  for (int i = 0; i < 29; ++i) EXPECT_EQ(verdictFor(flood[static_cast<size_t>(i)]), Verdict::full) << i;
  other.send(toBytes(ClientHello{}));
  EXPECT_EQ(verdictFor(other), Verdict::welcome) << "though it was silent for longest";
}

TEST_F(Strangers, WhoGuessesTokensIsListenedToLessAndLess) {
  Notes lines;
  Server& server = serve({.identity = makeIdentity(), .token = Token::random(), .onWrongToken = lines.callback()});
  Address wrong = server.address();
  wrong.credentials->token = Token::random();
  const auto isRefused = [&](const Address& address) {
    Witness witness;
    Client client(io_, {.address = address, .connectsAgain = false}, witness);
    return witness.sentenceWhen(ConnectionPhase::refused);
  };
  for (int i = 0; i < 4; ++i) EXPECT_THAT(isRefused(wrong), HasSubstr("does not accept this token")) << i;
  EXPECT_TRUE(lines.has("127.0.0.1:")) << lines.all();
  EXPECT_TRUE(lines.has("a wrong token, number 4 in a row; not listened to for 1 s")) << lines.all();
  EXPECT_THAT(isRefused(server.address()), Not(HasSubstr("token"))) << "not even who has the right one";
  time_.jump(1s);
  Witness witness;
  Client client(io_, {.address = server.address()}, witness);
  EXPECT_TRUE(witness.waitForConnection());
}

TEST_F(Strangers, TheLongestIdleClientMakesRoom) {
  Server& server = serve({.clients = {2, 2, 1s}});
  BareSocket first = greetedClient(server), second = greetedClient(server);
  ASSERT_TRUE(first.isOpen() && second.isOpen());
  BareSocket early = BareSocket::connect(server.port());
  early.send(toBytes(ClientHello{}));
  EXPECT_EQ(verdictFor(early), Verdict::full) << "nobody has been idle for long enough";
  time_.jump(900ms);
  first.send(requestMessage(requestOf(1)));
  ASSERT_TRUE(comesTrue([&] { return server.requests().isAwaited(1); }));
  time_.jump(900ms);
  const BareSocket newcomer = greetedClient(server);
  EXPECT_TRUE(newcomer.isOpen());
  EXPECT_TRUE(second.isEnded()) << "the first one waits for an answer";
  EXPECT_TRUE(notes_.has("it made room for another client")) << notes_.all();
  EXPECT_TRUE(hasClients(2));
  EXPECT_EQ(first.end(10ms), BareSocket::End::none);
}

TEST_F(Strangers, WhoLeavesAnswersUnreadHoldsNoPlace) {
  Server& server = serve({.clients = {1, 1, 1s}});
  BareSocket slow = greetedClient(server, 2, 4096);
  for (uint64_t id = 1; id <= 2; ++id) slow.send(requestMessage(requestOf(id)));
  const std::optional<RequestJob> job = server.requests().take({});
  server.answer(job->client, headOf(1), Bytes(size_t{20} << 20));
  settle(*io_);
  time_.jump(Server::kLongestWait - 1ms);
  BareSocket early = BareSocket::connect(server.port());
  early.send(toBytes(ClientHello{}));
  EXPECT_EQ(verdictFor(early), Verdict::full) << "it may still take it";
  time_.jump(1ms);
  EXPECT_TRUE(greetedClient(server).isOpen());
  EXPECT_TRUE(slow.isEnded());
}

TEST_F(Strangers, WhoseRequestTakesAllTooLongHoldsNoPlace) {
  Server& server = serve({.clients = {1, 1, 1s}, .patience = 60s});
  BareSocket heavy = greetedClient(server);
  heavy.send(requestMessage(requestOf(1)));
  ASSERT_TRUE(server.requests().take({}));  // and nothing comes of it
  time_.jump(Server::kLongestUse - 1ms);
  BareSocket early = BareSocket::connect(server.port());
  early.send(toBytes(ClientHello{}));
  EXPECT_EQ(verdictFor(early), Verdict::full);
  time_.jump(1ms);
  EXPECT_TRUE(greetedClient(server).isOpen());
  EXPECT_TRUE(heavy.isEnded());
}

TEST_F(Strangers, AnAddressWithAsManyClientsAsItMayHaveReplacesItsOwn) {
  Server& server = serve({.clients = {8, 2, 0s}});
  BareSocket other = greetedClient(server, 1, 0, 3);
  time_.jump(1s);
  BareSocket first = greetedClient(server), second = greetedClient(server);
  time_.jump(1s);
  const BareSocket third = greetedClient(server);
  EXPECT_TRUE(third.isOpen());
  EXPECT_TRUE(first.isEnded());
  EXPECT_EQ(second.end(10ms), BareSocket::End::none);
  EXPECT_EQ(other.end(10ms), BareSocket::End::none);
}

TEST_F(Strangers, WhoWaitsHearsOfTheOthers) {
  Server& server = serve({.heartbeat = 1s});
  Witness witness;
  Client client(io_, {.address = server.address()}, witness);
  ASSERT_TRUE(witness.waitForConnection());
  BareSocket other = greetedClient(server);
  client.request(requestOf(1));
  other.send(requestMessage(requestOf(1)));
  ASSERT_TRUE(comesTrue([&] { return server.requests().waitingCount(1) + server.requests().waitingCount(2) == 2; }));
  EXPECT_TRUE(time_.passUntil([&] { return witness.look([&] { return witness.busyWith == std::vector<uint16_t>{1}; }); }));
  const Answering answering(server, 100);
  EXPECT_TRUE(witness.frameOf(1));
  time_.pass(3s);
  EXPECT_EQ(witness.look([&] { return witness.busyWith.size(); }), 1u) << "only while it waits";
  // A client of before this message does not get it.
  ClientHello old;
  old.capabilities = kCapabilities & ~uint32_t{kCanHearBusy};
  BareSocket without = BareSocket::connect(server.port());
  without.send(toBytes(old));
  EXPECT_EQ(verdictFor(without), Verdict::welcome);
}

TEST_F(Strangers, ThoseThatCanHearItAreToldOfProcesses) {
  Server& server = serve({});
  Witness witness;
  Client client(io_, {.address = server.address()}, witness);
  ASSERT_TRUE(witness.waitForConnection());
  ClientHello old;
  old.capabilities = kCapabilities & ~uint32_t{kCanHearProcesses};
  BareSocket without = BareSocket::connect(server.port());
  without.send(toBytes(old));
  ASSERT_EQ(verdictFor(without), Verdict::welcome);
  const std::vector<ProcessFields> processes(2, ProcessFields{.sentBytes = 5});
  const auto answer = [&] {
    const std::optional<RequestJob> job = server.requests().take({});
    server.answer(job->client, headOf(job->request.id), Bytes(10), nullptr, processes);
  };
  client.request(requestOf(1));
  answer();
  EXPECT_TRUE(witness.frameOf(1));
  EXPECT_EQ(witness.look([&] { return witness.processes; }), (std::vector<std::vector<ProcessFields>>{processes}));
  without.send(requestMessage(requestOf(1)));
  answer();
  while (const std::optional<BareSocket::Message> message = without.receiveMessage()) {
    if (message->type == MessageType::frame) break;
    EXPECT_NE(message->type, MessageType::processes);
  }
}

TEST_F(Strangers, TheSlowestReaderGoesWhereMemoryIsShort) {
  Server& server = serve({});
  ByteBudget budget(size_t{1} << 30);
  const auto answerWith = [&](size_t bytes) {
    const std::optional<RequestJob> job = server.requests().take({});
    server.answer(job->client, headOf(job->request.id), Bytes(bytes), budget.tryTake(bytes));
  };
  std::vector<BareSocket> slow;
  for (const size_t megabytes : {20, 40, 30}) {
    slow.push_back(greetedClient(server, 1, 4096));
    slow.back().send(requestMessage(requestOf(1)));
    answerWith(megabytes << 20);
  }
  EXPECT_EQ(budget.taken(), size_t{90} << 20);
  settle(*io_);
  server.makeRoom();
  settle(*io_);
  EXPECT_EQ(budget.taken(), size_t{90} << 20) << "they may still take it";
  time_.jump(Server::kLongestWait);
  server.makeRoom();
  EXPECT_TRUE(comesTrue([&] { return budget.taken() == size_t{50} << 20; })) << budget.taken();
  EXPECT_TRUE(slow[1].isEnded());
  EXPECT_TRUE(notes_.has("it reads too slowly")) << notes_.all();
  slow.clear();
  EXPECT_TRUE(comesTrue([&] { return budget.taken() == 0; })) << "given back with the connection";
}

/// In real time, and with as many sockets as that takes; in the clear and over TLS.
class StrangersInRealTime : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Over, StrangersInRealTime, testing::Bool(), [](const auto& over) { return over.param ? "Tls" : "Tcp"; });

TEST_P(StrangersInRealTime, AThousandSilentConnectionsAndAFloodHoldUpNobody) {
  rlimit files{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &files), 0);
  files.rlim_cur = files.rlim_max;
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &files), 0);
  if (files.rlim_max < 4096) GTEST_SKIP() << "this takes more descriptors than " << files.rlim_max;
  const auto io = std::make_shared<IoThread>();
  ServerSettings settings{.scene = someScene()};
  if (GetParam()) {
    settings.identity = makeIdentity();
    settings.token = Token::random();
  }
  Server server(io, settings);
  const Answering answering(server, 1000);
  std::vector<BareSocket> idle;
  for (int i = 0; i < 1000; ++i) idle.push_back(BareSocket::connect(server.port()));
  std::atomic<int> flooded = 0;
  std::vector<std::jthread> floods;
  for (int i = 0; i < 2; ++i)
    floods.emplace_back([&](const std::stop_token& stop) {
      std::deque<BareSocket> held;
      while (!stop.stop_requested()) {
        held.push_back(BareSocket::connect(server.port()));
        ++flooded;
        if (held.size() > 100) held.pop_front();
        std::this_thread::sleep_for(1ms);
      }
    });
  ASSERT_TRUE(comesTrue([&] { return flooded > 600; }));
  for (int i = 0; i < 10; ++i) {
    const TimePoint begin = now();
    Witness witness;
    Client client(io, {.address = server.address()}, witness);
    client.request(requestOf(1));
    ASSERT_TRUE(witness.frameOf(1));
    EXPECT_LT(secondsSince(begin), 2.0);
  }
}

}  // namespace
}  // namespace warpscope::net
