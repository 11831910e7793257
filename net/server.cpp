// Accepting, greeting, one session per client.
// See server.h.
#include "net/server.h"

#include <array>
#include <condition_variable>
#include <map>
#include <mutex>
#include <stdexcept>

#include "net/login_limiter.h"
#include "net/reading.h"
#include "net/server_session.h"
#include "net/tcp_stream.h"
#include "net/tls_stream.h"

namespace warpscope::net {
namespace {

/// What is wrong with the settings, or nothing.
std::string faultOf(const ServerSettings& settings) {
  constexpr std::chrono::hours kLongest{1};
  if (settings.identity.has_value() != settings.token.has_value()) return "a certificate and a token go together";
  if (!settings.identity && !isLoopback(settings.listen.host)) return "others can reach it, which needs a certificate and a token";
  for (const PlaceLimits& limits : {settings.clients, settings.greetings})
    if (limits.most < 1 || limits.mostOfAnAddress < 1) return "there is no place for anybody";
  if (settings.scene.views.empty() || settings.scene.views.size() > kMaxViews)
    return "a scene has 1 to " + std::to_string(kMaxViews) + " views, not " + std::to_string(settings.scene.views.size());
  if (settings.maxDepth < 1 || settings.maxDepth > kMaxDepth)
    return "1 to " + std::to_string(kMaxDepth) + " requests can be under way, not " + std::to_string(settings.maxDepth);
  if (settings.heartbeat < std::chrono::milliseconds(1) || settings.patience <= settings.heartbeat || settings.patience > kLongest)
    return "heartbeats need at least 1 ms, and patience more than a heartbeat and at most an hour";
  if (settings.patience < std::chrono::milliseconds(kLeastPatienceMs)) return "patience is a second at least";
  return {};
}

constexpr size_t kMostFarewells = 64;

}  // namespace

/// What the server's threads share. Everything but the queue belongs to the I/O thread.
struct Server::State : std::enable_shared_from_this<State> {
  State(IoThread& thread, ServerSettings theSettings)
      : io(thread.context()),
        clock(thread.clock()),
        settings(std::move(theSettings)),
        listener(io.get_executor(), settings.listen.host, settings.listen.port),
        sceneBytes(sceneMessage(settings.scene)),
        logins(settings.loginLimits) {}

  void note(const std::string& text) const {
    if (settings.onNote) settings.onNote(text);
  }

  /// A connection that has not shown yet who it is.
  struct Greeting {
    Stream* stream;
    TcpStream* tcp;  ///< as long as no byte has come: it can be told in the clear
    std::string network;
    TimePoint since;
    bool madeRoom = false;
  };

  Awaitable<void> acceptAll();
  void makeRoomForGreeting(const TcpStream& newcomer);
  Awaitable<void> serve(uint64_t greeting, std::unique_ptr<TcpStream> tcp);
  Awaitable<void> serveClient(std::unique_ptr<Stream> stream, const ClientHello& hello, const std::string& network);
  Awaitable<void> tellFull(TcpStream& tcp);
  /// Whether there is a place for one more client of `network`; another one may have to go for it.
  bool makeRoomForClient(const std::string& network);
  Awaitable<std::unique_ptr<Stream>> secured(std::unique_ptr<TcpStream> tcp, TimePoint deadline);
  /// The hello of a client that may stay.
  Awaitable<std::optional<ClientHello>> greet(Stream& stream, TimePoint deadline, const std::string& network);
  Awaitable<void> turnAway(Stream& stream, TimePoint deadline, Verdict verdict, std::string why);
  Awaitable<void> turnAwayWrongToken(Stream& stream, TimePoint deadline);
  Awaitable<void> reply(Stream& stream, TimePoint deadline, ServerHello hello);
  /// On any thread.
  void answer(ClientId client, Outgoing outgoing);
  void begin();
  void end();

  asio::io_context& io;
  Clock& clock;
  const ServerSettings settings;
  TcpListener listener;
  const Bytes sceneBytes;
  LoginLimiter logins;
  TlsStream::Context tls;
  RequestQueue queue;
  std::map<ClientId, std::shared_ptr<ServerSession>> sessions;
  std::map<uint64_t, Greeting> greetings;
  uint64_t lastGreeting = 0;
  size_t farewells = 0;  // that are told why they go; others go without a word
  ClientId lastClient = 0;
  bool isStopped = false;

