// Servers that lie to a client: about what they answer, how long it is, and how much of it there is.
// Mirrors "What a client promises" of net/README.md, as far as net/client.h keeps it; what frames mean is in
// ../wrong_answers_test.cpp.
#include "tests/net/adversarial_server.h"

namespace warpscope::net {
namespace {

constexpr size_t kMiB = size_t{1} << 20;
constexpr uint32_t kGiB = uint32_t{1} << 30;

FrameRequest someRequest() {
  FrameRequest request = requestOf(1);
  request.camera.width = request.camera.height = 64;
  request.settings = {{"step", "0.5"}, {"samplesPerRay", "1"}};
  request.codec = {1, 1, 95};
  return request;
}

class AttacksClient : public testing::Test {
 protected:
  /// What the client ends with for good when its request is answered with `bytes`, after a while of not coming back.
  std::string refusalOf(const std::function<Bytes(const FrameRequest&)>& answer) {
    BareListener listener;
    Witness witness;
    witness.judge = [](const FrameHead&, uint64_t payloadBytes) { return payloadBytes > 50'000 ? "too long" : ""; };
    Client client(io_, {.address = listener.address()}, witness);
    BareSocket socket = greetedServer(listener);
    client.request(someRequest());
    const std::optional<FrameRequest> request = nextRequest(socket);
    if (!request) return "no request came";
    socket.send(answer(*request));
    const std::string sentence = witness.sentenceWhen(ConnectionPhase::refused);
    EXPECT_TRUE(witness.look([&] { return witness.frames.empty() && witness.countOf(ConnectionPhase::waiting) == 0; }));
    clock_.advance(1h);
    EXPECT_FALSE(listener.accept(20ms).isOpen()) << "it came back";
    return sentence;
  }
  /// The same, for a head with a change, of which only the head is sent.
  std::string refusalOf(void (*change)(FrameHead&), size_t payloadBytes = 10) {
    return refusalOf([&](const FrameRequest& request) {
      FrameHead head = echoOf(request);
      change(head);
      return frameMessage(head, payloadBytes);
    });
  }

  VirtualClock clock_;
  const std::shared_ptr<IoThread> io_ = std::make_shared<IoThread>(clock_);
};

TEST_F(AttacksClient, AnswersToSomethingElseAreNotBelieved) {
  const std::string wrong = "the server answered something else than it was asked: ";
  EXPECT_EQ(refusalOf([](FrameHead& h) { h.id = 2; }), wrong + "nobody waits for frame 2");
  EXPECT_EQ(refusalOf([](FrameHead& h) { h.id = 0; }), wrong + "nobody waits for frame 0");
  EXPECT_EQ(refusalOf([](FrameHead& h) { h.wanted = Wanted::picture; }), wrong + "a picture where samples were wanted");
  EXPECT_EQ(refusalOf([](FrameHead& h) { h.camera.width = h.camera.height = 8192; }),
            wrong + "a size of 8192x8192 pixels, not 64x64");
  EXPECT_EQ(refusalOf([](FrameHead& h) { h.camera.height = 63; }), wrong + "a size of 64x63 pixels, not 64x64");
  EXPECT_EQ(refusalOf([](FrameHead& h) { h.camera.eye[2] = 1.0f; }), wrong + "another camera");
  EXPECT_EQ(refusalOf([](FrameHead& h) { h.camera.tanHalfFovY = 0.7f; }), wrong + "another camera");
  EXPECT_EQ(refusalOf([](FrameHead& h) { h.settings[1].value = "8"; }), wrong + "the setting samplesPerRay is not 1");
  EXPECT_EQ(refusalOf([](FrameHead& h) { h.settings.erase(h.settings.begin()); }),
            wrong + "the setting step is not 0.5");
  EXPECT_EQ(refusalOf([](FrameHead& h) { h.codec.format = 0; }), wrong + "another codec");
  EXPECT_EQ(refusalOf([](FrameHead& h) { h.codec.quality = 1; }), wrong + "another codec");
  EXPECT_EQ(refusalOf([](FrameHead&) {}, 50'001), wrong + "too long") << "whoever takes frames judges them";
  EXPECT_EQ(refusalOf([](const FrameRequest&) {
              return failureMessage({2, "sorry"});
            }),
            wrong + "nobody waits for frame 2");
}

TEST_F(AttacksClient, WhatWasNotAskedAboutMayBeAdded) {
  BareListener listener;
  Witness witness;
  Client client(io_, {.address = listener.address()}, witness);
  BareSocket socket = greetedServer(listener);
  client.request(someRequest());
  const std::optional<FrameRequest> request = nextRequest(socket);
  ASSERT_TRUE(request);
  FrameHead head = echoOf(*request);
  head.settings.insert(head.settings.begin(), {"heuristic", "gradient"});
  std::swap(head.settings[1], head.settings[2]);
  socket.send(frameMessage(head, 10) + Bytes(10));
  EXPECT_TRUE(witness.frameOf(1));
}

TEST_F(AttacksClient, AGibibyteOfZerosIsNotRead) {
  Witness witness;
  witness.judge = [](const FrameHead& head, uint64_t payloadBytes) {
    return payloadBytes > 100 * head.camera.width * head.camera.height ? "too long" : "";
  };
  size_t sent = 0;
  std::atomic<bool> hasEnded = false;
  const AdversarialServer server(someScene(), [&](BareSocket& to, const FrameRequest& request) {
    to.send(frameMessage(echoOf(request), kGiB - 1000));
    const Bytes zeros(kMiB);
    while (sent < kGiB && to.send(zeros)) sent += zeros.size();
    hasEnded = true;
    return false;
  });
  const PeakMemory peak;
  Client client(io_, {.address = server.address()}, witness);
  client.request(someRequest());
  EXPECT_THAT(witness.sentenceWhen(ConnectionPhase::refused), HasSubstr("too long"));
  ASSERT_TRUE(comesTrue([&] { return hasEnded.load(); }));
  EXPECT_LT(sent, 32 * kMiB) << "what the sockets hold";
  if (const auto grown = peak.grownBytes(); grown && !kIsSanitized) EXPECT_LT(*grown, 8 * kMiB);
  EXPECT_EQ(server.connections(), 1);
}

TEST_F(AttacksClient, HeadsThatLieAboutTheirLengthEndTheConnection) {
  const auto sentenceFor = [&](uint16_t length, uint32_t bodyBytes) {
    BareListener listener;
    Witness witness;
    Client client(io_, {.address = listener.address()}, witness);
    BareSocket socket = greetedServer(listener);
    client.request(someRequest());
    const std::optional<FrameRequest> request = nextRequest(socket);
    Bytes bytes = frameMessage(echoOf(*request), 0);
    for (size_t i = 0; i < 4; ++i) bytes[4 + i] = static_cast<std::byte>(bodyBytes >> 8 * i);
    for (size_t i = 0; i < 2; ++i) bytes[kMessageHeadBytes + i] = static_cast<std::byte>(length >> 8 * i);
    bytes.resize(bytes.size() + kMaxFrameHeadBytes);  // so that all of what it says is there
    socket.send(bytes);
    return witness.sentenceWhen(ConnectionPhase::waiting);
  };
  const auto honest = static_cast<uint16_t>(frameMessage(echoOf(someRequest()), 0).size() - kMessageHeadBytes);
  for (const int lie : {-1, 1, 100}) {
    const auto length = static_cast<uint16_t>(honest + lie);
    EXPECT_THAT(sentenceFor(length, 20'000), HasSubstr("sent a damaged frame")) << lie;
  }
  EXPECT_THAT(sentenceFor(0, 20'000), HasSubstr("sent a damaged frame"));
  EXPECT_THAT(sentenceFor(0xffff, 70'000), HasSubstr("sent a damaged frame"));
  EXPECT_THAT(sentenceFor(honest, honest - 1), HasSubstr("sent a damaged frame")) << "longer than its message";
}

TEST_F(AttacksClient, FloodsOfSmallMessagesAreReadAndForgotten) {
  constexpr size_t kMessages = 300'000;
  BareListener listener;
  Witness witness;
  Client client(io_, {.address = listener.address()}, witness);
  BareSocket socket = greetedServer(listener);
  client.request(someRequest());
  const std::optional<FrameRequest> request = nextRequest(socket);
  ASSERT_TRUE(request);
  Bytes flood;
  for (size_t i = 0; i < kMessages / 3; ++i)
    flood = std::move(flood) + beatMessage(MessageType::ping, i) + beatMessage(MessageType::pong, ~uint64_t{i}) +
            busyMessage(0);
  const PeakMemory peak;
  const std::jthread reader(
      [&] { socket.receive(kMessages * (kMessageHeadBytes + kBeatBytes), 2s); });  // as slowly as it likes
  ASSERT_TRUE(socket.send(flood + frameMessage(echoOf(*request), 10) + Bytes(10)));
  EXPECT_TRUE(witness.frameOf(1)) << "the frame behind them";
  EXPECT_TRUE(witness.look([&] { return witness.roundTrips.empty(); })) << "pongs for no ping measure nothing";
  if (const auto grown = peak.grownBytes(); grown && !kIsSanitized)
    EXPECT_LT(*grown, 16 * kMiB) << "of which the test has " << flood.size();
}

TEST_F(AttacksClient, ADripIsProgressAndCanBeLeft) {
  BareListener listener;
  Witness witness;
  const PassingTime time{clock_, io_};
  std::optional<Client> client(std::in_place, io_, ClientSettings{.address = listener.address()}, witness);
  BareSocket socket = greetedServer(listener, 1, 1000, 5000);
  client->request(someRequest());
  const std::optional<FrameRequest> request = nextRequest(socket);
  ASSERT_TRUE(request);
  socket.send(frameMessage(echoOf(*request), 50'000));
  const PeakMemory peak;
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(socket.send(Bytes(1)));
    ASSERT_TRUE(time.isAwaited(5000ms)) << "it has read of that";
    time.jump(900ms);
  }
  EXPECT_TRUE(witness.look([&] { return witness.isConnected() && witness.frames.empty(); }));
  if (const auto grown = peak.grownBytes(); grown && !kIsSanitized) EXPECT_LT(*grown, 4 * kMiB);
  const TimePoint before = clock_.now();
  time.passDuring([&] { client.reset(); });
  EXPECT_LT(clock_.now() - before, 5s) << "whoever leaves waits for nothing of it";
}

}  // namespace
}  // namespace warpscope::net
