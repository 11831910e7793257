// The colour pipeline and the feature pipeline of the paper, as planes; what is done per pixel is vector code.
// See flip.h.
#include "render/metrics/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "render/core/error.h"
#include "render/core/parallel.h"
#include "render/core/simd.h"
#include "render/metrics/displayed.h"
#include "render/metrics/filters.h"

namespace warpscope {
namespace {

using Planes = std::array<Image<float>, 3>;
using Kernel = std::vector<float>;

// --- Colour spaces. Linear RGB of the sRGB primaries to XYZ, whose white is that of RGB (1, 1, 1).

constexpr double kXyzFromRgb[3][3] = {{10135552.0 / 24577794.0, 8788810.0 / 24577794.0, 4435075.0 / 24577794.0},
                                      {2613072.0 / 12288897.0, 8788810.0 / 12288897.0, 887015.0 / 12288897.0},
                                      {1425312.0 / 73733382.0, 8788810.0 / 73733382.0, 70074185.0 / 73733382.0}};

constexpr double whiteOf(int row) { return kXyzFromRgb[row][0] + kXyzFromRgb[row][1] + kXyzFromRgb[row][2]; }

/// RGB to XYZ relative to white, and back.
struct Conversion {
  float relativeFromRgb[3][3];
  float rgbFromRelative[3][3];

  Conversion() {
    glm::dmat3 matrix;  // columns first
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column) matrix[column][row] = kXyzFromRgb[row][column] / whiteOf(row);
    const glm::dmat3 inverse = glm::inverse(matrix);
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column) {
        relativeFromRgb[row][column] = static_cast<float>(matrix[column][row]);
        rgbFromRelative[row][column] = static_cast<float>(inverse[column][row]);
      }
  }
};

const Conversion& conversion() {
  static const Conversion kConversion;
  return kConversion;
}

template <class Real>
Real rowTimes(const float (&row)[3], const Real& x, const Real& y, const Real& z) {
  return Real(row[0]) * x + Real(row[1]) * y + Real(row[2]) * z;
}

FloatBatch linearFromSrgb(const FloatBatch& v) {
  const FloatBatch curve = xsimd::pow((v + FloatBatch(0.055f)) / FloatBatch(1.055f), FloatBatch(2.4f));
  return selected(v > FloatBatch(0.04045f), curve, v / FloatBatch(12.92f));
}

/// Calls body(i) for batches that cover [0, count), count >= kBatchLanes; the last one may overlap the one before it, and comes last.
template <class Body>
void forBatches(size_t count, const Body& body) {
  constexpr size_t kLanes = kBatchLanes;
  parallelForRanges(count / kLanes, 1 << 10, [&](size_t begin, size_t end) {
    for (size_t batch = begin; batch < end; ++batch) body(batch * kLanes);
  });
  if (count % kLanes != 0) body(count - kLanes);
}

FloatBatch load(const Image<float>& plane, size_t i) { return FloatBatch::load_unaligned(plane.data() + i); }
void store(Image<float>& plane, size_t i, const FloatBatch& value) { value.store_unaligned(plane.data() + i); }

// --- Contrast sensitivity: each opponent channel is blurred as the eye cannot resolve it (section 4.1.1).

struct Sensitivity {
  double weight[2], width[2];  ///< of a sum of two Gaussians over degrees
};
constexpr Sensitivity kAchromatic{{1.0, 0.0}, {0.0047, 1e-5}}, kRedGreen{{1.0, 0.0}, {0.0053, 1e-5}}, kBlueYellow{{34.1, 13.5}, {0.04, 0.025}};
constexpr double kLargestWidth = 0.04;

/// One Gaussian of a sum, for rows and for columns: their product has the share of the whole kernel's sum that is its.
struct SeparableGaussian {
  Kernel rows, columns;
};

