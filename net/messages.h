// The protocol: every message, what is in it, and how large it may be. README.md beside this is the same in prose.
// Little-endian fields, written and read one by one (wire.h). What the numbers of cameras and settings mean is the program's business: here
// they are carried, not understood.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "net/token.h"

namespace warpscope::net {

/// The first bytes of both sides.
inline constexpr std::array<uint8_t, 8> kMagic{'w', 'a', 'r', 'p', 's', 'c', 'o', 'p'};
/// Sides of different versions do not talk to each other.
inline constexpr uint16_t kProtocolVersion = 5;

/// What a side can do beyond the least; what both can is used.
enum Capability : uint32_t {
  kCanPack = 1u << 0,      ///< frames in the format `packed`
  kCanJpeg = 1u << 1,      ///< colours as JPEG
  kCanPicture = 1u << 2,   ///< pictures at full precision, besides samples
  kCanLayers = 1u << 3,    ///< several samples a ray
  kCanPlanes = 1u << 4,    ///< planes of data for each sample, of which those that are not known are skipped
  kCanHearBusy = 1u << 5,  ///< of others that the server works for meanwhile: a message that is sent to no other client
  kCanHearProcesses = 1u << 6,  ///< that a volume is spread over, likewise
};
inline constexpr uint32_t kCapabilities = kCanPack | kCanJpeg | kCanPicture | kCanLayers | kCanPlanes | kCanHearBusy | kCanHearProcesses;

// --- Limits. A length beyond them ends the connection before anything is allocated.

inline constexpr size_t kHelloHeadBytes = 8 + 2;  ///< of a greeting in every version: the first bytes, and the version
inline constexpr size_t kClientHelloBytes = 8 + 2 + 4 + 8 + 2 + 1 + Token::kBytes;
inline constexpr size_t kServerHelloBytes = 8 + 2 + 1 + 4 + 8 + 2 + 4 + 4;
inline constexpr size_t kMessageHeadBytes = 8;
inline constexpr size_t kMaxSceneBytes = 64 << 10;
inline constexpr size_t kMaxFailureBytes = 4 << 10;
inline constexpr uint64_t kMaxFrameBytes = uint64_t{1} << 30;  ///< what a client may agree to at most
inline constexpr uint32_t kLeastPatienceMs = 1000;             ///< links and machines pause for as long now and then
inline constexpr uint16_t kMaxDepth = 16;                      ///< requests that may be under way at a time
inline constexpr size_t kMaxViews = 256;
inline constexpr size_t kMaxSettings = 64;      ///< of a march
inline constexpr size_t kMaxSettingName = 48;   ///< bytes, 1 at least
inline constexpr size_t kMaxSettingValue = 512;  ///< bytes; lists are long
inline constexpr size_t kMaxPlanes = 16;        ///< of a frame
inline constexpr size_t kMaxPlaneName = 32;     ///< bytes, 1 at least
inline constexpr size_t kMaxProcesses = 1024;   ///< that are told of
inline constexpr size_t kProcessSlots = 32;     ///< of time, that a process tells of

// --- The handshake: one message each, of fixed size.

/// Client to server, first.
struct ClientHello {
  uint16_t version = kProtocolVersion;
  uint32_t capabilities = kCapabilities;
  uint64_t maxFrameBytes = kMaxFrameBytes;  ///< it takes no larger message
  uint16_t depth = 1;                       ///< how many requests it wants to have under way, 1..kMaxDepth
  std::optional<Token> token;

  bool operator==(const ClientHello&) const = default;
};

enum class Verdict : uint8_t {
  welcome,
  otherVersion,  ///< `version` says which one the server speaks
  wrongToken,
  full,          ///< no room for another client
};

/// Server to client. Unless it is a welcome, the server closes.
struct ServerHello {
  uint16_t version = kProtocolVersion;
  Verdict verdict = Verdict::welcome;
  uint32_t capabilities = kCapabilities;  ///< of those that the client has
  uint64_t sessionId = 0;
  uint16_t depth = 1;          ///< requests that may be under way, at most what the client asked for
  uint32_t heartbeatMs = 0;    ///< each side says something at least this often
  uint32_t patienceMs = 0;     ///< who has said nothing for this long is gone

