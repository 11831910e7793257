// TCP: connecting to a name by whichever of its addresses answers, listening, and streams over the connections.
// Options of sockets: RFC 9293 (reset), RFC 5482 (user timeout), Linux tcp(7).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "net/lookup.h"
#include "net/stream.h"
#include "net/timer.h"

namespace warpscope::net {

/// How long a peer may leave what was sent to it unacknowledged before the connection is given up.
inline constexpr std::chrono::seconds kPeerTimeout{20};

/// Who is counted as one: an address of IPv4, and of IPv6 the half that names a network, as whoever has one of its addresses has them all.
/// RFC 4291, section 2.5.
asio::ip::address networkOf(const asio::ip::address& address);

class TcpStream final : public Stream {
 public:
  /// Takes a connected socket, and sets it up: no delay for small writes (Nagle), keep-alive, kPeerTimeout.
  explicit TcpStream(asio::ip::tcp::socket socket);

  using Stream::write;
  Awaitable<size_t> readSome(asio::mutable_buffer buffer) override;
  Awaitable<void> write(std::span<const asio::const_buffer> buffers) override;
  Awaitable<void> finish(TimePoint deadline) override;
  void close() noexcept override;
  void abort() noexcept override;
  asio::any_io_executor executor() override { return socket_.get_executor(); }
  const std::string& peer() const override { return peer_; }

  /// Until there is something to read, an end included.
  Awaitable<void> waitReadable();
  /// Ends what waits, with operation_aborted; the stream goes on.
  void cancel() noexcept;
  /// The peer's networkOf, as a text.
  const std::string& network() const { return network_; }

  bool isClosed() const { return isClosed_; }
  /// For what is built on top of it.
  asio::ip::tcp::socket& socket() { return socket_; }

 private:
  Awaitable<void> dropUntilEnd();

  asio::ip::tcp::socket socket_;
  std::string peer_, network_;
  Timer readDone_;  // waited for by finish(), woken by the reader
  bool isReading_ = false;
  bool hasEnded_ = false;  // Asio reports an end once: a second read would wait for ever
  bool isFinishing_ = false;
  bool isClosed_ = false;
};

/// Tries the addresses of `host` (a name, or an IPv4 or IPv6 address without brackets) one after the other; none may take more than its
/// share of the time that is left. Throws DeadlineExceeded, or system_error with the last reason.
Awaitable<std::unique_ptr<TcpStream>> connectTcp(asio::any_io_executor executor, std::string host, uint16_t port,
                                                 TimePoint deadline, Resolver resolver = resolveBySystem);

class TcpListener {
 public:
  /// Listens on the first address of `host` that can be had; port 0 takes a free one. Looking up a name may take a while: it blocks.
  /// Throws system_error.
  TcpListener(asio::any_io_executor executor, const std::string& host, uint16_t port);

  /// The next connection. Connections that failed meanwhile are passed over, and while the machine has no descriptors or memory for
  /// another one, this waits, longer each time. Throws DeadlineExceeded (the listener goes on), or operation_aborted after close().
  Awaitable<std::unique_ptr<TcpStream>> accept(std::optional<TimePoint> deadline = {});

  /// Told of each wait for descriptors or memory, with a sentence.
  void onShortage(std::function<void(const std::string&)> callback) { onShortage_ = std::move(callback); }

  void close() noexcept;

  uint16_t port() const { return endpoint_.port(); }
  /// Where it listens: "127.0.0.1:4711", "[::1]:4711".
  std::string address() const;
  /// Only this machine can connect.
  bool isLoopback() const;

 private:
  Awaitable<void> waitForDescriptors(const error_code& reason);

  asio::ip::tcp::acceptor acceptor_;
  asio::ip::tcp::endpoint endpoint_;
  Timer pause_;
  Duration nextPause_;
  std::function<void(const std::string&)> onShortage_;
};

}  // namespace warpscope::net
