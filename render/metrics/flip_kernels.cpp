// Taps in double, rounded once.
// See flip_kernels.h.
#include "render/metrics/flip_kernels.h"

#include <cmath>
#include <numbers>

namespace warpscope {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kNegligible = 1e-7;

/// A Gaussian over degrees, as the paper writes it: weight * sqrt(pi / width) * exp(-pi^2 d^2 / width), d in degrees.
struct Sensitivity {
  double weight, width;
};
constexpr Sensitivity kAchromatic{1.0, 0.0047}, kRedGreen{1.0, 0.0053};
constexpr std::array<Sensitivity, 2> kBlueYellow{{{34.1, 0.04}, {13.5, 0.025}}};
constexpr double kLargestWidth = 0.04;

/// The Gaussians, of which the sum of all taps is 1.
template <size_t kCount>
std::array<SeparableTaps, kCount> gaussians(const std::array<Sensitivity, kCount>& sensitivities, double pixelsPerDegree) {
  const int largest = static_cast<int>(std::ceil(3.0 * std::sqrt(kLargestWidth / (2.0 * kPi * kPi)) * pixelsPerDegree));
  std::array<std::vector<double>, kCount> lines;
  std::array<double, kCount> factors;
  double total = 0.0;
  for (size_t k = 0; k < kCount; ++k) {
    const auto tap = [&](int i) {
      const double degrees = i / pixelsPerDegree;
      return std::exp(-kPi * kPi * degrees * degrees / sensitivities[k].width);
    };
    int radius = 0;
    while (radius < largest && tap(radius + 1) >= kNegligible) ++radius;
    double sum = 0.0;
    for (int i = -radius; i <= radius; ++i) {
      lines[k].push_back(tap(i));
      sum += lines[k].back();
    }
    factors[k] = sensitivities[k].weight * std::sqrt(kPi / sensitivities[k].width);
    total += factors[k] * sum * sum;
  }
  std::array<SeparableTaps, kCount> result;
  for (size_t k = 0; k < kCount; ++k)
    for (const double tap : lines[k]) {
      // The square root on both sides: neither is far from 1 in sum.
      const double share = std::sqrt(factors[k] / total);
      result[k].rows.push_back(static_cast<float>(tap * share));
      result[k].columns.push_back(static_cast<float>(tap * share));
    }
  return result;
}

/// Positive taps sum up to 1, negative ones to -1.
FilterTaps normalized(const std::vector<double>& taps) {
  double positive = 0.0, negative = 0.0;
  for (const double tap : taps) (tap > 0.0 ? positive : negative) += tap;
  FilterTaps result;
  for (const double tap : taps) result.push_back(static_cast<float>(tap > 0.0 ? tap / positive : negative < 0.0 ? tap / -negative : 0.0));
  return result;
}

}  // namespace

FlipKernels flipKernels(double pixelsPerDegree) {
  FlipKernels kernels;
  kernels.achromatic = gaussians<1>({kAchromatic}, pixelsPerDegree)[0];
  kernels.redGreen = gaussians<1>({kRedGreen}, pixelsPerDegree)[0];
  kernels.blueYellow = gaussians(kBlueYellow, pixelsPerDegree);

  constexpr double kWidthDegrees = 0.082;  // of an edge, peak to trough
  const double deviation = 0.5 * kWidthDegrees * pixelsPerDegree;
  const int radius = static_cast<int>(std::ceil(3.0 * deviation));
  std::vector<double> smooth, edge, point;
  for (int i = -radius; i <= radius; ++i) {
    const double g = std::exp(-0.5 * i * i / (deviation * deviation));
    smooth.push_back(g);
    edge.push_back(-i * g);
    point.push_back((i * i / (deviation * deviation) - 1.0) * g);
  }
  kernels.smooth = normalized(smooth);
  kernels.edge = normalized(edge);
  kernels.point = normalized(point);
  return kernels;
}

}  // namespace warpscope
