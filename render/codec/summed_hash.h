// Hashes that are sums of what each word adds at its place (placedHash), made on all cores.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "render/codec/bytes.h"
#include "render/core/parallel.h"
#include "render/core/placed_hash.h"

namespace warpscope {

/// What words `wordAt(i)` from `begin` to `end` add, whose places are `first` further on.
template <class WordAt>
uint64_t placedHashes(size_t begin, size_t end, const WordAt& wordAt, uint64_t first) {
  uint64_t sum = 0;
  for (size_t i = begin; i < end; ++i) sum += placedHash(wordAt(i), first + i);
  return sum;
}

/// Of `count` words, whose places begin at `first`.
template <class WordAt>
uint64_t summedHash(size_t count, uint64_t first, const WordAt& wordAt) {
  constexpr size_t kGrain = size_t{1} << 15;
  std::atomic<uint64_t> sum = 0;
  parallelForRanges(count, kGrain, [&](size_t begin, size_t end) { sum += placedHashes(begin, end, wordAt, first); });
  return sum;
}

}  // namespace warpscope
