// One connection after the other, each with a reader and a writer.
// See client.h. Pauses with jitter: Brooker 2015, "Exponential backoff and jitter" (equal jitter).
#include "net/client.h"

#include <cmath>
#include <deque>
#include <random>

#include "net/channel.h"
#include "net/linked_stream.h"
#include "net/tcp_stream.h"
#include "net/tls_stream.h"

namespace warpscope::net {
namespace {

TimePoint now() { return std::chrono::steady_clock::now(); }

uint64_t nanosecondsOf(TimePoint time) {
  return static_cast<uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count());
}

/// It makes no sense to try again.
class Refused : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Asked {
  FrameRequest request;
  TimePoint requestedAt;
  TimePoint sentAt;
};

}  // namespace

/// Everything belongs to the I/O thread. Lives until the last coroutine has ended, which may be after the client's end: looking up a name
/// cannot be interrupted.
struct Client::State : std::enable_shared_from_this<State> {
  State(asio::io_context& theIo, ClientSettings theSettings, ClientEvents& theEvents)
      : io(theIo), settings(std::move(theSettings)), events(theEvents), pause(io), wake(io.get_executor()) {}

  Awaitable<void> run();
  Awaitable<void> converse();
  Awaitable<std::unique_ptr<Stream>> open(TimePoint deadline);
  Awaitable<ServerHello> greet(Stream& stream, TimePoint deadline);
  Awaitable<void> read(Channel& channel);
  Awaitable<void> write(Channel& channel);
  Awaitable<void> readFrame(Channel& channel, const MessageHead& head);

  void tell(ConnectionPhase phase, std::string sentence = {}, std::optional<TimePoint> next = {}) {
    if (isClosed) return;
    events.onState({phase, std::move(sentence), now(), next, attempts});
  }
  /// Takes the request that was answered from those under way. Throws ProtocolError if there is none.
  Asked takeAsked(uint64_t id, const std::string& peer);
  void askAgain();
  Duration nextPause();

  asio::io_context& io;  // which owns the coroutines, and they this
  ClientSettings settings;
  ClientEvents& events;
  asio::steady_timer pause;
  Signal wake;  // the writer
  LinkedStream* link = nullptr;  // of the connection
  Stream* stream = nullptr;      // that can be aborted
  std::optional<Asked> wanted;   // the newest that was not sent
  std::deque<Asked> underWay;
  std::optional<uint64_t> pong;
  uint16_t agreedDepth = 1;
  Duration heartbeat{0};
  int attempts = 0;
  bool isClosed = false;
  bool isWriterDone = true;
  Signal* writerEnd = nullptr;
  std::minstd_rand dice{std::random_device{}()};
};

Duration Client::State::nextPause() {
  const double doubled = static_cast<double>(settings.firstPause.count()) * std::exp2(std::min(attempts - 1, 20));
  const double most = std::min(doubled, static_cast<double>(settings.longestPause.count()));
  const double share = std::uniform_real_distribution<double>(0.5, 1.0)(dice);
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double, std::milli>(share * most));
}

void Client::State::askAgain() {
  // The newest of what was under way, unless something newer waits already.
  if (!wanted && !underWay.empty()) wanted = underWay.back();
  underWay.clear();
}

Awaitable<void> Client::State::run() {
  while (!isClosed) {
    tell(ConnectionPhase::connecting);
    ++attempts;
    std::string sentence;
    bool isRefused = false;
    try {
      co_await converse();
      sentence = "the server ended the connection";
    } catch (const Refused& error) {
      sentence = error.what();
      isRefused = true;
    } catch (const FingerprintMismatch& error) {
      sentence = error.what();
      isRefused = true;
    } catch (const std::exception& error) {
      sentence = error.what();
    }
    link = nullptr;
    stream = nullptr;
    askAgain();
    if (isClosed) break;
    if (isRefused || !settings.connectsAgain) {
      tell(ConnectionPhase::refused, sentence);
      break;
    }
    const TimePoint next = now() + nextPause();
    tell(ConnectionPhase::waiting, sentence, next);
    pause.expires_at(next);
    error_code ignored;
    co_await pause.async_wait(into(ignored));
  }
}

Awaitable<std::unique_ptr<Stream>> Client::State::open(TimePoint deadline) {
  std::unique_ptr<TcpStream> tcp =
      co_await connectTcp(io.get_executor(), settings.address.where.host, settings.address.where.port, deadline);
  if (!settings.address.credentials) co_return std::move(tcp);
  co_return co_await openTls(std::move(tcp), settings.address.credentials->fingerprint, deadline);
}

