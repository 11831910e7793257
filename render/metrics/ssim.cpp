// Means, variances and squared differences by separable filters, strip by strip.
// See ssim.h.
#include "render/metrics/ssim.h"

#include "render/metrics/batches.h"
#include "render/metrics/filters.h"
#include "render/metrics/ssim_formulas.h"

namespace warpscope {
namespace {

const auto& window() {
  static const auto kWindow = ssimWindow();
  return kWindow;
}

/// Means of a plane's window less kSsimCenter, and variances.
struct Moments {
  RowStrip values, squares;
  std::vector<float> means, variances;  ///< of the row last asked for

  void filter(const Image<float>& plane, uint32_t begin, uint32_t end) {
    const auto filterBy = [&](RowStrip& strip, const auto& valueOf) {
      strip.filter(plane.width(), plane.height(), begin, end, kSsimRadius, window(), [&](uint32_t y, float* to) {
        const float* const row = plane.row(y);
        forBatches(plane.width(), [&]<class Real>(size_t x) { storeTo(to + x, valueOf(loadAs<Real>(row + x) - Real(kSsimCenter))); });
      });
    };
    filterBy(values, [](const auto& value) { return value; });
    filterBy(squares, [](const auto& value) { return value * value; });
    means.resize(rowStride(plane.width()));
    variances.resize(means.size());
  }
  void atRow(uint32_t y) {
    values.filterColumns(y, window(), means.data());
    squares.filterColumns(y, window(), variances.data());
    forBatches(means.size(), [&]<class Real>(size_t x) {
      const Real mean = loadAs<Real>(means.data() + x);
      storeTo(variances.data() + x, loadAs<Real>(variances.data() + x) - mean * mean);
    });
  }
};

struct Scratch {
  Moments moments;
  RowStrip differences;
  std::vector<float> squaredDifferences;
};

}  // namespace

SsimReference::SsimReference(const ColorPlanes& reference) : reference_(&reference) {
  const uint32_t width = reference[0].width(), height = reference[0].height();
  for (size_t c = 0; c < 3; ++c) {
    Channel& channel = channels_[c];
    channel.means.reshape(width, height);
    channel.variances.reshape(width, height);
    sumOverStrips<Moments>(height, [&](uint32_t begin, uint32_t end, Moments& moments) {
      moments.filter(reference[c], begin, end);
      for (uint32_t y = begin; y < end; ++y) {
        moments.atRow(y);
        std::copy_n(moments.means.data(), width, channel.means.row(y));
        std::copy_n(moments.variances.data(), width, channel.variances.row(y));
      }
      return 0.0;
    });
  }
}

double SsimReference::similarity(const ColorPlanes& image) const {
  const uint32_t width = image[0].width(), height = image[0].height();
  const uint32_t marginX = width > 2 * kSsimRadius ? kSsimRadius : 0, marginY = height > 2 * kSsimRadius ? kSsimRadius : 0;
  double sum = 0.0;
  for (size_t c = 0; c < 3; ++c) {
    const Image<float>&values = image[c], &expected = (*reference_)[c];
    const Channel& channel = channels_[c];
    sum += sumOverStrips<Scratch>(height, [&](uint32_t begin, uint32_t end, Scratch& scratch) {
      Moments& moments = scratch.moments;
      auto& differences = scratch.differences;
      auto& squaredDifferences = scratch.squaredDifferences;
      moments.filter(values, begin, end);
      differences.filter(width, height, begin, end, kSsimRadius, window(), [&](uint32_t y, float* to) {
        const float *const a = values.row(y), *const b = expected.row(y);
        forBatches(width, [&]<class Real>(size_t x) {
          const Real apart = loadAs<Real>(a + x) - loadAs<Real>(b + x);
          storeTo(to + x, apart * apart);
        });
      });
      squaredDifferences.resize(rowStride(width));
      double strip = 0.0;
      for (uint32_t y = std::max(begin, marginY); y < std::min(end, height - marginY); ++y) {
        moments.atRow(y);
        differences.filterColumns(y, window(), squaredDifferences.data());
        FloatBatch sums(0.0f);
        forBatches(width - 2 * marginX, [&]<class Real>(size_t i) {
          const size_t x = i + marginX;
          const Real meanA = loadAs<Real>(moments.means.data() + x), meanB = loadAs<Real>(channel.means.row(y) + x);
          const Real similarity = ssimOf(meanA, meanB, loadAs<Real>(moments.variances.data() + x), loadAs<Real>(channel.variances.row(y) + x),
                                         loadAs<Real>(squaredDifferences.data() + x));
          if constexpr (std::is_same_v<Real, float>)
            strip += static_cast<double>(similarity);
          else
            sums += similarity;
        });
        strip += static_cast<double>(sumOf(sums));
      }
      return strip;
    });
  }
  return sum / (3.0 * static_cast<double>(width - 2 * marginX) * (height - 2 * marginY));
}

double ssimSrgb(const Image<glm::vec4>& image, const Image<glm::vec4>& reference, const glm::vec3& background) {
  requireOneSize(image, reference, "SSIM");
  const ColorPlanes expected = srgbPlanes(reference, background, "SSIM");
  return SsimReference(expected).similarity(srgbPlanes(image, background, "SSIM"));
}

}  // namespace warpscope
