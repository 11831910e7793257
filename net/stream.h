// Bytes in both directions: what the protocol is written against, be it TCP, TLS or a simulated link.
// Everything about a stream happens on its executor, which must run one handler at a time (one thread, or a strand).
#pragma once

#include <span>
#include <string>

#include "net/asio.h"

namespace warpscope::net {

/// One coroutine may read while another one writes, but no two do the same. Operations that fail throw boost::system::system_error with a
/// sentence that names the peer. A stream must outlive the operations on it: close it and let them end first.
class Stream {
 public:
  virtual ~Stream() = default;

  /// Reads at least one byte into `buffer`, which is not empty, and returns how many; 0 at a clean end, and from then on.
  virtual Awaitable<size_t> readSome(asio::mutable_buffer buffer) = 0;

  /// Writes all of the buffers. They, and the span of them, stay untouched until then.
  virtual Awaitable<void> write(std::span<const asio::const_buffer> buffers) = 0;
  Awaitable<void> write(asio::const_buffer buffer);

  /// The last words: the peer reads everything written and then a clean end. Waits for the peer's own end, and closes. A read under way
  /// goes on, later ones fail as after close(); what the peer still sends is dropped. No write may be under way. Never throws: at
  /// `deadline` it closes and returns.
  virtual Awaitable<void> finish(TimePoint deadline) = 0;

  /// Ends operations under way with operation_aborted; later ones fail the same way. What was written before may still arrive, but only
  /// finish() makes sure of it. Calling it again does nothing.
  virtual void close() noexcept = 0;
  /// Like close(), but what has not left yet is dropped and the peer's next operation fails: its connection was reset.
  virtual void abort() noexcept = 0;

  virtual asio::any_io_executor executor() = 0;
  /// Whom the bytes go to, for people: "127.0.0.1:4711", "[::1]:4711".
  virtual const std::string& peer() const = 0;
};

/// Fills `buffer`. An end before that is an error (eof).
Awaitable<void> readExactly(Stream& stream, asio::mutable_buffer buffer);

/// Fills `buffer` and returns true, or returns false at a clean end before its first byte. An end after that is an error (eof).
Awaitable<bool> readExactlyOrEnd(Stream& stream, asio::mutable_buffer buffer);

}  // namespace warpscope::net
