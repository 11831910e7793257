// Two forms of one formula.
// See textbook_ssim.h.
#include "app/experiment/textbook_ssim.h"

#include <array>
#include <cmath>
#include <vector>

#include "render/core/parallel.h"
#include "render/metrics/ssim_formulas.h"

namespace warpscope {
namespace {

/// Of the window around a pixel: the weighted mean of `value(x, y)`.
template <class Real, class F>
Real windowMean(uint32_t x, uint32_t y, const std::array<Real, 2 * kSsimRadius + 1>& taps, const F& value) {
  Real mean = 0;
  for (int j = -kSsimRadius; j <= kSsimRadius; ++j)
    for (int i = -kSsimRadius; i <= kSsimRadius; ++i)
      mean += taps[static_cast<size_t>(i + kSsimRadius)] * taps[static_cast<size_t>(j + kSsimRadius)] *
              value(static_cast<uint32_t>(static_cast<int>(x) + i), static_cast<uint32_t>(static_cast<int>(y) + j));
  return mean;
}

/// The mean of `similarity(x, y)` over all pixels whose window lies inside; rows in parallel.
template <class F>
double meanOverPixels(uint32_t width, uint32_t height, const F& similarity) {
  std::vector<double> rows(height - 2 * kSsimRadius, 0.0);
  parallelForRanges(rows.size(), 4, [&](size_t begin, size_t end) {
    for (size_t row = begin; row < end; ++row)
      for (uint32_t x = kSsimRadius; x < width - kSsimRadius; ++x)
        rows[row] += static_cast<double>(similarity(x, static_cast<uint32_t>(row) + kSsimRadius));
  });
  double sum = 0.0;
  for (const double row : rows) sum += row;
  return sum / (static_cast<double>(rows.size()) * (width - 2 * kSsimRadius));
}

}  // namespace

double textbookSsim(const ColorPlanes& a, const ColorPlanes& b) {
  constexpr float kC1 = 0.01f * 0.01f, kC2 = 0.03f * 0.03f;
  const auto taps = ssimWindow();
  double sum = 0.0;
  for (size_t c = 0; c < a.size(); ++c)
    sum += meanOverPixels(a[c].width(), a[c].height(), [&](uint32_t x, uint32_t y) {
      const auto mean = [&](const auto& value) { return windowMean<float>(x, y, taps, value); };
      const Image<float>&p = a[c], &q = b[c];
      const float meanA = mean([&](uint32_t i, uint32_t j) { return p(i, j); });
      const float meanB = mean([&](uint32_t i, uint32_t j) { return q(i, j); });
      const float varianceA = mean([&](uint32_t i, uint32_t j) { return p(i, j) * p(i, j); }) - meanA * meanA;
      const float varianceB = mean([&](uint32_t i, uint32_t j) { return q(i, j) * q(i, j); }) - meanB * meanB;
      const float covariance = mean([&](uint32_t i, uint32_t j) { return p(i, j) * q(i, j); }) - meanA * meanB;
      return (2.0f * meanA * meanB + kC1) * (2.0f * covariance + kC2) /
             ((meanA * meanA + meanB * meanB + kC1) * (varianceA + varianceB + kC2));
    });
  return sum / static_cast<double>(a.size());
}

double exactSsim(const Image<float>& a, const Image<float>& b) {
  std::array<double, 2 * kSsimRadius + 1> taps;
  double sum = 0.0;
  for (int i = -kSsimRadius; i <= kSsimRadius; ++i) sum += taps[static_cast<size_t>(i + kSsimRadius)] = std::exp(-0.5 * i * i / 2.25);
  for (double& tap : taps) tap /= sum;
  return meanOverPixels(a.width(), a.height(), [&](uint32_t x, uint32_t y) {
    constexpr double kC1 = 1e-4, kC2 = 9e-4;
    const auto mean = [&](const auto& value) { return windowMean<double>(x, y, taps, value); };
    const auto at = [](const Image<float>& plane, uint32_t i, uint32_t j) { return static_cast<double>(plane(i, j)); };
    const double meanA = mean([&](uint32_t i, uint32_t j) { return at(a, i, j); });
    const double meanB = mean([&](uint32_t i, uint32_t j) { return at(b, i, j); });
    const auto deviationA = [&](uint32_t i, uint32_t j) { return at(a, i, j) - meanA; };
    const auto deviationB = [&](uint32_t i, uint32_t j) { return at(b, i, j) - meanB; };
    const double varianceA = mean([&](uint32_t i, uint32_t j) { return deviationA(i, j) * deviationA(i, j); });
    const double varianceB = mean([&](uint32_t i, uint32_t j) { return deviationB(i, j) * deviationB(i, j); });
    const double covariance = mean([&](uint32_t i, uint32_t j) { return deviationA(i, j) * deviationB(i, j); });
    return (2.0 * meanA * meanB + kC1) * (2.0 * covariance + kC2) /
           ((meanA * meanA + meanB * meanB + kC1) * (varianceA + varianceB + kC2));
  });
}

}  // namespace warpscope
