// A stream whose other side is a fuzzer's bytes, handed out in pieces of sizes that are the fuzzer's too. No sockets.
// What is written to it is dropped.
#pragma once

#include <algorithm>

#include "net/stream.h"

namespace warpscope::net {

class MemoryStream final : public Stream {
 public:
  /// `pieces`: sizes, used over and over; 0 stands for a pause before one byte. Empty: all at once.
  MemoryStream(asio::any_io_executor executor, std::span<const uint8_t> bytes, std::span<const uint8_t> pieces)
      : executor_(std::move(executor)), rest_(bytes), pieces_(pieces) {}

  using Stream::write;
  Awaitable<size_t> readSome(asio::mutable_buffer buffer) override {
    const size_t piece = pieces_.empty() ? buffer.size() : pieces_[next_++ % pieces_.size()];
    if (piece == 0) co_await asio::post(executor_, asio::use_awaitable);
    if (isClosed_) throw system_error(asio::error::operation_aborted, "reading from memory");
    const size_t count = asio::buffer_copy(buffer, asio::buffer(rest_.data(), rest_.size()), std::max<size_t>(piece, 1));
    rest_ = rest_.subspan(count);
    co_return count;
  }
  Awaitable<void> write(std::span<const asio::const_buffer>) override { co_return; }
  Awaitable<void> finish(TimePoint) override {
    close();
    co_return;
  }
  void close() noexcept override { isClosed_ = true; }
  void abort() noexcept override { isClosed_ = true; }
  asio::any_io_executor executor() override { return executor_; }
  const std::string& peer() const override { return peer_; }

 private:
  const asio::any_io_executor executor_;
  std::span<const uint8_t> rest_;
  const std::span<const uint8_t> pieces_;
  size_t next_ = 0;
  bool isClosed_ = false;
  const std::string peer_ = "a fuzzer";
};

/// Runs `work` to its end. What it may throw is what bytes from elsewhere may cause: anything else is a bug.
template <class Work>
void runOnBytes(asio::io_context& io, Work work) {
  bool hasEnded = false;
  asio::co_spawn(io, std::move(work), [&hasEnded](const std::exception_ptr& failure) {
    hasEnded = true;
    if (!failure) return;
    try {
      std::rethrow_exception(failure);
    } catch (const system_error& error) {
      if (error.code() != asio::error::eof) std::abort();
    } catch (const std::runtime_error&) {  // of the protocol
    }
  });
  io.restart();
  io.run();
  if (!hasEnded) std::abort();
}

/// The first bytes: how many sizes of pieces follow, and these; then what the other side says.
struct FuzzedPeer {
  explicit FuzzedPeer(std::span<const uint8_t> data) {
    const size_t count = data.empty() ? 0 : std::min<size_t>(data[0] % 16, data.size() - 1);
    if (!data.empty()) data = data.subspan(1);
    pieces = data.first(count);
    bytes = data.subspan(count);
  }

  std::span<const uint8_t> pieces, bytes;
};

}  // namespace warpscope::net
