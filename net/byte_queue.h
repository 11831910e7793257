// Bytes that wait, first in, first out, in one block of memory that is used again and again.
// A ring buffer that grows as needed and is given back when it has run empty.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "net/asio.h"

namespace warpscope::net {

class ByteQueue {
 public:
  size_t size() const { return size_; }

  void push(asio::const_buffer bytes);
  /// The first `count` bytes, in two parts of which the second may be empty. Valid until the queue changes.
  std::array<asio::const_buffer, 2> front(size_t count) const;
  void pop(size_t count);
  void clear();

 private:
  std::vector<std::byte> ring_;
  size_t begin_ = 0, size_ = 0;
};

}  // namespace warpscope::net
