// Separable filters over strips of rows, so that what passes from the filter along rows to the one along columns stays in the cache.
// Beyond the border the outermost pixel goes on. Kernels have an odd number of taps, the middle one on the pixel itself; they are not mirrored.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <span>
#include <vector>

#include "render/core/image.h"
#include "render/core/parallel.h"

namespace warpscope {

/// Rows that are filtered at once; wider strips filter fewer rows twice, narrower ones need less cache.
inline constexpr uint32_t kStripRows = 32;

/// Floats that a row buffer needs for `width` pixels: filters write whole vectors.
size_t rowStride(uint32_t width);

/// A row buffer of `width` pixels.
inline std::vector<float> rowBuffer(uint32_t width) { return std::vector<float>(rowStride(width)); }

/// Some rows of a plane after a filter along x, for a filter along y.
class RowStrip {
 public:
  /// Takes rows [begin - margin, end + margin) of a plane of width x height pixels, as far as it has them, and filters them:
  /// out(x) = sum over j of kernel[j] * in(x + j - radius). readRow(y, to) writes row y.
  template <class ReadRow>
  void filter(uint32_t width, uint32_t height, uint32_t begin, uint32_t end, size_t margin, std::span<const float> kernel,
              const ReadRow& readRow) {
    first_ = begin - std::min(begin, static_cast<uint32_t>(margin));
    last_ = static_cast<uint32_t>(std::min<size_t>(end + margin, height)) - 1;
    stride_ = rowStride(width);
    values_.resize(std::max(values_.size(), stride_ * (last_ - first_ + 1)));
    const size_t radius = kernel.size() / 2;
    padded_.resize(std::max(padded_.size(), stride_ + 2 * radius));
    for (uint32_t y = first_; y <= last_; ++y) {
      float* const row = padded_.data() + radius;
      readRow(y, row);
      std::fill_n(padded_.data(), radius, row[0]);
      std::fill_n(row + width, radius, row[width - 1]);
      filterPadded(kernel, values_.data() + stride_ * (y - first_));
    }
  }

  /// Of rows of a plane that is there.
  void filter(const Image<float>& in, uint32_t begin, uint32_t end, size_t margin, std::span<const float> kernel) {
    filter(in.width(), in.height(), begin, end, margin, kernel, [&](uint32_t y, float* to) { std::copy_n(in.row(y), in.width(), to); });
  }

  /// Row y filtered along y as well: out(x) = sum over j of kernel[j] * row(y + j - radius)(x), added to what is there if `adds`. `out` is a row
  /// buffer; y lies within the strip, and the margin was the kernel's radius or more.
  void filterColumns(uint32_t y, std::span<const float> kernel, float* out, bool adds = false) const;

 private:
  void filterPadded(std::span<const float> kernel, float* out) const;

  uint32_t first_ = 0, last_ = 0;  // rows
  size_t stride_ = 0;
  std::vector<float> values_, padded_;
};

/// Sum of body(begin, end, scratch) over the strips of `height` rows, in parallel, the same whatever the number of threads. Each thread has a
/// Scratch of its own.
template <class Scratch, class Body>
double sumOverStrips(uint32_t height, const Body& body) {
  std::vector<double> sums((height + kStripRows - 1) / kStripRows);
  tbb::enumerable_thread_specific<Scratch> scratches;
  parallelForRanges(sums.size(), 1, [&](size_t first, size_t last) {
    for (size_t strip = first; strip < last; ++strip) {
      const auto begin = static_cast<uint32_t>(strip) * kStripRows;
      sums[strip] = body(begin, std::min(begin + kStripRows, height), scratches.local());
    }
  });
  return std::accumulate(sums.begin(), sums.end(), 0.0);
}

}  // namespace warpscope
