// Loops over arrays of floats by vectors as wide as the processor's, the rest one by one; and sums that do not depend on the number of threads.
// Host only.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <functional>

#include "render/core/simd.h"

namespace warpscope {

template <class Real>
inline Real loadAs(const float* from);
template <>
inline FloatBatch loadAs<FloatBatch>(const float* from) {
  return FloatBatch::load_unaligned(from);
}
template <>
inline float loadAs<float>(const float* from) {
  return *from;
}
inline void storeTo(float* to, const FloatBatch& value) { value.store_unaligned(to); }
inline void storeTo(float* to, float value) { *to = value; }

inline float sumOf(const FloatBatch& value) {
  alignas(64) float lanes[kBatchLanes];
  value.store_aligned(lanes);
  float sum = 0.0f;
  for (const float lane : lanes) sum += lane;
  return sum;
}

/// Calls body.template operator()<Real>(i) for 0 <= i < count, with FloatBatch for as many at once as fit, then with float.
template <class Body>
void forBatches(size_t count, const Body& body) {
  size_t i = 0;
  for (; i + kBatchLanes <= count; i += kBatchLanes) body.template operator()<FloatBatch>(i);
  for (; i < count; ++i) body.template operator()<float>(i);
}

/// Sum of body(begin, end), an additive value whose default is zero, over fixed pieces of [0, count) in parallel: the same whatever the number
/// of threads.
template <class Sum, class Body>
Sum sumOverPieces(size_t count, size_t piece, const Body& body) {
  return tbb::parallel_deterministic_reduce(
      tbb::blocked_range<size_t>(0, count, piece), Sum{},
      [&](const tbb::blocked_range<size_t>& range, Sum partial) { return partial + body(range.begin(), range.end()); }, std::plus<>());
}

}  // namespace warpscope
