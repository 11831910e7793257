// Ranks by void and cluster, in integers, so that they are the same on every machine.
// See jitter.h.
#include "render/effects/jitter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace warpscope {
namespace {

constexpr uint32_t kPlaces = kNoiseSide * kNoiseSide;
constexpr uint32_t kSeed = 2012;
constexpr double kSigma = 1.5;  // Ulichney's, in pixels

/// Points on a torus, and at each place how close they are.
class Pattern {
 public:
  Pattern() : isSet_(kPlaces, false), closeness_(kPlaces, 0) {
    for (uint32_t i = 0; i < kPlaces; ++i) {
      const auto along = [](uint32_t d) { return std::min(d, kNoiseSide - d); };
      const double dx = along(i % kNoiseSide), dy = along(i / kNoiseSide);
      weights_[i] = std::llround(std::exp(-(dx * dx + dy * dy) / (2.0 * kSigma * kSigma)) * 0x1p30);
    }
  }

  bool isSet(uint32_t place) const { return isSet_[place]; }
  void set(uint32_t place, bool isPoint) {
    isSet_[place] = isPoint;
    const uint32_t x0 = place % kNoiseSide, y0 = place / kNoiseSide;
    for (uint32_t i = 0; i < kPlaces; ++i) {
      const uint32_t dx = (i - x0) % kNoiseSide, dy = (i / kNoiseSide - y0) % kNoiseSide;
      const int64_t weight = weights_[dy * kNoiseSide + dx];
      closeness_[i] += isPoint ? weight : -weight;
    }
  }
  /// Of the points the one that is closest to others.
  uint32_t tightestCluster() const { return mostBy([&](uint32_t i) { return isSet_[i] ? closeness_[i] : -1; }); }
  /// Of the places without a point the one that is farthest from any.
  uint32_t largestVoid() const { return mostBy([&](uint32_t i) { return isSet_[i] ? INT64_MIN : -closeness_[i]; }); }

 private:
  template <class Score>
  static uint32_t mostBy(const Score& score) {
    uint32_t best = 0;
    for (uint32_t i = 1; i < kPlaces; ++i)
      if (score(i) > score(best)) best = i;
    return best;
  }

  std::vector<bool> isSet_;
  std::vector<int64_t> closeness_;
  std::array<int64_t, kPlaces> weights_;
};

std::vector<float> makeNoise() {
  constexpr uint32_t kFirst = kPlaces / 10;
  Pattern even;
  std::mt19937 random(kSeed);
  for (uint32_t points = 0; points < kFirst;) {
    const uint32_t place = random() % kPlaces;
    if (even.isSet(place)) continue;
    even.set(place, true);
    ++points;
  }
  for (;;) {  // until the points are spread evenly
    const uint32_t cluster = even.tightestCluster();
    even.set(cluster, false);
    const uint32_t gap = even.largestVoid();
    even.set(gap, true);
    if (gap == cluster) break;
  }
  std::vector<float> noise(kPlaces);
  const auto rank = [&](uint32_t place, uint32_t k) { noise[place] = (static_cast<float>(k) + 0.5f) / static_cast<float>(kPlaces) - 0.5f; };
  Pattern fewer = even;
  for (uint32_t k = kFirst; k-- > 0;) {
    const uint32_t cluster = fewer.tightestCluster();
    fewer.set(cluster, false);
    rank(cluster, k);
  }
  for (uint32_t k = kFirst; k < kPlaces; ++k) {
    const uint32_t gap = even.largestVoid();
    even.set(gap, true);
    rank(gap, k);
  }
  return noise;
}

}  // namespace

std::span<const float> blueNoise() {
  static const std::vector<float> noise = makeNoise();
  return noise;
}

}  // namespace warpscope
