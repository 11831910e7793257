// Means, variances and covariance by separable filters.
// See ssim.h.
#include "render/metrics/ssim.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <array>
#include <cmath>
#include <functional>

#include "render/core/parallel.h"
#include "render/metrics/displayed.h"
#include "render/metrics/filters.h"

namespace warpscope {
namespace {

constexpr int kRadius = 5;
constexpr float kDeviation = 1.5f;
constexpr float kC1 = 0.01f * 0.01f, kC2 = 0.03f * 0.03f;  // of values 0..1

std::array<float, 2 * kRadius + 1> gaussian() {
  std::array<float, 2 * kRadius + 1> kernel;
  float sum = 0.0f;
  for (int i = -kRadius; i <= kRadius; ++i)
    sum += kernel[static_cast<size_t>(i + kRadius)] = std::exp(-0.5f * static_cast<float>(i * i) / (kDeviation * kDeviation));
  for (float& tap : kernel) tap /= sum;
  return kernel;
}

/// Planes that are used for every channel.
struct Scratch {
  Image<float> product, between;
  Image<float> meanA, meanB, meanAA, meanBB, meanAB;
};

void blur(const Image<float>& in, Scratch& scratch, Image<float>& out) {
  static const auto kKernel = gaussian();
  filterRows(in, kKernel, scratch.between);
  filterColumns(scratch.between, kKernel, out);
}

void blurProduct(const Image<float>& a, const Image<float>& b, Scratch& scratch, Image<float>& out) {
  scratch.product.reshape(a.width(), a.height());
  parallelForRanges(a.size(), 1 << 15, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) scratch.product[i] = a[i] * b[i];
  });
  blur(scratch.product, scratch, out);
}

double meanSimilarity(const Image<float>& a, const Image<float>& b, Scratch& s) {
  blur(a, s, s.meanA);
  blur(b, s, s.meanB);
  blurProduct(a, a, s, s.meanAA);
  blurProduct(b, b, s, s.meanBB);
  blurProduct(a, b, s, s.meanAB);
  const uint32_t marginX = a.width() > 2 * kRadius ? kRadius : 0, marginY = a.height() > 2 * kRadius ? kRadius : 0;
  const double sum = tbb::parallel_deterministic_reduce(
      tbb::blocked_range<uint32_t>(marginY, a.height() - marginY, 16), 0.0,
      [&](const tbb::blocked_range<uint32_t>& rows, double partial) {
        for (uint32_t y = rows.begin(); y < rows.end(); ++y)
          for (uint32_t x = marginX; x < a.width() - marginX; ++x) {
            const float ma = s.meanA(x, y), mb = s.meanB(x, y);
            const float varianceA = s.meanAA(x, y) - ma * ma, varianceB = s.meanBB(x, y) - mb * mb;
            const float covariance = s.meanAB(x, y) - ma * mb;
            partial += static_cast<double>((2.0f * ma * mb + kC1) * (2.0f * covariance + kC2) /
                                           ((ma * ma + mb * mb + kC1) * (varianceA + varianceB + kC2)));
          }
        return partial;
      },
      std::plus<>());
  return sum / (static_cast<double>(a.width() - 2 * marginX) * (a.height() - 2 * marginY));
}

}  // namespace

double ssimSrgb(const Image<glm::vec4>& image, const Image<glm::vec4>& reference, const glm::vec3& background) {
  requireOneSize(image, reference, "SSIM");
  const DisplayedPlanes a = displayedPlanes(image, background, "SSIM"), b = displayedPlanes(reference, background, "SSIM");
  Scratch scratch;
  double sum = 0.0;
  for (size_t channel = 0; channel < 3; ++channel) sum += meanSimilarity(a[channel], b[channel], scratch);
  return sum / 3.0;
}

}  // namespace warpscope
