// Rays against boxes: zero and negative zero components, origins on a face, flat, inverted and NaN boxes, rays along shared edges.
// Mirrors render/core/box.h, and the box test of render/warp/lbvh/lbvh.h, which must lose no hit; truth in exact arithmetic.
#include "render/core/box.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <random>

#include "render/warp/lbvh/lbvh.h"

namespace warpscope {
namespace {

using Exact = boost::multiprecision::cpp_bin_float_100;

constexpr float kInfinity = std::numeric_limits<float>::infinity();
const Box kUnitBox{glm::vec3(0.0f), glm::vec3(1.0f)};

RayInterval meet(const Box& box, const glm::vec3& origin, const glm::vec3& direction) {
  return intersectBox(reciprocalOf(origin, direction), box, 0.0f, kInfinity);
}

/// The test that culls: where the ray enters the box, widened a little; negative if it misses that.
float entry(const Box& box, const glm::vec3& origin, const glm::vec3& direction) {
  return entryDistance(lbvhRayOf({origin, direction}, reachOf(box)), box, kInfinity);
}

TEST(RayBox, NegativeZeroIsZero) {
  for (const float y : {-0.5f, 0.0f, 0.5f, 1.0f, 1.5f}) {
    const RayInterval plus = meet(kUnitBox, {-1.0f, y, 0.5f}, {1.0f, 0.0f, 0.0f});
    const RayInterval minus = meet(kUnitBox, {-1.0f, y, 0.5f}, {1.0f, -0.0f, -0.0f});
    EXPECT_EQ(plus.isMiss(), minus.isMiss()) << y;
    EXPECT_EQ(plus.isMiss(), y < 0.0f || y > 1.0f) << y;
    const float culled = entry(kUnitBox, {-1.0f, y, 0.5f}, {1.0f, 0.0f, 0.0f});
    EXPECT_EQ(culled, entry(kUnitBox, {-1.0f, y, 0.5f}, {1.0f, -0.0f, -0.0f}));
    EXPECT_EQ(culled < 0.0f, plus.isMiss()) << y;
    if (plus.isMiss()) continue;
    EXPECT_EQ(plus.tNear, minus.tNear);
    EXPECT_EQ(plus.tFar, minus.tFar);
  }
}

TEST(RayBox, InAFaceIsAHit) {
  const RayInterval interval = meet(kUnitBox, {-1.0f, 1.0f, 0.0f}, {1.0f, 0.0f, 0.0f});
  EXPECT_EQ(interval.tNear, 1.0f);
  EXPECT_EQ(interval.tFar, 2.0f);
  EXPECT_FALSE(meet(kUnitBox, {0.0f, 0.5f, -2.0f}, {0.0f, 0.0f, 1.0f}).isMiss());
  EXPECT_NEAR(entry(kUnitBox, {-1.0f, 1.0f, 0.0f}, {1.0f, 0.0f, 0.0f}), 1.0f, 1e-5f);
  EXPECT_NEAR(entry(kUnitBox, {0.0f, 0.5f, -2.0f}, {0.0f, 0.0f, 1.0f}), 2.0f, 1e-5f);
  EXPECT_EQ(entry(kUnitBox, {0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}), 0.0f);  // begins in a corner
}

TEST(RayBox, FlatBoxIsHit) {
  const Box flat{{0.0f, 0.0f, 0.5f}, {1.0f, 1.0f, 0.5f}};
  const RayInterval interval = meet(flat, {0.5f, 0.5f, 0.0f}, {0.0f, 0.0f, 1.0f});
  EXPECT_EQ(interval.tNear, 0.5f);
  EXPECT_EQ(interval.tFar, 0.5f);
  EXPECT_FALSE(meet({glm::vec3(0.5f), glm::vec3(0.5f)}, glm::vec3(0.0f), glm::vec3(1.0f)).isMiss());
  EXPECT_NEAR(entry(flat, {0.5f, 0.5f, 0.0f}, {0.0f, 0.0f, 1.0f}), 0.5f, 1e-5f);
  EXPECT_GE(entry({glm::vec3(0.5f), glm::vec3(0.5f)}, glm::vec3(0.0f), glm::normalize(glm::vec3(1.0f))), 0.0f);
}

TEST(RayBox, EmptyInvertedAndNanBoxesAreMissed) {
  EXPECT_TRUE(meet(Box{}, glm::vec3(0.5f), {0.0f, 0.0f, 1.0f}).isMiss());
  EXPECT_TRUE(meet({glm::vec3(1.0f), glm::vec3(0.0f)}, {0.5f, 0.5f, -1.0f}, {0.0f, 0.0f, 1.0f}).isMiss());
  for (int axis = 0; axis < 3; ++axis) {
    Box box = kUnitBox;
    box.upper[axis] = std::nanf("");
    EXPECT_TRUE(meet(box, {0.5f, 0.5f, -1.0f}, {0.0f, 0.0f, 1.0f}).isMiss()) << axis;
  }
}

TEST(RayBox, EndlessRayHasTheBoxsInterval) {
  const RayInterval interval = meet(kUnitBox, {0.5f, 0.5f, 0.5f}, {0.0f, 1.0f, 0.0f});
  EXPECT_EQ(interval.tNear, 0.0f);
  EXPECT_EQ(interval.tFar, 0.5f);
  EXPECT_TRUE(meet(kUnitBox, {0.5f, 2.0f, 0.5f}, {0.0f, 1.0f, 0.0f}).isMiss());
  EXPECT_EQ(entry(kUnitBox, {0.5f, 0.5f, 0.5f}, {0.0f, 1.0f, 0.0f}), 0.0f);
  EXPECT_LT(entry(kUnitBox, {0.5f, 2.0f, 0.5f}, {0.0f, 1.0f, 0.0f}), 0.0f);
}

TEST(RayBox, SharedEdgesHaveNoCracks) {
  // Four boxes around the edge x = y = 1/3; rays from anywhere to points on that edge.
  const float third = 1.0f / 3.0f;
  std::mt19937 random(18);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  for (int i = 0; i < 100000; ++i) {
    const glm::vec3 target(third, third, 0.9f * unit(random));
    const glm::vec3 origin =
        target + std::pow(10.0f, 3.0f * unit(random)) * glm::vec3(unit(random), unit(random), unit(random));
    bool hit = false;
    for (const glm::vec2 corner : {glm::vec2(-1, -1), glm::vec2(-1, 1), glm::vec2(1, -1), glm::vec2(1, 1)}) {
      const glm::vec3 far(corner, 1.0f), near(third, third, -1.0f);
      hit = hit || entry({glm::min(far, near), glm::max(far, near)}, origin, glm::normalize(target - origin)) >= 0.0f;
    }
    ASSERT_TRUE(hit) << "seed 18, ray " << i;
  }
}

RC_GTEST_PROP(RayBox, IsTheTrueIntervalAndCullingLosesNothing, (uint32_t seed)) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  for (int i = 0; i < 200; ++i) {
    const auto vector = [&] { return glm::vec3(unit(random), unit(random), unit(random)); };
    const glm::vec3 center = std::pow(10.0f, 4.0f * unit(random)) * vector();
    const glm::vec3 half = std::pow(10.0f, 2.0f * unit(random)) * glm::abs(vector());
    const Box box{center - half, center + half};
    const glm::vec3 origin = std::pow(10.0f, 4.0f * unit(random)) * vector();
    // Towards a corner: the ray grazes three faces.
    const glm::vec3 direction = glm::normalize(glm::vec3(unit(random) < 0 ? box.lower.x : box.upper.x,
                                                         unit(random) < 0 ? box.lower.y : box.upper.y,
                                                         unit(random) < 0 ? box.lower.z : box.upper.z) -
                                               origin);
    Exact exactNear = 0, exactFar = 1e30;
    for (int axis = 0; axis < 3; ++axis) {
      if (direction[axis] == 0.0f) continue;
      const Exact a = (Exact(box.lower[axis]) - origin[axis]) / Exact(direction[axis]);
      const Exact b = (Exact(box.upper[axis]) - origin[axis]) / Exact(direction[axis]);
      exactNear = std::max(exactNear, std::min(a, b));
      exactFar = std::min(exactFar, std::max(a, b));
    }
    if (exactNear > exactFar) continue;
    const float entered = entry(box, origin, direction);
    RC_ASSERT(entered >= 0.0f);
    RC_ASSERT(Exact(entered) <= exactNear);
    const Exact tolerance = exactFar * 4 / 16777216;
    const RayInterval interval = meet(box, origin, direction);
    if (exactFar - exactNear > 2 * tolerance) RC_ASSERT(!interval.isMiss());
    RC_ASSERT(abs(Exact(interval.tNear) - exactNear) <= tolerance);
    RC_ASSERT(abs(Exact(interval.tFar) - exactFar) <= tolerance);
  }
}

}  // namespace
}  // namespace warpscope
