// One list of fields for writing and reading each message.
// See messages.h.
#include "net/messages.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "net/wire.h"

namespace warpscope::net {
namespace {

// The fields of each message in their order, for a writer and const values as for a reader and others.

template <class Wire>
void flag(Wire& wire, const bool& value)
  requires std::same_as<Wire, WireWriter>
{
  wire.number(static_cast<uint8_t>(value));
}
void flag(WireReader& wire, bool& value) {
  uint8_t number;
  wire.number(number);
  if (number > 1) wire.fail();
  value = number == 1;
}

/// Enumerations from 0 to `last`.
template <class Enum>
void choice(WireWriter& wire, const Enum& value, Enum) {
  wire.number(static_cast<uint8_t>(value));
}
template <class Enum>
void choice(WireReader& wire, Enum& value, Enum last) {
  uint8_t number;
  wire.number(number);
  if (number > static_cast<uint8_t>(last)) wire.fail();
  value = static_cast<Enum>(number);
}

template <class Wire, class Camera>
void cameraFields(Wire& wire, Camera& camera) {
  wire.numbers(camera.eye);
  wire.numbers(camera.right);
  wire.numbers(camera.up);
  wire.numbers(camera.forward);
  wire.number(camera.tanHalfFovY);
  wire.number(camera.width);
  wire.number(camera.height);
}

/// Whether `items` have names of 1 to `longest` bytes, no two the same.
template <class Items>
bool haveNames(const Items& items, size_t longest) {
  for (auto item = items.begin(); item != items.end(); ++item) {
    if (item->name.empty() || item->name.size() > longest) return false;
    if (std::any_of(items.begin(), item, [&](const auto& other) { return other.name == item->name; })) return false;
  }
  return true;
}

/// A list of at most `most` named items: their number, and what `fields` writes or reads of each.
template <class Item, class Fields>
void namedList(WireWriter& wire, const std::vector<Item>& items, size_t most, size_t longest, const char* what, Fields fields) {
  if (items.size() > most || !haveNames(items, longest))
    throw std::invalid_argument("there must be at most " + std::to_string(most) + " " + what + ", each with a name of its own of 1 to " +
                                std::to_string(longest) + " bytes");
  wire.number(static_cast<uint8_t>(items.size()));
  for (const Item& item : items) fields(wire, item);
}
template <class Item, class Fields>
void namedList(WireReader& wire, std::vector<Item>& items, size_t most, size_t longest, const char*, Fields fields) {
  uint8_t count;
  wire.number(count);
  if (count > most) wire.fail();
  items.clear();
  for (uint8_t i = 0; i < count && !wire.hasFailed(); ++i) fields(wire, items.emplace_back());
  if (!haveNames(items, longest)) wire.fail();
}

void shortText(WireWriter& wire, const std::string& text, size_t longest) {
  if (text.size() > longest) throw std::invalid_argument("\"" + text + "\" is longer than " + std::to_string(longest) + " bytes");
  wire.text(text);
}
void shortText(WireReader& wire, std::string& text, size_t longest) { wire.text(text, longest); }

template <class Wire, class Settings>
void settingFields(Wire& wire, Settings& settings) {
  namedList(wire, settings, kMaxSettings, kMaxSettingName, "settings", [](Wire& to, auto& setting) {
    shortText(to, setting.name, kMaxSettingName);
    shortText(to, setting.value, kMaxSettingValue);
  });
}

template <class Wire, class Planes>
void planeFields(Wire& wire, Planes& planes) {
  namedList(wire, planes, kMaxPlanes, kMaxPlaneName, "planes", [](Wire& to, auto& plane) {
    shortText(to, plane.name, kMaxPlaneName);
    to.number(plane.element);
  });
}

template <class Wire, class Codec>
void codecFields(Wire& wire, Codec& codec) {
  wire.number(codec.format);
  wire.number(codec.color);
  wire.number(codec.quality);
}

/// What a request asks for, and its answer repeats.
template <class Wire, class Message>
void askedFields(Wire& wire, Message& message) {
  wire.number(message.id);
  choice(wire, message.wanted, Wanted::picture);
  cameraFields(wire, message.camera);
  settingFields(wire, message.settings);
  codecFields(wire, message.codec);
}

template <class Wire, class Request>
void requestFields(Wire& wire, Request& request) {
  askedFields(wire, request);
  wire.number(request.sentAtNs);
}

template <class Wire, class Head>
void frameFields(Wire& wire, Head& head) {
  askedFields(wire, head);
  wire.numbers(head.bounds);
  wire.number(head.radiusUnit);
  wire.number(head.nearDepth);
  wire.number(head.depthStep);
  wire.number(head.voxelRadius);
  wire.number(head.sampleCount);
  auto& stages = head.stages;
  for (auto* stage : {&stages.queueMs, &stages.marchMs, &stages.compactMs, &stages.copyMs, &stages.encodeMs, &stages.sendMs})
    wire.number(*stage);
  wire.number(head.requestSentAtNs);
  planeFields(wire, head.planes);
}

template <class Wire, class Scene>
void sceneNumbers(Wire& wire, Scene& scene) {
  wire.numbers(scene.dims);
  wire.numbers(scene.spacing);
  wire.numbers(scene.origin);
  wire.numbers(scene.direction);
  flag(wire, scene.hasOrientation);
  wire.numbers(scene.up);
  wire.numbers(scene.front);
  wire.number(scene.fovYDeg);
  wire.numbers(scene.background);
  settingFields(wire, scene.settings);
}

template <class Wire, class View>
void viewFields(Wire& wire, View& view) {
  for (auto* number : {&view.angleDeg, &view.elevationDeg, &view.distance, &view.panRight, &view.panUp}) wire.number(*number);
}

template <class Wire, class Process>
void processFields(Wire& wire, Process& process) {
  wire.numbers(process.lower);
  wire.numbers(process.upper);
  wire.number(process.tiles);
  wire.number(process.deviceTiles);
  wire.number(process.marchMs);
  wire.number(process.waitMs);
  wire.number(process.sentBytes);
  wire.number(process.slotMs);
  wire.number(process.mostThreads);
  wire.numbers(process.marching);
  wire.numbers(process.waiting);
}

void magic(WireWriter& wire) { wire.numbers(kMagic); }
void magic(WireReader& wire) {
  std::array<uint8_t, kMagic.size()> read;
  wire.numbers(read);
  if (read != kMagic) wire.fail();
}

/// A message whose body is written by `body`.
template <class Body>
Bytes messageOf(MessageType type, size_t bytesBehind, Body&& body) {
  Bytes inner;
  WireWriter wire(inner);
  body(wire);
  Bytes out;
  append(out, {type, static_cast<uint32_t>(inner.size() + bytesBehind)});
  out.insert(out.end(), inner.begin(), inner.end());
  return out;
}

template <class Message>
std::optional<Message> ifComplete(const WireReader& wire, Message message) {
  if (!wire.isComplete()) return std::nullopt;
  return message;
}

}  // namespace

Bytes toBytes(const ClientHello& hello) {
  Bytes out;
  WireWriter wire(out);
  magic(wire);
  wire.number(hello.version);
  wire.number(hello.capabilities);
  wire.number(hello.maxFrameBytes);
  wire.number(hello.depth);
  flag(wire, hello.token.has_value());
  std::array<uint8_t, Token::kBytes> secret{};
  if (hello.token) std::copy_n(hello.token->bytes().begin(), secret.size(), secret.begin());
  wire.numbers(secret);
  return out;
}

Bytes toBytes(const ServerHello& hello) {
  Bytes out;
  WireWriter wire(out);
  magic(wire);
  wire.number(hello.version);
  choice(wire, hello.verdict, Verdict::full);
  wire.number(hello.capabilities);
  wire.number(hello.sessionId);
  wire.number(hello.depth);
  wire.number(hello.heartbeatMs);
  wire.number(hello.patienceMs);
  return out;
}

void append(Bytes& out, const MessageHead& head) {
  WireWriter wire(out);
  wire.number(static_cast<uint8_t>(head.type));
  wire.numbers(std::array<uint8_t, 3>{});
  wire.number(head.bodyBytes);
}

Bytes sceneMessage(const SceneFields& scene) {
  return messageOf(MessageType::scene, 0, [&](WireWriter& wire) {
    wire.text(std::string_view(scene.name).substr(0, SceneFields::kMaxName));
    wire.text(std::string_view(scene.title).substr(0, SceneFields::kMaxName));
    sceneNumbers(wire, scene);
    const size_t count = std::min(scene.views.size(), kMaxViews);
    wire.number(static_cast<uint16_t>(count));
    for (size_t i = 0; i < count; ++i) viewFields(wire, scene.views[i]);
  });
}

Bytes requestMessage(const FrameRequest& request) {
  return messageOf(MessageType::request, 0, [&](WireWriter& wire) { requestFields(wire, request); });
}

Bytes frameMessage(const FrameHead& head, size_t payloadBytes) {
  Bytes fields;
  WireWriter fieldsWire(fields);
  frameFields(fieldsWire, head);
  return messageOf(MessageType::frame, payloadBytes, [&](WireWriter& wire) {
    wire.number(static_cast<uint16_t>(kFrameHeadLengthBytes + fields.size()));
    wire.bytes(fields);
  });
}

Bytes failureMessage(const Failure& failure) {
  return messageOf(MessageType::failure, 0, [&](WireWriter& wire) {
    wire.number(failure.id);
    wire.text(std::string_view(failure.sentence).substr(0, kMaxFailureBytes - 10));
  });
}

Bytes beatMessage(MessageType pingOrPong, uint64_t number) {
  return messageOf(pingOrPong, 0, [&](WireWriter& wire) { wire.number(number); });
}

Bytes busyMessage(uint16_t others) {
  return messageOf(MessageType::busy, 0, [&](WireWriter& wire) { wire.number(others); });
}

Bytes processesMessage(std::span<const ProcessFields> processes) {
  return messageOf(MessageType::processes, 0, [&](WireWriter& wire) {
    const size_t count = std::min(processes.size(), kMaxProcesses);
    wire.number(static_cast<uint16_t>(count));
    for (const ProcessFields& process : processes.first(count)) processFields(wire, process);
  });
}

bool beginsLikeMagic(ByteView bytes) {
  const size_t count = std::min(bytes.size(), kMagic.size());
  return std::ranges::equal(bytes.first(count), std::as_bytes(std::span(kMagic)).first(count));
}

std::optional<uint16_t> readHelloVersion(ByteView bytes) {
  WireReader wire(bytes);
  magic(wire);
  uint16_t version;
  wire.number(version);
  return ifComplete(wire, version);
}

std::optional<ClientHello> readClientHello(ByteView bytes) {
  WireReader wire(bytes);
  ClientHello hello;
  magic(wire);
  wire.number(hello.version);
  if (!wire.hasFailed() && hello.version != kProtocolVersion) return hello;
  wire.number(hello.capabilities);
  wire.number(hello.maxFrameBytes);
  wire.number(hello.depth);
  bool hasToken;
  flag(wire, hasToken);
  std::array<uint8_t, Token::kBytes> secret;
  wire.numbers(secret);
  if (hasToken)
    hello.token = Token(secret);
  else if (secret != std::array<uint8_t, Token::kBytes>{})
    return std::nullopt;
  if (hello.depth < 1 || hello.depth > kMaxDepth) return std::nullopt;
  if (hello.maxFrameBytes < kLeastFrameHeadBytes || hello.maxFrameBytes > kMaxFrameBytes) return std::nullopt;
  return ifComplete(wire, hello);
}

std::optional<ServerHello> readServerHello(ByteView bytes) {
  WireReader wire(bytes);
  ServerHello hello;
  magic(wire);
  wire.number(hello.version);
  if (!wire.hasFailed() && hello.version != kProtocolVersion) {
    hello.verdict = Verdict::otherVersion;
    return hello;
  }
  choice(wire, hello.verdict, Verdict::full);
  wire.number(hello.capabilities);
  wire.number(hello.sessionId);
  wire.number(hello.depth);
  wire.number(hello.heartbeatMs);
  wire.number(hello.patienceMs);
  constexpr uint32_t kLongestMs = 3600 * 1000;
  const bool isWelcome = hello.verdict == Verdict::welcome;
  if (isWelcome && (hello.depth < 1 || hello.depth > kMaxDepth)) return std::nullopt;
  if (isWelcome && (hello.heartbeatMs < 1 || hello.heartbeatMs > kLongestMs || hello.patienceMs < hello.heartbeatMs ||
                    hello.patienceMs < kLeastPatienceMs || hello.patienceMs > kLongestMs))
    return std::nullopt;
  return ifComplete(wire, hello);
}

std::optional<MessageHead> readMessageHead(ByteView bytes) {
  WireReader wire(bytes);
  uint8_t type;
  std::array<uint8_t, 3> zeros;
  MessageHead head;
  wire.number(type);
  wire.numbers(zeros);
  wire.number(head.bodyBytes);
  if (type < static_cast<uint8_t>(MessageType::scene) || type > static_cast<uint8_t>(MessageType::processes))
    return std::nullopt;
  if (zeros != std::array<uint8_t, 3>{}) return std::nullopt;
  head.type = static_cast<MessageType>(type);
  return ifComplete(wire, head);
}

std::optional<SceneFields> readScene(ByteView body) {
  WireReader wire(body);
  SceneFields scene;
  wire.text(scene.name, SceneFields::kMaxName);
  wire.text(scene.title, SceneFields::kMaxName);
  sceneNumbers(wire, scene);
  uint16_t count;
  wire.number(count);
  if (count < 1 || count > kMaxViews) return std::nullopt;
  scene.views.resize(count);
  for (ViewFields& view : scene.views) viewFields(wire, view);
  return ifComplete(wire, std::move(scene));
}

std::optional<FrameRequest> readRequest(ByteView body) {
  WireReader wire(body);
  FrameRequest request;
  requestFields(wire, request);
  return ifComplete(wire, request);
}

std::optional<size_t> readFrameHeadLength(ByteView bytes) {
  WireReader wire(bytes);
  uint16_t length;
  wire.number(length);
  if (length < kLeastFrameHeadBytes || length > kMaxFrameHeadBytes) return std::nullopt;
  return ifComplete(wire, size_t{length});
}

std::optional<FrameHead> readFrameHead(ByteView bytes) {
  WireReader wire(bytes);
  uint16_t length;
  wire.number(length);
  if (length != bytes.size()) return std::nullopt;
  FrameHead head;
  frameFields(wire, head);
  return ifComplete(wire, head);
}

std::optional<Failure> readFailure(ByteView body) {
  WireReader wire(body);
  Failure failure;
  wire.number(failure.id);
  wire.text(failure.sentence, kMaxFailureBytes - 10);
  return ifComplete(wire, std::move(failure));
}

std::optional<uint64_t> readBeat(ByteView body) {
  WireReader wire(body);
  uint64_t number;
  wire.number(number);
  return ifComplete(wire, number);
}

std::optional<uint16_t> readBusy(ByteView body) {
  WireReader wire(body);
  uint16_t others;
  wire.number(others);
  return ifComplete(wire, others);
}

std::optional<std::vector<ProcessFields>> readProcesses(ByteView body) {
  WireReader wire(body);
  uint16_t count;
  wire.number(count);
  if (count > kMaxProcesses || body.size() != 2 + count * kProcessBytes) return std::nullopt;
  std::vector<ProcessFields> processes(count);
  for (ProcessFields& process : processes) processFields(wire, process);
  const auto isTime = [](double ms) { return ms >= 0.0 && ms < std::numeric_limits<double>::infinity(); };
  if (!std::ranges::all_of(processes, [&](const ProcessFields& one) { return isTime(one.marchMs) && isTime(one.waitMs) && isTime(one.slotMs) && isTime(one.mostThreads); })) return std::nullopt;
  return ifComplete(wire, std::move(processes));
}

}  // namespace warpscope::net