Awaitable<ServerHello> Client::State::greet(Stream& to, TimePoint deadline) {
  ClientHello hello;
  hello.maxFrameBytes = settings.maxFrameBytes;
  hello.depth = settings.depth;
  if (settings.address.credentials) hello.token = settings.address.credentials->token;
  const Bytes bytes = toBytes(hello);
  co_await withDeadline(to, deadline, "greeting the server", to.write(asio::buffer(bytes)));
  std::array<std::byte, kServerHelloBytes> answer;
  co_await withDeadline(to, deadline, "waiting for the server's greeting", readExactly(to, asio::buffer(answer)));
  const std::string& peer = to.peer();
  if (!hasMagic(answer)) throw Refused(peer + " is no warpscope server");
  const std::optional<ServerHello> read = readServerHello(answer);
  if (!read) throw Refused(peer + " greets in a way that this program does not understand");
  if (read->verdict == Verdict::otherVersion)
    throw Refused(peer + " speaks version " + std::to_string(read->version) + " of the protocol, this program version " +
                  std::to_string(kProtocolVersion));
  if (read->verdict == Verdict::wrongToken) throw Refused(peer + " does not accept this token: ask for the server's current address");
  if (read->verdict == Verdict::full) throw std::runtime_error(peer + " has no room for another client");
  co_return *read;
}

Awaitable<void> Client::State::converse() {
  const TimePoint deadline = now() + settings.connectPatience;
  std::unique_ptr<Stream> opened = co_await open(deadline);
  auto linked = std::make_unique<LinkedStream>(std::move(opened), settings.link);
  if (isClosed) co_return;
  link = linked.get();
  stream = link;
  link->setSettings(settings.link);  // it may have changed while this was connecting
  const ServerHello welcome = co_await greet(*link, deadline);
  agreedDepth = std::min(welcome.depth, settings.depth);
  heartbeat = std::chrono::milliseconds(welcome.heartbeatMs);
  // What the link simulates is no silence of the server's.
  const double linkMs = 2.0 * (settings.link.up.delayMs + settings.link.down.delayMs);
  Channel channel(std::move(linked), std::chrono::milliseconds(welcome.patienceMs + static_cast<int64_t>(linkMs)));

  const std::optional<MessageHead> head = co_await channel.readHead();
  if (!head || head->type != MessageType::scene) throw ProtocolError(channel.stream().peer() + " did not begin with its scene");
  const Bytes body = co_await channel.readBody(*head, kMaxSceneBytes);
  const std::optional<SceneFields> scene = readScene(body);
  if (!scene) throw ProtocolError(channel.stream().peer() + " sent a damaged scene");
  if (isClosed) co_return;
  attempts = 0;
  events.onScene(*scene);
  tell(ConnectionPhase::connected);

  Signal end(io.get_executor());
  isWriterDone = false;
  asio::co_spawn(
      io, write(channel), [self = shared_from_this(), &channel, &end](const std::exception_ptr&) {
        self->isWriterDone = true;
        channel.stream().abort();
        end.wake();
      });
  std::exception_ptr trouble;
  try {
    co_await read(channel);
  } catch (...) {
    trouble = std::current_exception();
  }
  channel.stream().abort();
  stream = nullptr;
  link = nullptr;
  wake.wake();
  while (!isWriterDone) co_await end.waitUntil(now() + std::chrono::seconds(1));
  if (trouble) std::rethrow_exception(trouble);
}

Awaitable<void> Client::State::read(Channel& channel) {
  while (const std::optional<MessageHead> head = co_await channel.readHead()) {
    const std::string& peer = channel.stream().peer();
    switch (head->type) {
      case MessageType::frame:
        co_await readFrame(channel, *head);
        break;
      case MessageType::failure: {
        const Bytes body = co_await channel.readBody(*head, kMaxFailureBytes);
        const std::optional<Failure> failure = readFailure(body);
        if (!failure) throw ProtocolError(peer + " sent a damaged message");
        takeAsked(failure->id, peer);
        wake.wake();
        if (!isClosed) events.onFailure(*failure);
        break;
      }
      case MessageType::ping:
      case MessageType::pong: {
        const Bytes body = co_await channel.readBody(*head, kBeatBytes);
        const std::optional<uint64_t> beat = readBeat(body);
        if (!beat) throw ProtocolError(peer + " sent a damaged heartbeat");
        if (head->type == MessageType::ping) {
          pong = *beat;
          wake.wake();
        } else if (!isClosed && *beat <= nanosecondsOf(now())) {
          events.onRoundTrip(std::chrono::nanoseconds(nanosecondsOf(now()) - *beat));
        }
        break;
      }
      default:
        throw ProtocolError(peer + " sent a message that servers do not send");
    }
  }
}

