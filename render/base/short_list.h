// A list of few elements with a known most, held in place: for settings, which are copied and compared.
// Mirrors what is needed of std::inplace_vector (C++26).
#pragma once

#include <array>
#include <cstddef>

namespace warpscope {

/// Up to kMostElements; those that are not there are T{}, so that lists are equal where their elements are.
template <class T, size_t kMostElements>
class ShortList {
 public:
  static constexpr size_t kMost = kMostElements;

  constexpr ShortList() = default;

  const T* begin() const { return elements_.data(); }
  const T* end() const { return elements_.data() + size_; }
  size_t size() const { return size_; }
  /// Throws std::out_of_range where the list is full.
  constexpr void add(const T& element) { elements_.at(size_++) = element; }

  bool operator==(const ShortList&) const = default;

 private:
  std::array<T, kMost> elements_{};
  size_t size_ = 0;
};

}  // namespace warpscope