  bool operator==(const ServerHello&) const = default;
};

// --- Messages: a head of 8 bytes (type, three zeros, length of the body), then the body.

enum class MessageType : uint8_t {
  scene = 1,    ///< server to client, once, first
  request = 2,  ///< client to server
  frame = 3,    ///< server to client, the answer to a request
  failure = 4,  ///< server to client, the other answer
  ping = 5,     ///< client to server, to measure the round trip; server to client, when there is nothing else to say
  pong = 6,     ///< the answer
  busy = 7,     ///< server to client that waits for an answer: the server works for others
  processes = 8,  ///< server to client, before a frame: what processes did that march together
};

struct MessageHead {
  MessageType type = MessageType::ping;
  uint32_t bodyBytes = 0;

  bool operator==(const MessageHead&) const = default;
};

/// As Camera (render/core/camera.h), in volume space.
struct CameraFields {
  std::array<float, 3> eye{}, right{}, up{}, forward{};
  float tanHalfFovY = 0.0f;
  uint32_t width = 0, height = 0;

  bool operator==(const CameraFields&) const = default;
};

/// One setting of a march, by name. What there is, and what values mean, is the program's business.
struct SettingField {
  std::string name, value;  ///< at most kMaxSettingName and kMaxSettingValue bytes

  bool operator==(const SettingField&) const = default;
};
/// At most kMaxSettings, no two of the same name. What is not among them is as it is by itself.
using SettingFields = std::vector<SettingField>;

/// As CodecSettings (render/codec/codec.h).
struct CodecFields {
  uint8_t format = 0, color = 0, quality = 0;

  bool operator==(const CodecFields&) const = default;
};

/// Where a scene's camera may stand.
struct ViewFields {
  double angleDeg = 0.0, elevationDeg = 0.0, distance = 1.0, panRight = 0.0, panUp = 0.0;

  bool operator==(const ViewFields&) const = default;
};

/// What a client has to know of the scene to make cameras for it: everything but the voxels.
struct SceneFields {
  std::string name, title;              ///< at most kMaxName bytes each
  std::array<uint32_t, 3> dims{};       ///< voxels
  std::array<double, 3> spacing{}, origin{};
  std::array<double, 9> direction{};    ///< columns: the grid's axes in the world
  bool hasOrientation = false;
  std::array<double, 3> up{}, front{};  ///< world directions
  double fovYDeg = 0.0;
  std::array<float, 3> background{};    ///< linear RGB
  std::vector<ViewFields> views;        ///< 1..kMaxViews
  SettingFields settings;               ///< that a march begins with

  static constexpr size_t kMaxName = 1024;
  bool operator==(const SceneFields&) const = default;
};

enum class Wanted : uint8_t {
  samples,  ///< of the server's march
  picture,  ///< colours of the same rays, linear premultiplied RGBA, 4 floats a pixel
};

struct FrameRequest {
  uint64_t id = 0;  ///< from 1 on, each greater than the one before
  Wanted wanted = Wanted::samples;
  CameraFields camera;
  SettingFields settings;
  CodecFields codec;
  uint64_t sentAtNs = 0;  ///< the client's clock; comes back as it is

  bool operator==(const FrameRequest&) const = default;
};

/// Milliseconds on the server, one stage after the other.
struct StageTimes {
  double queueMs = 0.0;  ///< from the request's arrival until its turn
  double marchMs = 0.0, compactMs = 0.0, copyMs = 0.0, encodeMs = 0.0;
  double sendMs = 0.0;   ///< from then until its first byte was handed to the network

  bool operator==(const StageTimes&) const = default;
};

/// As SamplePlane (render/march/sample_planes.h), without its values, which are in the payload.
struct PlaneFields {
  std::string name;     ///< at most kMaxPlaneName bytes
  uint8_t element = 0;

  bool operator==(const PlaneFields&) const = default;
};

/// What describes a frame's payload.
struct FrameHead {
  uint64_t id = 0;  ///< the request's
  Wanted wanted = Wanted::samples;
  CameraFields camera;
  SettingFields settings;
  CodecFields codec;
  std::array<float, 6> bounds{};  ///< of positions: lower, upper
  float radiusUnit = 1.0f;
  float nearDepth = 0.0f, depthStep = 1.0f;  ///< forward depth at which depth codes begin, and of one of their steps
  float voxelRadius = 1.0f;
  uint64_t sampleCount = 0;
  StageTimes stages;
  uint64_t requestSentAtNs = 0;
  std::vector<PlaneFields> planes;  ///< in the payload's order; at most kMaxPlanes, no two of the same name

