// Client and server in tests: who is told what, who answers, and peers made of bare sockets that do what no honest program does.
// Everything has a time limit: a hang is a failure.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <thread>

#include "net/client.h"
#include "net/server.h"

namespace warpscope::net {

using namespace std::chrono_literals;
using testing::HasSubstr;

// In real time: for hanging alone, and for tests that are about real time.
inline TimePoint now() { return std::chrono::steady_clock::now(); }
inline double secondsSince(TimePoint begin) { return std::chrono::duration<double>(now() - begin).count(); }
/// Longer than anything takes that works, however busy the machine is.
inline constexpr std::chrono::seconds kHang{60};

inline SceneFields someScene() {
  SceneFields scene;
  scene.name = "scene";
  scene.dims = {4, 5, 6};
  scene.views.push_back({10.0, 20.0, 1.5, 0.0, 0.0});
  return scene;
}

inline FrameRequest requestOf(uint64_t id) {
  FrameRequest request;
  request.id = id;
  return request;
}

inline FrameHead headOf(uint64_t id) {
  FrameHead head;
  head.id = id;
  return head;
}

/// Of a message of any kind.
inline Bytes headOf(MessageType type, uint32_t bodyBytes) {
  Bytes bytes;
  append(bytes, {type, bodyBytes});
  return bytes;
}

inline Bytes operator+(Bytes a, ByteView b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// Until `condition` holds; false if it does not in time.
template <class Condition>
bool comesTrue(Condition condition, Duration patience = kHang) {
  for (const TimePoint limit = now() + patience; now() < limit; std::this_thread::sleep_for(1ms))
    if (condition()) return true;
  return condition();
}

/// What was ready on the thread has run, and what that made ready.
inline void settle(IoThread& io) {
  for (int i = 0; i < 32; ++i) io.call([] {});
}

/// Time as the test lets it pass: none by itself.
class PassingTime {
 public:
  explicit PassingTime(VirtualClock& clock, std::shared_ptr<IoThread> io) : clock_(clock), io_(std::move(io)) {}

  /// All of it at once, after which everything that it made ready has run.
  void jump(Duration duration) const {
    clock_.advance(duration);
    settle(*io_);
  }
  /// Whether somebody comes to wait for the time that is `later` than now.
  bool isAwaited(Duration later) const {
    return comesTrue([&] { return clock_.hasSleeper(clock_.now() + later); });
  }
  /// Jumps there once somebody waits for it and all that is ready has run; false if nobody does.
  bool jumpTo(Duration later) const {
    const TimePoint time = clock_.now() + later;
    if (!comesTrue([&] { return clock_.hasSleeper(time); })) return false;
    settle(*io_);
    jump(time - clock_.now());
    return true;
  }
  /// From one time that somebody waits for to the next one.
  void pass(Duration duration) const {
    const TimePoint end = clock_.now() + duration;
    do settle(*io_);
    while (clock_.advanceToNextSleeper(end));
    jump(end - clock_.now());
  }
  /// The same until `condition` holds. What nobody waits for within `horizon` does not come: deadlines, as opposed to links.
  template <class Condition>
  bool passUntil(Condition condition, Duration horizon = 1s) const {
    return comesTrue([&] {
      settle(*io_);
      if (condition()) return true;
      clock_.advanceToNextSleeper(clock_.now() + horizon);
      return false;
    });
  }
  /// Calls `f`, which waits for the clock, and lets time pass until it returns.
  template <class F>
  void passDuring(F f) const {
    std::atomic<bool> hasReturned = false;
    const std::jthread thread([&] {
      f();
      hasReturned = true;
    });
    while (!hasReturned) {
      std::this_thread::sleep_for(1ms);  // on a busy machine `f` needs its turn as much as time
      settle(*io_);
      if (!hasReturned) clock_.advanceToNextSleeper(clock_.now() + 1s);
    }
  }

 private:
  VirtualClock& clock_;
  const std::shared_ptr<IoThread> io_;
};

/// Keeps what a client is told, and lets a test wait for it.
class Witness : public ClientEvents {
 public:
  void onState(const ConnectionState& state) override { note([&] { states.push_back(state); }); }
  void onScene(const SceneFields& scene) override { note([&] { scenes.push_back(scene); }); }
  std::string faultOf(const FrameHead& head, uint64_t payloadBytes) override { return judge ? judge(head, payloadBytes) : std::string(); }
  void onFrame(Frame frame, const FrameArrival& arrival) override {
    note([&] {
      frames.push_back(std::move(frame));
      arrivals.push_back(arrival);
    });
  }
  void onFailure(const Failure& failure) override { note([&] { failures.push_back(failure); }); }
  void onRoundTrip(Duration duration) override { note([&] { roundTrips.push_back(duration); }); }
  void onBusy(uint16_t others) override { note([&] { busyWith.push_back(others); }); }
  void onProcesses(const std::vector<ProcessFields>& told) override { note([&] { processes.push_back(told); }); }

  template <class Condition>
  bool waitFor(Condition condition, Duration patience = kHang) {
    std::unique_lock lock(mutex);
    return changed.wait_for(lock, patience, condition);
  }
  bool waitForConnection() {
    return waitFor([this] { return isIn(ConnectionPhase::connected); });
  }
  /// The sentence of the next state of that phase.
  std::string sentenceWhen(ConnectionPhase phase) {
    std::unique_lock lock(mutex);
    if (!changed.wait_for(lock, kHang, [&] { return isIn(phase); })) return "no such phase came";
    return states.back().sentence;
  }
  std::optional<Frame> frameOf(uint64_t id, Duration patience = kHang) {
    std::unique_lock lock(mutex);
    const auto find = [&] { return std::ranges::find(frames, id, [](const Frame& frame) { return frame.head.id; }); };
    if (!changed.wait_for(lock, patience, [&] { return find() != frames.end(); })) return std::nullopt;
    return *find();
  }

  template <class F>
  auto look(F f) {
    const std::scoped_lock lock(mutex);
    return f();
  }

  // With the mutex held:
  bool isIn(ConnectionPhase phase) const { return !states.empty() && states.back().phase == phase; }
  bool isConnected() const { return isIn(ConnectionPhase::connected); }
  bool isRefused() const { return isIn(ConnectionPhase::refused); }
  size_t countOf(ConnectionPhase phase) const {
    return static_cast<size_t>(std::ranges::count(states, phase, [](const ConnectionState& state) { return state.phase; }));
  }

  std::function<std::string(const FrameHead&, uint64_t)> judge;  // of frames; set before a client begins
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<ConnectionState> states;
  std::vector<SceneFields> scenes;
  std::vector<Frame> frames;
  std::vector<FrameArrival> arrivals;
  std::vector<Failure> failures;
  std::vector<Duration> roundTrips;
  std::vector<uint16_t> busyWith;
  std::vector<std::vector<ProcessFields>> processes;

 private:
  template <class F>
  void note(F&& f) {
    {
      const std::scoped_lock lock(mutex);
      f();
    }
    changed.notify_all();
  }
};

/// Answers every request with a payload of so many bytes, all of them the request's id.
class Answering {
 public:
  Answering(Server& server, size_t payloadBytes, Duration work = 0s)
      : thread_([this, &server, payloadBytes, work](const std::stop_token& stop) {
          while (const std::optional<RequestJob> job = server.requests().take(stop)) {
            if (work > 0s) std::this_thread::sleep_for(work);
            ++count;
            FrameHead head;
            head.id = job->request.id;
            head.camera = job->request.camera;
            server.answer(job->client, head, Bytes(payloadBytes, static_cast<std::byte>(job->request.id)));
          }
        }) {}

  std::atomic<int> count{0};

 private:
  std::jthread thread_;
};

/// What a server notes.
class Notes {
 public:
  std::function<void(const std::string&)> callback() {
    return [this](const std::string& text) {
      const std::scoped_lock lock(mutex_);
      all_ += text + "\n";
    };
  }
  std::string all() const {
    const std::scoped_lock lock(mutex_);
    return all_;
  }
  bool has(const std::string& part) const {
    return comesTrue([&] { return all().find(part) != std::string::npos; });
  }

 private:
  mutable std::mutex mutex_;
  std::string all_;
};

/// A blocking socket whose every operation ends within `patience`, in real time.
class BareSocket {
 public:
  explicit BareSocket(int handle) : handle_(handle) {}
  BareSocket(BareSocket&& other) noexcept : handle_(std::exchange(other.handle_, -1)) {}
  BareSocket& operator=(BareSocket&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~BareSocket() { close(); }

  /// Connected to the port of this machine. `receiveBytes`: of the socket's buffer. `from`: the last byte of the client's own address,
  /// 127.0.0.`from`, so that a test can have clients of several.
  static BareSocket connect(uint16_t port, int receiveBytes = 0, uint8_t from = 1) {
    BareSocket made(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    sockaddr_in own{};
    own.sin_family = AF_INET;
    own.sin_addr.s_addr = htonl(INADDR_LOOPBACK - 1 + from);
    if (from != 1 && ::bind(made.handle_, reinterpret_cast<const sockaddr*>(&own), sizeof own) != 0) made.close();
    if (receiveBytes > 0) setsockopt(made.handle_, SOL_SOCKET, SO_RCVBUF, &receiveBytes, sizeof receiveBytes);
    const int yes = 1;
    setsockopt(made.handle_, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    sockaddr_in where{};
    where.sin_family = AF_INET;
    where.sin_port = htons(port);
    where.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(made.handle_, reinterpret_cast<const sockaddr*>(&where), sizeof where) != 0) made.close();
    return made;
  }

  int handle() const { return handle_; }
  bool isOpen() const { return handle_ >= 0; }
  void close() {
    if (handle_ >= 0) ::close(std::exchange(handle_, -1));
  }
  /// Unsent bytes are dropped, and the peer is told so.
  void reset() {
    const linger now{1, 0};
    setsockopt(handle_, SOL_SOCKET, SO_LINGER, &now, sizeof now);
    close();
  }
  void endWriting() { ::shutdown(handle_, SHUT_WR); }

  /// False if not all of it can be sent.
  bool send(ByteView bytes, Duration patience = kHang) {
    const TimePoint limit = now() + patience;
    while (!bytes.empty()) {
      if (!wait(POLLOUT, limit)) return false;
      const ssize_t sent = ::send(handle_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
      if (sent < 0 && errno != EAGAIN) return false;
      if (sent > 0) bytes = bytes.subspan(static_cast<size_t>(sent));
    }
    return true;
  }
  bool sendByteByByte(ByteView bytes) {
    for (size_t i = 0; i < bytes.size(); ++i)
      if (!send(bytes.subspan(i, 1))) return false;
    return true;
  }
  /// Fewer at an end, a reset, or when time is up.
  Bytes receive(size_t size, Duration patience = kHang) {
    const TimePoint limit = now() + patience;
    Bytes bytes(size);
    size_t got = 0;
    while (got < size && wait(POLLIN, limit)) {
      const ssize_t count = ::recv(handle_, bytes.data() + got, size - got, MSG_DONTWAIT);
      if (count == 0 || (count < 0 && errno != EAGAIN)) break;
      if (count > 0) got += static_cast<size_t>(count);
    }
    bytes.resize(got);
    return bytes;
  }
  enum class End { none, clean, reset };
  /// How the peer ends the connection in time; what it sends meanwhile is dropped.
  End end(Duration patience = kHang) {
    const TimePoint limit = now() + patience;
    std::array<char, 65536> dropped;
    while (wait(POLLIN, limit)) {
      const ssize_t count = ::recv(handle_, dropped.data(), dropped.size(), MSG_DONTWAIT);
      if (count == 0) return End::clean;
      if (count < 0 && errno != EAGAIN) return End::reset;
    }
    return End::none;
  }
  bool isEnded(Duration patience = kHang) { return end(patience) != End::none; }

  /// The next message: its head and body.
  struct Message {
    MessageType type;
    Bytes body;
  };
  std::optional<Message> receiveMessage(Duration patience = kHang) {
    const std::optional<MessageHead> head = readMessageHead(receive(kMessageHeadBytes, patience));
    if (!head) return std::nullopt;
    Message message{head->type, receive(head->bodyBytes, patience)};
    if (message.body.size() != head->bodyBytes) return std::nullopt;
    return message;
  }
  /// The next frame, of which nothing is kept; false if it does not come whole.
  bool skipFrame(Duration patience = kHang) {
    const TimePoint limit = now() + patience;
    while (true) {
      const std::optional<MessageHead> head = readMessageHead(receive(kMessageHeadBytes, limit - now()));
      if (!head) return false;
      for (size_t left = head->bodyBytes; left > 0;) {
        const size_t got = receive(std::min<size_t>(left, 65536), limit - now()).size();
        if (got == 0) return false;
        left -= got;
      }
      if (head->type == MessageType::frame) return true;
    }
  }
  /// The next message of a type.
  std::optional<Bytes> receiveBody(MessageType type, Duration patience = kHang) {
    for (const TimePoint limit = now() + patience; now() < limit;) {
      const std::optional<Message> message = receiveMessage(limit - now());
      if (!message) return std::nullopt;
      if (message->type == type) return message->body;
    }
    return std::nullopt;
  }

 private:
  bool wait(short events, TimePoint limit) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(limit - now()).count();
    pollfd waiting{handle_, events, 0};
    return handle_ >= 0 && left > 0 && ::poll(&waiting, 1, static_cast<int>(left)) > 0;
  }

  int handle_;
};

/// Listens on a free port of this machine, for a server that is none.
class BareListener {
 public:
  explicit BareListener(int backlog = 16) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in where{};
    where.sin_family = AF_INET;
    where.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof where;
    if (::bind(socket_.handle(), reinterpret_cast<const sockaddr*>(&where), size) != 0 || ::listen(socket_.handle(), backlog) != 0 ||
        ::getsockname(socket_.handle(), reinterpret_cast<sockaddr*>(&where), &size) != 0)
      socket_.close();
    port_ = ntohs(where.sin_port);
  }

  /// Not open if nobody comes in time.
  BareSocket accept(Duration patience = kHang) {
    pollfd waiting{socket_.handle(), POLLIN, 0};
    const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(patience).count();
    if (::poll(&waiting, 1, static_cast<int>(ms)) <= 0) return BareSocket(-1);
    return BareSocket(::accept4(socket_.handle(), nullptr, nullptr, SOCK_CLOEXEC));
  }
  uint16_t port() const { return port_; }
  Address address() const { return {{"127.0.0.1", port_}, {}}; }

 private:
  BareSocket socket_;
  uint16_t port_ = 0;
};

/// A client of bare bytes that has been greeted and has its scene.
inline BareSocket greetedClientAt(uint16_t port, uint16_t depth = 1, int receiveBytes = 0, uint8_t from = 1) {
  BareSocket socket = BareSocket::connect(port, receiveBytes, from);
  ClientHello hello;
  hello.depth = depth;
  socket.send(toBytes(hello));
  const std::optional<ServerHello> answer = readServerHello(socket.receive(kServerHelloBytes));
  if (!answer || answer->verdict != Verdict::welcome || !socket.receiveBody(MessageType::scene)) socket.close();
  return socket;
}

inline BareSocket greetedClient(const Server& server, uint16_t depth = 1, int receiveBytes = 0, uint8_t from = 1) {
  return greetedClientAt(server.port(), depth, receiveBytes, from);
}

/// What a server says first.
inline Bytes welcomeBytes(uint16_t depth = 1, uint32_t heartbeatMs = 1000, uint32_t patienceMs = 5000) {
  ServerHello hello;
  hello.depth = depth;
  hello.heartbeatMs = heartbeatMs;
  hello.patienceMs = patienceMs;
  return toBytes(hello) + sceneMessage(someScene());
}

/// A server of bare bytes, of one client that has been greeted; its hello is read.
inline BareSocket greetedServer(BareListener& listener, uint16_t depth = 1, uint32_t heartbeatMs = 1000, uint32_t patienceMs = 5000) {
  BareSocket socket = listener.accept();
  if (!readClientHello(socket.receive(kClientHelloBytes))) socket.close();
  socket.send(welcomeBytes(depth, heartbeatMs, patienceMs));
  return socket;
}

inline std::optional<FrameRequest> nextRequest(BareSocket& socket, Duration patience = kHang) {
  const std::optional<Bytes> body = socket.receiveBody(MessageType::request, patience);
  return body ? readRequest(*body) : std::nullopt;
}

inline Bytes wholeFrame(uint64_t id, size_t payloadBytes) {
  return frameMessage(headOf(id), payloadBytes) + Bytes(payloadBytes, static_cast<std::byte>(id));
}

inline size_t openFiles() {
  size_t count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) ++count;
  return count;
}

/// Resident.
inline size_t memoryBytes() {
  size_t pages = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> pages >> resident;
  return resident * static_cast<size_t>(sysconf(_SC_PAGESIZE));
}

/// Sanitizers keep freed memory and slow things down.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kIsSanitized = true;
#else
inline constexpr bool kIsSanitized = false;
#endif

}  // namespace warpscope::net
