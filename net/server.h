// The server's end of the network: greets clients, collects their requests, sends them answers. It knows nothing of rendering.
// One reader and one writer coroutine per client, a deadline on every read and write; see messages.h for what is said.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "net/address.h"
#include "net/certificate.h"
#include "net/io_thread.h"
#include "net/request_queue.h"

namespace warpscope::net {

struct ServerSettings {
  HostPort listen{"127.0.0.1", 0};   ///< port 0 takes a free one
  std::optional<Identity> identity{};  ///< with it TLS; without it only loopback is listened on
  std::optional<Token> token{};        ///< that clients have to show; with an identity, and only then
  SceneFields scene{};                 ///< with 1..kMaxViews views
  size_t maxClients = 64;
  size_t maxGreetings = 32;          ///< connections that have not shown yet who they are
  uint16_t maxDepth = kMaxDepth;     ///< 1..kMaxDepth
  std::chrono::milliseconds greetingPatience{10000};  ///< for TLS and the greetings together; and for a round trip more until the first message
  std::chrono::milliseconds heartbeat{2000};
  std::chrono::milliseconds patience{10000};          ///< without any progress; longer than a heartbeat
  std::function<void(const std::string&)> onNote{};    ///< what happens, for logs; on the I/O thread. Never holds a token
};

class Server {
 public:
  /// Listens. Throws std::invalid_argument for settings that cannot be, such as an address beyond loopback without identity and token, and
  /// system_error if it cannot be listened on.
  Server(std::shared_ptr<IoThread> io, ServerSettings settings);
  /// As stop().
  ~Server();

  /// Listens no more and ends all connections; returns when they have ended.
  void stop();

  /// What clients ask for. Whoever takes a request answers it, by one of the two below, each client's in the order in which they were taken.
  RequestQueue& requests();
  /// Safe on any thread; nothing happens if the client is gone. `head.stages.sendMs` is filled in here.
  void answer(ClientId client, const FrameHead& head, Bytes payload);
  void answer(ClientId client, Failure failure);

  uint16_t port() const;
  /// What clients connect to, with the fingerprint and the token.
  Address address() const;

 private:
  class Session;
  struct State;
  const std::shared_ptr<IoThread> io_;
  std::shared_ptr<State> state_;
};

}  // namespace warpscope::net
