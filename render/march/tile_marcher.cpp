// Depths of rays that have been marched.
// See tile_marcher.h.
#include "render/march/tile_marcher.h"

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

bool RelayedTile::beginAgain() {
  isAgain = true;
  again.resize(rays.size());
  bool any = false;
  for (size_t place = 0; place < rays.size(); ++place) {
    RelayedRay& ray = rays[place];
    ray.isDone = !ray.hasMet();
    ray.state.next = 0;
    any = any || !ray.isDone;
    if (!isDivided || ray.counting.size() < 2) continue;
    again[place].isDivided = true;
    again[place].accumulatedEnd = ray.counting.back().accumulatedAfter();
    ray.counting.clear();
  }
  return any;
}

}  // namespace warpscope
