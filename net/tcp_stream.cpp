// Sockets: connecting, accepting, and what of their errors is passed over, waited out or thrown.
// See tcp_stream.h; errors of accept that concern only the new connection: Linux accept(2).
#include "net/tcp_stream.h"

#include <netinet/tcp.h>

#include <algorithm>
#include <array>
#include <vector>

#include "net/address.h"
#include "net/deadline.h"

namespace warpscope::net {
namespace {

using asio::ip::tcp;

constexpr Duration kFirstPause = std::chrono::milliseconds(10);
constexpr Duration kLongestPause = std::chrono::seconds(1);

// A silent peer is asked for a sign of life after this time, this often, and given up after so many questions.
constexpr int kIdleSeconds = 10, kProbeSeconds = 5, kProbes = 4;

std::string endpointText(const tcp::endpoint& endpoint) { return toString(HostPort{endpoint.address().to_string(), endpoint.port()}); }

template <int level, int name>
using IntegerOption = asio::detail::socket_option::integer<level, name>;

/// What a system does not have, the connection does without.
void setUp(tcp::socket& socket) {
  error_code ignored;
  socket.set_option(tcp::no_delay(true), ignored);
  socket.set_option(tcp::socket::keep_alive(true), ignored);
#if defined(TCP_KEEPIDLE) && defined(TCP_KEEPINTVL) && defined(TCP_KEEPCNT)
  socket.set_option(IntegerOption<IPPROTO_TCP, TCP_KEEPIDLE>(kIdleSeconds), ignored);
  socket.set_option(IntegerOption<IPPROTO_TCP, TCP_KEEPINTVL>(kProbeSeconds), ignored);
  socket.set_option(IntegerOption<IPPROTO_TCP, TCP_KEEPCNT>(kProbes), ignored);
#endif
#if defined(TCP_USER_TIMEOUT)
  const auto timeoutMs = std::chrono::duration_cast<std::chrono::milliseconds>(kPeerTimeout).count();
  socket.set_option(IntegerOption<IPPROTO_TCP, TCP_USER_TIMEOUT>(static_cast<int>(timeoutMs)), ignored);
#endif
}

/// Errors that are over with the connection that they concern. What else goes wrong would go wrong again at once.
bool isOfConnection(const error_code& error) {
  using namespace boost::system::errc;
  return error == connection_aborted || error == protocol_error;
}

/// Errors after which there is nothing more to accept.
bool isEndOfListening(const error_code& error) {
  using namespace boost::system::errc;
  return error == asio::error::operation_aborted || error == bad_file_descriptor || error == invalid_argument ||
         error == not_a_socket;
}

tcp::endpoint listenOn(tcp::acceptor& acceptor, const tcp::endpoint& endpoint) {
  acceptor.open(endpoint.protocol());
  acceptor.set_option(tcp::acceptor::reuse_address(true));
  if (endpoint.address().is_v6()) {
    error_code ignored;
    acceptor.set_option(asio::ip::v6_only(false), ignored);  // "::" means every address, of either kind
  }
  acceptor.bind(endpoint);
  acceptor.listen();
  return acceptor.local_endpoint();
}

}  // namespace

asio::ip::address networkOf(const asio::ip::address& address) {
  if (address.is_v4()) return address;
  const asio::ip::address_v6 whole = address.to_v6();
  if (whole.is_v4_mapped()) return asio::ip::make_address_v4(asio::ip::v4_mapped, whole);
  asio::ip::address_v6::bytes_type bytes = whole.to_bytes();
  std::fill(bytes.begin() + bytes.size() / 2, bytes.end(), static_cast<unsigned char>(0));
  return asio::ip::address_v6(bytes);
}

TcpStream::TcpStream(tcp::socket socket) : socket_(std::move(socket)), readDone_(socket_.get_executor()) {
  setUp(socket_);
  error_code error;
  const tcp::endpoint remote = socket_.remote_endpoint(error);
  peer_ = error ? "a peer that is gone" : endpointText(remote);  // it may leave before anybody looks
  if (!error) network_ = networkOf(remote.address()).to_string();
}

Awaitable<void> TcpStream::waitReadable() {
  error_code error = asio::error::operation_aborted;
  if (!isClosed_) co_await socket_.async_wait(tcp::socket::wait_read, into(error));
  if (isClosed_) error = asio::error::operation_aborted;
  if (error) throw system_error(error, "reading from " + peer_);
}

void TcpStream::cancel() noexcept {
  error_code ignored;
  socket_.cancel(ignored);
}

Awaitable<size_t> TcpStream::readSome(asio::mutable_buffer buffer) {
  error_code error = asio::error::operation_aborted;
  size_t count = 0;
  if (!isClosed_ && !isFinishing_) {
    if (hasEnded_) co_return 0;
    isReading_ = true;
    count = co_await socket_.async_read_some(buffer, into(error));
    isReading_ = false;
    hasEnded_ = error == asio::error::eof;
    readDone_.cancel();
  }
  if (isClosed_) error = asio::error::operation_aborted;
  if (error == asio::error::eof) co_return 0;
  if (error) throw system_error(error, "reading from " + peer_);
  co_return count;
}

Awaitable<void> TcpStream::write(std::span<const asio::const_buffer> buffers) {
  error_code error = asio::error::operation_aborted;
  if (!isClosed_) co_await asio::async_write(socket_, buffers, into(error));
  if (isClosed_) error = asio::error::operation_aborted;
  if (error) throw system_error(error, "writing to " + peer_);
}

Awaitable<void> TcpStream::finish(TimePoint deadline) {
  if (isClosed_ || std::exchange(isFinishing_, true)) co_return;
  error_code error;
  socket_.shutdown(tcp::socket::shutdown_send, error);
  // A socket that is closed with bytes unread resets the connection, and the peer would lose what is still on its way to it.
  const Watchdog watchdog(executor(), deadline, [this] { close(); });
  while (isReading_ && !isClosed_) co_await readDone_.wait();
  if (!hasEnded_ && !isClosed_) co_await dropUntilEnd();
  close();
}

/// Looks at the socket before it waits: its end may have been reported already, to whom this stream does not know (TLS reads past it).
Awaitable<void> TcpStream::dropUntilEnd() {
  std::array<char, 4096> dropped;
  error_code error;
  socket_.non_blocking(true, error);
  while (!isClosed_) {
    socket_.read_some(asio::buffer(dropped), error);
    if (error == asio::error::would_block) co_await socket_.async_wait(tcp::socket::wait_read, into(error));
    if (error) co_return;
  }
}

void TcpStream::close() noexcept {
  if (std::exchange(isClosed_, true)) return;
  error_code ignored;
  socket_.close(ignored);
  readDone_.cancel();
}

void TcpStream::abort() noexcept {
  if (isClosed_) return;
  error_code ignored;
  socket_.set_option(tcp::socket::linger(true, 0), ignored);
  close();
}

Awaitable<std::unique_ptr<TcpStream>> connectTcp(asio::any_io_executor executor, std::string host, uint16_t port,
                                                 TimePoint deadline, Resolver resolver) {
  const std::string whom = toString(HostPort{host, port});
  const std::vector<asio::ip::address> addresses = co_await lookUp(executor, host, deadline, std::move(resolver));
  error_code error = asio::error::host_not_found;
  bool hasExpired = false;
  for (size_t i = 0; i < addresses.size(); ++i) {
    const TimePoint now = clockOf(executor).now();
    const auto addressesLeft = static_cast<Duration::rep>(addresses.size() - i);
    tcp::socket socket(executor);
    const Watchdog watchdog(executor, now + (deadline - now) / addressesLeft, [&socket] {
      error_code ignored;
      socket.close(ignored);
    });
    co_await socket.async_connect(tcp::endpoint(addresses[i], port), into(error));
    hasExpired = watchdog.hasExpired();
    if (!error && !hasExpired) co_return std::make_unique<TcpStream>(std::move(socket));
  }
  if (hasExpired) throw DeadlineExceeded("connecting to " + whom);
  throw system_error(error, "cannot connect to " + whom);
}

TcpListener::TcpListener(asio::any_io_executor executor, const std::string& host, uint16_t port)
    : acceptor_(executor), pause_(executor), nextPause_(kFirstPause) {
  const std::string where = "cannot listen on " + toString(HostPort{host, port});
  error_code error;
  tcp::resolver resolver(executor);
  const auto found = resolver.resolve(host, std::to_string(port), tcp::resolver::passive | tcp::resolver::numeric_service, error);
  if (error) throw system_error(error, where);
  error = asio::error::host_not_found;
  for (const auto& entry : found) {
    try {
      acceptor_ = tcp::acceptor(executor);
      endpoint_ = listenOn(acceptor_, entry.endpoint());
      return;
    } catch (const system_error& failure) {
      error = failure.code();
    }
  }
  throw system_error(error, where);
}

Awaitable<std::unique_ptr<TcpStream>> TcpListener::accept(std::optional<TimePoint> deadline) {
  std::optional<Watchdog> watchdog;
  if (deadline) {
    watchdog.emplace(acceptor_.get_executor(), *deadline, [this] {
      error_code ignored;
      acceptor_.cancel(ignored);
      pause_.cancel();
    });
  }
  while (true) {
    error_code error = asio::error::operation_aborted;
    tcp::socket socket(acceptor_.get_executor());
    if (acceptor_.is_open()) co_await acceptor_.async_accept(socket, into(error));
    if (watchdog && watchdog->hasExpired()) throw DeadlineExceeded("waiting for a connection on " + address());
    if (!error) {
      nextPause_ = kFirstPause;
      co_return std::make_unique<TcpStream>(std::move(socket));
    }
    if (isEndOfListening(error)) throw system_error(error, "waiting for a connection on " + address());
    if (!isOfConnection(error)) co_await waitForDescriptors(error);
    if (watchdog && watchdog->hasExpired()) throw DeadlineExceeded("waiting for a connection on " + address());
  }
}

/// Waits without looking: what is missing shows only when the next connection is accepted.
Awaitable<void> TcpListener::waitForDescriptors(const error_code& reason) {
  if (onShortage_) onShortage_("no connection can be accepted on " + address() + " for now: " + reason.message());
  pause_.setTo(pause_.clock().now() + nextPause_);
  nextPause_ = std::min(2 * nextPause_, kLongestPause);
  co_await pause_.wait();
}

void TcpListener::close() noexcept {
  error_code ignored;
  acceptor_.close(ignored);
  pause_.cancel();
}

std::string TcpListener::address() const { return endpointText(endpoint_); }
bool TcpListener::isLoopback() const { return net::isLoopback(endpoint_.address().to_string()); }

}  // namespace warpscope::net
