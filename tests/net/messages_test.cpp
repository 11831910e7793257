// Messages as bytes: round trips, the layout pinned byte by byte, and whatever else than a message gives nothing.
// Mirrors net/messages.h. The expected bytes were packed by another program from the tables in net/README.md.
#include "net/messages.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "net/wire.h"

namespace warpscope::net {
namespace {

std::string hexOf(ByteView bytes) {
  std::string text;
  for (const std::byte byte : bytes)
    for (const int digit : {std::to_integer<int>(byte) >> 4, std::to_integer<int>(byte) & 15}) text += "0123456789abcdef"[digit];
  return text;
}

Token someToken() {
  std::array<uint8_t, Token::kBytes> bytes;
  for (size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<uint8_t>(0xa0 + i);
  return Token(bytes);
}

ClientHello someClientHello() { return {kProtocolVersion, 5, 0x12345678, 3, someToken()}; }
ServerHello someServerHello() { return {kProtocolVersion, Verdict::wrongToken, 5, 0x1122334455667788, 4, 2000, 10000}; }
CameraFields someCamera() { return {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {10, 11, 12}, 0.5f, 640, 480}; }
SettingFields someSettings() { return {{"step", "0.25"}, {"heuristic", "peak"}}; }
FrameRequest someRequest() { return {0x0102030405060708, Wanted::picture, someCamera(), someSettings(), {1, 2, 80}, 99}; }
FrameHead someFrameHead() {
  return {7, Wanted::samples, someCamera(), someSettings(), {1, 2, 80}, {-1, -2, -3, 1, 2, 3}, 0.75f, 3.0f, 0.25f, 2.0f, 1000, {1, 2, 3, 4, 5, 6}, 99,
          {{"layer", 0}, {"extent", 2}}};
}
ProcessFields someProcess() { return {{1, 2, 3}, {4, 5, 6}, 7, 8, 9.0, 10.0, 11, 0.5f, 2.0f, {12, 255}, {13}}; }
SceneFields someScene() {
  SceneFields scene;
  scene.name = "fish";
  scene.title = "A fish";
  scene.dims = {4, 5, 6};
  scene.spacing = {1.0, 0.5, 0.25};
  scene.origin = {-1.0, -2.0, -3.0};
  scene.direction = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  scene.hasOrientation = true;
  scene.up = {0, 0, 1};
  scene.front = {0, 1, 0};
  scene.fovYDeg = 45.0;
  scene.background = {0.1f, 0.2f, 0.3f};
  scene.views = {{10.0, 20.0, 1.5, 0.25, -0.25}, {}};
  scene.settings = someSettings();
  return scene;
}

/// As many and as long ones as there may be.
SettingFields mostSettings() {
  SettingFields settings;
  for (size_t i = 0; i < kMaxSettings; ++i) {
    std::string name = std::to_string(i);
    name.resize(kMaxSettingName, 'n');
    settings.push_back({name, std::string(kMaxSettingValue, 'v')});
  }
  return settings;
}
std::vector<PlaneFields> mostPlanes() {
  std::vector<PlaneFields> planes;
  for (size_t i = 0; i < kMaxPlanes; ++i) {
    std::string name = std::to_string(i);
    name.resize(kMaxPlaneName, 'p');
    planes.push_back({name, static_cast<uint8_t>(255 - i)});
  }
  return planes;
}

Bytes bodyOf(const Bytes& message) { return {message.begin() + kMessageHeadBytes, message.end()}; }

TEST(Messages, TheLayoutIsPinned) {
  EXPECT_EQ(hexOf(toBytes(someClientHello())),
      "7761727073636f700500050000007856341200000000030001a0a1a2a3a4a5a6a7a8a9aaabacadaeafb0b1b2b3b4b5b6b7");
  EXPECT_EQ(hexOf(toBytes(someServerHello())),
      "7761727073636f700500020500000088776655443322110400d007000010270000");
  EXPECT_EQ(hexOf(sceneMessage(someScene())),
      "01000000470100000400666973680600412066697368040000000500000006000000000000000000f03f000000000000e03f000000000000"
      "d03f000000000000f0bf00000000000000c000000000000008c0000000000000f03f00000000000000000000000000000000000000000000"
      "0000000000000000f03f000000000000000000000000000000000000000000000000000000000000f03f0100000000000000000000000000"
      "000000000000000000f03f0000000000000000000000000000f03f00000000000000000000000000804640cdcccc3dcdcc4c3e9a99993e02"
      "0400737465700400302e3235090068657572697374696304007065616b020000000000000024400000000000003440000000000000f83f00"
      "0000000000d03f000000000000d0bf00000000000000000000000000000000000000000000f03f00000000000000000000000000000000");
  EXPECT_EQ(hexOf(requestMessage(someRequest())),
      "020000006e0000000807060504030201010000803f0000004000004040000080400000a0400000c0400000e0400000004100001041000020"
      "4100003041000040410000003f80020000e0010000020400737465700400302e3235090068657572697374696304007065616b0102506300"
      "000000000000");
  EXPECT_EQ(hexOf(frameMessage(someFrameHead(), 1000)),
      "03000000ca040000e2000700000000000000000000803f0000004000004040000080400000a0400000c0400000e040000000410000104100"
      "00204100003041000040410000003f80020000e0010000020400737465700400302e3235090068657572697374696304007065616b010250"
      "000080bf000000c0000040c00000803f00000040000040400000403f000040400000803e00000040e803000000000000000000000000f03f0000000000000040"
      "000000000000084000000000000010400000000000001440000000000000184063000000000000000205006c61796572000600657874656e"
      "7402");
  EXPECT_EQ(hexOf(failureMessage({7, "sorry"})),
      "040000000f00000007000000000000000500736f727279");
  EXPECT_EQ(hexOf(beatMessage(MessageType::ping, 0x0807060504030201)), "05000000080000000102030405060708");
  EXPECT_EQ(hexOf(beatMessage(MessageType::pong, 1)), "06000000080000000100000000000000");
  EXPECT_EQ(hexOf(busyMessage(0x0201)), "07000000020000000102");
  EXPECT_EQ(hexOf(processesMessage(std::vector{someProcess()})),
      "08000000820000000100010000000200000003000000040000000500000006000000070000000800000000000000000022400000000000002440" "0b00000000000000"
      "0000003f000000400cff0000000000000000000000000000000000000000000000000000000000000d00000000000000000000000000000000000000000000000000000000000000");
}

TEST(Messages, TheSizesAreAsDeclared) {
  EXPECT_EQ(toBytes(ClientHello{}).size(), kClientHelloBytes);
  EXPECT_EQ(toBytes(someClientHello()).size(), kClientHelloBytes);
  EXPECT_EQ(toBytes(ServerHello{}).size(), kServerHelloBytes);
  EXPECT_EQ(requestMessage({}).size(), kMessageHeadBytes + kLeastRequestBytes);
  EXPECT_EQ(frameMessage({}, 0).size(), kMessageHeadBytes + kLeastFrameHeadBytes);
  FrameRequest request;
  request.settings = mostSettings();
  EXPECT_EQ(requestMessage(request).size(), kMessageHeadBytes + kMaxRequestBytes);
  FrameHead head;
  head.settings = mostSettings();
  head.planes = mostPlanes();
  EXPECT_EQ(frameMessage(head, 0).size(), kMessageHeadBytes + kMaxFrameHeadBytes);
  EXPECT_EQ(beatMessage(MessageType::ping, 0).size(), kMessageHeadBytes + kBeatBytes);
  EXPECT_EQ(busyMessage(0).size(), kMessageHeadBytes + kBusyBytes);
  EXPECT_EQ(processesMessage(std::vector<ProcessFields>(kMaxProcesses)).size(), kMessageHeadBytes + kMaxProcessesBytes);
  EXPECT_EQ(processesMessage(std::vector<ProcessFields>(kMaxProcesses + 1)).size(), kMessageHeadBytes + kMaxProcessesBytes) << "the first of them";
  SceneFields largest = someScene();
  largest.name = largest.title = std::string(2 * SceneFields::kMaxName, 'n');
  largest.views.resize(2 * kMaxViews);
  largest.settings = mostSettings();
  EXPECT_LE(bodyOf(sceneMessage(largest)).size(), kMaxSceneBytes);
  EXPECT_EQ(bodyOf(failureMessage({1, std::string(100'000, 's')})).size(), kMaxFailureBytes);
}

TEST(Messages, RoundTripsGiveTheSame) {
  const auto check = [](const auto& message, const Bytes& bytes, auto read) {
    const auto again = read(bytes);
    ASSERT_TRUE(again) << hexOf(bytes);
    EXPECT_TRUE(*again == message) << hexOf(bytes);
  };
  constexpr uint64_t kMost = std::numeric_limits<uint64_t>::max();
  constexpr float kMostF = std::numeric_limits<float>::max(), kLeastF = std::numeric_limits<float>::denorm_min();
  constexpr double kInfinite = std::numeric_limits<double>::infinity();

  check(someClientHello(), toBytes(someClientHello()), readClientHello);
  const ClientHello least{kProtocolVersion, 0, kLeastFrameHeadBytes, 1, {}};
  check(least, toBytes(least), readClientHello);
  const ClientHello most{kProtocolVersion, 0xffffffff, kMaxFrameBytes, kMaxDepth, someToken()};
  check(most, toBytes(most), readClientHello);

  check(someServerHello(), toBytes(someServerHello()), readServerHello);
  const ServerHello welcome{kProtocolVersion, Verdict::welcome, 0xffffffff, kMost, kMaxDepth, 1, 3600 * 1000};
  check(welcome, toBytes(welcome), readServerHello);

  check(someScene(), bodyOf(sceneMessage(someScene())), readScene);
  SceneFields scene = someScene();
  scene.name = std::string(SceneFields::kMaxName, '\xff');
  scene.title = "";
  scene.dims.fill(0xffffffff);
  scene.spacing = {kInfinite, -kInfinite, -0.0};
  scene.views.resize(kMaxViews);
  scene.hasOrientation = false;
  check(scene, bodyOf(sceneMessage(scene)), readScene);

  FrameRequest request = someRequest();
  check(request, bodyOf(requestMessage(request)), readRequest);
  request.id = request.sentAtNs = kMost;
  request.camera.width = request.camera.height = 0xffffffff;
  request.camera.eye = {kMostF, -kMostF, kLeastF};
  request.settings = mostSettings();
  request.codec = {255, 255, 255};
  check(request, bodyOf(requestMessage(request)), readRequest);
  request.settings = {{"a", ""}, {"b", std::string("\0\xff", 2)}};
  check(request, bodyOf(requestMessage(request)), readRequest);

  FrameHead head = someFrameHead();
  check(head, bodyOf(frameMessage(head, 10)), readFrameHead);
  head.id = head.sampleCount = head.requestSentAtNs = kMost;
  head.wanted = Wanted::picture;
  head.stages.sendMs = kInfinite;
  head.settings = mostSettings();
  head.planes = mostPlanes();
  check(head, bodyOf(frameMessage(head, 0)), readFrameHead);
  head.settings.clear();
  head.planes.clear();
  check(head, bodyOf(frameMessage(head, 0)), readFrameHead);

  check(Failure{kMost, std::string(kMaxFailureBytes - 10, '\0')}, bodyOf(failureMessage({kMost, std::string(kMaxFailureBytes - 10, '\0')})),
        readFailure);
  check(Failure{}, bodyOf(failureMessage({})), readFailure);
  check(kMost, bodyOf(beatMessage(MessageType::pong, kMost)), readBeat);
  check(uint16_t{0xfffe}, bodyOf(busyMessage(0xfffe)), readBusy);
  for (const size_t count : {size_t{0}, size_t{1}, kMaxProcesses})
    check(std::vector(count, someProcess()), bodyOf(processesMessage(std::vector(count, someProcess()))), readProcesses);
  for (const double ms : {-1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    ProcessFields process = someProcess();
    process.waitMs = ms;
    EXPECT_FALSE(readProcesses(bodyOf(processesMessage(std::vector{process})))) << ms;
    process = someProcess();
    process.slotMs = static_cast<float>(ms);
    EXPECT_FALSE(readProcesses(bodyOf(processesMessage(std::vector{process})))) << ms;
  }
}

TEST(Messages, NumbersThatAreNoneTravelAsTheyAre) {
  FrameRequest request;
  request.camera.tanHalfFovY = std::numeric_limits<float>::quiet_NaN();
  const std::optional<FrameRequest> again = readRequest(bodyOf(requestMessage(request)));
  ASSERT_TRUE(again);
  EXPECT_EQ(std::bit_cast<uint32_t>(again->camera.tanHalfFovY), std::bit_cast<uint32_t>(request.camera.tanHalfFovY));
}

/// Every kind of message, its bytes, and what bytes are as one, written again: none of those that are none.
struct Kind {
  const char* name;
  Bytes bytes;
  std::function<Bytes(ByteView)> again;
};

std::vector<Kind> kinds() {
  const auto again = [](auto read, auto write) {
    return [read, write](ByteView bytes) {
      const auto message = read(bytes);
      return message ? write(*message) : Bytes();
    };
  };
  const auto greeting = [](auto read) {
    return [read](ByteView bytes) {
      const auto hello = read(bytes);
      if (!hello) return Bytes();
      Bytes written = toBytes(*hello);
      if (hello->version == kProtocolVersion) return written;
      // Of another version nothing else is read.
      written.resize(kHelloHeadBytes);
      written.insert(written.end(), bytes.begin() + kHelloHeadBytes, bytes.end());
      return written;
    };
  };
  const auto written = [](const MessageHead& message) {
    Bytes bytes;
    append(bytes, message);
    return bytes;
  };
  const auto bodyBy = [](auto write) { return [write](const auto& message) { return bodyOf(write(message)); }; };
  const auto frame = [](const FrameHead& message) { return frameMessage(message, 1000); };
  const auto beat = [](uint64_t value) { return beatMessage(MessageType::ping, value); };
  const auto processes = [](const std::vector<ProcessFields>& message) { return processesMessage(message); };
  return {
      {"client hello", toBytes(someClientHello()), greeting(readClientHello)},
      {"server hello", toBytes(someServerHello()), greeting(readServerHello)},
      {"head", written({MessageType::frame, 0x01020304}), again(readMessageHead, written)},
      {"scene", bodyOf(sceneMessage(someScene())), again(readScene, bodyBy(sceneMessage))},
      {"request", bodyOf(requestMessage(someRequest())), again(readRequest, bodyBy(requestMessage))},
      {"frame", bodyOf(frameMessage(someFrameHead(), 1000)), again(readFrameHead, bodyBy(frame))},
      {"failure", bodyOf(failureMessage({7, "sorry"})), again(readFailure, bodyBy(failureMessage))},
      {"beat", bodyOf(beatMessage(MessageType::ping, 7)), again(readBeat, bodyBy(beat))},
      {"busy", bodyOf(busyMessage(3)), again(readBusy, bodyBy(busyMessage))},
      {"processes", bodyOf(processesMessage(std::vector(3, someProcess()))), again(readProcesses, bodyBy(processes))},
  };
}

TEST(Messages, TruncatedAtAnyByteTheyAreNothing) {
  for (const Kind& kind : kinds()) {
    ASSERT_EQ(kind.again(kind.bytes), kind.bytes) << kind.name;
    for (size_t size = 0; size < kind.bytes.size(); ++size) {
      const Bytes cut(kind.bytes.begin(), kind.bytes.begin() + static_cast<ptrdiff_t>(size));
      EXPECT_TRUE(kind.again(cut).empty()) << kind.name << " cut to " << size;
    }
  }
}

TEST(Messages, WithAByteTooManyTheyAreNothing) {
  for (Kind& kind : kinds()) {
    kind.bytes.push_back(std::byte{0});
    EXPECT_TRUE(kind.again(kind.bytes).empty()) << kind.name;
  }
}

TEST(Messages, WithAnyByteChangedTheyAreNothingOrAnotherMessage) {
  size_t refused = 0, kept = 0;
  for (const Kind& kind : kinds())
    for (size_t at = 0; at < kind.bytes.size(); ++at)
      for (int value = 0; value < 256; ++value) {
        Bytes changed = kind.bytes;
        changed[at] = static_cast<std::byte>(value);
        const Bytes again = kind.again(changed);
        (again.empty() ? refused : kept) += 1;
        if (!again.empty()) ASSERT_EQ(again, changed) << kind.name << " at " << at;
      }
  EXPECT_GT(refused, 0u);
  EXPECT_GT(kept, 0u);
}

TEST(Messages, GarbageIsNothingOrAMessage) {
  std::mt19937 random(1);
  const std::vector<Kind> all = kinds();
  for (int i = 0; i < 20'000; ++i) {
    Bytes bytes(random() % 600);
    for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
    for (const Kind& kind : all)
      if (const Bytes again = kind.again(bytes); !again.empty()) ASSERT_EQ(again, bytes) << kind.name;
  }
}

/// The bytes of `message` with `value` at `at`.
template <class Number>
Bytes with(Bytes message, size_t at, Number value) {
  Bytes bytes;
  WireWriter(bytes).number(value);
  std::ranges::copy(bytes, message.begin() + static_cast<ptrdiff_t>(at));
  return message;
}

TEST(Messages, GreetingsBeyondTheLimitsAreNothing) {
  const Bytes client = toBytes(someClientHello());
  EXPECT_TRUE(readClientHello(with(client, 22, kMaxDepth)));
  for (const uint16_t depth : {uint16_t{0}, uint16_t{kMaxDepth + 1}, uint16_t{0xffff}}) EXPECT_FALSE(readClientHello(with(client, 22, depth)));
  for (const uint64_t most : {uint64_t{0}, uint64_t{kLeastFrameHeadBytes - 1}, kMaxFrameBytes + 1, ~uint64_t{0}})
    EXPECT_FALSE(readClientHello(with(client, 14, most))) << most;
  EXPECT_FALSE(readClientHello(with(client, 24, uint8_t{2}))) << "a flag is 0 or 1";
  EXPECT_FALSE(readClientHello(with(client, 24, uint8_t{0}))) << "without a token its bytes are zeros";

  const Bytes server = toBytes(ServerHello{kProtocolVersion, Verdict::welcome, 0, 1, 1, 100, 1000});
  EXPECT_TRUE(readServerHello(server));
  EXPECT_FALSE(readServerHello(with(server, 10, uint8_t{4}))) << "verdict";
  EXPECT_FALSE(readServerHello(with(server, 23, uint16_t{0}))) << "depth";
  EXPECT_FALSE(readServerHello(with(server, 23, uint16_t{kMaxDepth + 1}))) << "depth";
  EXPECT_FALSE(readServerHello(with(server, 25, uint32_t{0}))) << "heartbeat";
  EXPECT_FALSE(readServerHello(with(server, 25, uint32_t{1001}))) << "a heartbeat longer than patience";
  EXPECT_FALSE(readServerHello(with(server, 29, uint32_t{999}))) << "patience";
  EXPECT_FALSE(readServerHello(with(server, 29, uint32_t{3'600'001}))) << "patience";
  EXPECT_FALSE(readServerHello(with(server, 29, uint32_t{0xffffffff}))) << "patience";
}

TEST(Messages, OtherVersionsAreReadNoFurther) {
  for (const uint16_t other : {uint16_t{1}, uint16_t{2}}) {
    const Bytes bytes = with(toBytes(someClientHello()), 8, other);
    ASSERT_TRUE(readClientHello(bytes));
    EXPECT_EQ(readClientHello(bytes)->version, other);
    EXPECT_FALSE(readClientHello(bytes)->token);
    EXPECT_EQ(readHelloVersion(ByteView(bytes).first(kHelloHeadBytes)), other);
  }
  const Bytes client = toBytes(someClientHello());
  const ByteView head = ByteView(client).first(kHelloHeadBytes);
  EXPECT_FALSE(readHelloVersion(with(client, 3, uint8_t{0})));
  for (size_t size = 0; size <= kHelloHeadBytes; ++size) EXPECT_TRUE(beginsLikeMagic(head.first(size))) << size;
  EXPECT_FALSE(beginsLikeMagic(ByteView(with(client, 0, uint8_t{'W'})).first(1)));
}

TEST(Messages, NamesThatComeTwiceAreNothing) {
  FrameRequest request = someRequest();
  request.settings = {{"step", "1"}, {"stop", "2"}};
  Bytes bytes = bodyOf(requestMessage(request));
  EXPECT_TRUE(readRequest(bytes));
  const size_t second = 8 + 1 + kCameraBytes + 1 + (2 + 4 + 2 + 1) + 2;
  bytes = with(bytes, second + 2, static_cast<uint8_t>('e'));
  EXPECT_FALSE(readRequest(bytes));
  FrameHead head = someFrameHead();
  head.planes = {{"a", 1}, {"b", 1}};
  bytes = bodyOf(frameMessage(head, 0));
  EXPECT_TRUE(readFrameHead(bytes));
  EXPECT_FALSE(readFrameHead(with(bytes, bytes.size() - 2, static_cast<uint8_t>('a'))));
}

TEST(Messages, WhatNoReaderWouldTakeIsNotWritten) {
  const auto refuses = [](const SettingFields& settings, const std::vector<PlaneFields>& planes) {
    FrameHead head;
    head.settings = settings;
    head.planes = planes;
    EXPECT_THROW(frameMessage(head, 0), std::invalid_argument);
    if (!planes.empty()) return;
    FrameRequest request;
    request.settings = settings;
    EXPECT_THROW(requestMessage(request), std::invalid_argument);
    SceneFields scene = someScene();
    scene.settings = settings;
    EXPECT_THROW(sceneMessage(scene), std::invalid_argument);
  };
  SettingFields settings = mostSettings();
  settings.push_back({"one too many", ""});
  refuses(settings, {});
  refuses({{"", "1"}}, {});
  refuses({{std::string(kMaxSettingName + 1, 'n'), "1"}}, {});
  refuses({{"step", std::string(kMaxSettingValue + 1, 'v')}}, {});
  refuses({{"step", "1"}, {"step", "2"}}, {});
  std::vector<PlaneFields> planes = mostPlanes();
  planes.push_back({"one too many", 0});
  refuses({}, planes);
  refuses({}, {{"", 0}});
  refuses({}, {{std::string(kMaxPlaneName + 1, 'p'), 0}});
  refuses({}, {{"layer", 0}, {"layer", 0}});
}

TEST(Messages, LengthsThatCannotBeAreNothing) {
  const Bytes scene = bodyOf(sceneMessage(someScene()));
  for (const uint16_t length : {uint16_t{3}, uint16_t{5}, uint16_t{1024}, uint16_t{1025}, uint16_t{0xffff}})
    EXPECT_FALSE(readScene(with(scene, 0, length))) << length;
  const size_t views = scene.size() - 2 * 40 - 2;
  for (const uint16_t count : {uint16_t{0}, uint16_t{1}, uint16_t{3}, uint16_t{256}, uint16_t{257}, uint16_t{0xffff}})
    EXPECT_FALSE(readScene(with(scene, views, count))) << count;
  const Bytes failure = bodyOf(failureMessage({7, "sorry"}));
  for (const uint16_t length : {uint16_t{0}, uint16_t{4}, uint16_t{6}, uint16_t{0xffff}}) EXPECT_FALSE(readFailure(with(failure, 8, length)));

  // Of settings and planes: how many, and how long.
  const Bytes request = bodyOf(requestMessage(someRequest()));
  const size_t settings = 8 + 1 + kCameraBytes;
  for (const uint8_t count : {0, 1, 3, 64, 65, 255}) EXPECT_FALSE(readRequest(with(request, settings, count))) << int{count};
  for (const uint16_t length : {uint16_t{0}, uint16_t{3}, uint16_t{5}, uint16_t{kMaxSettingName + 1}, uint16_t{0xffff}}) {
    EXPECT_FALSE(readRequest(with(request, settings + 1, length))) << length;
    EXPECT_FALSE(readRequest(with(request, settings + 7, length))) << length;
  }
  const Bytes frame = bodyOf(frameMessage(someFrameHead(), 0));
  const size_t planes = frame.size() - 1 - (2 + 5 + 1) - (2 + 6 + 1);
  EXPECT_TRUE(readFrameHead(with(frame, planes, uint8_t{2})));
  for (const uint8_t count : {0, 1, 3, 16, 17, 255}) EXPECT_FALSE(readFrameHead(with(frame, planes, count))) << int{count};
  for (const uint16_t length : {uint16_t{0}, uint16_t{4}, uint16_t{6}, uint16_t{kMaxPlaneName + 1}, uint16_t{0xffff}})
    EXPECT_FALSE(readFrameHead(with(frame, planes + 1, length))) << length;
  // A frame's head says its length.
  EXPECT_EQ(readFrameHeadLength(ByteView(frame).first(kFrameHeadLengthBytes)), frame.size());
  for (const int change : {-1, 1}) EXPECT_FALSE(readFrameHead(with(frame, 0, static_cast<uint16_t>(static_cast<int>(frame.size()) + change))));
  const auto lengthOf = [&](size_t length) { return readFrameHeadLength(ByteView(with(frame, 0, static_cast<uint16_t>(length))).first(kFrameHeadLengthBytes)); };
  EXPECT_EQ(lengthOf(kLeastFrameHeadBytes), kLeastFrameHeadBytes);
  EXPECT_EQ(lengthOf(kMaxFrameHeadBytes), kMaxFrameHeadBytes);
  for (const size_t length : {size_t{0}, kLeastFrameHeadBytes - 1, kMaxFrameHeadBytes + 1, size_t{0xffff}}) EXPECT_FALSE(lengthOf(length)) << length;
  EXPECT_FALSE(readFrameHeadLength(ByteView(frame).first(1)));

  Bytes head;
  append(head, {MessageType::frame, 0xffffffff});
  ASSERT_TRUE(readMessageHead(head));  // a length alone is no fault: whoever reads the body says what is too much
  EXPECT_EQ(readMessageHead(head)->bodyBytes, 0xffffffffu);
  for (const uint8_t type : {uint8_t{0}, uint8_t{9}, uint8_t{255}}) EXPECT_FALSE(readMessageHead(with(head, 0, type)));
  for (const size_t zero : {1, 2, 3}) EXPECT_FALSE(readMessageHead(with(head, zero, uint8_t{1})));
}

}  // namespace
}  // namespace warpscope::net
