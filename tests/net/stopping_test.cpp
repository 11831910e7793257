// Stopping servers and clients in the middle of everything: it takes no time, and leaves nothing.
// Mirrors Server::stop(), Client::close() and IoThread. The clock stands still: what waited for a deadline would wait for ever.
#include "tests/net/exchange.h"

namespace warpscope::net {
namespace {

class Stopping : public testing::Test {
 protected:
  ServerSettings settings() const {
    ServerSettings made;
    made.scene = someScene();
    made.greetingPatience = made.patience = 60s;
    made.heartbeat = 10s;
    return made;
  }
  ServerSettings withTls() const {
    ServerSettings made = settings();
    made.identity = makeIdentity();
    made.token = Token::random();
    return made;
  }
  ClientSettings clientOf(const Address& address) const {
    ClientSettings made;
    made.address = address;
    made.connectPatience = 60s;
    made.firstPause = made.longestPause = 60s;
    return made;
  }

  VirtualClock clock_;
  std::shared_ptr<IoThread> io_ = std::make_shared<IoThread>(clock_);
};

TEST_F(Stopping, AServerThatNobodyCalled) {
  std::optional<Server> server(std::in_place, io_, settings());
  server->stop();
  server->stop();
  server.reset();
}

TEST_F(Stopping, AServerDuringGreetings) {
  for (const bool isTls : {false, true}) {
    std::optional<Server> server(std::in_place, io_, isTls ? withTls() : settings());
    std::vector<BareSocket> sockets;
    const Bytes hello = toBytes(ClientHello{});
    for (size_t size = 0; size < 20; ++size) {
      sockets.push_back(BareSocket::connect(server->port()));
      sockets.back().send(ByteView(hello).first(size));
    }
    std::this_thread::sleep_for(20ms);
    server->stop();
    for (BareSocket& socket : sockets) EXPECT_TRUE(socket.isEnded());
  }
}

TEST_F(Stopping, AServerAsConnectionsCome) {
  for (int round = 0; round < 50; ++round) {
    Server server(io_, settings());
    std::vector<BareSocket> sockets;
    for (int i = 0; i < 3; ++i) sockets.push_back(BareSocket::connect(server.port()));  // perhaps not yet accepted
    server.stop();
  }
}

TEST_F(Stopping, AServerWhoseFarewellNobodyHears) {
  Server server(io_, settings());
  BareSocket socket = BareSocket::connect(server.port());
  socket.send(Bytes(100, std::byte{'x'}));  // turned away: it waits for our end now
  ASSERT_EQ(socket.receive(kServerHelloBytes).size(), kServerHelloBytes);
  server.stop();
}

TEST_F(Stopping, AServerDuringRenderingAndSending) {
  for (const bool isTls : {false, true}) {
    Server server(io_, isTls ? withTls() : settings());
    Witness witness;
    Client waiting(io_, clientOf(server.address()), witness);
    waiting.request(requestOf(1));
    std::stop_source stop;
    const std::optional<RequestJob> job = server.requests().take(stop.get_token());
    ASSERT_TRUE(job);  // it is never answered
    std::optional<BareSocket> slow;
    if (!isTls) {
      slow = greetedClient(server, 1, 4096);
      slow->send(requestMessage(requestOf(1)));
      const std::optional<RequestJob> large = server.requests().take(stop.get_token());
      server.answer(large->client, headOf(1), Bytes(64 << 20));
      ASSERT_EQ(slow->receive(1000).size(), 1000u);
    }
    server.stop();
    server.answer(job->client, headOf(1), Bytes(10));  // too late, and nothing happens
    EXPECT_EQ(server.requests().clientCount(), 0u);
  }
}

TEST_F(Stopping, AServerAndItsThread) {
  std::optional<Server> server(std::in_place, io_, settings());
  BareSocket socket = greetedClient(*server);
  server.reset();
  io_.reset();
}

TEST_F(Stopping, AClientBeforeItHasBegun) {
  Witness witness;
  for (int round = 0; round < 50; ++round) {
    BareListener listener;
    const Client client(io_, clientOf(listener.address()), witness);
  }
}

TEST_F(Stopping, AClientThatConnectsToWhereNobodyAnswers) {
  // With its queue full, a listener drops whoever comes, as an address does behind which there is nothing.
  BareListener listener(0);
  std::vector<Witness> witnesses(6);
  std::vector<std::unique_ptr<Client>> clients;
  for (Witness& witness : witnesses) clients.push_back(std::make_unique<Client>(io_, clientOf(listener.address()), witness));
  std::this_thread::sleep_for(50ms);
  for (Witness& witness : witnesses) EXPECT_FALSE(witness.look([&] { return witness.isConnected(); }));
  clients.clear();
  io_.reset();
}

TEST_F(Stopping, AClientDuringItsHandshake) {
  BareListener listener;
  for (const bool isTls : {false, true}) {
    Address address = listener.address();
    if (isTls) address.credentials = Credentials{{}, Token::random()};
    Witness witness;
    std::optional<Client> client(std::in_place, io_, clientOf(address), witness);
    BareSocket socket = listener.accept();
    ASSERT_EQ(socket.receive(10).size(), 10u);
    client.reset();
    EXPECT_TRUE(socket.isEnded(1s)) << "its connection goes with it";
  }
}

TEST_F(Stopping, AClientInTheMiddleOfAFrame) {
  BareListener listener;
  Witness witness;
  std::optional<Client> client(std::in_place, io_, clientOf(listener.address()), witness);
  BareSocket socket = greetedServer(listener);
  client->request(requestOf(1));
  ASSERT_TRUE(nextRequest(socket));
  const Bytes frame = wholeFrame(1, 10'000);
  socket.send(ByteView(frame).first(5000));
  settle(*io_);
  PassingTime(clock_, io_).passDuring([&] { client.reset(); });  // a farewell that nobody answers is the one thing that takes time
  EXPECT_TRUE(socket.isEnded());
  EXPECT_TRUE(witness.frames.empty());
}

TEST_F(Stopping, AClientBehindASlowLink) {
  Server server(io_, settings());
  const Answering answering(server, 1 << 20);
  Witness witness;
  ClientSettings slow = clientOf(server.address());
  slow.link = parseLinkSettings("delay=20,rate=2M");
  std::optional<Client> client(std::in_place, io_, slow, witness);
  const PassingTime time(clock_, io_);
  ASSERT_TRUE(time.passUntil([&] { return witness.look([&] { return witness.isConnected(); }); }));
  client->request(requestOf(1));
  time.pass(100ms);
  time.passDuring([&] { client.reset(); });
  server.stop();
}

TEST_F(Stopping, AClientThatWaitsToConnectAgain) {
  const uint16_t nobody = BareListener().port();
  Witness witness;
  std::optional<Client> client(std::in_place, io_, clientOf({{"127.0.0.1", nobody}, {}}), witness);
  ASSERT_TRUE(witness.waitFor([&] { return witness.isIn(ConnectionPhase::waiting); }));
  client->close();
  client->close();
  client->request(requestOf(1));
  client->setDepth(3);
  client->setLink({});
  client->connectNow();
  client.reset();
  io_.reset();
}

TEST_F(Stopping, NothingIsToldOnceClosed) {
  Server server(io_, settings());
  const Answering answering(server, 1000);
  for (int round = 0; round < 30; ++round) {
    Witness witness;
    Client client(io_, clientOf(server.address()), witness);
    for (uint64_t id = 1; id <= 20; ++id) client.request(requestOf(id));
    std::this_thread::sleep_for(std::chrono::microseconds(200 * round));
    client.close();
    const auto told = [&] {
      const std::scoped_lock lock(witness.mutex);
      return witness.states.size() + witness.frames.size() + witness.scenes.size() + witness.roundTrips.size();
    };
    const size_t before = told();
    std::this_thread::sleep_for(2ms);
    EXPECT_EQ(told(), before);
  }
}

TEST_F(Stopping, BothAtOnceInAnyOrder) {
  for (int round = 0; round < 40; ++round) {
    auto io = std::make_shared<IoThread>();
    auto server = std::make_unique<Server>(io, settings());
    const Address address = server->address();
    Witness witness;
    auto client = std::make_unique<Client>(io, clientOf(address), witness);
    client->request(requestOf(1));
    std::this_thread::sleep_for(std::chrono::microseconds(100 * round));
    {
      const std::jthread one([&] { server.reset(); }), other([&] { client.reset(); });
    }
    io.reset();
  }
}

}  // namespace
}  // namespace warpscope::net
