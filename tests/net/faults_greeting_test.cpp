// Greetings that go wrong: other protocols, versions, tokens and certificates, pieces, slowness; and what each side is told.
// Mirrors net/reading.h, with net/client.h and net/server.h around it.
#include <random>

#include "tests/net/exchange.h"

namespace warpscope::net {
namespace {

/// What a client of a bare server that says `bytes` and ends is told.
std::string sentenceAfter(const Bytes& bytes, ConnectionPhase phase) {
  VirtualClock clock;
  const auto io = std::make_shared<IoThread>(clock);
  BareListener listener;
  Witness witness;
  Client client(io, {.address = listener.address()}, witness);
  BareSocket socket = listener.accept();
  EXPECT_EQ(socket.receive(kClientHelloBytes).size(), kClientHelloBytes);
  socket.send(bytes);
  socket.endWriting();
  return witness.sentenceWhen(phase);
}

Bytes bytesOf(std::string_view text) {
  const auto view = std::as_bytes(std::span(text));
  return {view.begin(), view.end()};
}

/// Whether it ends as time passes, whenever it was accepted.
bool endsInTime(BareSocket& socket, VirtualClock& clock) {
  for (int i = 0; i < 600; ++i, clock.advance(200ms))
    if (socket.isEnded(100ms)) return true;
  return false;
}

/// A little-endian number of 16 bits at `at`.
Bytes withNumber(Bytes bytes, size_t at, uint16_t value) {
  bytes[at] = static_cast<std::byte>(value & 0xff);
  bytes[at + 1] = static_cast<std::byte>(value >> 8);
  return bytes;
}

TEST(FaultsGreeting, AClientOfAnotherProtocolIsToldSo) {
  for (const char* words : {"HTTP/1.1 400 Bad Request\r\n\r\n", "SSH-2.0-OpenSSH_9.2", "x", "warpscap"})
    EXPECT_THAT(sentenceAfter(bytesOf(words), ConnectionPhase::refused), HasSubstr("does not speak warpscope's protocol")) << words;
}

TEST(FaultsGreeting, AClientOfAnotherVersionIsToldSo) {
  for (const uint16_t version : {uint16_t{0}, uint16_t{1}, uint16_t{kProtocolVersion + 1}, uint16_t{0xffff}}) {
    const Bytes hello = withNumber(toBytes(ServerHello{}), 8, version);
    const std::string wanted = "speaks version " + std::to_string(version) + " of the protocol, this program version " + std::to_string(kProtocolVersion);
    EXPECT_THAT(sentenceAfter(hello, ConnectionPhase::refused), HasSubstr(wanted));
    EXPECT_THAT(sentenceAfter({hello.begin(), hello.begin() + kHelloHeadBytes}, ConnectionPhase::refused), HasSubstr(wanted));
  }
}

Bytes helloOf(Verdict verdict) {
  ServerHello hello;
  hello.verdict = verdict;
  return toBytes(hello);
}

TEST(FaultsGreeting, EveryVerdictHasItsSentence) {
  EXPECT_THAT(sentenceAfter(helloOf(Verdict::otherVersion), ConnectionPhase::refused), HasSubstr("does not speak version " + std::to_string(kProtocolVersion)));
  EXPECT_THAT(sentenceAfter(helloOf(Verdict::wrongToken), ConnectionPhase::refused), HasSubstr("does not accept this token"));
  EXPECT_THAT(sentenceAfter(helloOf(Verdict::full), ConnectionPhase::waiting), HasSubstr("no room for another client"));
  Bytes unknown = helloOf(Verdict::full);
  unknown[kHelloHeadBytes] = std::byte{77};
  EXPECT_THAT(sentenceAfter(unknown, ConnectionPhase::refused), HasSubstr("greets in a way that this program does not understand"));
}

TEST(FaultsGreeting, AnEndInsteadOfAGreetingIsTold) {
  EXPECT_THAT(sentenceAfter({}, ConnectionPhase::waiting), HasSubstr("ended without a greeting"));
}

TEST(FaultsGreeting, PlainAndEncryptedDoNotMix) {
  VirtualClock clock;
  const auto io = std::make_shared<IoThread>(clock);
  Notes plainNotes, tlsNotes;
  Server plain(io, {.scene = someScene(), .onNote = plainNotes.callback()});
  Server tls(io, {.identity = makeIdentity(), .token = Token::random(), .scene = someScene(), .onNote = tlsNotes.callback()});
  {
    Address wrong = tls.address();
    wrong.where.port = plain.port();
    Witness witness;
    Client client(io, {.address = wrong}, witness);
    EXPECT_THAT(witness.sentenceWhen(ConnectionPhase::refused), HasSubstr("the peer does not speak TLS"));
    EXPECT_TRUE(plainNotes.has("speaks TLS, which was not expected")) << plainNotes.all();
  }
  Address wrong = plain.address();
  wrong.where.port = tls.port();
  Witness witness;
  Client client(io, {.address = wrong}, witness);
  EXPECT_THAT(witness.sentenceWhen(ConnectionPhase::refused), HasSubstr("speaks TLS, which was not expected"));
  EXPECT_TRUE(tlsNotes.has("the peer does not speak TLS")) << tlsNotes.all();
}

TEST(FaultsGreeting, AnotherCertificateIsRefused) {
  VirtualClock clock;
  const auto io = std::make_shared<IoThread>(clock);
  Server server(io, {.identity = makeIdentity(), .token = Token::random(), .scene = someScene()});
  Address wrong = server.address();
  wrong.credentials->fingerprint[5] ^= 1;
  Witness witness;
  Client client(io, {.address = wrong}, witness);
  EXPECT_THAT(witness.sentenceWhen(ConnectionPhase::refused), HasSubstr("is not the one that the address is for"));
}

TEST(FaultsGreeting, SentencesDiffer) {
  std::vector<std::string> sentences;
  for (const Verdict verdict : {Verdict::otherVersion, Verdict::wrongToken})
    sentences.push_back(sentenceAfter(helloOf(verdict), ConnectionPhase::refused));
  sentences.push_back(sentenceAfter(helloOf(Verdict::full), ConnectionPhase::waiting));
  sentences.push_back(sentenceAfter(withNumber(toBytes(ServerHello{}), 8, 2), ConnectionPhase::refused));
  sentences.push_back(sentenceAfter(bytesOf("HTTP/1.1 400"), ConnectionPhase::refused));
  sentences.push_back(sentenceAfter({}, ConnectionPhase::waiting));
  for (std::string& sentence : sentences) {  // each names the port, which differs
    ASSERT_FALSE(sentence.empty());
    EXPECT_THAT(sentence, HasSubstr("127.0.0.1:"));
    sentence.erase(0, sentence.find(' '));
  }
  std::ranges::sort(sentences);
  EXPECT_EQ(std::ranges::adjacent_find(sentences), sentences.end());
}

TEST(FaultsGreeting, TheServerSaysWhyItTurnsAway) {
  VirtualClock clock;
  const auto io = std::make_shared<IoThread>(clock);
  Notes notes;
  Server server(io, {.scene = someScene(), .onNote = notes.callback()});
  const auto answerTo = [&](const Bytes& bytes) {
    BareSocket socket = BareSocket::connect(server.port());
    socket.send(bytes);
    const std::optional<ServerHello> answer = readServerHello(socket.receive(kServerHelloBytes));
    EXPECT_TRUE(socket.receive(1, 5s).empty());
    return answer;
  };
  const std::optional<ServerHello> other = answerTo(withNumber(toBytes(ClientHello{}), 8, 7));
  ASSERT_TRUE(other);
  EXPECT_EQ(other->verdict, Verdict::otherVersion);
  EXPECT_EQ(other->version, kProtocolVersion);
  EXPECT_TRUE(notes.has("turned away: version 7 of the protocol")) << notes.all();
  Bytes shorter = withNumber(toBytes(ClientHello{}), 8, 7);
  shorter.resize(kHelloHeadBytes);
  const std::optional<ServerHello> answer = answerTo(shorter);
  EXPECT_TRUE(answer && answer->verdict == Verdict::otherVersion) << "other versions may greet in fewer bytes";
  const std::optional<ServerHello> http = answerTo(bytesOf("GET / HTTP/1.0\r\n\r\n"));
  ASSERT_TRUE(http);
  EXPECT_EQ(http->verdict, Verdict::otherVersion);
  EXPECT_TRUE(notes.has("does not speak warpscope's protocol")) << notes.all();
  EXPECT_FALSE(answerTo(withNumber(toBytes(ClientHello{}), 22, 0)));  // a depth of 0
  EXPECT_TRUE(notes.has("sent a damaged greeting")) << notes.all();
}

TEST(FaultsGreeting, CutAtAnyByteTheServerLosesNothing) {
  VirtualClock clock;
  const auto io = std::make_shared<IoThread>(clock);
  Server server(io, {.scene = someScene()});
  const size_t before = openFiles();
  const Bytes hello = toBytes(ClientHello{});
  for (size_t size = 0; size < hello.size(); ++size) {
    BareSocket ended = BareSocket::connect(server.port()), reset = BareSocket::connect(server.port());
    ASSERT_TRUE(ended.isOpen() && reset.isOpen());
    ended.send(ByteView(hello).first(size));
    reset.send(ByteView(hello).first(size));
    ended.endWriting();
    reset.reset();
    EXPECT_TRUE(ended.isEnded()) << size;
  }
  EXPECT_TRUE(comesTrue([&] { return openFiles() == before; }));
  EXPECT_TRUE(greetedClient(server).isOpen());
}

TEST(FaultsGreeting, SilenceAtAnyByteEndsAtTheDeadline) {
  VirtualClock clock;
  const auto io = std::make_shared<IoThread>(clock);
  Server server(io, {.scene = someScene(), .greetings = {64, 64}, .greetingPatience = 200ms});
  const Bytes hello = toBytes(ClientHello{});
  std::vector<BareSocket> sockets;
  for (size_t size = 0; size < hello.size(); ++size) {
    sockets.push_back(BareSocket::connect(server.port()));
    sockets.back().send(ByteView(hello).first(size));
  }
  for (BareSocket& socket : sockets) EXPECT_TRUE(endsInTime(socket, clock));
}

TEST(FaultsGreeting, SlownessEndsAtTheDeadlineOfTheWhole) {
  VirtualClock clock;
  const auto io = std::make_shared<IoThread>(clock);
  Server server(io, {.scene = someScene(), .greetingPatience = 300ms});
  BareSocket socket = BareSocket::connect(server.port());
  const PassingTime time(clock, io);
  ASSERT_TRUE(time.isAwaited(300ms));
  const Bytes hello = toBytes(ClientHello{});
  for (size_t sent = 0; sent < 14; ++sent) {
    ASSERT_TRUE(socket.send(ByteView(hello).subspan(sent, 1)));
    time.jump(20ms);
  }
  time.jump(19ms);
  EXPECT_TRUE(socket.send(ByteView(hello).subspan(14, 1)));
  EXPECT_FALSE(socket.isEnded(50ms));
  time.jump(1ms);
  EXPECT_TRUE(socket.isEnded()) << "progress byte by byte must not hold a place for ever";
}

TEST(FaultsGreeting, SlowServersAreGivenUp) {
  VirtualClock clock;
  const auto io = std::make_shared<IoThread>(clock);
  BareListener listener;
  Witness witness;
  Client client(io, {.address = listener.address(), .connectPatience = 300ms}, witness);
  BareSocket socket = listener.accept();
  ASSERT_EQ(socket.receive(kClientHelloBytes).size(), kClientHelloBytes);
  const PassingTime time(clock, io);
  ASSERT_TRUE(time.isAwaited(300ms));
  const Bytes hello = toBytes(ServerHello{});
  for (size_t i = 0; i < 19; ++i) {
    ASSERT_TRUE(socket.send(ByteView(hello).subspan(i, 1)));
    time.jump(15ms);
  }
  time.jump(14ms);
  EXPECT_EQ(witness.look([&] { return witness.countOf(ConnectionPhase::waiting); }), 0u);
  time.jump(1ms);
  EXPECT_THAT(witness.sentenceWhen(ConnectionPhase::waiting), HasSubstr("waiting for the greeting"));
}

TEST(FaultsGreeting, SilentTlsPeersAreGivenUpByBothSides) {
  VirtualClock clock;
  const auto io = std::make_shared<IoThread>(clock);
  Notes notes;
  Server server(io, {.identity = makeIdentity(), .token = Token::random(), .scene = someScene(), .greetingPatience = 200ms,
                     .onNote = notes.callback()});
  const PassingTime time(clock, io);
  BareSocket silent = BareSocket::connect(server.port());
  const std::byte begun{22};  // the type of a record of TLS: the rest does not come
  silent.send({&begun, 1});
  ASSERT_TRUE(time.jumpTo(200ms));
  EXPECT_TRUE(silent.isEnded());
  EXPECT_TRUE(notes.has("TLS handshake")) << notes.all();
  BareListener listener;
  Address address = server.address();
  address.where.port = listener.port();
  Witness witness;
  Client client(io, {.address = address, .connectPatience = 200ms}, witness);
  BareSocket accepted = listener.accept();
  ASSERT_EQ(accepted.receive(10).size(), 10u) << "it has begun";
  ASSERT_TRUE(time.jumpTo(200ms));
  EXPECT_THAT(witness.sentenceWhen(ConnectionPhase::waiting), HasSubstr("TLS handshake"));
}

TEST(FaultsGreeting, ByteByByteIsAsGoodAsAtOnce) {
  VirtualClock clock;
  const auto io = std::make_shared<IoThread>(clock);
  Server server(io, {.scene = someScene()});
  const Answering answering(server, 1000);
  BareSocket socket = BareSocket::connect(server.port());
  ASSERT_TRUE(socket.sendByteByByte(toBytes(ClientHello{}) + requestMessage(requestOf(3))));
  ASSERT_EQ(socket.receive(kServerHelloBytes).size(), kServerHelloBytes);
  const std::optional<Bytes> frame = socket.receiveBody(MessageType::frame);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->size(), kLeastFrameHeadBytes + 1000);
}

TEST(FaultsGreeting, TheServerByteByByteIsAsGoodAsAtOnce) {
  VirtualClock clock;
  const auto io = std::make_shared<IoThread>(clock);
  BareListener listener;
  Witness witness;
  Client client(io, {.address = listener.address()}, witness);
  BareSocket socket = listener.accept();
  ASSERT_EQ(socket.receive(kClientHelloBytes).size(), kClientHelloBytes);
  ASSERT_TRUE(socket.sendByteByByte(welcomeBytes()));
  ASSERT_TRUE(witness.waitForConnection());
  client.request(requestOf(9));
  ASSERT_TRUE(nextRequest(socket));
  ASSERT_TRUE(socket.sendByteByByte(wholeFrame(9, 500)));
  ASSERT_TRUE(witness.frameOf(9));
  EXPECT_EQ(witness.frameOf(9)->payload, Bytes(500, std::byte{9}));
}

TEST(FaultsGreeting, GluedMessagesAreTakenApart) {
  VirtualClock clock;
  const auto io = std::make_shared<IoThread>(clock);
  Server server(io, {.scene = someScene()});
  const Answering answering(server, 10);
  BareSocket socket = BareSocket::connect(server.port());
  ClientHello hello;
  hello.depth = 4;
  Bytes all = toBytes(hello);
  for (uint64_t id = 1; id <= 4; ++id) all = all + beatMessage(MessageType::pong, id) + requestMessage(requestOf(id));
  ASSERT_TRUE(socket.send(all + beatMessage(MessageType::ping, 77)));
  ASSERT_EQ(socket.receive(kServerHelloBytes).size(), kServerHelloBytes);
  size_t frames = 0;
  bool isAnswered = false;
  while (frames < 4 || !isAnswered) {
    const std::optional<BareSocket::Message> message = socket.receiveMessage();
    ASSERT_TRUE(message);
    frames += message->type == MessageType::frame;
    isAnswered |= message->type == MessageType::pong && readBeat(message->body) == 77;
  }
}

TEST(FaultsGreeting, GarbageIsTurnedAwayAndTheServerGoesOn) {
  VirtualClock clock;
  const auto io = std::make_shared<IoThread>(clock);
  Server server(io, {.scene = someScene()});
  std::mt19937 random(7);
  for (int round = 0; round < 50; ++round) {
    Bytes garbage(1 + random() % 5000);
    for (std::byte& byte : garbage) byte = static_cast<std::byte>(random());
    BareSocket socket = BareSocket::connect(server.port());
    socket.send(garbage);
    socket.endWriting();
    EXPECT_TRUE(socket.isEnded());
  }
  EXPECT_TRUE(greetedClient(server).isOpen());
}

TEST(FaultsGreeting, TokensAreInNoNoteAndNoSentence) {
  VirtualClock clock;
  const auto io = std::make_shared<IoThread>(clock);
  Notes notes;
  const Token right = Token::random(), wrong = Token::random();
  std::string told;
  {
    Server server(io, {.identity = makeIdentity(), .token = right, .scene = someScene(), .greetingPatience = 200ms,
                       .onNote = notes.callback()});
    const auto tryWith = [&](const Address& address, BareListener* silent = nullptr) {
      Witness witness;
      Client client(io, {.address = address, .connectPatience = 300ms}, witness);
      if (silent != nullptr) {
        const BareSocket socket = silent->accept();
        EXPECT_TRUE(PassingTime(clock, io).jumpTo(300ms));
      }
      EXPECT_TRUE(witness.waitFor([&] { return witness.states.size() > 1; }));
      const std::scoped_lock lock(witness.mutex);
      for (const ConnectionState& state : witness.states) told += state.sentence + "\n";
    };
    Address address = server.address();
    tryWith(address);
    address.credentials->token = wrong;
    tryWith(address);
    address.credentials->fingerprint[0] ^= 1;
    tryWith(address);
    BareListener silent;
    address.where.port = silent.port();
    tryWith(address, &silent);
    Server plain(io, {.scene = someScene(), .onNote = notes.callback()});
    address.where.port = plain.port();
    tryWith(address);
  }
  const std::string all = told + notes.all();
  EXPECT_THAT(all, HasSubstr("does not accept this token"));
  EXPECT_THAT(all, HasSubstr("a wrong token"));
  for (const Token& token : {right, wrong}) {
    std::string hex;
    for (const uint8_t byte : token.bytes()) {
      constexpr const char* kDigits = "0123456789abcdef";
      hex += kDigits[byte >> 4];
      hex += kDigits[byte & 15];
    }
    const std::string raw(token.bytes().begin(), token.bytes().end());
    // Parts of it would be bad enough.
    EXPECT_EQ(all.find(token.text().substr(0, 8)), std::string::npos);
    EXPECT_EQ(all.find(hex.substr(0, 8)), std::string::npos);
    EXPECT_EQ(all.find(raw.substr(0, 6)), std::string::npos);
  }
}

TEST(FaultsGreeting, SettingsThatCannotBeAreRefused) {
  VirtualClock clock;
  const auto io = std::make_shared<IoThread>(clock);
  const auto isRefused = [&](ServerSettings settings) {
    try {
      const Server server(io, std::move(settings));
    } catch (const std::invalid_argument&) {
      return true;
    }
    return false;
  };
  EXPECT_FALSE(isRefused({.scene = someScene()}));
  EXPECT_TRUE(isRefused({.listen = {"0.0.0.0", 0}, .scene = someScene()}));
  EXPECT_TRUE(isRefused({.listen = {"::", 0}, .scene = someScene()}));
  EXPECT_TRUE(isRefused({.identity = makeIdentity(), .scene = someScene()}));
  EXPECT_TRUE(isRefused({.token = Token::random(), .scene = someScene()}));
  EXPECT_TRUE(isRefused({})) << "no views";
  EXPECT_TRUE(isRefused({.scene = someScene(), .maxDepth = 0}));
  EXPECT_TRUE(isRefused({.scene = someScene(), .maxDepth = kMaxDepth + 1}));
  EXPECT_TRUE(isRefused({.scene = someScene(), .heartbeat = 0ms}));
  EXPECT_TRUE(isRefused({.scene = someScene(), .heartbeat = 100ms, .patience = 100ms}));
  EXPECT_TRUE(isRefused({.scene = someScene(), .patience = 2h}));
  EXPECT_TRUE(isRefused({.scene = someScene(), .heartbeat = 100ms, .patience = 999ms}));
}

}  // namespace
}  // namespace warpscope::net