  bool operator==(const FrameHead&) const = default;
};

struct Frame {
  FrameHead head;
  std::vector<std::byte> payload;
};

/// What one of the processes did that a volume is spread over, for the last frame that is known of it.
struct ProcessFields {
  std::array<uint32_t, 3> lower{}, upper{};  ///< cells of its brick
  uint32_t tiles = 0;                        ///< that came to it
  uint32_t deviceTiles = 0;                  ///< of them, marched by a device
  double marchMs = 0.0, waitMs = 0.0;        ///< of all its threads together
  uint64_t sentBytes = 0;                    ///< to others of them
  float slotMs = 0.0f;                       ///< length of the slots below, the first of which begins when the frame reaches it
  float mostThreads = 0.0f;                  ///< what 255 stands for in them: so many threads' time
  std::array<uint8_t, kProcessSlots> marching{}, waiting{};

  bool operator==(const ProcessFields&) const = default;
};

struct Failure {
  uint64_t id = 0;       ///< the request's
  std::string sentence;

  bool operator==(const Failure&) const = default;
};

// Sizes of bodies and heads that depend on how many settings and planes there are: without any, and with as many and as long ones as may be.
inline constexpr size_t kCameraBytes = 13 * 4 + 2 * 4;
inline constexpr size_t kMaxSettingsBytes = kMaxSettings * (2 + kMaxSettingName + 2 + kMaxSettingValue);
inline constexpr size_t kLeastRequestBytes = 8 + 1 + kCameraBytes + 1 + 3 + 8;
inline constexpr size_t kMaxRequestBytes = kLeastRequestBytes + kMaxSettingsBytes;
inline constexpr size_t kFrameHeadLengthBytes = 2;  ///< a frame's head begins with its length, these included
inline constexpr size_t kLeastFrameHeadBytes = kFrameHeadLengthBytes + 8 + 1 + kCameraBytes + 1 + 3 + 10 * 4 + 8 + 6 * 8 + 8 + 1;
inline constexpr size_t kMaxFrameHeadBytes = kLeastFrameHeadBytes + kMaxSettingsBytes + kMaxPlanes * (2 + kMaxPlaneName + 1);
inline constexpr size_t kBeatBytes = 8;
inline constexpr size_t kBusyBytes = 2;
inline constexpr size_t kProcessBytes = 6 * 4 + 2 * 4 + 2 * 8 + 8 + 2 * 4 + 2 * kProcessSlots;
inline constexpr size_t kMaxProcessesBytes = 2 + kMaxProcesses * kProcessBytes;

// --- Bytes of each. Writing appends; reading gives nothing for bytes that are not exactly one such message. Settings and planes that no
// reader would take are the program's mistake: then writing throws std::invalid_argument.

using Bytes = std::vector<std::byte>;
using ByteView = std::span<const std::byte>;

Bytes toBytes(const ClientHello& hello);
Bytes toBytes(const ServerHello& hello);
void append(Bytes& out, const MessageHead& head);
/// With their heads:
Bytes sceneMessage(const SceneFields& scene);
Bytes requestMessage(const FrameRequest& request);
/// Without the payload, which follows.
Bytes frameMessage(const FrameHead& head, size_t payloadBytes);
Bytes failureMessage(const Failure& failure);
Bytes beatMessage(MessageType pingOrPong, uint64_t number);
/// For clients that can hear it (kCanHearBusy). `others`: how many clients it works for besides that one.
Bytes busyMessage(uint16_t others);
/// For clients that can hear it (kCanHearProcesses). Of more than kMaxProcesses the first.
Bytes processesMessage(std::span<const ProcessFields> processes);

/// Whether the other side's bytes, as far as they have come, begin as this protocol does.
bool beginsLikeMagic(ByteView bytes);
/// Of a greeting's first kHelloHeadBytes; nothing if they are another protocol's.
std::optional<uint16_t> readHelloVersion(ByteView bytes);
/// The version may be another one: then the rest is as it may be.
std::optional<ClientHello> readClientHello(ByteView bytes);
std::optional<ServerHello> readServerHello(ByteView bytes);
/// Nothing for a type that there is not.
std::optional<MessageHead> readMessageHead(ByteView bytes);
std::optional<SceneFields> readScene(ByteView body);
std::optional<FrameRequest> readRequest(ByteView body);
/// The length of a frame's head, of its first kFrameHeadLengthBytes; nothing if no head has that length.
std::optional<size_t> readFrameHeadLength(ByteView bytes);
/// Of all the head's bytes.
std::optional<FrameHead> readFrameHead(ByteView bytes);
std::optional<Failure> readFailure(ByteView body);
std::optional<uint64_t> readBeat(ByteView body);
std::optional<uint16_t> readBusy(ByteView body);
std::optional<std::vector<ProcessFields>> readProcesses(ByteView body);

}  // namespace warpscope::net
