// A march's source without a volume: samples with a given opacity each, all of one straight colour; and rays through
// it. What a source is: render/march/march.h.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "render/march/march.h"

namespace warpscope {

template <int kSize>
struct MadeUpSource {
  static constexpr int kBatch = kSize;
  std::function<float(int)> alphaAt;
  RayLattice lattice;
  glm::vec3 straight{1.0f, 0.5f, 0.25f};
  int first = 0;

  int skip(int i) const { return i; }
  uint32_t classify(int i, int n) {
    first = i;
    uint32_t visible = 0;
    for (int k = 0; k < n; ++k) visible |= uint32_t{alphaAt(i + k) > 0.0f} << k;
    return visible;
  }
  bool classifyLast() { return classify(lattice.count - 1, 1) != 0; }
  float alpha(int k) const { return alphaAt(first + k); }
  float unitAlpha(int k) const { return correctOpacity(alpha(k), 1.0f / lattice.dt); }
  glm::vec3 color(int k) const { return straight * alpha(k); }
};

inline RayLattice latticeOf(float t0, float length, float dt) { return makeLattice({t0, t0 + length}, dt); }

/// A ray from the origin; where it goes matters to lights alone.
inline RayPath alongZ(const RayLattice& lattice) { return {{glm::vec3(0.0f), {0.0f, 0.0f, 1.0f}}, lattice}; }

/// Of the settings as they come.
inline constexpr float kContribution = 1.0f / 1024;

/// What marching a made-up ray gives.
struct Marched {
  RayColor color;
  std::vector<CountingSample> counting;
};

/// The ray with these opacities, marched in pieces that end at `cuts` and at its end.
template <int kSize = 8, class Light = Unlit>
Marched march(const RayLattice& lattice, const std::function<float(int)>& alphaAt, float stopBelow = 0.0f,
              std::vector<int> cuts = {}, const Light& light = {}) {
  MadeUpSource<kSize> source{alphaAt, lattice};
  Marched result;
  cuts.push_back(lattice.count);
  int begin = 0;
  for (const int end : cuts) {
    if (result.color.transmittance.value() < stopBelow) break;
    marchRay(alongZ(lattice), begin, end, source, light, {kContribution, stopBelow}, result.color,
             [&](const CountingSample& sample) {
               result.counting.push_back(sample);
               return true;
             });
    begin = end;
  }
  return result;
}

inline bool sameSamples(const std::vector<CountingSample>& a, const std::vector<CountingSample>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const CountingSample& x, const CountingSample& y) {
    return x.t == y.t && x.ds == y.ds && x.alpha == y.alpha && x.transmittance == y.transmittance;
  });
}

}  // namespace warpscope
