// One connection after the other, each with a reader and a writer.
// See client.h. Pauses with jitter: Brooker 2015, "Exponential backoff and jitter" (equal jitter).
#include "net/client.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <random>
#include <stop_token>

#include "net/channel.h"
#include "net/linked_stream.h"
#include "net/reading.h"
#include "net/tcp_stream.h"
#include "net/tls_stream.h"

namespace warpscope::net {
namespace {

uint64_t nanosecondsOf(TimePoint time) {
  return static_cast<uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count());
}

/// It makes no sense to try again.
class Refused : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

constexpr size_t kMostPings = 16;  // that are remembered
/// How long leaving may take: for what is being written, the way to the server and the way back.
constexpr std::chrono::milliseconds kFarewellPatience{1000};

/// How long the simulated link may keep silent though the server does not.
Duration simulatedSilence(const LinkSettings& link) {
  double longestMs = link.delayMs + 4.0 * link.jitterMs + link.outageMs;
  if (link.trace && !link.trace->delaysMs.empty()) longestMs += std::ranges::max(link.trace->delaysMs);
  return durationOfMs(longestMs);
}
Duration simulatedSilence(const DuplexLinkSettings& link) { return simulatedSilence(link.up) + simulatedSilence(link.down); }

std::string differenceOf(const SettingFields& asked, const SettingFields& answered) {
  for (const SettingField& setting : asked) {
    const auto found = std::ranges::find(answered, setting.name, &SettingField::name);
    if (found == answered.end() || found->value != setting.value) return "the setting " + setting.name + " is not " + setting.value;
  }
  return {};
}

/// What a frame says of itself that was asked otherwise; empty if nothing is. Texts of the server's are not repeated.
std::string differenceOf(const FrameRequest& asked, const FrameHead& head, ClientEvents& events) {
  const auto sizeOf = [](const CameraFields& camera) {
    return std::to_string(camera.width) + "x" + std::to_string(camera.height);
  };
  if (head.wanted != asked.wanted)
    return asked.wanted == Wanted::samples ? "a picture where samples were wanted"
                                           : "samples where a picture was wanted";
  if (head.camera.width != asked.camera.width || head.camera.height != asked.camera.height)
    return "a size of " + sizeOf(head.camera) + " pixels, not " + sizeOf(asked.camera);
  if (head.camera != asked.camera) return "another camera";
  if (std::string fault = differenceOf(asked.settings, head.settings); !fault.empty() && !events.admits(asked.settings, head.settings)) return fault;
  if (head.codec != asked.codec) return "another codec";
  return {};
}

struct Asked {
  FrameRequest request;
  TimePoint requestedAt;
  TimePoint sentAt;
};

}  // namespace

bool ClientEvents::admits(const SettingFields&, const SettingFields&) { return false; }

/// Everything but `ended` belongs to the I/O thread. Lives until the last coroutine has ended, which may be after the client's end:
/// connecting is left to its deadline.
struct Client::State : std::enable_shared_from_this<State>, private FromServer {
  State(IoThread& thread, ClientSettings theSettings, ClientEvents& theEvents)
      : io(thread.context()),
        clock(thread.clock()),
        settings(std::move(theSettings)),
        events(theEvents),
        pause(io.get_executor()),
        wake(io.get_executor()) {}

  Awaitable<void> run();
  Awaitable<void> converse();
  Awaitable<std::unique_ptr<Stream>> open(TimePoint deadline);
  Awaitable<ServerHello> greet(Stream& stream, TimePoint deadline);
  Awaitable<void> talk(Channel& channel);
  Awaitable<void> write(Channel& channel);

  std::string faultOf(const FrameHead& head, uint64_t payloadBytes) override;
  std::string faultOf(const Failure& failure) override;
  void onFrame(Frame frame, TimePoint beganAt) override;
  void onFailure(const Failure& failure) override;
  void onPing(uint64_t number) override;
  void onPong(uint64_t number) override;
  void onBusy(uint16_t others) override;
  void onProcesses(std::vector<ProcessFields> processes) override {
    if (!isClosed) events.onProcesses(processes);
  }

  void tell(ConnectionPhase phase, std::string sentence = {}, std::optional<TimePoint> next = {}) {
    if (isClosed) return;
    events.onState({phase, std::move(sentence), now(), next, attempts});
  }
  /// The request under way of that id.
  std::deque<Asked>::iterator find(uint64_t id);
  /// Of the request that is answered next, which faultOf() put first.
  Asked takeAsked();
  void askAgain();
  void leave();
  Duration nextPause();
  TimePoint now() const { return clock.now(); }
  Duration patience() const { return serverPatience + simulatedSilence(settings.link); }

