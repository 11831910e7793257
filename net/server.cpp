// Accepting, greeting, one session per client.
// See server.h.
#include "net/server.h"

#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <stdexcept>

#include "net/channel.h"
#include "net/tcp_stream.h"
#include "net/tls_stream.h"

namespace warpscope::net {
namespace {

TimePoint now() { return std::chrono::steady_clock::now(); }

double millisecondsSince(TimePoint time) { return std::chrono::duration<double, std::milli>(now() - time).count(); }

/// What is on its way to a client.
struct Outgoing {
  std::optional<FrameHead> frame;  ///< if it is one, whose head is written when its turn comes
  Bytes bytes;                     ///< the payload, or the whole message
  TimePoint readyAt;
};

}  // namespace

/// What the server's threads share. Everything but the queue belongs to the I/O thread.
struct Server::State : std::enable_shared_from_this<State> {
  State(asio::io_context& theIo, ServerSettings theSettings)
      : io(theIo),
        settings(std::move(theSettings)),
        listener(io.get_executor(), settings.listen.host, settings.listen.port),
        sceneBytes(sceneMessage(settings.scene)) {}

  void note(const std::string& text) const {
    if (settings.onNote) settings.onNote(text);
  }

  Awaitable<void> acceptAll();
  Awaitable<void> serve(std::unique_ptr<TcpStream> tcp);
  Awaitable<std::unique_ptr<Stream>> secured(std::unique_ptr<TcpStream> tcp, TimePoint deadline);
  /// The hello of a client that may stay.
  Awaitable<std::optional<ClientHello>> greet(Stream& stream, TimePoint deadline);
  Awaitable<void> reply(Stream& stream, TimePoint deadline, ServerHello hello);
  void begin();
  void end();

  asio::io_context& io;
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
class Server::Session : public std::enable_shared_from_this<Session> {
 public:
  Session(std::shared_ptr<State> server, ClientId id, std::unique_ptr<Stream> stream, uint16_t depth, uint64_t maxFrameBytes)
      : server_(std::move(server)),
        id_(id),
        channel_(std::move(stream), server_->settings.patience),
        depth_(depth),
        maxFrameBytes_(maxFrameBytes),
        wake_(channel_.stream().executor()) {}

  const std::string& peer() { return channel_.stream().peer(); }

  /// Reads until the client leaves; throws what made it end otherwise.
  Awaitable<void> read() {
    while (const std::optional<MessageHead> head = co_await channel_.readHead()) {
      const bool isRequest = head->type == MessageType::request;
      if (!isRequest && head->type != MessageType::ping && head->type != MessageType::pong)
        throw ProtocolError(peer() + " sent a message that clients do not send");
      const Bytes body = co_await channel_.readBody(*head, isRequest ? kRequestBytes : kBeatBytes);
      if (isRequest) {
        const std::optional<FrameRequest> request = readRequest(body);
        if (!request) throw ProtocolError(peer() + " sent a damaged request");
        if (!server_->queue.put(id_, *request, now())) throw ProtocolError(peer() + " sent a request out of order");
      } else if (const std::optional<uint64_t> beat = readBeat(body); !beat) {
        throw ProtocolError(peer() + " sent a damaged heartbeat");
      } else if (head->type == MessageType::ping) {
        pong_ = *beat;  // of several, the last: the answers cannot pile up
        wake_.wake();
      }
    }
  }

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

  void close() {
    isClosed_ = true;
    channel_.stream().abort();
    wake_.wake();
  }

 private:
  Awaitable<void> send(const Outgoing& next) {
    if (!next.frame) {
      co_await channel_.write(next.bytes, "sending an answer");
      co_return;
    }
    if (kFrameHeadBytes + next.bytes.size() > maxFrameBytes_) {
      const Bytes message = failureMessage({next.frame->id, "the frame has " + std::to_string(next.bytes.size()) +
                                                                " bytes, more than this client takes"});
      co_await channel_.write(message, "sending an answer");
      co_return;
    }
    FrameHead head = *next.frame;
    head.stages.sendMs = millisecondsSince(next.readyAt);
    const Bytes message = frameMessage(head, next.bytes.size());
    co_await channel_.write(message, "sending a frame");
    co_await channel_.write(next.bytes, "sending a frame");
  }

