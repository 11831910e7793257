// Bytes that are sent later, in whatever memory who made them had for them.
#pragma once

#include <concepts>
#include <cstddef>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>

namespace warpscope::net {

class HeldBytes {
 public:
  HeldBytes() = default;
  /// Of a container of bytes, which is moved or copied, and goes with the last of its copies.
  template <class Container>
    requires(!std::same_as<std::remove_cvref_t<Container>, HeldBytes>)
  HeldBytes(Container&& bytes) {
    auto held = std::make_shared<const std::remove_cvref_t<Container>>(std::forward<Container>(bytes));
    bytes_ = std::span<const std::byte>(*held);
    holder_ = std::move(held);
  }

  size_t size() const { return bytes_.size(); }
  bool empty() const { return bytes_.empty(); }
  operator std::span<const std::byte>() const { return bytes_; }

 private:
  std::span<const std::byte> bytes_;
  std::shared_ptr<const void> holder_;
};

}  // namespace warpscope::net