  std::mutex mutex;  // of the number of coroutines that still run
  std::condition_variable ended;
  size_t running = 0;
};

void Server::State::begin() {
  const std::scoped_lock lock(mutex);
  ++running;
}

void Server::State::end() {
  {
    const std::scoped_lock lock(mutex);
    --running;
  }
  ended.notify_all();
}

void Server::State::answer(ClientId client, Outgoing outgoing) {
  outgoing.queuedBytes = outgoing.bytes.size();
  queue.finished(client, outgoing.queuedBytes);  // before it may be done
  auto shared = std::make_shared<Outgoing>(std::move(outgoing));
  asio::post(io, [self = shared_from_this(), client, shared] {
    if (const auto found = self->sessions.find(client); found != self->sessions.end()) found->second->put(std::move(*shared));
  });
}

Awaitable<void> Server::State::acceptAll() {
  while (!isStopped) {
    std::unique_ptr<TcpStream> tcp;
    try {
      tcp = co_await listener.accept();
    } catch (const system_error&) {
      continue;  // closed, or nothing that would come again
    }
    if (isStopped) break;
    if (!logins.admits(tcp->peer(), clock.now())) {
      tcp->abort();  // without a word: whoever has the right token tries again
      continue;
    }
    makeRoomForGreeting(*tcp);
    // Known from here on, so that stop() finds it even before its coroutine has begun.
    const uint64_t greeting = ++lastGreeting;
    greetings[greeting] = {tcp.get(), tcp.get(), tcp->network(), clock.now()};
    begin();
    asio::co_spawn(
        io, [self = shared_from_this(), greeting, shared = std::make_shared<std::unique_ptr<TcpStream>>(std::move(tcp))]() {
          return self->serve(greeting, std::move(*shared));
        },
        [self = shared_from_this()](const std::exception_ptr&) { self->end(); });
  }
}

/// Those that stay silent go first, the oldest before the others: whoever has just come has had no time to say anything.
void Server::State::makeRoomForGreeting(const TcpStream& newcomer) {
  std::vector<Occupant> occupants;
  for (const auto& [id, greeting] : greetings)
    if (!greeting.madeRoom) occupants.push_back({id, greeting.network, greeting.since, greeting.tcp != nullptr, false});
  const Admission admission = admit(occupants, newcomer.network(), settings.greetings, clock.now());
  if (!admission.whoGoes) return;
  Greeting& goes = greetings.at(*admission.whoGoes);
  goes.madeRoom = true;
  if (goes.tcp != nullptr)
    goes.tcp->cancel();  // its coroutine tells it why
  else
    goes.stream->abort();
}

bool Server::State::makeRoomForClient(const std::string& network) {
  std::vector<Occupant> occupants;
  for (const auto& [id, session] : sessions)
    if (!session->isClosed()) occupants.push_back({id, session->network(), session->lastOfUse(), false, session->isInUse()});
  const Admission admission = admit(occupants, network, settings.clients, clock.now());
  if (admission.whoGoes) sessions.at(*admission.whoGoes)->close(std::make_exception_ptr(std::runtime_error("idle for longest, it made room for another client")));
  return admission.isPossible;
}

/// As much as can be said to somebody who has said nothing. Over TLS that is a fatal alert, "user canceled": RFC 8446, section 6.1.
Awaitable<void> Server::State::tellFull(TcpStream& tcp) {
  constexpr std::chrono::milliseconds kPatience{500};
  constexpr std::array<uint8_t, 7> kAlert{21, 3, 3, 0, 2, 2, 90};
  ServerHello full;
  full.verdict = Verdict::full;
  const Bytes hello = toBytes(full);
  const TimePoint deadline = clock.now() + kPatience;
  co_await withDeadline(tcp, deadline, "refusing", tcp.write(tls ? asio::buffer(kAlert) : asio::buffer(hello)));
  co_await tcp.finish(deadline);
}

Awaitable<std::unique_ptr<Stream>> Server::State::secured(std::unique_ptr<TcpStream> tcp, TimePoint deadline) {
  if (!tls) co_return std::move(tcp);
  co_return co_await acceptTls(std::move(tcp), tls, deadline);
}

Awaitable<void> Server::State::reply(Stream& stream, TimePoint deadline, ServerHello hello) {
  const Bytes bytes = toBytes(hello);
  co_await withDeadline(stream, deadline, "answering the greeting", stream.write(asio::buffer(bytes)));
}

Awaitable<void> Server::State::turnAwayWrongToken(Stream& stream, TimePoint deadline) {
  const std::string line = logins.failed(stream.peer(), clock.now());
  if (!line.empty() && settings.onWrongToken) settings.onWrongToken(line);
  co_await turnAway(stream, deadline, Verdict::wrongToken, "a wrong token");
}

/// Says why, and sees to it that it arrives.
Awaitable<void> Server::State::turnAway(Stream& stream, TimePoint deadline, Verdict verdict, std::string why) {
  note(stream.peer() + " turned away: " + why);
  ServerHello answer;
  answer.verdict = verdict;
  co_await reply(stream, deadline, answer);
  co_await stream.finish(deadline);
}

Awaitable<std::optional<ClientHello>> Server::State::greet(Stream& stream, TimePoint deadline, const std::string& network) {
  std::optional<ClientHello> hello;
  std::string foreign;
  try {
    hello = co_await receiveClientHello(stream, deadline);
  } catch (const ForeignPeer& error) {
    foreign = error.what();
  }
  // Who speaks another protocol, TLS above all, learns from the answer that this is none of it.
  if (!hello)
    co_await turnAway(stream, deadline, Verdict::otherVersion, std::move(foreign));
  else if (hello->version != kProtocolVersion)
    co_await turnAway(stream, deadline, Verdict::otherVersion, "version " + std::to_string(hello->version) + " of the protocol");
  else if (settings.token && !(hello->token && *hello->token == *settings.token))
    co_await turnAwayWrongToken(stream, deadline);
  else if (!makeRoomForClient(network))
    co_await turnAway(stream, deadline, Verdict::full, "no room for another client");
  else
    co_return hello;
  co_return std::nullopt;
}

Awaitable<void> Server::State::serve(uint64_t id, std::unique_ptr<TcpStream> tcp) {
  const std::string peer = tcp->peer(), network = tcp->network();
  const TimePoint accepted = clock.now(), deadline = accepted + settings.greetingPatience;
  std::unique_ptr<Stream> stream;
  std::optional<ClientHello> hello;
  std::string trouble;
  try {
    co_await withDeadline(*tcp, accepted + std::min(settings.firstBytePatience, settings.greetingPatience), "waiting for the first byte", tcp->waitReadable());
    greetings.at(id).tcp = nullptr;
    stream = co_await secured(std::move(tcp), deadline);
    greetings.at(id).stream = stream.get();
    hello = co_await greet(*stream, deadline, network);
  } catch (const std::exception& error) {
    trouble = error.what();
  }
  const bool madeRoom = greetings.at(id).madeRoom;
  greetings.erase(id);
  if (madeRoom) trouble = "too many connections have not shown who they are";
  if (!trouble.empty()) note(peer + " turned away: " + trouble);
  if (isStopped) co_return;
  if (madeRoom && tcp && farewells < kMostFarewells) {
    ++farewells;
    try {
      co_await tellFull(*tcp);
    } catch (const system_error&) {
      // It is gone already.
    }
    --farewells;
    co_return;
  }
  if (hello && !madeRoom) co_await serveClient(std::move(stream), *hello, network);
}

Awaitable<void> Server::State::serveClient(std::unique_ptr<Stream> stream, const ClientHello& hello, const std::string& network) {
  const std::string peer = stream->peer();
  const TimePoint deadline = clock.now() + settings.greetingPatience;
  if (settings.token) logins.succeeded(peer);
  ServerHello welcome;
  welcome.capabilities = kCapabilities & hello.capabilities;
  welcome.sessionId = ++lastClient;
  welcome.depth = std::min(hello.depth, settings.maxDepth);
  welcome.heartbeatMs = static_cast<uint32_t>(settings.heartbeat.count());
  welcome.patienceMs = static_cast<uint32_t>(settings.patience.count());
  const ClientId id = lastClient;
  Stream& kept = *stream;
  auto session = std::make_shared<ServerSession>(std::move(stream), network,
                                                 SessionSettings{.id = id,
                                                                 .depth = welcome.depth,
                                                                 .maxFrameBytes = hello.maxFrameBytes,
                                                                 .capabilities = welcome.capabilities,
                                                                 .heartbeat = settings.heartbeat,
                                                                 .patience = settings.patience,
                                                                 .firstMessagePatience = settings.patience + settings.greetingPatience},
                                                 queue, sceneBytes);
  sessions[id] = session;
  queue.join(id, welcome.depth);
  note(peer + " connected");
  std::exception_ptr failure;
  try {
    co_await reply(kept, deadline, welcome);
    // The writer beside the reader; whichever ends first ends the other.
    begin();
    session->writerBegins();
    asio::co_spawn(
        io, [session] { return session->write(); },
        [self = shared_from_this(), session](const std::exception_ptr& writerFailure) {
          session->writerEnds(writerFailure);
          self->end();
        });
    co_await session->read();
  } catch (...) {
    failure = std::current_exception();
  }
  session->close(failure);
  queue.leave(id);
  sessions.erase(id);
  co_await session->untilWriterEnds();
  const std::string why = session->reason().sentence();
  note(peer + " left" + (why.empty() ? "" : ": " + why));
}

Server::Server(std::shared_ptr<IoThread> io, ServerSettings settings) : io_(std::move(io)) {
  const std::string where = toString(settings.listen);
  if (const std::string fault = faultOf(settings); !fault.empty()) throw std::invalid_argument("cannot serve on " + where + ": " + fault);
  state_ = io_->call([&] { return std::make_shared<State>(*io_, std::move(settings)); });
  if (state_->settings.identity) state_->tls = makeServerContext(*state_->settings.identity);
  // Names may be looked up to anything.
  if (!state_->tls && !state_->listener.isLoopback())
    throw std::invalid_argument("cannot serve on " + where + ": it is " + state_->listener.address() + ", which others can reach");
  state_->listener.onShortage([state = state_.get()](const std::string& text) { state->note(text); });
  state_->begin();
  asio::co_spawn(
      io_->context(), [state = state_] { return state->acceptAll(); },
      [state = state_](const std::exception_ptr&) { state->end(); });
}

Server::~Server() { stop(); }

void Server::stop() {
  io_->call([state = state_.get()] {
    state->isStopped = true;
    state->listener.close();
    for (const auto& [id, greeting] : state->greetings) greeting.stream->abort();
    const auto why = std::make_exception_ptr(std::runtime_error("the server stopped"));
    for (const auto& [id, session] : std::map(state->sessions)) session->close(why);
  });
  std::unique_lock lock(state_->mutex);
  state_->ended.wait(lock, [this] { return state_->running == 0; });
}

RequestQueue& Server::requests() { return state_->queue; }

void Server::answer(ClientId client, const FrameHead& head, HeldBytes payload, ByteBudget::SharePtr share, std::span<const ProcessFields> processes) {
  Outgoing outgoing{.frame = head, .bytes = std::move(payload), .readyAt = io_->clock().now(), .share = std::move(share)};
  if (!processes.empty()) outgoing.processes = processesMessage(processes);
  state_->answer(client, std::move(outgoing));
}

void Server::answer(ClientId client, Failure failure) {
  state_->answer(client, {.frame = {}, .bytes = failureMessage(failure), .readyAt = io_->clock().now()});
}

void Server::makeRoom() {
  asio::post(io_->context(), [state = state_] {
    ServerSession* slowest = nullptr;
    for (const auto& [id, session] : state->sessions)
      if (!session->isClosed() && session->longestWait() >= kLongestWait && (slowest == nullptr || session->waitingBytes() > slowest->waitingBytes()))
        slowest = session.get();
    if (slowest == nullptr) return;
    const std::string bytes = std::to_string(slowest->waitingBytes());
    slowest->close(std::make_exception_ptr(std::runtime_error("it reads too slowly: " + bytes + " bytes wait for it, and memory is short")));
  });
}

uint16_t Server::port() const { return state_->listener.port(); }

Address Server::address() const {
  Address address{{state_->settings.listen.host, port()}, {}};
  if (state_->settings.identity && state_->settings.token)
    address.credentials = Credentials{state_->settings.identity->fingerprint, *state_->settings.token};
  return address;
}

}  // namespace warpscope::net