  const std::shared_ptr<State> server_;
  const ClientId id_;
  Channel channel_;
  const uint16_t depth_;
  const uint64_t maxFrameBytes_;
  Signal wake_;
  std::deque<Outgoing> outgoing_;
  std::optional<uint64_t> pong_;
  uint64_t pings_ = 0;
  bool isClosed_ = false;
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
    if (greetings.size() >= settings.maxGreetings) {
      note(tcp->peer() + " turned away: too many connections that have not shown who they are");
      tcp->abort();
      continue;
    }
    begin();
    asio::co_spawn(
        io, [self = shared_from_this(), shared = std::make_shared<std::unique_ptr<TcpStream>>(std::move(tcp))]() {
          return self->serve(std::move(*shared));
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

Awaitable<std::optional<ClientHello>> Server::State::greet(Stream& stream, TimePoint deadline) {
  std::array<std::byte, kClientHelloBytes> bytes;
  co_await withDeadline(stream, deadline, "reading the greeting", readExactly(stream, asio::buffer(bytes)));
  if (!hasMagic(bytes)) {
    note(stream.peer() + " turned away: it does not speak this protocol");
    co_return std::nullopt;
  }
  const std::optional<ClientHello> hello = readClientHello(bytes);
  ServerHello answer;
  if (!hello) {
    note(stream.peer() + " turned away: its greeting is damaged");
    co_return std::nullopt;
  }
  if (hello->version != kProtocolVersion)
    answer.verdict = Verdict::otherVersion;
  else if (settings.token && !(hello->token && *hello->token == *settings.token))
    answer.verdict = Verdict::wrongToken;
  else if (sessions.size() >= settings.maxClients)
    answer.verdict = Verdict::full;
  if (answer.verdict == Verdict::welcome) co_return hello;
  constexpr const char* kReasons[] = {"", "another version of the protocol", "a wrong token", "no room for another client"};
  note(stream.peer() + " turned away: " + kReasons[static_cast<size_t>(answer.verdict)]);
  co_await reply(stream, deadline, answer);
  co_await stream.finish(deadline);
  co_return std::nullopt;
}

Awaitable<void> Server::State::serve(std::unique_ptr<TcpStream> tcp) {
  const std::string peer = tcp->peer();
  const uint64_t greeting = ++lastGreeting;
  const TimePoint deadline = now() + settings.greetingPatience;
  greetings[greeting] = tcp.get();
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
  begin();
  try {
    co_await reply(kept, deadline, welcome);
    // The writer beside the reader; whichever ends first ends the other.
    asio::co_spawn(
        io, [session] { return session->write(); },
        [self = shared_from_this(), session](const std::exception_ptr&) {
          session->close();
          self->end();
        });
  } catch (const std::exception& error) {
    trouble = error.what();
    end();
  }
  if (trouble.empty()) {
    try {
      co_await session->read();
    } catch (const std::exception& error) {
      trouble = error.what();
    }
  }
  session->close();
  queue.leave(id);
  sessions.erase(id);
  note(peer + " left" + (trouble.empty() ? "" : ": " + trouble));
}

Server::Server(std::shared_ptr<IoThread> io, ServerSettings settings) : io_(std::move(io)) {
  if ((!settings.identity || !settings.token) && !isLoopback(settings.listen.host))
    throw std::invalid_argument("listening on " + toString(settings.listen) +
                                ", which others can reach, needs a certificate and a token");
  state_ = io_->call([&] { return std::make_shared<State>(io_->context(), std::move(settings)); });
  if (state_->settings.identity) state_->tls = makeServerContext(*state_->settings.identity);
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
    for (const auto& [id, session] : std::map(state->sessions)) session->close();
  });
  std::unique_lock lock(state_->mutex);
  state_->ended.wait(lock, [this] { return state_->running == 0; });
}

RequestQueue& Server::requests() { return state_->queue; }

void Server::answer(ClientId client, const FrameHead& head, Bytes payload) {
  auto outgoing = std::make_shared<Outgoing>(Outgoing{head, std::move(payload), now()});
  asio::post(io_->context(), [state = state_, client, outgoing] {
    if (const auto found = state->sessions.find(client); found != state->sessions.end()) found->second->put(std::move(*outgoing));
  });
}

void Server::answer(ClientId client, Failure failure) {
  auto outgoing = std::make_shared<Outgoing>(Outgoing{std::nullopt, failureMessage(failure), now()});
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