std::vector<SeparableGaussian> gaussiansOf(const Sensitivity& sensitivity, double pixelsPerDegree) {
  constexpr double kPi = std::numbers::pi;
  const int radius = static_cast<int>(std::ceil(3.0 * std::sqrt(kLargestWidth / (2.0 * kPi * kPi)) * pixelsPerDegree));
  std::vector<std::vector<double>> taps;
  std::vector<double> factors;
  double total = 0.0;
  for (int k = 0; k < 2; ++k) {
    if (sensitivity.weight[k] == 0.0) continue;
    std::vector<double> line;
    double sum = 0.0;
    for (int i = -radius; i <= radius; ++i) {
      const double degrees = i / pixelsPerDegree;
      line.push_back(std::exp(-kPi * kPi * degrees * degrees / sensitivity.width[k]));
      sum += line.back();
    }
    factors.push_back(sensitivity.weight[k] * std::sqrt(kPi / sensitivity.width[k]));
    total += factors.back() * sum * sum;
    taps.push_back(std::move(line));
  }
  std::vector<SeparableGaussian> gaussians;
  for (size_t k = 0; k < taps.size(); ++k) {
    SeparableGaussian gaussian;
    for (const double tap : taps[k]) {
      gaussian.rows.push_back(static_cast<float>(tap));
      gaussian.columns.push_back(static_cast<float>(tap * factors[k] / total));
    }
    gaussians.push_back(std::move(gaussian));
  }
  return gaussians;
}

void blur(const Image<float>& in, const std::vector<SeparableGaussian>& gaussians, Image<float>& between, Image<float>& out) {
  for (size_t k = 0; k < gaussians.size(); ++k) {
    filterRows(in, gaussians[k].rows, between);
    filterColumns(between, gaussians[k].columns, out, k > 0);
  }
}

/// sRGB to the linear opponent space YCxCz.
void toOpponent(const DisplayedPlanes& srgb, Planes& opponent) {
  for (Image<float>& plane : opponent) plane.reshape(srgb[0].width(), srgb[0].height());
  const Conversion& c = conversion();
  forBatches(srgb[0].size(), [&](size_t i) {
    const FloatBatch r = linearFromSrgb(load(srgb[0], i)), g = linearFromSrgb(load(srgb[1], i)), b = linearFromSrgb(load(srgb[2], i));
    const FloatBatch x = rowTimes(c.relativeFromRgb[0], r, g, b), y = rowTimes(c.relativeFromRgb[1], r, g, b),
                     z = rowTimes(c.relativeFromRgb[2], r, g, b);
    store(opponent[0], i, FloatBatch(116.0f) * y - FloatBatch(16.0f));
    store(opponent[1], i, FloatBatch(500.0f) * (x - y));
    store(opponent[2], i, FloatBatch(200.0f) * (y - z));
  });
}

// --- Colours as they are seen: CIELAB with the Hunt effect, and their distance HyAB (section 4.1.2, 4.1.3).

template <class Real>
struct Lab {
  Real lightness, a, b;
};

FloatBatch labCurve(const FloatBatch& t) {
  constexpr float kDelta = 6.0f / 29.0f;
  return selected(t > FloatBatch(kDelta * kDelta * kDelta), xsimd::cbrt(t), t / FloatBatch(3.0f * kDelta * kDelta) + FloatBatch(4.0f / 29.0f));
}

/// Of linear RGB, which is brought into 0..1.
Lab<FloatBatch> huntLab(const FloatBatch& red, const FloatBatch& green, const FloatBatch& blue) {
  const Conversion& c = conversion();
  const FloatBatch r = saturated(red), g = saturated(green), b = saturated(blue);
  const FloatBatch fx = labCurve(rowTimes(c.relativeFromRgb[0], r, g, b)), fy = labCurve(rowTimes(c.relativeFromRgb[1], r, g, b)),
                   fz = labCurve(rowTimes(c.relativeFromRgb[2], r, g, b));
  const FloatBatch lightness = FloatBatch(116.0f) * fy - FloatBatch(16.0f);
  const FloatBatch hunt = FloatBatch(0.01f) * lightness;
  return {lightness, hunt * FloatBatch(500.0f) * (fx - fy), hunt * FloatBatch(200.0f) * (fy - fz)};
}