Asked Client::State::takeAsked(uint64_t id, const std::string& peer) {
  // Answers come in the order of requests; those in between were replaced by newer ones and get none.
  while (!underWay.empty() && underWay.front().request.id < id) underWay.pop_front();
  if (underWay.empty() || underWay.front().request.id != id) throw ProtocolError(peer + " answered what nobody asked");
  Asked asked = underWay.front();
  underWay.pop_front();
  return asked;
}

Awaitable<void> Client::State::readFrame(Channel& channel, const MessageHead& head) {
  const std::string& peer = channel.stream().peer();
  if (head.bodyBytes > settings.maxFrameBytes || head.bodyBytes < kFrameHeadBytes)
    throw ProtocolError(peer + " announced a frame of " + std::to_string(head.bodyBytes) + " bytes");
  std::array<std::byte, kFrameHeadBytes> bytes;
  co_await channel.read(bytes, "a frame's head");
  FrameArrival arrival;
  arrival.beganAt = now();
  const std::optional<FrameHead> frameHead = readFrameHead(bytes);
  if (!frameHead) throw ProtocolError(peer + " sent a damaged frame");
  const MessageHead rest{MessageType::frame, static_cast<uint32_t>(head.bodyBytes - kFrameHeadBytes)};
  // In two steps: GCC 12 destroys parts of an aggregate too early if it waits among its members.
  Bytes payload = co_await channel.readBody(rest, settings.maxFrameBytes);
  Frame frame{*frameHead, std::move(payload)};
  arrival.arrivedAt = now();
  const Asked asked = takeAsked(frameHead->id, peer);
  arrival.requestedAt = asked.requestedAt;
  arrival.sentAt = asked.sentAt;
  wake.wake();  // there is room for the next request
  if (!isClosed) events.onFrame(std::move(frame), arrival);
}

Awaitable<void> Client::State::write(Channel& channel) {
  TimePoint lastSaid = now();
  while (stream != nullptr) {
    if (pong) {
      const Bytes message = beatMessage(MessageType::pong, *std::exchange(pong, std::nullopt));
      co_await channel.write(message, "sending a heartbeat");
    } else if (wanted && underWay.size() < std::min(agreedDepth, settings.depth)) {
      Asked asked = *std::exchange(wanted, std::nullopt);
      asked.sentAt = now();
      asked.request.sentAtNs = nanosecondsOf(asked.sentAt);
      underWay.push_back(asked);
      const Bytes message = requestMessage(asked.request);
      co_await channel.write(message, "sending a request");
    } else if (now() - lastSaid >= heartbeat) {
      const Bytes message = beatMessage(MessageType::ping, nanosecondsOf(now()));
      co_await channel.write(message, "sending a heartbeat");
    } else {
      co_await wake.waitUntil(lastSaid + heartbeat);
      continue;
    }
    lastSaid = now();
  }
}

Client::Client(std::shared_ptr<IoThread> io, ClientSettings settings, ClientEvents& events) : io_(std::move(io)) {
  requireValid(settings.link);
  state_ = std::make_shared<State>(io_->context(), std::move(settings), events);
  asio::co_spawn(
      io_->context(), [state = state_] { return state->run(); }, [state = state_](const std::exception_ptr&) {});
}

Client::~Client() { close(); }

void Client::request(const FrameRequest& request) {
  asio::post(io_->context(), [state = state_, asked = Asked{request, now(), {}}] {
    state->wanted = asked;
    state->wake.wake();
  });
}

void Client::setLink(const DuplexLinkSettings& link) {
  requireValid(link);
  asio::post(io_->context(), [state = state_, link] {
    state->settings.link = link;
    if (state->link != nullptr) state->link->setSettings(link);
  });
}

void Client::setDepth(uint16_t depth) {
  asio::post(io_->context(), [state = state_, depth] {
    state->settings.depth = std::clamp<uint16_t>(depth, 1, kMaxDepth);
    // What the server agreed to was for the connection: for more, it takes another one.
    if (state->settings.depth > state->agreedDepth && state->stream != nullptr) state->stream->abort();
    state->wake.wake();
  });
}

void Client::connectNow() {
  asio::post(io_->context(), [state = state_] { state->pause.cancel(); });
}

void Client::close() {
  io_->call([state = state_.get()] {
    state->isClosed = true;
    state->pause.cancel();
    if (state->stream != nullptr) state->stream->abort();
  });
}

}  // namespace warpscope::net
