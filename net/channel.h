// Messages over a stream, with the deadlines that both sides keep: what client and server sessions share.
// A deadline is for progress, not for a message: a large frame may take long on a slow link, as long as some of it keeps coming.
#pragma once

#include <exception>
#include <memory>
#include <stdexcept>
#include <string>

#include "net/deadline.h"
#include "net/messages.h"
#include "net/stream.h"

namespace warpscope::net {

/// The other side does not keep to the protocol. The sentence says where.
class ProtocolError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Largest piece that is read or written under one deadline: at most this much has to pass within it.
inline constexpr size_t kPieceBytes = 64 << 10;

class Channel {
 public:
  /// `patience`: how long the other side may leave a read or a write without any progress.
  Channel(std::unique_ptr<Stream> stream, Duration patience)
      : stream_(std::move(stream)), clock_(clockOf(stream_->executor())), patience_(patience) {}

  Stream& stream() { return *stream_; }
  Clock& clock() const { return clock_; }
  void setPatience(Duration patience) { patience_ = patience; }

  /// Fills `bytes`. Throws system_error, also at an end.
  Awaitable<void> read(std::span<std::byte> bytes, std::string what);
  /// The head of the next message; nothing at a clean end between messages. Throws ProtocolError.
  Awaitable<std::optional<MessageHead>> readHead();
  /// A body of at most `largest` bytes; memory grows with what arrives. Throws ProtocolError for a longer one.
  Awaitable<Bytes> readBody(MessageHead head, size_t largest);

  /// All of it, piece by piece.
  Awaitable<void> write(ByteView bytes, std::string what);

 private:
  TimePoint deadline() const { return clock_.now() + patience_; }

  std::unique_ptr<Stream> stream_;
  Clock& clock_;
  Duration patience_;
};

/// Why a connection ended: its first failure, leaving aside operation_aborted, which only follows from closing it.
class Reason {
 public:
  void add(const std::exception_ptr& failure);
  /// Null if nothing failed.
  const std::exception_ptr& failure() const { return failure_; }
  /// Empty if nothing failed.
  std::string sentence() const;

 private:
  std::exception_ptr failure_;
};

/// Wakes one coroutine that waits, from the same executor. A wake-up that comes first is not lost.
class Signal {
 public:
  explicit Signal(const asio::any_io_executor& executor) : timer_(executor) {}

  void wake() {
    isSet_ = true;
    timer_.cancel();
  }
  /// Until wake() or `time`.
  Awaitable<void> waitUntil(TimePoint time) {
    if (!isSet_) {
      timer_.setTo(time);
      co_await timer_.wait();
    }
    isSet_ = false;
  }

 private:
  Timer timer_;
  bool isSet_ = false;
};

}  // namespace warpscope::net
