// The server's end of the network: greets clients, collects their requests, sends them answers. It knows nothing of rendering.
// One reader and one writer coroutine per client, a deadline on every read and write; see messages.h for what is said.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "net/address.h"
#include "net/byte_budget.h"
#include "net/certificate.h"
#include "net/held_bytes.h"
#include "net/io_thread.h"
#include "net/login_limits.h"
#include "net/places.h"
#include "net/request_queue.h"

namespace warpscope::net {

struct ServerSettings {
  HostPort listen{"127.0.0.1", 0};   ///< port 0 takes a free one
  std::optional<Identity> identity{};  ///< with it TLS; without it only loopback is listened on
  std::optional<Token> token{};        ///< that clients have to show; with an identity, and only then
  SceneFields scene{};                 ///< with 1..kMaxViews views
  /// Of clients. Beyond it the longest idle one goes, as long as there is one.
  PlaceLimits clients{.most = 64, .mostOfAnAddress = 48, .leastIdleness = std::chrono::seconds(1)};
  /// Of connections that have not shown yet who they are. Beyond it the oldest one goes, first of those that have said nothing.
  PlaceLimits greetings{.most = 512, .mostOfAnAddress = 256};
  uint16_t maxDepth = kMaxDepth;     ///< 1..kMaxDepth
  std::chrono::milliseconds firstBytePatience{3000};  ///< for a connection's first byte
  std::chrono::milliseconds greetingPatience{10000};  ///< for TLS and the greetings together; and for a round trip more until the first message
  std::chrono::milliseconds heartbeat{2000};
  std::chrono::milliseconds patience{10000};          ///< without any progress; longer than a heartbeat
  LoginLimits loginLimits{};         ///< of wrong tokens; who exceeds them is not listened to for a while
  std::function<void(const std::string&)> onWrongToken{};  ///< with the address, a line now and then: see login_limiter.h; on the I/O thread
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

  /// What clients ask for. Whoever takes a request answers it, by one of the two below.
  RequestQueue& requests();
  /// Safe on any thread; nothing happens if the client is gone. `head.stages.sendMs` is filled in here. A frame larger than the client takes
  /// becomes a failure that says so. `share` is given back once the payload has been sent or dropped; may be null. `processes` go first,
  /// if there are any, to clients that can hear of them.
  void answer(ClientId client, const FrameHead& head, HeldBytes payload, ByteBudget::SharePtr share = nullptr, std::span<const ProcessFields> processes = {});
  void answer(ClientId client, Failure failure);

  /// Memory is short: parts with the client for which most waits, of those that have let an answer wait for kLongestWait; nothing if there is
  /// none. Safe on any thread.
  void makeRoom();
  /// An honest reader takes an answer within it, or has few bytes waiting.
  static constexpr std::chrono::seconds kLongestWait{2};
  /// Who waits for one answer for longer than this keeps no place where others need it.
  static constexpr std::chrono::seconds kLongestUse{10};

  uint16_t port() const;
  /// What clients connect to, with the fingerprint and the token.
  Address address() const;

 private:
  struct State;
  const std::shared_ptr<IoThread> io_;
  std::shared_ptr<State> state_;
};

}  // namespace warpscope::net
