// Otsu's threshold and quantiles of what lies above.
// See auto_transfer_function.h.
#include "app/scene/auto_transfer_function.h"

#include <algorithm>
#include <cmath>

#include "render/core/color.h"

namespace warpscope {
namespace {

glm::vec3 srgb(float r, float g, float b) { return {linearFromSrgb(r), linearFromSrgb(g), linearFromSrgb(b)}; }

/// Last bin of the background: the split that maximises the variance between the two sides.
int otsuThreshold(const std::array<size_t, 256>& histogram) {
  double total = 0.0, sum = 0.0;
  for (int bin = 0; bin < 256; ++bin) {
    total += static_cast<double>(histogram[bin]);
    sum += static_cast<double>(histogram[bin]) * bin;
  }
  double below = 0.0, sumBelow = 0.0, best = -1.0;
  int threshold = 0;
  for (int bin = 0; bin < 255; ++bin) {
    below += static_cast<double>(histogram[bin]);
    sumBelow += static_cast<double>(histogram[bin]) * bin;
    const double above = total - below;
    if (below <= 0.0 || above <= 0.0) continue;
    const double difference = sumBelow / below - (sum - sumBelow) / above;
    const double between = below * above * difference * difference;
    if (between > best) {
      best = between;
      threshold = bin;
    }
  }
  return threshold;
}

}  // namespace

TransferFunction autoTransferFunction(const VoxelStatistics& statistics) {
  const double lower = statistics.rangeLower;
  // A volume of one value shows as a faint body: it is all there is to see.
  if (!(statistics.lowest < statistics.highest)) return {{{statistics.lowest, srgb(0.8f, 0.8f, 0.8f), 0.02f}}};

  const auto& histogram = statistics.histogram;
  const int threshold = otsuThreshold(histogram);
  size_t object = 0;
  for (int bin = threshold + 1; bin < 256; ++bin) object += histogram[bin];
  const auto quantile = [&](double fraction) {
    size_t seen = 0;
    for (int bin = threshold + 1; bin < 256; ++bin) {
      seen += histogram[bin];
      if (static_cast<double>(seen) >= fraction * static_cast<double>(object)) return bin;
    }
    return 255;
  };

  struct Stop {
    double fraction;
    glm::vec3 color;
    float alpha;
  };
  // Neutral, and lighter with every stop: a hue of its own at either end would read as a finding.
  const Stop stops[] = {{0.10, srgb(0.31f, 0.37f, 0.45f), 0.06f}, {0.40, srgb(0.55f, 0.59f, 0.62f), 0.25f},
                        {0.75, srgb(0.78f, 0.76f, 0.70f), 0.60f}, {0.95, srgb(0.91f, 0.88f, 0.80f), 0.80f},
                        {0.995, srgb(0.98f, 0.96f, 0.91f), 0.95f}};
  TransferFunction function;
  // A blend of the ends, because the extent of a double volume may overflow.
  const auto valueAt = [&](double bin) { return std::lerp(lower, statistics.rangeUpper, bin / 256.0); };
  double previous = valueAt(threshold);
  function.points.push_back({previous, stops[0].color, 0.0f});
  for (const Stop& stop : stops) {
    previous = std::max(previous, valueAt(quantile(stop.fraction) + 0.5));
    function.points.push_back({previous, stop.color, stop.alpha});
  }
  return function;
}

}  // namespace warpscope
