// Accepting, greeting, one session per client.
// See server.h.
#include "net/server.h"

#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <stdexcept>

#include "net/reading.h"
#include "net/tcp_stream.h"
#include "net/tls_stream.h"

namespace warpscope::net {
namespace {

/// What is on its way to a client.
struct Outgoing {
  std::optional<FrameHead> frame;  ///< if it is one, whose head is written when its turn comes
  Bytes bytes;                     ///< the payload, or the whole message
  TimePoint readyAt;
};

/// What is wrong with the settings, or nothing.
std::string faultOf(const ServerSettings& settings) {
  constexpr std::chrono::hours kLongest{1};
  if (settings.identity.has_value() != settings.token.has_value()) return "a certificate and a token go together";
  if (!settings.identity && !isLoopback(settings.listen.host)) return "others can reach it, which needs a certificate and a token";
  if (settings.scene.views.empty() || settings.scene.views.size() > kMaxViews)
    return "a scene has 1 to " + std::to_string(kMaxViews) + " views, not " + std::to_string(settings.scene.views.size());
  if (settings.maxDepth < 1 || settings.maxDepth > kMaxDepth)
    return "1 to " + std::to_string(kMaxDepth) + " requests can be under way, not " + std::to_string(settings.maxDepth);
  if (settings.heartbeat < std::chrono::milliseconds(1) || settings.patience <= settings.heartbeat || settings.patience > kLongest)
    return "heartbeats need at least 1 ms, and patience more than a heartbeat and at most an hour";
  return {};
}

}  // namespace

/// What the server's threads share. Everything but the queue belongs to the I/O thread.
struct Server::State : std::enable_shared_from_this<State> {
  State(IoThread& thread, ServerSettings theSettings)
      : io(thread.context()),
        clock(thread.clock()),
        settings(std::move(theSettings)),
        listener(io.get_executor(), settings.listen.host, settings.listen.port),
        sceneBytes(sceneMessage(settings.scene)) {}

  void note(const std::string& text) const {
    if (settings.onNote) settings.onNote(text);
  }

  Awaitable<void> acceptAll();
  Awaitable<void> serve(uint64_t greeting, std::unique_ptr<TcpStream> tcp);
  Awaitable<std::unique_ptr<Stream>> secured(std::unique_ptr<TcpStream> tcp, TimePoint deadline);
  /// The hello of a client that may stay.
  Awaitable<std::optional<ClientHello>> greet(Stream& stream, TimePoint deadline);
  Awaitable<void> turnAway(Stream& stream, TimePoint deadline, Verdict verdict, std::string why);
  Awaitable<void> reply(Stream& stream, TimePoint deadline, ServerHello hello);
  void begin();
  void end();

  asio::io_context& io;
  Clock& clock;
  const ServerSettings settings;
  TcpListener listener;
  const Bytes sceneBytes;
  TlsStream::Context tls;
  RequestQueue queue;
  std::map<ClientId, std::shared_ptr<Session>> sessions;
  std::map<uint64_t, Stream*> greetings;  // to be aborted when the server stops
  uint64_t lastGreeting = 0;
  ClientId lastClient = 0;
  bool isStopped = false;

  std::mutex mutex;  // of the number of coroutines that still run
  std::condition_variable ended;
  size_t running = 0;
};

/// One client that has been let in.
class Server::Session : public std::enable_shared_from_this<Session>, private FromClient {
 public:
  Session(std::shared_ptr<State> server, ClientId id, std::unique_ptr<Stream> stream, uint16_t depth, uint64_t maxFrameBytes)
      : server_(std::move(server)),
        id_(id),
        // Its first message comes a round trip after the welcome, of which nothing is known yet.
        channel_(std::move(stream), server_->settings.patience + server_->settings.greetingPatience),
        depth_(depth),
        maxFrameBytes_(maxFrameBytes),
        wake_(channel_.stream().executor()),
        writerEnd_(channel_.stream().executor()) {}

  /// Reads until the client leaves; throws what made it end otherwise.
  Awaitable<void> read() { return readClient(channel_, *this); }

