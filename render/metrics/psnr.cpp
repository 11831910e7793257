// Both pictures pass through small blocks that stay in the cache: no plane is ever whole in memory. Blocks are summed in double.
// See psnr.h.
#include "render/metrics/psnr.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "render/metrics/batches.h"

namespace warpscope {
namespace {

constexpr size_t kPixelsPerPiece = 1 << 14;
constexpr size_t kBlockPixels = 512;  // few enough to be summed in float

/// As a display shows some pixels.
struct Block {
  alignas(64) float srgb[3][kBlockPixels];

  [[nodiscard]] bool fill(const glm::vec4* pixels, size_t count, const glm::vec3& background) {
    return displayPixels(pixels, count, background, {}, {srgb[0], srgb[1], srgb[2]});
  }
};

/// Sum of (a - b)^2 of a block.
double squaredDifference(const float* a, const float* b, size_t count) {
  FloatBatch sums(0.0f);
  float rest = 0.0f;
  forBatches(count, [&]<class Real>(size_t i) {
    const Real difference = loadAs<Real>(a + i) - loadAs<Real>(b + i);
    if constexpr (std::is_same_v<Real, float>)
      rest += difference * difference;
    else
      sums = mulAdd(difference, difference, sums);
  });
  return static_cast<double>(sumOf(sums)) + static_cast<double>(rest);
}

/// Sum of body(begin, count) over the blocks of `size` pixels.
template <class Body>
double sumOverBlocks(size_t size, const Body& body) {
  return sumOverPieces<double>(size, kPixelsPerPiece, [&](size_t begin, size_t end) {
    double sum = 0.0;
    for (size_t at = begin; at < end; at += kBlockPixels) sum += body(at, std::min(kBlockPixels, end - at));
    return sum;
  });
}

}  // namespace

double sumOfSquares(const ColorPlanes& a, const ColorPlanes& b) {
  return sumOverBlocks(a[0].size(), [&](size_t at, size_t count) {
    double sum = 0.0;
    for (size_t channel = 0; channel < 3; ++channel) sum += squaredDifference(&a[channel][at], &b[channel][at], count);
    return sum;
  });
}

double psnrOfSquares(double squares, size_t pixels) {
  if (squares == 0.0) return std::numeric_limits<double>::infinity();
  return -10.0 * std::log10(squares / (3.0 * static_cast<double>(pixels)));
}

double psnrSrgb(const Image<glm::vec4>& image, const Image<glm::vec4>& reference, const glm::vec3& background) {
  requireOneSize(image, reference, "PSNR");
  std::atomic<bool> isFinite = true;
  const double squares = sumOverBlocks(image.size(), [&](size_t at, size_t count) {
    Block a, b;
    const bool isFiniteA = a.fill(image.data() + at, count, background), isFiniteB = b.fill(reference.data() + at, count, background);
    if (!isFiniteA || !isFiniteB) isFinite = false;
    double sum = 0.0;
    for (int channel = 0; channel < 3; ++channel) sum += squaredDifference(a.srgb[channel], b.srgb[channel], count);
    return sum;
  });
  if (!isFinite) refuseNonFinite("PSNR");
  return psnrOfSquares(squares, image.size());
}

}  // namespace warpscope
