// Folds over samples that are at hand.
// See depth_of_samples.h.
#include "render/march/depth_of_samples.h"

#include "render/core/counters.h"

namespace warpscope {
namespace {

template <class Depth, bool kHasSecondPass>
DepthResult depthOf(const std::vector<CountingSample>& counting, float threshold) {
  if constexpr (Depth::kTwoPass) {
    FirstPass pass;
    for (const CountingSample& sample : counting) pass.add(sample);
    auto fold = Depth::start(threshold, pass.profile);
    if (!pass.decides(fold) && kHasSecondPass) {
      WARPSCOPE_COUNT(secondPasses, 1);
      for (const CountingSample& sample : counting) fold.add(sample);
    }
    return Depth::result(fold);
  } else {
    auto fold = Depth::start(threshold, ProfileFold{});
    for (const CountingSample& sample : counting) fold.add(sample);
    return Depth::result(fold);
  }
}

}  // namespace

float spreadOf(const std::vector<CountingSample>& counting) {
  WARPSCOPE_COUNT(spreads, 1);
  MomentsFold fold;
  for (const CountingSample& sample : counting) fold.add(sample);
  return fold.result().spread;
}

DepthFunction depthFunctionOf(Heuristic heuristic, bool hasSecondPass) {
  return visitHeuristic(heuristic, [&](auto depth) -> DepthFunction {
    using Depth = decltype(depth);
    return hasSecondPass ? depthOf<Depth, true> : depthOf<Depth, false>;
  });
}

bool hasOnePass(Heuristic heuristic) {
  return visitHeuristic(heuristic, []<class Depth>(Depth) { return !Depth::kTwoPass; });
}

void findSampleOf(const RelayedRay& ray, const DepthOfSamples& ofList, Heuristic heuristic, const glm::vec4& premultiplied, RaySamples& found) {
  found.clear();
  if (ray.state.hasCounted) {
    DepthResult depth = AnyDepth<false>{heuristic}.result(ray.state.fold);
    if (ofList.hasSpread) depth.spread = ray.state.moments.result().spread;
    found.add({depth, premultiplied});
  } else if (!ray.counting.empty()) {
    found.add({ofList(ray.counting), premultiplied});
  }
}

}  // namespace warpscope
