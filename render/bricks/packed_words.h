// Messages between ranks on different machines, packed: what RankWriter would write one after the other, in streams of like things.
// Of values beside others (WordsBeside) each word is in a column of its own, less the one above it, a byte at a time: neighbouring rays have like signs and exponents. Entropy
// coding by Zstandard (zstd_section.h); transposing bytes of like numbers as in Masui et al. 2015 ("bitshuffle").
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "render/bricks/rank_bytes.h"

namespace warpscope {

class PackedWriter {
 public:
  template <class T>
  PackedWriter& put(const T& value) {
    plain_.put(value);
    return *this;
  }
  template <class Range>
  PackedWriter& putAll(const Range& values) {
    plain_.putAll(values);
    return *this;
  }
  /// As RankWriter's; `first`: the column of the value's first word, the others follow it.
  template <class T>
  PackedWriter& putBeside(const T& value, const T& usual, size_t first) {
    const WordsBeside<T> beside(value, usual);
    plain_.put(beside.marks);
    if (columns_.size() < first + wordsOf<T>) columns_.resize(first + wordsOf<T>);
    for (size_t i = 0, next = 0; i < wordsOf<T>; ++i)
      if (beside.isMarked(beside.marks, i)) columns_[first + i].push_back(beside.words[next++]);
    return *this;
  }
  std::vector<std::byte> take();

 private:
  RankWriter plain_;
  std::vector<std::vector<uint32_t>> columns_;
};

/// What a PackedWriter wrote, in its order. Throws std::runtime_error where it did not.
class PackedReader {
 public:
  explicit PackedReader(std::span<const std::byte> bytes);
  PackedReader(const PackedReader&) = delete;  // one part reads the other
  PackedReader& operator=(const PackedReader&) = delete;

  template <class T>
  T get() {
    return reader_.get<T>();
  }
  template <class Range>
  void getAll(Range& values) {
    reader_.getAll(values);
  }
  template <class T>
  T getBeside(const T& usual, size_t first) {
    const auto marks = reader_.get<typename WordsBeside<T>::Marks>();
    return WordsBeside<T>::valueOf(usual, marks, [&](size_t i) { return nextOf(first + i); });
  }
  bool isAtEnd() const { return reader_.isAtEnd(); }

 private:
  uint32_t nextOf(size_t column);

  std::vector<uint8_t> plain_;
  std::vector<std::vector<uint32_t>> columns_;
  std::vector<size_t> read_;  // of each column
  RankReader reader_{{}};
};

}  // namespace warpscope
