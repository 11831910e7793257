// Messages between ranks as bytes: values as they are in memory, since all ranks run the same program on the same kind of processor.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <new>
#include <span>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <vector>

namespace warpscope {

class RankWriter {
 public:
  template <class T>
  RankWriter& put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    append(&value, sizeof value);
    return *this;
  }
  /// How many there are, and they.
  template <class Range>
  RankWriter& putAll(const Range& values) {
    static_assert(std::is_trivially_copyable_v<typename Range::value_type>);
    put(static_cast<uint64_t>(values.size()));
    append(values.data(), values.size() * sizeof(typename Range::value_type));
    return *this;
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  void append(const void* from, size_t size) {
    const auto* const first = static_cast<const std::byte*>(from);
    bytes_.insert(bytes_.end(), first, first + size);
  }

  std::vector<std::byte> bytes_;
};

/// What a RankWriter wrote, in its order. Throws std::runtime_error where there is no more.
class RankReader {
 public:
  explicit RankReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <class T>
  T get() {
    static_assert(std::is_trivially_copyable_v<T>);
    alignas(T) std::byte held[sizeof(T)];
    std::memcpy(held, next(sizeof(T)).data(), sizeof(T));
    return *std::launder(reinterpret_cast<T*>(held));
  }
  template <class Range>
  void getAll(Range& values) {
    using Value = typename Range::value_type;
    const auto count = get<uint64_t>();
    if (count > bytes_.size() / sizeof(Value)) throwShort();
    values.resize(count);
    if (count > 0) std::memcpy(values.data(), next(count * sizeof(Value)).data(), count * sizeof(Value));
  }
  bool isAtEnd() const { return bytes_.empty(); }

 private:
  [[noreturn]] static void throwShort() { throw std::runtime_error("a message between processes is too short"); }
  std::span<const std::byte> next(size_t size) {
    if (size > bytes_.size()) throwShort();
    const std::span<const std::byte> taken = bytes_.first(size);
    bytes_ = bytes_.subspan(size);
    return taken;
  }

  std::span<const std::byte> bytes_;
};

}  // namespace warpscope
