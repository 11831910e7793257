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
  /// Of a container of bytes, which is moved, and goes with the last of the copies.
  template <class Container>
    requires(!std::is_reference_v<Container> && !std::is_const_v<Container> && !std::same_as<Container, HeldBytes>)
  HeldBytes(Container&& bytes) {
    struct Held {
      explicit Held(Container own) : container(std::move(own)), bytes(container) {}
      const Container container;
      const std::span<const std::byte> bytes;
    };
    const auto held = std::make_shared<const Held>(std::move(bytes));
    bytes_ = {held, &held->bytes};
  }

  size_t size() const { return bytes_ ? bytes_->size() : 0; }
  bool empty() const { return size() == 0; }
  operator std::span<const std::byte>() const { return bytes_ ? *bytes_ : std::span<const std::byte>(); }

 private:
  std::shared_ptr<const std::span<const std::byte>> bytes_;  // none after a move
};

}  // namespace warpscope::net