  /// Writes until the session is closed; throws what made it end otherwise.
  Awaitable<void> write() {
    co_await channel_.write(server_->sceneBytes, "sending the scene");
    TimePoint lastSaid = now();
    while (!isClosed_) {
      if (pong_) {
        const Bytes message = beatMessage(MessageType::pong, *std::exchange(pong_, std::nullopt));
        co_await channel_.write(message, "sending a heartbeat");
      } else if (!outgoing_.empty()) {
        const Outgoing next = std::move(outgoing_.front());
        outgoing_.pop_front();
        co_await send(next);
        server_->queue.done(id_);
      } else if (now() - lastSaid >= server_->settings.heartbeat) {
        const Bytes message = beatMessage(MessageType::ping, ++pings_);
        co_await channel_.write(message, "sending a heartbeat");
      } else {
        co_await wake_.waitUntil(lastSaid + server_->settings.heartbeat);
        continue;
      }
      lastSaid = now();
    }
  }

  void put(Outgoing outgoing) {
    // No more than `depth` requests are given out for a client, so no more answers can wait here.
    if (!isClosed_ && outgoing_.size() < depth_) outgoing_.push_back(std::move(outgoing));
    wake_.wake();
  }

  /// Ends both coroutines; null if that was the client's wish.
  void close(const std::exception_ptr& why) {
    reason_.add(why);
    isClosed_ = true;
    channel_.stream().abort();
    wake_.wake();
  }
  void writerBegins() { isWriting_ = true; }
  void writerEnds(const std::exception_ptr& why) {
    close(why);
    isWriting_ = false;
    writerEnd_.wake();
  }
  Awaitable<void> untilWriterEnds() {
    while (isWriting_) co_await writerEnd_.waitUntil(now() + std::chrono::seconds(1));
  }
  /// Known when both have ended.
  const Reason& reason() const { return reason_; }

 private:
  TimePoint now() const { return server_->clock.now(); }

  bool onRequest(const FrameRequest& request) override {
    channel_.setPatience(server_->settings.patience);
    return server_->queue.put(id_, request, now());
  }
  void onPing(uint64_t number) override {
    channel_.setPatience(server_->settings.patience);
    pong_ = number;  // of several, the last: the answers cannot pile up
    wake_.wake();
  }

  Awaitable<void> send(const Outgoing& next) {
    if (!next.frame) {
      co_await channel_.write(next.bytes, "sending an answer");
      co_return;
    }
    FrameHead head = *next.frame;
    head.stages.sendMs = millisecondsBetween(next.readyAt, now());
    const Bytes message = frameMessage(head, next.bytes.size());
    if (message.size() - kMessageHeadBytes + next.bytes.size() > maxFrameBytes_) {
      const Bytes failure = failureMessage({next.frame->id, "the frame has " + std::to_string(next.bytes.size()) +
                                                                " bytes, more than this client takes"});
      co_await channel_.write(failure, "sending an answer");
      co_return;
    }
    co_await channel_.write(message, "sending a frame");
    co_await channel_.write(next.bytes, "sending a frame");
  }