  asio::io_context& io;  // which owns the coroutines, and they this
  Clock& clock;
  ClientSettings settings;
  ClientEvents& events;
  Timer pause;
  Signal wake;  // the writer
  // Of the connection, while there is one:
  Stream* stream = nullptr;      // that can be aborted
  LinkedStream* link = nullptr;
  Channel* channel = nullptr;
  bool isTalking = false;        // it has come to messages
  bool isReading = false;        // of them
  std::optional<Watchdog> farewell;  // while the writer ends the connection, or is about to
  std::optional<Asked> wanted;   // the newest that was not sent
  std::deque<Asked> underWay;    // in the order of their ids
  uint64_t newestId = 0;
  std::optional<uint64_t> pong;
  std::deque<uint64_t> pings;    // that were not answered, by when they were sent
  uint16_t offeredDepth = kMaxDepth, agreedDepth = 1;
  Duration heartbeat{0}, serverPatience{0};
  TimePoint connectedAt;
  bool isOfUse = false;     // the connection has brought an answer
  bool isRenewed = false;   // the connection was ended to begin another one
  int attempts = 0;         // since it was connected
  int failures = 0;         // since a connection was of use
  bool isClosed = false;
  std::stop_source ended;   // asked to stop when run() has returned
  std::minstd_rand dice{std::random_device{}()};
};

Duration Client::State::nextPause() {
  const double doubled = static_cast<double>(settings.firstPause.count()) * std::exp2(std::clamp(failures - 1, 0, 20));
  const double most = std::min(doubled, static_cast<double>(settings.longestPause.count()));
  const double share = std::uniform_real_distribution<double>(0.5, 1.0)(dice);
  return durationOfMs(share * most);
}

void Client::State::askAgain() {
  // The newest of what was under way, unless something newer waits already.
  if (!wanted && !underWay.empty()) wanted = underWay.back();
  underWay.clear();
}

/// Ends the connection. Where it has come to messages the server reads a clean end after the last of them, and knows that nothing broke.
void Client::State::leave() {
  if (stream == nullptr || farewell) return;
  if (!isTalking) {
    stream->abort();
    return;
  }
  farewell.emplace(io.get_executor(), now() + kFarewellPatience, [this] { stream->abort(); });
  wake.wake();
}

Awaitable<void> Client::State::run() {
  while (!isClosed) {
    tell(ConnectionPhase::connecting);
    ++attempts;
    isRenewed = isOfUse = false;
    offeredDepth = kMaxDepth;
    connectedAt = TimePoint::max();
    std::string sentence;
    bool isRefused = false;
    try {
      co_await converse();
      sentence = "the server ended the connection";
    } catch (const Refused& error) {
      sentence = error.what();
      isRefused = true;
    } catch (const WrongAnswer& error) {
      sentence = error.what();
      isRefused = true;
    } catch (const FingerprintMismatch& error) {
      sentence = error.sentence();
      isRefused = true;
    } catch (const NoTls& error) {
      sentence = std::string(error.what()) + ": its address would begin with warp://";
      isRefused = true;
    } catch (const std::exception& error) {
      sentence = error.what();
    }
    stream = nullptr;
    link = nullptr;
    channel = nullptr;
    askAgain();
    if (isClosed) break;
    if (isRefused || (!settings.connectsAgain && !isRenewed)) {
      tell(ConnectionPhase::refused, sentence);
      break;
    }
    if (isRenewed) continue;
    // A server that greets and then breaks off is no better than one that is not there.
    const bool hasLasted = connectedAt != TimePoint::max() && now() - connectedAt >= settings.longestPause;
    failures = isOfUse || hasLasted ? 1 : failures + 1;
    const TimePoint next = now() + nextPause();
    tell(ConnectionPhase::waiting, sentence, next);
    pause.setTo(next);
    co_await pause.wait();
  }
}

Awaitable<std::unique_ptr<Stream>> Client::State::open(TimePoint deadline) {
  if (settings.opener) co_return settings.opener(io);
  const HostPort& where = settings.address.where;
  Awaitable<std::unique_ptr<TcpStream>> connecting = connectTcp(io.get_executor(), where.host, where.port, deadline, settings.resolver ? settings.resolver : resolveBySystem);
  std::unique_ptr<TcpStream> tcp = co_await std::move(connecting);
  if (isClosed || !settings.address.credentials) co_return std::move(tcp);
  stream = tcp.get();
  co_return co_await openTls(std::move(tcp), settings.address.credentials->fingerprint, deadline);
}

