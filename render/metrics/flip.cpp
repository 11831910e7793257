// The colour pipeline and the feature pipeline of the paper, strip by strip; what is done per pixel is vector code.
// See flip.h.
#include "render/metrics/flip.h"

#include "render/base/error.h"
#include "render/metrics/batches.h"
#include "render/metrics/filters.h"
#include "render/metrics/flip_formulas.h"

namespace warpscope {
namespace {

/// What the eye makes of a pixel.
template <class Real>
struct Seen {
  Triple<Real> lab;
  Real edge, point;
};

ColorPlanes opponentPlanes(const ColorPlanes& linear) {
  ColorPlanes opponent;
  for (Image<float>& plane : opponent) plane.reshape(linear[0].width(), linear[0].height());
  parallelForRanges(linear[0].size(), 1 << 14, [&](size_t begin, size_t end) {
    forBatches(end - begin, [&]<class Real>(size_t offset) {
      const size_t i = begin + offset;
      const Triple<Real> color =
          opponentOf(Triple<Real>{loadAs<Real>(&linear[0][i]), loadAs<Real>(&linear[1][i]), loadAs<Real>(&linear[2][i])});
      storeTo(&opponent[0][i], color.x);
      storeTo(&opponent[1][i], color.y);
      storeTo(&opponent[2][i], color.z);
    });
  });
  return opponent;
}

/// Opponent colours of a strip after the filters along rows, and of one row after those along columns.
class SeenStrip {
 public:
  void filter(const ColorPlanes& opponent, const FlipKernels& kernels, uint32_t begin, uint32_t end) {
    const auto rows = [&](RowStrip& strip, size_t channel, const FilterTaps& taps) {
      strip.filter(opponent[channel], begin, end, taps.size() / 2, taps);
    };
    rows(achromatic_, 0, kernels.achromatic.rows);
    rows(redGreen_, 1, kernels.redGreen.rows);
    for (size_t k = 0; k < 2; ++k) rows(blueYellow_[k], 2, kernels.blueYellow[k].rows);
    rows(smooth_, 0, kernels.smooth);
    rows(edge_, 0, kernels.edge);
    rows(point_, 0, kernels.point);
    for (std::vector<float>& row : rows_) row.resize(rowStride(opponent[0].width()));
  }

  void filterRow(const FlipKernels& kernels, uint32_t y) {
    achromatic_.filterColumns(y, kernels.achromatic.columns, rows_[0].data());
    redGreen_.filterColumns(y, kernels.redGreen.columns, rows_[1].data());
    for (size_t k = 0; k < 2; ++k) blueYellow_[k].filterColumns(y, kernels.blueYellow[k].columns, rows_[2].data(), k > 0);
    edge_.filterColumns(y, kernels.smooth, rows_[3].data());
    smooth_.filterColumns(y, kernels.edge, rows_[4].data());
    point_.filterColumns(y, kernels.smooth, rows_[5].data());
    smooth_.filterColumns(y, kernels.point, rows_[6].data());
  }

  /// Of the row last filtered.
  template <class Real>
  Seen<Real> at(size_t x) const {
    const auto value = [&](size_t row) { return loadAs<Real>(rows_[row].data() + x); };
    const auto strength = [](const Real& along, const Real& across) { return sqrtOf(along * along + across * across); };
    return {huntLabOf(Triple<Real>{value(0), value(1), value(2)}), strength(value(3), value(4)), strength(value(5), value(6))};
  }

 private:
  RowStrip achromatic_, redGreen_, smooth_, edge_, point_;
  std::array<RowStrip, 2> blueYellow_;
  std::array<std::vector<float>, 7> rows_;
};

/// Sum of body(y, strip), whose strip is filtered for row y, over all rows.
template <class Body>
double sumOverSeenRows(const ColorPlanes& linear, const FlipKernels& kernels, const Body& body) {
  const ColorPlanes opponent = opponentPlanes(linear);
  return sumOverStrips<SeenStrip>(linear[0].height(), [&](uint32_t begin, uint32_t end, SeenStrip& strip) {
    strip.filter(opponent, kernels, begin, end);
    double sum = 0.0;
    for (uint32_t y = begin; y < end; ++y) {
      strip.filterRow(kernels, y);
      sum += body(y, strip);
    }
    return sum;
  });
}

FlipKernels checkedKernels(float pixelsPerDegree) {
  requireFlipResolution(pixelsPerDegree);
  return flipKernels(static_cast<double>(pixelsPerDegree));
}

}  // namespace

void requireFlipResolution(float pixelsPerDegree) {
  if (!(pixelsPerDegree >= 1.0f && pixelsPerDegree <= 1000.0f)) throw InputError("FLIP needs 1 to 1000 pixels per degree");
}

FlipReference::FlipReference(const ColorPlanes& reference, float pixelsPerDegree) : kernels_(checkedKernels(pixelsPerDegree)) {
  for (Image<float>& plane : seen_) plane.reshape(reference[0].width(), reference[0].height());
  sumOverSeenRows(reference, kernels_, [&](uint32_t y, const SeenStrip& strip) {
    forBatches(reference[0].width(), [&]<class Real>(size_t x) {
      const Seen<Real> seen = strip.at<Real>(x);
      const Real values[5] = {seen.lab.x, seen.lab.y, seen.lab.z, seen.edge, seen.point};
      for (size_t k = 0; k < 5; ++k) storeTo(seen_[k].row(y) + x, values[k]);
    });
    return 0.0;
  });
}

double FlipReference::difference(const ColorPlanes& image, Image<float>& map) const {
  const uint32_t width = image[0].width(), height = image[0].height();
  const ColorRange range = flipColorRange();
  map.reshape(width, height);
  const double sum = sumOverSeenRows(image, kernels_, [&](uint32_t y, const SeenStrip& strip) {
    FloatBatch sums(0.0f);
    float rest = 0.0f;
    forBatches(width, [&]<class Real>(size_t x) {
      const Seen<Real> a = strip.at<Real>(x);
      const auto known = [&](size_t k) { return loadAs<Real>(seen_[k].row(y) + x); };
      const Real value = flipOf(colorDifference(range, a.lab, Triple<Real>{known(0), known(1), known(2)}),
                                featureDifference(a.edge, a.point, known(3), known(4)));
      storeTo(map.row(y) + x, value);
      if constexpr (std::is_same_v<Real, float>)
        rest += value;
      else
        sums += value;
    });
    return static_cast<double>(sumOf(sums)) + static_cast<double>(rest);
  });
  return sum / static_cast<double>(map.size());
}

FlipResult flip(const Image<glm::vec4>& image, const Image<glm::vec4>& reference, const glm::vec3& background, float pixelsPerDegree) {
  requireOneSize(image, reference, "FLIP");
  const FlipReference prepared(linearPlanes(reference, background, "FLIP"), pixelsPerDegree);
  FlipResult result;
  result.mean = prepared.difference(linearPlanes(image, background, "FLIP"), result.map);
  return result;
}

}  // namespace warpscope
