// Client and server together over loopback: greeting, requests, answers, and connecting again.
// Mirrors net/client.h and net/server.h.
#include "tests/net/exchange.h"

namespace warpscope::net {
namespace {

TEST(Exchange, ScenesRequestsAndFramesArrive) {
  const auto io = std::make_shared<IoThread>();
  Server server(io, {.scene = someScene()});
  const Answering answering(server, 200'000);
  Witness witness;
  Client client(io, {.address = server.address()}, witness);
  ASSERT_TRUE(witness.waitFor([&] { return witness.isConnected(); }));
  ASSERT_EQ(witness.scenes.size(), 1u);
  EXPECT_EQ(witness.scenes[0], someScene());
  for (uint64_t id = 1; id <= 5; ++id) {
    FrameRequest request;
    request.id = id;
    request.camera.width = 100 + static_cast<uint32_t>(id);
    client.request(request);
    ASSERT_TRUE(witness.waitFor([&] { return witness.frames.size() == id; }));
    EXPECT_EQ(witness.frames.back().head.id, id);
    EXPECT_EQ(witness.frames.back().head.camera.width, 100 + id);
    EXPECT_EQ(witness.frames.back().payload, Bytes(200'000, static_cast<std::byte>(id)));
  }
}

TEST(Exchange, TlsWithTheRightTokenWorksAndWithAWrongOneIsRefused) {
  const auto io = std::make_shared<IoThread>();
  Server server(io, {.identity = makeIdentity(), .token = Token::random(), .scene = someScene()});
  {
    Witness witness;
    Client client(io, {.address = server.address()}, witness);
    EXPECT_TRUE(witness.waitFor([&] { return witness.isConnected(); }));
  }
  Address other = server.address();
  other.credentials->token = Token::random();
  Witness witness;
  Client client(io, {.address = other}, witness);
  ASSERT_TRUE(witness.waitFor([&] { return witness.isRefused(); }));
  EXPECT_NE(witness.states.back().sentence.find("does not accept this token"), std::string::npos) << witness.states.back().sentence;
}

TEST(Exchange, AClientConnectsAgainAndAsksAgain) {
  const auto io = std::make_shared<IoThread>();
  auto server = std::make_unique<Server>(io, ServerSettings{.scene = someScene()});
  const Address address = server->address();
  Witness witness;
  Client client(io, {.address = address, .firstPause = 10ms, .longestPause = 50ms}, witness);
  ASSERT_TRUE(witness.waitFor([&] { return witness.isConnected(); }));
  FrameRequest request;
  request.id = 7;
  client.request(request);
  ASSERT_TRUE(comesTrue([&] { return server->requests().waitingCount(1) == 1; }));
  server.reset();
  ASSERT_TRUE(witness.waitFor([&] { return !witness.isConnected(); }));
  server = std::make_unique<Server>(io, ServerSettings{.listen = address.where, .scene = someScene()});
  const Answering answering(*server, 10);
  ASSERT_TRUE(witness.waitFor([&] { return witness.frames.size() == 1; }));
  EXPECT_EQ(witness.frames[0].head.id, 7u);
}

}  // namespace
}  // namespace warpscope::net
