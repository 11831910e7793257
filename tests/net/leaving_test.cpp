// Clients that leave on purpose: their server reads a clean end, and does not take it for a broken connection.
// Mirrors Client::close() and Client::setDepth(). Clean ends: RFC 9293, section 3.6; of TLS: RFC 8446, section 6.1.
#include "tests/net/exchange.h"

namespace warpscope::net {
namespace {

/// Over TCP, and over TLS.
class Leaving : public testing::TestWithParam<bool> {
 protected:
  Leaving() {
    ServerSettings settings;
    settings.scene = someScene();
    settings.onNote = notes_.callback();
    if (GetParam()) {
      settings.identity = makeIdentity();
      settings.token = Token::random();
    }
    server_.emplace(io_, std::move(settings));
  }
  ClientSettings clientSettings() const {
    ClientSettings made;
    made.address = server_->address();
    return made;
  }
  /// How the server's note of a client's end goes on after "left"; nothing if there is none in time.
  std::optional<std::string> reason(int clients = 1) {
    const auto countOf = [this] {
      int count = 0;
      const std::string all = notes_.all();
      for (size_t at = all.find(" left"); at != std::string::npos; at = all.find(" left", at + 1)) ++count;
      return count;
    };
    if (!comesTrue([&] { return countOf() >= clients; })) return std::nullopt;
    const std::string all = notes_.all();
    const size_t begin = all.rfind(" left") + 5;
    return all.substr(begin, all.find('\n', begin) - begin);
  }

  // It stands still where a test does not move it: leaving takes a round trip, and no time besides.
  VirtualClock clock_;
  std::shared_ptr<IoThread> io_ = std::make_shared<IoThread>(clock_);
  Notes notes_;
  std::optional<Server> server_;
  Witness witness_;
};

TEST_P(Leaving, WithNothingUnderWay) {
  std::optional<Client> client(std::in_place, io_, clientSettings(), witness_);
  ASSERT_TRUE(witness_.waitForConnection());
  client.reset();
  EXPECT_EQ(reason(), "");
}

TEST_P(Leaving, WhileTheServerRenders) {
  std::optional<Client> client(std::in_place, io_, clientSettings(), witness_);
  client->request(requestOf(1));
  std::stop_source stop;
  const std::optional<RequestJob> job = server_->requests().take(stop.get_token());
  ASSERT_TRUE(job);  // and never answered
  client.reset();
  EXPECT_EQ(reason(), "");
  EXPECT_TRUE(comesTrue([&] { return job->hasLeft.stop_requested(); }));
}

TEST_P(Leaving, WhileFramesCome) {
  const Answering answering(*server_, 1 << 20);
  for (int round = 0; round < 20; ++round) {
    Witness witness;
    std::optional<Client> client(std::in_place, io_, clientSettings(), witness);
    ASSERT_TRUE(witness.waitForConnection());
    for (uint64_t id = 1; id <= 3; ++id) client->request(requestOf(id));
    std::this_thread::sleep_for(std::chrono::microseconds(300 * round));
    client.reset();
    ASSERT_EQ(reason(round + 1), "") << "round " << round;
  }
}

TEST_P(Leaving, BehindALinkThatTakesItsTime) {
  const Answering answering(*server_, 100'000);
  ClientSettings settings = clientSettings();
  settings.link = parseLinkSettings("delay=80,rate=20M");
  std::optional<Client> client(std::in_place, io_, settings, witness_);
  const PassingTime time(clock_, io_);
  ASSERT_TRUE(time.passUntil([&] { return witness_.look([&] { return witness_.isConnected(); }); }));
  client->request(requestOf(1));
  time.passDuring([&] { client.reset(); });
  EXPECT_EQ(reason(), "");
}

/// The thread of the sockets goes with the client: what it said last has left before.
TEST_P(Leaving, WithItsThread) {
  auto io = std::make_shared<IoThread>(clock_);
  std::optional<Client> client(std::in_place, io, clientSettings(), witness_);
  ASSERT_TRUE(witness_.waitForConnection());
  io.reset();
  client.reset();
  EXPECT_EQ(reason(), "");
}

TEST_P(Leaving, ForAnotherConnection) {
  const Answering answering(*server_, 1000);
  ClientSettings settings = clientSettings();
  settings.depth = 1;
  Client client(io_, settings, witness_);
  ASSERT_TRUE(witness_.waitForConnection());
  client.setDepth(4);
  EXPECT_EQ(reason(), "");
  client.request(requestOf(1));
  EXPECT_TRUE(witness_.frameOf(1));
}

INSTANTIATE_TEST_SUITE_P(Over, Leaving, testing::Values(false, true), [](const auto& info) { return info.param ? "tls" : "tcp"; });

/// Who ends without a word has not left on purpose.
TEST(LeavingServer, NotesAConnectionThatBreaks) {
  Notes notes;
  ServerSettings settings;
  settings.scene = someScene();
  settings.onNote = notes.callback();
  VirtualClock clock;
  const Server server(std::make_shared<IoThread>(clock), settings);
  BareSocket socket = greetedClient(server);
  socket.reset();
  EXPECT_TRUE(notes.has(" left: reading from 127.0.0.1")) << notes.all();
  EXPECT_TRUE(notes.has("Connection reset by peer")) << notes.all();
}

TEST(LeavingClient, EndsCleanlyInTheMiddleOfAFrame) {
  BareListener listener;
  Witness witness;
  ClientSettings settings;
  settings.address = listener.address();
  VirtualClock clock;
  std::optional<Client> client(std::in_place, std::make_shared<IoThread>(clock), settings, witness);
  BareSocket socket = greetedServer(listener);
  client->request(requestOf(1));
  ASSERT_TRUE(nextRequest(socket));
  const Bytes frame = wholeFrame(1, 100'000);
  socket.send(ByteView(frame).first(50'000));
  const std::jthread closing([&] { client.reset(); });
  EXPECT_EQ(socket.end(), BareSocket::End::clean);
  socket.close();
}

/// Neither reads nor ends: one second is all that it gets.
TEST(LeavingClient, DoesNotWaitForAServerThatHangs) {
  BareListener listener;
  Witness witness;
  ClientSettings settings;
  settings.address = listener.address();
  VirtualClock clock;
  const auto io = std::make_shared<IoThread>(clock);
  const PassingTime time(clock, io);
  std::optional<Client> client(std::in_place, io, settings, witness);
  const BareSocket socket = greetedServer(listener);
  ASSERT_TRUE(witness.waitForConnection());
  settle(*io);
  std::atomic<bool> hasClosed = false;
  std::jthread closing([&] {
    client.reset();
    hasClosed = true;
  });
  EXPECT_TRUE(time.isAwaited(2000ms));  // by who closes; a heartbeat, too, may be due after 1000 ms
  EXPECT_TRUE(time.isAwaited(1000ms));
  settle(*io);
  time.jump(999ms);
  EXPECT_FALSE(hasClosed);
  time.jump(1ms);
  closing.join();  // it ends
}

}  // namespace
}  // namespace warpscope::net