Awaitable<ServerHello> Client::State::greet(Stream& to, TimePoint deadline) {
  ClientHello hello;
  hello.maxFrameBytes = settings.maxFrameBytes;
  hello.depth = offeredDepth = settings.depth;
  if (settings.address.credentials) hello.token = settings.address.credentials->token;
  const Bytes bytes = toBytes(hello);
  co_await withDeadline(to, deadline, "greeting the server", to.write(asio::buffer(bytes)));
  ServerHello answer;
  try {
    answer = co_await receiveServerHello(to, deadline);
  } catch (const ForeignPeer& error) {
    throw Refused(error.what() + std::string(error.speaksTls() ? ": ask for the server's address, which begins with warps://" : ""));
  } catch (const ProtocolError&) {
    throw Refused(to.peer() + " greets in a way that this program does not understand");
  }
  const std::string& peer = to.peer();
  if (answer.version != kProtocolVersion)
    throw Refused(peer + " speaks version " + std::to_string(answer.version) + " of the protocol, this program version " +
                  std::to_string(kProtocolVersion));
  switch (answer.verdict) {
    case Verdict::welcome:
      co_return answer;
    case Verdict::otherVersion:
      throw Refused(peer + " does not speak version " + std::to_string(kProtocolVersion) + " of the protocol with this program");
    case Verdict::wrongToken:
      throw Refused(peer + " does not accept this token: ask for the server's current address");
    case Verdict::full:
      break;
  }
  throw std::runtime_error(peer + " has no room for another client");
}

Awaitable<void> Client::State::converse() {
  const TimePoint deadline = now() + settings.connectPatience + simulatedSilence(settings.link);
  std::unique_ptr<Stream> opened = co_await open(deadline);
  if (isClosed) co_return;
  // What is set by then: it may have changed while this was connecting.
  auto linked = std::make_unique<LinkedStream>(std::move(opened), settings.link);
  stream = link = linked.get();
  const ServerHello welcome = co_await greet(*link, deadline);
  agreedDepth = std::min(welcome.depth, offeredDepth);
  heartbeat = std::chrono::milliseconds(welcome.heartbeatMs);
  serverPatience = std::chrono::milliseconds(welcome.patienceMs);
  Channel made(std::move(linked), patience());
  channel = &made;
  const SceneFields scene = co_await readFirstScene(made);
  if (isClosed) co_return;
  attempts = 0;
  connectedAt = now();
  events.onScene(scene);
  tell(ConnectionPhase::connected);
  co_await talk(made);
}

/// Reads and writes until one of the two ends, which ends the other; leave() ends the writer first. Throws the first one's reason.
Awaitable<void> Client::State::talk(Channel& with) {
  Signal writerEnd(io.get_executor());
  Reason reason;
  bool isWriting = true;
  pong.reset();
  pings.clear();
  isTalking = isReading = true;
  asio::co_spawn(io, write(with), [&with, &writerEnd, &reason, &isWriting](const std::exception_ptr& failure) {
    reason.add(failure);
    with.stream().abort();
    isWriting = false;
    writerEnd.wake();
  });
  try {
    co_await readServer(with, settings.maxFrameBytes, *this);
  } catch (...) {
    reason.add(std::current_exception());
  }
  isReading = false;
  if (!farewell) with.stream().abort();
  wake.wake();
  while (isWriting) co_await writerEnd.waitUntil(now() + std::chrono::seconds(1));
  isTalking = false;
  farewell.reset();
  stream = nullptr;
  if (reason.failure()) std::rethrow_exception(reason.failure());
}

std::deque<Asked>::iterator Client::State::find(uint64_t id) {
  return std::ranges::find(underWay, id, [](const Asked& asked) { return asked.request.id; });
}

// Answers come in the order of requests; those in between were replaced by newer ones and get none.

std::string Client::State::faultOf(const FrameHead& head, uint64_t payloadBytes) {
  const auto found = find(head.id);
  if (isClosed || found == underWay.end()) return "nobody waits for frame " + std::to_string(head.id);
  std::string fault = differenceOf(found->request, head, events);
  if (fault.empty()) fault = events.faultOf(head, payloadBytes);
  if (fault.empty()) underWay.erase(underWay.begin(), found);
  return fault;
}

std::string Client::State::faultOf(const Failure& failure) {
  const auto found = find(failure.id);
  if (found == underWay.end()) return "nobody waits for frame " + std::to_string(failure.id);
  underWay.erase(underWay.begin(), found);
  return {};
}

Asked Client::State::takeAsked() {
  const Asked asked = underWay.front();
  underWay.pop_front();
  isOfUse = true;
  wake.wake();  // there is room for the next request
  return asked;
}