Lab<FloatBatch> huntLabOfOpponent(const Planes& opponent, size_t i) {
  const Conversion& c = conversion();
  const FloatBatch y = (load(opponent[0], i) + FloatBatch(16.0f)) / FloatBatch(116.0f);
  const FloatBatch x = y + load(opponent[1], i) / FloatBatch(500.0f), z = y - load(opponent[2], i) / FloatBatch(200.0f);
  return huntLab(rowTimes(c.rgbFromRelative[0], x, y, z), rowTimes(c.rgbFromRelative[1], x, y, z), rowTimes(c.rgbFromRelative[2], x, y, z));
}

FloatBatch distanceHyab(const Lab<FloatBatch>& p, const Lab<FloatBatch>& q) {
  const FloatBatch a = p.a - q.a, b = p.b - q.b;
  return xsimd::abs(p.lightness - q.lightness) + sqrtOf(a * a + b * b);
}

constexpr float kColorExponent = 0.7f, kFeatureExponent = 0.5f;
constexpr float kSmallShare = 0.4f, kSmallResult = 0.95f;  // differences up to 0.4 of the largest take 0.95 of the range

/// The largest difference that two colours have: that of green and blue.
float largestColorDifference() {
  static const float kLargest = [] {
    const FloatBatch none(0.0f), all(1.0f);
    alignas(64) float values[kBatchLanes];
    xsimd::pow(distanceHyab(huntLab(none, all, none), huntLab(none, none, all)), FloatBatch(kColorExponent)).store_aligned(values);
    return values[0];
  }();
  return kLargest;
}

FloatBatch colorDifference(const Lab<FloatBatch>& p, const Lab<FloatBatch>& q) {
  const float largest = largestColorDifference(), small = kSmallShare * largest;
  const FloatBatch d = xsimd::pow(distanceHyab(p, q), FloatBatch(kColorExponent));
  return selected(d < FloatBatch(small), d * FloatBatch(kSmallResult / small),
                  FloatBatch(kSmallResult) + (d - FloatBatch(small)) * FloatBatch((1.0f - kSmallResult) / (largest - small)));
}

// --- Features: edges and points of the achromatic channel, as fine as the eye finds them (section 4.2).

struct FeatureKernels {
  Kernel smooth, edge, point;
};

FeatureKernels featureKernels(double pixelsPerDegree) {
  constexpr double kWidthDegrees = 0.082;
  const double deviation = 0.5 * kWidthDegrees * pixelsPerDegree;
  const int radius = static_cast<int>(std::ceil(3.0 * deviation));
  std::vector<double> smooth, edge, point;
  for (int i = -radius; i <= radius; ++i) {
    const double g = std::exp(-0.5 * i * i / (deviation * deviation));
    smooth.push_back(g);
    edge.push_back(-i * g);
    point.push_back((i * i / (deviation * deviation) - 1.0) * g);
  }
  // Positive taps sum up to 1, negative ones to -1.
  const auto normalized = [](const std::vector<double>& taps) {
    double positive = 0.0, negative = 0.0;
    for (const double tap : taps) (tap > 0.0 ? positive : negative) += tap;
    Kernel kernel;
    for (const double tap : taps) kernel.push_back(static_cast<float>(tap > 0.0 ? tap / positive : negative < 0.0 ? tap / -negative : 0.0));
    return kernel;
  };
  return {normalized(smooth), normalized(edge), normalized(point)};
}

/// How strong edges and points are at each pixel.
struct Features {
  Image<float> edge, point;
};

Features featuresOf(const Planes& opponent, const FeatureKernels& kernels) {
  Image<float> gray(opponent[0].width(), opponent[0].height());
  forBatches(gray.size(), [&](size_t i) { store(gray, i, (load(opponent[0], i) + FloatBatch(16.0f)) / FloatBatch(116.0f)); });
  Image<float> smooth, along, across;
  Features features;
  const auto strength = [&](const Kernel& kernel, Image<float>& out) {
    Image<float> between;
    filterRows(gray, kernel, between);
    filterColumns(between, kernels.smooth, along);
    filterColumns(smooth, kernel, across);
    out.reshape(gray.width(), gray.height());
    forBatches(gray.size(), [&](size_t i) {
      const FloatBatch x = load(along, i), y = load(across, i);
      store(out, i, sqrtOf(x * x + y * y));
    });
  };
  filterRows(gray, kernels.smooth, smooth);
  strength(kernels.edge, features.edge);
  strength(kernels.point, features.point);
  return features;
}

