// Mean squared error in parallel, summed in double.
// See psnr.h.
#include "render/metrics/psnr.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <cmath>
#include <limits>

#include "render/metrics/displayed.h"

namespace warpscope {

double psnrSrgb(const Image<glm::vec4>& image, const Image<glm::vec4>& reference, const glm::vec3& background) {
  requireOneSize(image, reference, "PSNR");
  const DisplayedPlanes a = displayedPlanes(image, background, "PSNR"), b = displayedPlanes(reference, background, "PSNR");
  // Fixed pieces, summed in order: the same number whatever the number of threads.
  constexpr size_t kPiece = 1 << 14;
  const auto sum = tbb::parallel_deterministic_reduce(
      tbb::blocked_range<size_t>(0, image.size(), kPiece), 0.0,
      [&](const tbb::blocked_range<size_t>& range, double partial) {
        for (size_t i = range.begin(); i < range.end(); ++i) {
          const glm::dvec3 difference(a[0][i] - b[0][i], a[1][i] - b[1][i], a[2][i] - b[2][i]);
          partial += glm::dot(difference, difference);
        }
        return partial;
      },
      std::plus<>());
  if (sum == 0.0) return std::numeric_limits<double>::infinity();
  return -10.0 * std::log10(sum / (3.0 * static_cast<double>(image.size())));
}

}  // namespace warpscope
