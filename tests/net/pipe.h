// Two streams that are each other's peer, in memory: what is written at one end is there at the other, in no time.
// Without sockets nothing but the clock is waited for, so that tests in virtual time are exact.
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <utility>

#include "net/byte_queue.h"
#include "net/deadline.h"
#include "net/stream.h"

namespace warpscope::net {

class PipeEnd final : public Stream {
 public:
  static std::pair<std::unique_ptr<PipeEnd>, std::unique_ptr<PipeEnd>> makePair(const asio::any_io_executor& executor) {
    const auto shared = std::make_shared<Shared>(executor);
    return {std::unique_ptr<PipeEnd>(new PipeEnd(shared, 0)), std::unique_ptr<PipeEnd>(new PipeEnd(shared, 1))};
  }
  ~PipeEnd() override { close(); }

  using Stream::write;
  Awaitable<size_t> readSome(asio::mutable_buffer buffer) override {
    const std::shared_ptr<Shared> shared = shared_;
    Side& mine = shared->sides[side_];
    Side& other = shared->sides[1 - side_];
    while (true) {
      require(mine, "reading from ");
      if (const size_t count = std::min(buffer.size(), other.sent.size()); count > 0) {
        asio::buffer_copy(buffer, other.sent.front(count));
        other.sent.pop(count);
        shared->changed.cancel();
        co_return count;
      }
      if (other.hasEnded) co_return 0;
      co_await shared->changed.wait();
    }
  }
  Awaitable<void> write(std::span<const asio::const_buffer> buffers) override {
    const std::shared_ptr<Shared> shared = shared_;
    Side& mine = shared->sides[side_];
    for (const asio::const_buffer& buffer : buffers) {
      for (asio::const_buffer rest = buffer; rest.size() > 0;) {
        require(mine, "writing to ");
        const size_t count = std::min(rest.size(), kCapacityBytes - mine.sent.size());
        mine.sent.push(asio::buffer(rest, count));
        rest += count;
        shared->changed.cancel();
        if (count == 0) co_await shared->changed.wait();
      }
    }
  }
  Awaitable<void> finish(TimePoint deadline) override {
    const std::shared_ptr<Shared> shared = shared_;
    shared->sides[side_].hasEnded = true;
    shared->changed.cancel();
    const Watchdog watchdog(executor(), deadline, [this] { close(); });
    std::array<std::byte, 1024> dropped;
    try {
      while (const size_t count = co_await readSome(asio::buffer(dropped))) static_cast<void>(count);
    } catch (const system_error&) {
      // It is closed, or was reset: either is an end.
    }
    close();
  }
  void close() noexcept override { end(false); }
  void abort() noexcept override { end(true); }
  asio::any_io_executor executor() override { return shared_->executor; }
  const std::string& peer() const override { return shared_->names[1 - side_]; }

 private:
  static constexpr size_t kCapacityBytes = 256 << 10;

  struct Side {
    ByteQueue sent;         // and not yet read
    bool hasEnded = false;  // writes no more
    bool isClosed = false;
    bool isReset = false;   // by the other side
  };
  struct Shared {
    explicit Shared(const asio::any_io_executor& of) : executor(of), changed(of) {}

    asio::any_io_executor executor;
    Timer changed;  // without a time: whoever changes something ends all waits
    std::array<Side, 2> sides;
    std::array<std::string, 2> names{"one end of a pipe", "the other end of a pipe"};
  };

  PipeEnd(std::shared_ptr<Shared> shared, size_t side) : shared_(std::move(shared)), side_(side) {}

  void require(const Side& mine, const char* what) const {
    if (mine.isClosed) throw system_error(asio::error::operation_aborted, what + peer());
    if (mine.isReset) throw system_error(asio::error::connection_reset, what + peer());
  }
  void end(bool isAbort) noexcept {
    Side& mine = shared_->sides[side_];
    if (std::exchange(mine.isClosed, true)) return;
    mine.hasEnded = true;
    if (isAbort) shared_->sides[1 - side_].isReset = true;
    shared_->changed.cancel();
  }

  const std::shared_ptr<Shared> shared_;
  const size_t side_;
};

}  // namespace warpscope::net
