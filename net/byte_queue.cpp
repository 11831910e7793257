// The ring.
// See byte_queue.h.
#include "net/byte_queue.h"

#include <algorithm>

namespace warpscope::net {
namespace {

constexpr size_t kSmallest = 64 << 10;  // kept even when empty

}  // namespace

void ByteQueue::push(asio::const_buffer bytes) {
  if (size_ + bytes.size() > ring_.size()) {
    std::vector<std::byte> larger(std::max({kSmallest, 2 * ring_.size(), size_ + bytes.size()}));
    asio::buffer_copy(asio::buffer(larger), front(size_));
    ring_ = std::move(larger);
    begin_ = 0;
  }
  if (bytes.size() == 0) return;
  const size_t end = (begin_ + size_) % ring_.size(), first = std::min(bytes.size(), ring_.size() - end);
  asio::buffer_copy(asio::buffer(&ring_[end], first), bytes);
  asio::buffer_copy(asio::buffer(ring_), bytes + first);
  size_ += bytes.size();
}

std::array<asio::const_buffer, 2> ByteQueue::front(size_t count) const {
  const size_t first = std::min(count, ring_.size() - begin_);
  return {asio::const_buffer(ring_.data() + begin_, first), asio::const_buffer(ring_.data(), count - first)};
}

void ByteQueue::pop(size_t count) {
  size_ -= count;
  begin_ = size_ == 0 ? 0 : (begin_ + count) % ring_.size();
  if (size_ == 0 && ring_.size() > kSmallest) clear();
}

void ByteQueue::clear() {
  ring_ = {};
  begin_ = size_ = 0;
}

}  // namespace warpscope::net
