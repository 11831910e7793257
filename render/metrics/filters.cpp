// Tap by tap over whole rows, which compilers turn into vector code.
// See filters.h.
#include "render/metrics/filters.h"

#include <algorithm>
#include <vector>

#include "render/core/parallel.h"

namespace warpscope {
namespace {

constexpr size_t kRowsPerPiece = 16;

void addScaled(float* __restrict to, const float* __restrict from, float factor, size_t count) {
  for (size_t i = 0; i < count; ++i) to[i] += factor * from[i];
}

}  // namespace

void filterRows(const Image<float>& in, std::span<const float> kernel, Image<float>& out) {
  out.reshape(in.width(), in.height());
  const size_t width = in.width(), radius = kernel.size() / 2;
  parallelForRanges(in.height(), kRowsPerPiece, [&](size_t begin, size_t end) {
    std::vector<float> padded(width + 2 * radius);
    for (size_t y = begin; y < end; ++y) {
      const float* row = in.row(static_cast<uint32_t>(y));
      std::fill_n(padded.begin(), radius, row[0]);
      std::copy_n(row, width, padded.begin() + static_cast<std::ptrdiff_t>(radius));
      std::fill_n(padded.end() - static_cast<std::ptrdiff_t>(radius), radius, row[width - 1]);
      float* to = out.row(static_cast<uint32_t>(y));
      std::fill_n(to, width, 0.0f);
      for (size_t j = 0; j < kernel.size(); ++j) addScaled(to, padded.data() + j, kernel[j], width);
    }
  });
}

void filterColumns(const Image<float>& in, std::span<const float> kernel, Image<float>& out, bool adds) {
  if (!adds) out.reshape(in.width(), in.height());
  const auto height = static_cast<std::ptrdiff_t>(in.height()), radius = static_cast<std::ptrdiff_t>(kernel.size() / 2);
  parallelForRanges(in.height(), kRowsPerPiece, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      float* to = out.row(static_cast<uint32_t>(y));
      if (!adds) std::fill_n(to, in.width(), 0.0f);
      for (size_t j = 0; j < kernel.size(); ++j) {
        const auto from = std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(y + j) - radius, 0, height - 1);
        addScaled(to, in.row(static_cast<uint32_t>(from)), kernel[j], in.width());
      }
    }
  });
}

}  // namespace warpscope
