// What a ray's state is made of, and what lies behind what. Rays put together from pieces: stability/folds_test.cpp.
// Mirrors render/march/ray_state.h.
#include "render/march/ray_state.h"

#include <gtest/gtest.h>

#include <type_traits>

#include "heuristic_cases.h"
#include "made_up_source.h"

namespace warpscope {
namespace {

class RayStateOf : public testing::TestWithParam<Heuristic> {};
INSTANTIATE_TEST_SUITE_P(All, RayStateOf, testing::ValuesIn(everyHeuristic()), heuristicCase);

TEST_P(RayStateOf, IsPlainDataThatCanTravel) {
  visitHeuristic(GetParam(), [](auto depth) {
    using State = RayState<decltype(depth)>;
    EXPECT_TRUE(std::is_trivially_copyable_v<State>);
    EXPECT_TRUE(std::is_standard_layout_v<State>);
  });
}

TEST(RayState, LightIsSeenThroughWhatLiesInFront) {
  const RayLight front{{0.25, 0.0, 0.0}, 0.5}, back{{0.0, 1.0, 0.0}, 0.0};
  const RayLight both = RayLight::combine(front, back);
  EXPECT_EQ(both.color, glm::dvec3(0.25, 0.5, 0.0));
  EXPECT_EQ(both.transmittance, 0.0);
  EXPECT_EQ(both.premultiplied(), glm::vec4(0.25f, 0.5f, 0.0f, 1.0f));
  EXPECT_EQ(RayLight::combine(back, front).color, glm::dvec3(0.0, 1.0, 0.0));  // nothing is seen through what is opaque
}

TEST(RayState, BehindTheRaysEndNothingIsTaken) {
  const RayPath path = alongZ(latticeOf(0.0f, 4.0f, 1.0f));
  MadeUpSource<8> source{[](int) { return 0.5f; }, path.lattice};
  const auto state = marchPiece<ThresholdDepth>(path, 0, 4, source, Unlit{}, {kContribution, kContribution}, 0.8f,
                                                Transmittance(0.5 * kContribution));
  EXPECT_EQ(state.light.color, glm::dvec3(0.0));
  EXPECT_EQ(state.light.transmittance, 1.0);
  EXPECT_FALSE(state.depth().hasDepth);
}

}  // namespace
}  // namespace warpscope
