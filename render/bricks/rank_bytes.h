// Messages between ranks as bytes: values as they are in memory, since all ranks run the same program on the same kind of processor.
#pragma once

#include <array>
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

/// Of 32 bits, the last one filled up.
template <class T>
inline constexpr size_t wordsOf = (sizeof(T) + sizeof(uint32_t) - 1) / sizeof(uint32_t);

/// A value of which most is as `usual`, word by word: a mark for each word that is not, and those words. Both ends have the same `usual`.
template <class T>
struct WordsBeside {
  using Marks = std::array<uint8_t, (wordsOf<T> + 7) / 8>;

  WordsBeside(const T& value, const T& usual) {
    static_assert(std::is_trivially_copyable_v<T>);
    std::array<uint32_t, wordsOf<T>> all{}, before{};
    std::memcpy(all.data(), &value, sizeof value);
    std::memcpy(before.data(), &usual, sizeof usual);
    for (size_t i = 0; i < all.size(); ++i) {
      const bool isOther = all[i] != before[i];
      marks[i / 8] |= static_cast<uint8_t>(static_cast<unsigned>(isOther) << (i % 8));
      words[count] = all[i];
      count += isOther ? 1 : 0;
    }
  }
  static bool isMarked(const Marks& marks, size_t word) { return (marks[word / 8] >> (word % 8) & 1) != 0; }
  /// Back. `wordAt(i)` is asked for the i-th word where it is marked, in their order.
  template <class WordAt>
  static T valueOf(const T& usual, const Marks& marks, const WordAt& wordAt) {
    std::array<uint32_t, wordsOf<T>> all{};
    std::memcpy(all.data(), &usual, sizeof usual);
    for (size_t i = 0; i < all.size(); ++i)
      if (isMarked(marks, i)) all[i] = wordAt(i);
    T value = usual;
    std::memcpy(static_cast<void*>(&value), all.data(), sizeof value);
    return value;
  }

  Marks marks{};
  std::array<uint32_t, wordsOf<T>> words{};  ///< the first `count` of them
  size_t count = 0;
};

class RankWriter {
 public:
  template <class T>
  RankWriter& put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    append(&value, sizeof value);
    return *this;
  }
  /// WordsBeside.
  template <class T>
  RankWriter& putBeside(const T& value, const T& usual, size_t /*column: PackedWriter's*/ = 0) {
    const WordsBeside<T> beside(value, usual);
    append(beside.marks.data(), beside.marks.size());
    append(beside.words.data(), beside.count * sizeof(uint32_t));
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
  /// What another one has written.
  RankWriter& append(std::span<const std::byte> bytes) {
    append(bytes.data(), bytes.size());
    return *this;
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  void append(const void* from, size_t size) {
    if (size == 0) return;
    const size_t before = bytes_.size();
    bytes_.resize(before + size);
    std::memcpy(bytes_.data() + before, from, size);
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
  template <class T>
  T getBeside(const T& usual, size_t /*column*/ = 0) {
    const auto marks = get<typename WordsBeside<T>::Marks>();
    return WordsBeside<T>::valueOf(usual, marks, [&](size_t) { return get<uint32_t>(); });
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
  std::span<const std::byte> rest() const { return bytes_; }

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