void Client::State::onFrame(Frame frame, TimePoint beganAt) {
  const Asked asked = takeAsked();
  if (!isClosed) events.onFrame(std::move(frame), {asked.requestedAt, asked.sentAt, beganAt, now()});
}

void Client::State::onFailure(const Failure& failure) {
  takeAsked();
  if (!isClosed) events.onFailure(failure);
}

void Client::State::onPing(uint64_t number) {
  pong = number;  // of several, the last: the answers cannot pile up
  wake.wake();
}

void Client::State::onPong(uint64_t number) {
  // Servers answer the last of several; those before it are not measured. Numbers that were never sent are nothing to go by.
  const auto found = std::ranges::find(pings, number);
  if (found == pings.end()) return;
  pings.erase(pings.begin(), found + 1);
  if (!isClosed) events.onRoundTrip(std::chrono::nanoseconds(nanosecondsOf(now()) - number));
}

void Client::State::onBusy(uint16_t others) {
  // It may have crossed with the answer.
  if (!isClosed && !underWay.empty()) events.onBusy(others);
}

Awaitable<void> Client::State::write(Channel& to) {
  TimePoint nextPing = now();  // not only in silence: they measure the round trip
  while (isReading || farewell) {
    if (farewell) {
      co_await to.stream().finish(now() + kFarewellPatience);
      co_return;
    }
    if (pong) {
      const Bytes message = beatMessage(MessageType::pong, *std::exchange(pong, std::nullopt));
      co_await to.write(message, "sending a heartbeat");
    } else if (wanted && underWay.size() < std::min(agreedDepth, settings.depth)) {
      Asked asked = *std::exchange(wanted, std::nullopt);
      asked.sentAt = now();
      asked.request.sentAtNs = nanosecondsOf(asked.sentAt);
      underWay.push_back(asked);
      const Bytes message = requestMessage(asked.request);
      co_await to.write(message, "sending a request");
    } else if (now() >= nextPing) {
      nextPing = now() + heartbeat;
      pings.push_back(nanosecondsOf(now()));
      if (pings.size() > kMostPings) pings.pop_front();
      const Bytes message = beatMessage(MessageType::ping, pings.back());
      co_await to.write(message, "sending a heartbeat");
    } else {
      co_await wake.waitUntil(nextPing);
    }
  }
}

Client::Client(std::shared_ptr<IoThread> io, ClientSettings settings, ClientEvents& events) : io_(std::move(io)) {
  requireValid(settings.link);
  settings.depth = std::clamp<uint16_t>(settings.depth, 1, kMaxDepth);
  settings.maxFrameBytes = std::clamp<uint64_t>(settings.maxFrameBytes, kLeastFrameHeadBytes, kMaxFrameBytes);
  state_ = std::make_shared<State>(*io_, std::move(settings), events);
  asio::co_spawn(
      io_->context(), [state = state_] { return state->run(); }, [state = state_](const std::exception_ptr&) { state->ended.request_stop(); });
}

Client::~Client() { close(); }

void Client::request(const FrameRequest& request) {
  asio::post(io_->context(), [state = state_, asked = Asked{request, io_->clock().now(), {}}] {
    if (asked.request.id <= state->newestId) return;
    state->newestId = asked.request.id;
    state->wanted = asked;
    state->wake.wake();
  });
}

void Client::setLink(const DuplexLinkSettings& link) {
  requireValid(link);
  asio::post(io_->context(), [state = state_, link] {
    state->settings.link = link;
    if (state->link != nullptr) state->link->setSettings(link);
    if (state->channel != nullptr) state->channel->setPatience(state->patience());
  });
}

void Client::setDepth(uint16_t depth) {
  asio::post(io_->context(), [state = state_, depth] {
    state->settings.depth = std::clamp<uint16_t>(depth, 1, kMaxDepth);
    // What was agreed is for the connection: for more, it takes another one.
    if (state->settings.depth > state->offeredDepth && state->stream != nullptr) {
      state->isRenewed = true;
      state->leave();
    }
    state->wake.wake();
  });
}

void Client::connectNow() {
  asio::post(io_->context(), [state = state_] { state->pause.cancel(); });
}

void Client::close() {
  const bool isTalking = io_->call([state = state_.get()] {
    state->isClosed = true;
    state->pause.cancel();
    state->leave();
    return state->isTalking;
  });
  // What is sent last must leave before the thread that sends it may end.
  if (isTalking) io_->clock().waitUntil(io_->clock().now() + 2 * kFarewellPatience, state_->ended.get_token());
}

}  // namespace warpscope::net
