// Sums stay in registers, four vectors of them at a time.
// See filters.h.
#include "render/metrics/filters.h"

#include "render/core/simd.h"

namespace warpscope {
namespace {

constexpr size_t kLanes = kBatchLanes;
constexpr size_t kAtOnce = 4 * kLanes;

/// out[i] = sum over j of kernel[j] * from(j)[i], for i in [0, stride).
template <class From>
void weightedSum(std::span<const float> kernel, size_t stride, float* out, bool adds, const From& from) {
  for (size_t i = 0; i < stride; i += kAtOnce) {
    FloatBatch a(0.0f), b(0.0f), c(0.0f), d(0.0f);
    if (adds) {
      a = FloatBatch::load_unaligned(out + i);
      b = FloatBatch::load_unaligned(out + i + kLanes);
      c = FloatBatch::load_unaligned(out + i + 2 * kLanes);
      d = FloatBatch::load_unaligned(out + i + 3 * kLanes);
    }
    for (size_t j = 0; j < kernel.size(); ++j) {
      const FloatBatch tap(kernel[j]);
      const float* const values = from(j) + i;
      a = mulAdd(tap, FloatBatch::load_unaligned(values), a);
      b = mulAdd(tap, FloatBatch::load_unaligned(values + kLanes), b);
      c = mulAdd(tap, FloatBatch::load_unaligned(values + 2 * kLanes), c);
      d = mulAdd(tap, FloatBatch::load_unaligned(values + 3 * kLanes), d);
    }
    a.store_unaligned(out + i);
    b.store_unaligned(out + i + kLanes);
    c.store_unaligned(out + i + 2 * kLanes);
    d.store_unaligned(out + i + 3 * kLanes);
  }
}

}  // namespace

size_t rowStride(uint32_t width) { return (width + kAtOnce - 1) / kAtOnce * kAtOnce; }

void RowStrip::filterPadded(std::span<const float> kernel, float* out) const {
  weightedSum(kernel, stride_, out, false, [&](size_t j) { return padded_.data() + j; });
}

void RowStrip::filterColumns(uint32_t y, std::span<const float> kernel, float* out, bool adds) const {
  const auto radius = static_cast<std::ptrdiff_t>(kernel.size() / 2), first = static_cast<std::ptrdiff_t>(first_);
  weightedSum(kernel, stride_, out, adds, [&](size_t j) {
    const std::ptrdiff_t row = std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(y + j) - radius, first, last_);
    return values_.data() + stride_ * static_cast<size_t>(row - first);
  });
}

}  // namespace warpscope