  const std::shared_ptr<State> server_;
  const ClientId id_;
  Channel channel_;
  const uint16_t depth_;
  const uint64_t maxFrameBytes_;
  Signal wake_;  // the writer
  Signal writerEnd_;
  std::deque<Outgoing> outgoing_;
  std::optional<uint64_t> pong_;
  uint64_t pings_ = 0;
  bool isClosed_ = false;
  bool isWriting_ = false;
  Reason reason_;
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

Awaitable<void> Server::State::acceptAll() {
  while (!isStopped) {
    std::unique_ptr<TcpStream> tcp;
    try {
      tcp = co_await listener.accept();
    } catch (const system_error&) {
      continue;  // closed, or nothing that would come again
    }
    if (isStopped) break;
    if (greetings.size() >= settings.maxGreetings) {
      note(tcp->peer() + " turned away: too many connections that have not shown who they are");
      tcp->abort();
      continue;
    }
    // Known from here on, so that stop() finds it even before its coroutine has begun.
    const uint64_t greeting = ++lastGreeting;
    greetings[greeting] = tcp.get();
    begin();
    asio::co_spawn(
        io, [self = shared_from_this(), greeting, shared = std::make_shared<std::unique_ptr<TcpStream>>(std::move(tcp))]() {
          return self->serve(greeting, std::move(*shared));
        },
        [self = shared_from_this()](const std::exception_ptr&) { self->end(); });
  }
}

Awaitable<std::unique_ptr<Stream>> Server::State::secured(std::unique_ptr<TcpStream> tcp, TimePoint deadline) {
  if (!tls) co_return std::move(tcp);
  co_return co_await acceptTls(std::move(tcp), tls, deadline);
}

Awaitable<void> Server::State::reply(Stream& stream, TimePoint deadline, ServerHello hello) {
  const Bytes bytes = toBytes(hello);
  co_await withDeadline(stream, deadline, "answering the greeting", stream.write(asio::buffer(bytes)));
}

/// Says why, and sees to it that it arrives.
Awaitable<void> Server::State::turnAway(Stream& stream, TimePoint deadline, Verdict verdict, std::string why) {
  note(stream.peer() + " turned away: " + why);
  ServerHello answer;
  answer.verdict = verdict;
  co_await reply(stream, deadline, answer);
  co_await stream.finish(deadline);
}

Awaitable<std::optional<ClientHello>> Server::State::greet(Stream& stream, TimePoint deadline) {
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
    co_await turnAway(stream, deadline, Verdict::wrongToken, "a wrong token");
  else if (sessions.size() >= settings.maxClients)
    co_await turnAway(stream, deadline, Verdict::full, "no room for another client");
  else
    co_return hello;
  co_return std::nullopt;
}

Awaitable<void> Server::State::serve(uint64_t greeting, std::unique_ptr<TcpStream> tcp) {
  const std::string peer = tcp->peer();
  const TimePoint deadline = clock.now() + settings.greetingPatience;
  std::unique_ptr<Stream> stream;
  std::optional<ClientHello> hello;
  std::string trouble;
  try {
    stream = co_await secured(std::move(tcp), deadline);
    greetings[greeting] = stream.get();
    hello = co_await greet(*stream, deadline);
  } catch (const std::exception& error) {
    trouble = error.what();
  }
  greetings.erase(greeting);
  if (!trouble.empty()) note(peer + " turned away: " + trouble);
  if (!hello || isStopped) co_return;

  ServerHello welcome;
  welcome.capabilities = kCapabilities & hello->capabilities;
  welcome.sessionId = ++lastClient;
  welcome.depth = std::min(hello->depth, settings.maxDepth);
  welcome.heartbeatMs = static_cast<uint32_t>(settings.heartbeat.count());
  welcome.patienceMs = static_cast<uint32_t>(settings.patience.count());
  const ClientId id = lastClient;
  Stream& kept = *stream;
  auto session = std::make_shared<Session>(shared_from_this(), id, std::move(stream), welcome.depth, hello->maxFrameBytes);
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
    for (const auto& [id, stream] : state->greetings) stream->abort();
    const auto why = std::make_exception_ptr(std::runtime_error("the server stopped"));
    for (const auto& [id, session] : std::map(state->sessions)) session->close(why);
  });
  std::unique_lock lock(state_->mutex);
  state_->ended.wait(lock, [this] { return state_->running == 0; });
}

RequestQueue& Server::requests() { return state_->queue; }

void Server::answer(ClientId client, const FrameHead& head, Bytes payload) {
  auto outgoing = std::make_shared<Outgoing>(Outgoing{head, std::move(payload), io_->clock().now()});
  asio::post(io_->context(), [state = state_, client, outgoing] {
    if (const auto found = state->sessions.find(client); found != state->sessions.end()) found->second->put(std::move(*outgoing));
  });
}

void Server::answer(ClientId client, Failure failure) {
  auto outgoing = std::make_shared<Outgoing>(Outgoing{std::nullopt, failureMessage(failure), io_->clock().now()});
  asio::post(io_->context(), [state = state_, client, outgoing] {
    if (const auto found = state->sessions.find(client); found != state->sessions.end()) found->second->put(std::move(*outgoing));
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
