// Pieces, each under its own deadline.
// See channel.h.
#include "net/channel.h"

#include <algorithm>

namespace warpscope::net {

Awaitable<void> Channel::read(std::span<std::byte> bytes, std::string what) {
  while (!bytes.empty()) {
    const size_t most = std::min(bytes.size(), kPieceBytes);
    const size_t got = co_await withDeadline(*stream_, deadline(), what,
                                             stream_->readSome(asio::buffer(bytes.data(), most)));
    if (got == 0) throw system_error(asio::error::make_error_code(asio::error::eof), stream_->peer() + " ended in the middle of " + what);
    bytes = bytes.subspan(got);
  }
}

Awaitable<std::optional<MessageHead>> Channel::readHead() {
  std::array<std::byte, kMessageHeadBytes> bytes;
  const size_t got = co_await withDeadline(*stream_, deadline(), "waiting for a message",
                                           stream_->readSome(asio::buffer(bytes)));
  if (got == 0) co_return std::nullopt;
  co_await read(std::span(bytes).subspan(got), "a message's head");
  const std::optional<MessageHead> head = readMessageHead(bytes);
  if (!head) throw ProtocolError(stream_->peer() + " sent what is no message");
  co_return head;
}

Awaitable<Bytes> Channel::readBody(MessageHead head, size_t largest) {
  if (head.bodyBytes > largest)
    throw ProtocolError(stream_->peer() + " announced a message of " + std::to_string(head.bodyBytes) + " bytes, where " +
                        std::to_string(largest) + " are the most");
  Bytes body;
  while (body.size() < head.bodyBytes) {
    // As much again as has come, so that a length alone costs no memory.
    const size_t have = body.size(), wanted = std::min<size_t>(head.bodyBytes, std::max(2 * have, kPieceBytes));
    body.reserve(wanted);  // no more than that, as resize() alone would
    body.resize(wanted);
    co_await read(std::span(body).subspan(have), "a message");
  }
  co_return body;
}

Awaitable<void> Channel::write(ByteView bytes, std::string what) {
  while (!bytes.empty()) {
    const size_t most = std::min(bytes.size(), kPieceBytes);
    co_await withDeadline(*stream_, deadline(), what,
                          stream_->write(asio::buffer(bytes.data(), most)));
    bytes = bytes.subspan(most);
  }
}

void Reason::add(const std::exception_ptr& failure) {
  if (!failure || failure_) return;
  try {
    std::rethrow_exception(failure);
  } catch (const system_error& error) {
    if (error.code() == asio::error::operation_aborted) return;
  } catch (...) {
  }
  failure_ = failure;
}

std::string Reason::sentence() const {
  if (!failure_) return {};
  try {
    std::rethrow_exception(failure_);
  } catch (const std::exception& error) {
    return error.what();
  } catch (...) {
    return "an unknown failure";
  }
}

}  // namespace warpscope::net
