// What is the same for every stream.
// See stream.h.
#include "net/stream.h"

namespace warpscope::net {

Awaitable<void> Stream::write(asio::const_buffer buffer) { co_await write(std::span(&buffer, 1)); }

Awaitable<bool> readExactlyOrEnd(Stream& stream, asio::mutable_buffer buffer) {
  size_t done = 0;
  while (done < buffer.size()) {
    const size_t count = co_await stream.readSome(buffer + done);
    if (count == 0 && done == 0) co_return false;
    if (count == 0) {
      throw system_error(asio::error::eof, "reading from " + stream.peer() + ": it ended after " + std::to_string(done) + " of " +
                                               std::to_string(buffer.size()) + " bytes");
    }
    done += count;
  }
  co_return true;
}

Awaitable<void> readExactly(Stream& stream, asio::mutable_buffer buffer) {
  const bool isFilled = co_await readExactlyOrEnd(stream, buffer);
  if (isFilled) co_return;
  throw system_error(asio::error::eof, "reading from " + stream.peer() + ": it ended before the first of " +
                                           std::to_string(buffer.size()) + " bytes");
}

}  // namespace warpscope::net
