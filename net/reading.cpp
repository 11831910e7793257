// One loop over the messages of each side; which of them it may send is decided here.
// See reading.h. What is awaited gets a name first: GCC 12 destroys parts of larger expressions too early if they wait.
#include "net/reading.h"

namespace warpscope::net {
namespace {

/// A record of TLS: a type, and the major version 3 (RFC 8446, section 5.1).
bool looksLikeTls(ByteView bytes) {
  const auto type = std::to_integer<uint8_t>(bytes[0]);
  return type >= 20 && type <= 23 && std::to_integer<uint8_t>(bytes[1]) == 3;
}

/// The first bytes of a greeting, and its version. Other protocols may have said all they will before those are full.
Awaitable<uint16_t> receiveHelloHead(Stream& stream, TimePoint deadline, std::span<std::byte> bytes) {
  size_t got = 0;
  while (got < kHelloHeadBytes) {
    const size_t count = co_await withDeadline(stream, deadline, "waiting for the greeting",
                                               stream.readSome(asio::buffer(bytes.data() + got, kHelloHeadBytes - got)));
    if (count == 0) throw system_error(asio::error::make_error_code(asio::error::eof), stream.peer() + " ended without a greeting");
    got += count;
    if (!beginsLikeMagic(bytes.first(got))) throw ForeignPeer(stream.peer(), got >= 2 && looksLikeTls(bytes));
  }
  co_return readHelloVersion(bytes.first(got)).value();
}

template <class Hello, size_t kBytes, class Read>
Awaitable<Hello> receiveHello(Stream& stream, TimePoint deadline, Read readHello) {
  std::array<std::byte, kBytes> bytes;
  const uint16_t version = co_await receiveHelloHead(stream, deadline, bytes);
  Hello other;
  other.version = version;
  if (version != kProtocolVersion) co_return other;
  const std::span<std::byte> rest = std::span(bytes).subspan(kHelloHeadBytes);
  co_await withDeadline(stream, deadline, "waiting for the greeting", readExactly(stream, asio::buffer(rest.data(), rest.size())));
  const std::optional<Hello> hello = readHello(bytes);
  if (!hello) throw ProtocolError(stream.peer() + " sent a damaged greeting");
  co_return *hello;
}

Awaitable<uint64_t> readBeatOf(Channel& channel, MessageHead head) {
  const Bytes body = co_await channel.readBody(head, kBeatBytes);
  const std::optional<uint64_t> beat = readBeat(body);
  if (!beat) throw ProtocolError(channel.stream().peer() + " sent a damaged heartbeat");
  co_return *beat;
}

Awaitable<void> readFrame(Channel& channel, MessageHead head, uint64_t maxFrameBytes, FromServer& to) {
  const std::string& peer = channel.stream().peer();
  if (head.bodyBytes > maxFrameBytes || head.bodyBytes < kLeastFrameHeadBytes)
    throw ProtocolError(peer + " announced a frame of " + std::to_string(head.bodyBytes) + " bytes");
  std::array<std::byte, kMaxFrameHeadBytes> headBytes;
  const std::span<std::byte> lengthBytes = std::span(headBytes).first(kFrameHeadLengthBytes);
  co_await channel.read(lengthBytes, "a frame's head");
  const std::optional<size_t> length = readFrameHeadLength(lengthBytes);
  if (!length || *length > head.bodyBytes) throw ProtocolError(peer + " sent a damaged frame");
  const std::span<std::byte> bytes = std::span(headBytes).first(*length);
  co_await channel.read(bytes.subspan(kFrameHeadLengthBytes), "a frame's head");
  const TimePoint beganAt = channel.clock().now();
  const std::optional<FrameHead> frameHead = readFrameHead(bytes);
  if (!frameHead) throw ProtocolError(peer + " sent a damaged frame");
  const MessageHead rest{MessageType::frame, static_cast<uint32_t>(head.bodyBytes - bytes.size())};
  if (const std::string fault = to.faultOf(*frameHead, rest.bodyBytes); !fault.empty()) throw WrongAnswer(fault);
  Bytes payload = co_await channel.readBody(rest, rest.bodyBytes);
  Frame frame{*frameHead, std::move(payload)};
  to.onFrame(std::move(frame), beganAt);
}

}  // namespace

Awaitable<ClientHello> receiveClientHello(Stream& stream, TimePoint deadline) {
  const ClientHello hello = co_await receiveHello<ClientHello, kClientHelloBytes>(stream, deadline, readClientHello);
  co_return hello;
}

Awaitable<ServerHello> receiveServerHello(Stream& stream, TimePoint deadline) {
  const ServerHello hello = co_await receiveHello<ServerHello, kServerHelloBytes>(stream, deadline, readServerHello);
  co_return hello;
}

Awaitable<void> readClient(Channel& channel, FromClient& to) {
  const std::string& peer = channel.stream().peer();
  while (true) {
    const std::optional<MessageHead> head = co_await channel.readHead();
    if (!head) co_return;
    switch (head->type) {
      case MessageType::request: {
        const Bytes body = co_await channel.readBody(*head, kMaxRequestBytes);
        const std::optional<FrameRequest> request = readRequest(body);
        if (!request) throw ProtocolError(peer + " sent a damaged request");
        if (!to.onRequest(*request)) throw ProtocolError(peer + " sent a request out of order");
        break;
      }
      case MessageType::ping: {
        const uint64_t number = co_await readBeatOf(channel, *head);
        to.onPing(number);
        break;
      }
      case MessageType::pong:
        co_await readBeatOf(channel, *head);
        break;
      default:
        throw ProtocolError(peer + " sent a message that clients do not send");
    }
  }
}

Awaitable<SceneFields> readFirstScene(Channel& channel) {
  const std::string& peer = channel.stream().peer();
  const std::optional<MessageHead> head = co_await channel.readHead();
  if (!head) throw system_error(asio::error::make_error_code(asio::error::eof), peer + " ended before its scene");
  if (head->type != MessageType::scene) throw ProtocolError(peer + " did not begin with its scene");
  const Bytes body = co_await channel.readBody(*head, kMaxSceneBytes);
  std::optional<SceneFields> scene = readScene(body);
  if (!scene) throw ProtocolError(peer + " sent a damaged scene");
  co_return std::move(*scene);
}

Awaitable<void> readServer(Channel& channel, uint64_t maxFrameBytes, FromServer& to) {
  const std::string& peer = channel.stream().peer();
  while (true) {
    const std::optional<MessageHead> head = co_await channel.readHead();
    if (!head) co_return;
    switch (head->type) {
      case MessageType::frame:
        co_await readFrame(channel, *head, maxFrameBytes, to);
        break;
      case MessageType::failure: {
        const Bytes body = co_await channel.readBody(*head, kMaxFailureBytes);
        const std::optional<Failure> failure = readFailure(body);
        if (!failure) throw ProtocolError(peer + " sent a damaged message");
        if (const std::string fault = to.faultOf(*failure); !fault.empty()) throw WrongAnswer(fault);
        to.onFailure(*failure);
        break;
      }
      case MessageType::ping: {
        const uint64_t number = co_await readBeatOf(channel, *head);
        to.onPing(number);
        break;
      }
      case MessageType::pong: {
        const uint64_t number = co_await readBeatOf(channel, *head);
        to.onPong(number);
        break;
      }
      case MessageType::busy: {
        const Bytes body = co_await channel.readBody(*head, kBusyBytes);
        const std::optional<uint16_t> others = readBusy(body);
        if (!others) throw ProtocolError(peer + " sent a damaged message");
        to.onBusy(*others);
        break;
      }
      case MessageType::processes: {
        const Bytes body = co_await channel.readBody(*head, kMaxProcessesBytes);
        std::optional<std::vector<ProcessFields>> processes = readProcesses(body);
        if (!processes) throw ProtocolError(peer + " sent a damaged message");
        to.onProcesses(std::move(*processes));
        break;
      }
      default:
        throw ProtocolError(peer + " sent a message that servers do not send");
    }
  }
}

}  // namespace warpscope::net
