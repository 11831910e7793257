// Rays put together from pieces: the whole's light and depth to rounding, whatever the cuts; combining is associative
// and has an identity. Mirrors render/march/ray_state.h; every heuristic, with and without early ends.
#include "render/march/ray_state.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <type_traits>
#include <vector>

#include "heuristic_cases.h"
#include "made_up_source.h"

namespace warpscope {
namespace {

constexpr uint32_t kSeed = 2012;
constexpr int kRays = 60;
constexpr float kThreshold = 0.8f;

/// A ray's opacities, from faint to opaque, with gaps; its colours differ from sample to sample.
struct TestRay {
  RayPath path;
  std::vector<float> alphas;
  RayLimits limits;
};

/// Colours by place, so that light that is taken from the wrong piece shows.
struct ByPlace {
  template <class Source>
  glm::vec3 shade(const ClassifiedSample& sample, const Ray& ray, const Source&, int) const {
    const float z = ray.at(sample.t).z;
    return sample.alpha * glm::vec3(0.5f + 0.5f * std::sin(z), 0.5f + 0.5f * std::cos(3.0f * z), 0.25f);
  }
};

TestRay randomRay(std::mt19937& random) {
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  TestRay ray;
  const auto count = 1 + random() % 200;
  ray.path = alongZ(latticeOf(1.0f, 0.5f * static_cast<float>(count) - 0.2f, 0.5f));
  const float scale = std::exp2(-8.0f * unit(random));
  ray.alphas.resize(count);
  for (float& alpha : ray.alphas) alpha = random() % 3 ? std::min(1.0f, 2.0f * scale * unit(random)) : 0.0f;
  ray.limits = {kContribution, random() % 2 ? kContribution : 0.0f};
  return ray;
}

MadeUpSource<8> sourceOf(const TestRay& ray) {
  return {[&ray](int i) { return ray.alphas[static_cast<size_t>(i)]; }, ray.path.lattice};
}

/// Begins and ends of `pieces` pieces, some of them empty.
std::vector<int> randomCuts(int pieces, int count, std::mt19937& random) {
  std::vector<int> cuts{0, count};
  for (int i = 1; i < pieces; ++i) cuts.push_back(static_cast<int>(random() % (static_cast<uint32_t>(count) + 1)));
  std::sort(cuts.begin(), cuts.end());
  return cuts;
}

/// The state of each piece, as separate machines would find it: they exchange transmittances, then profiles.
template <class Depth>
std::vector<RayState<Depth>> statesOf(const TestRay& ray, const std::vector<int>& cuts) {
  std::vector<RayState<Depth>> states;
  std::vector<Transmittance> inFront{Transmittance()};
  for (size_t p = 0; p + 1 < cuts.size(); ++p) {
    MadeUpSource<8> source = sourceOf(ray);
    RayOpacity alone;
    marchRay(ray.path, cuts[p], cuts[p + 1], source, ByPlace{}, {kContribution, 0.0f}, alone,
             [](const CountingSample&) { return true; });
    states.push_back(
        marchPiece<Depth>(ray.path, cuts[p], cuts[p + 1], source, ByPlace{}, ray.limits, kThreshold, inFront[p]));
    inFront.push_back(Transmittance(inFront[p].exact() * alone.transmittance.exact()));
  }
  if constexpr (Depth::kTwoPass) {
    ProfileFold profile;
    for (const auto& state : states) profile = ProfileFold::combine(profile, state.profile);
    for (size_t p = 0; p + 1 < cuts.size(); ++p) {
      MadeUpSource<8> source = sourceOf(ray);
      states[p].fold = marchPieceAgain<Depth>(ray.path, cuts[p], cuts[p + 1], source, ByPlace{}, ray.limits, kThreshold,
                                              inFront[p], profile);
    }
  }
  return states;
}

template <class Depth>
RayState<Depth> combined(const std::vector<RayState<Depth>>& states) {
  RayState<Depth> whole;
  for (const auto& state : states) whole = RayState<Depth>::combine(whole, state);
  return whole;
}

template <class Depth>
void expectNear(const RayState<Depth>& a, const RayState<Depth>& b, float reach) {
  ASSERT_NEAR(a.light.transmittance, b.light.transmittance, 1e-12);
  for (int channel = 0; channel < 3; ++channel) ASSERT_NEAR(a.light.color[channel], b.light.color[channel], 2e-6);
  ASSERT_EQ(a.profile.any, b.profile.any);
  ASSERT_EQ(a.profile.alphaEntrance, b.profile.alphaEntrance);
  ASSERT_EQ(a.profile.alphaExit, b.profile.alphaExit);
  ASSERT_NEAR(a.profile.accumulatedEnd, b.profile.accumulatedEnd, 3e-7f);
  ASSERT_EQ(a.depth().hasDepth, b.depth().hasDepth);
  ASSERT_NEAR(a.depth().depth, b.depth().depth, reach);
  ASSERT_NEAR(a.depth().spread, b.depth().spread, 10.0f * reach);
}

/// As the marchers find a whole ray's.
template <class Depth>
void expectTheWhole(const TestRay& ray, const RayState<Depth>& state) {
  MadeUpSource<8> source = sourceOf(ray);
  RayColor color;
  std::vector<CountingSample> counting;
  marchRay(ray.path, 0, ray.path.lattice.count, source, ByPlace{}, ray.limits, color,
           [&](const CountingSample& sample) {
             counting.push_back(sample);
             return true;
           });
  ProfileFold profile;
  for (const CountingSample& sample : counting) profile.add(sample);
  RayState<Depth> whole;
  whole.light = {color.color(), color.transmittance.exact()};
  if (Depth::kTwoPass) whole.profile = profile;
  whole.fold = Depth::start(kThreshold, profile);
  for (const CountingSample& sample : counting) whole.fold.add(sample);
  expectNear(whole, state, 1e-4f);
  for (int channel = 0; channel < 4; ++channel)
    ASSERT_NEAR(state.light.premultiplied()[channel], color.premultiplied()[channel], 2e-6f);
}

class RayStateOf : public testing::TestWithParam<Heuristic> {};
INSTANTIATE_TEST_SUITE_P(All, RayStateOf, testing::ValuesIn(everyHeuristic()), heuristicCase);

TEST_P(RayStateOf, PiecesMakeTheWhole) {
  visitHeuristic(GetParam(), [&](auto depth) {
    using Depth = decltype(depth);
    std::mt19937 random(kSeed);
    for (int i = 0; i < kRays; ++i) {
      const TestRay ray = randomRay(random);
      for (const int pieces : {1, 2, 7}) {
        SCOPED_TRACE("seed " + std::to_string(kSeed) + ", ray " + std::to_string(i) + " in " + std::to_string(pieces));
        expectTheWhole(ray, combined(statesOf<Depth>(ray, randomCuts(pieces, ray.path.lattice.count, random))));
        if (testing::Test::HasFatalFailure()) return;
      }
    }
  });
}

TEST_P(RayStateOf, CombiningIsAssociativeAndHasAnIdentity) {
  visitHeuristic(GetParam(), [&](auto depth) {
    using State = RayState<decltype(depth)>;
    std::mt19937 random(kSeed + 1);
    for (int i = 0; i < kRays; ++i) {
      SCOPED_TRACE("seed " + std::to_string(kSeed + 1) + ", ray " + std::to_string(i));
      const TestRay ray = randomRay(random);
      const auto s = statesOf<decltype(depth)>(ray, randomCuts(4, ray.path.lattice.count, random));
      const auto both = [](const State& front, const State& back) { return State::combine(front, back); };
      expectNear(both(both(both(s[0], s[1]), s[2]), s[3]), both(s[0], both(s[1], both(s[2], s[3]))), 1e-4f);
      expectNear(both(both(s[0], s[1]), both(s[2], s[3])), both(s[0], both(both(s[1], s[2]), s[3])), 1e-4f);
      for (const State& state : s) {
        expectNear(both(State{}, state), state, 0.0f);
        expectNear(both(state, State{}), state, 0.0f);
        ASSERT_EQ(both(State{}, state).light.color, state.light.color);
        ASSERT_EQ(both(state, State{}).light.color, state.light.color);
      }
      if (testing::Test::HasFatalFailure()) return;
    }
  });
}

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
  const TestRay ray{alongZ(latticeOf(0.0f, 4.0f, 1.0f)), {0.5f, 0.5f, 0.5f, 0.5f}, {kContribution, kContribution}};
  MadeUpSource<8> source = sourceOf(ray);
  const auto state = marchPiece<ThresholdDepth>(ray.path, 0, 4, source, Unlit{}, ray.limits, kThreshold,
                                                Transmittance(0.5 * kContribution));
  EXPECT_EQ(state.light.color, glm::dvec3(0.0));
  EXPECT_EQ(state.light.transmittance, 1.0);
  EXPECT_FALSE(state.depth().hasDepth);
}

}  // namespace
}  // namespace warpscope