FloatBatch featureDifference(const Features& a, const Features& b, size_t i) {
  const FloatBatch edge = xsimd::abs(load(a.edge, i) - load(b.edge, i)), point = xsimd::abs(load(a.point, i) - load(b.point, i));
  static_assert(kFeatureExponent == 0.5f);
  return sqrtOf(maxOf(edge, point) * FloatBatch(std::numbers::sqrt2_v<float> / 2.0f));
}

/// Everything about one picture.
struct Seen {
  Planes opponent;  ///< blurred
  Features features;
};

Seen seen(const Image<glm::vec4>& image, const glm::vec3& background, float pixelsPerDegree, const FeatureKernels& kernels) {
  Planes sharp;
  toOpponent(displayedPlanes(image, background, "FLIP"), sharp);
  Seen result;
  Image<float> between;
  const Sensitivity* const sensitivities[3] = {&kAchromatic, &kRedGreen, &kBlueYellow};
  for (size_t channel = 0; channel < 3; ++channel)
    blur(sharp[channel], gaussiansOf(*sensitivities[channel], pixelsPerDegree), between, result.opponent[channel]);
  result.features = featuresOf(sharp, kernels);
  return result;
}

FlipResult compare(const Image<glm::vec4>& image, const Image<glm::vec4>& reference, const glm::vec3& background, float pixelsPerDegree) {
  const FeatureKernels kernels = featureKernels(pixelsPerDegree);
  const Seen a = seen(image, background, pixelsPerDegree, kernels), b = seen(reference, background, pixelsPerDegree, kernels);
  FlipResult result;
  result.map.reshape(image.width(), image.height());
  forBatches(image.size(), [&](size_t i) {
    const FloatBatch color = colorDifference(huntLabOfOpponent(a.opponent, i), huntLabOfOpponent(b.opponent, i));
    const FloatBatch difference = xsimd::pow(color, FloatBatch(1.0f) - featureDifference(a.features, b.features, i));
    store(result.map, i, selected(color > FloatBatch(0.0f), saturated(difference), FloatBatch(0.0f)));
  });
  double sum = 0.0;
  for (const float value : result.map) sum += value;
  result.mean = sum / static_cast<double>(image.size());
  return result;
}

}  // namespace

FlipResult flip(const Image<glm::vec4>& image, const Image<glm::vec4>& reference, const glm::vec3& background, float pixelsPerDegree) {
  requireOneSize(image, reference, "FLIP");
  if (!(pixelsPerDegree >= 1.0f && pixelsPerDegree <= 1000.0f)) throw InputError("FLIP needs 1 to 1000 pixels per degree");
  if (image.size() >= static_cast<size_t>(kBatchLanes)) return compare(image, reference, background, pixelsPerDegree);
  // Tiny images go on as their outermost pixels do, which is what filters take to be beyond the border anyway.
  const auto widened = [](const Image<glm::vec4>& small) {
    Image<glm::vec4> wide(small.width() + kBatchLanes, small.height());
    for (uint32_t y = 0; y < wide.height(); ++y)
      for (uint32_t x = 0; x < wide.width(); ++x) wide(x, y) = small(std::min(x, small.width() - 1), y);
    return wide;
  };
  const FlipResult wide = compare(widened(image), widened(reference), background, pixelsPerDegree);
  FlipResult result;
  result.map.reshape(image.width(), image.height());
  double sum = 0.0;
  for (uint32_t y = 0; y < image.height(); ++y)
    for (uint32_t x = 0; x < image.width(); ++x) sum += result.map(x, y) = wide.map(x, y);
  result.mean = sum / static_cast<double>(image.size());
  return result;
}

}  // namespace warpscope
