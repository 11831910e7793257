// Rays against boxes: cases 13 to 18. Intervals by 100 decimal digits, hits and misses with ties left open.
// Mirrors render/core/box.h, and the box test of render/warp/lbvh/lbvh.h, which must lose no hit.
#include "render/core/box.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "render/warp/lbvh/lbvh.h"
#include "tests/stability/backends.h"
#include "tests/stability/device_probe.h"
#include "tests/stability/exact.h"
#include "tests/stability/magnitudes.h"
#include "tests/stability/probes.h"
#include "tests/stability/record.h"

namespace warpscope {
namespace {

const Box kUnitBox{glm::vec3(0.0f), glm::vec3(1.0f)};

/// Both tests of boxes on one backend.
struct Boxes {
  Backend backend;

  RayInterval meet(const Box& box, const glm::vec3& origin, const glm::vec3& direction) const {
    return evaluate<BoxProbe>(backend, BoxProbe::Input{origin, direction, box});
  }
  /// The test that culls: where the ray enters the box, widened a little; negative if it misses that.
  float entry(const Box& box, const glm::vec3& origin, const glm::vec3& direction) const {
    return evaluate<CullProbe>(backend, BoxProbe::Input{origin, direction, box});
  }
};

TEST_P(Case13, NegativeZeroIsZero) {
  const Boxes boxes{GetParam()};
  for (const float y : {-0.5f, 0.0f, 0.5f, 1.0f, 1.5f}) {
    const RayInterval plus = boxes.meet(kUnitBox, {-1.0f, y, 0.5f}, {1.0f, 0.0f, 0.0f});
    const RayInterval minus = boxes.meet(kUnitBox, {-1.0f, y, 0.5f}, {1.0f, -0.0f, -0.0f});
    EXPECT_EQ(plus.isMiss(), minus.isMiss()) << y;
    EXPECT_EQ(plus.isMiss(), y < 0.0f || y > 1.0f) << y;
    const float culled = boxes.entry(kUnitBox, {-1.0f, y, 0.5f}, {1.0f, 0.0f, 0.0f});
    EXPECT_EQ(culled, boxes.entry(kUnitBox, {-1.0f, y, 0.5f}, {1.0f, -0.0f, -0.0f}));
    EXPECT_EQ(culled < 0.0f, plus.isMiss()) << y;
    if (plus.isMiss()) continue;
    EXPECT_EQ(plus.tNear, minus.tNear);
    EXPECT_EQ(plus.tFar, minus.tFar);
  }
  recordExact("intersectBox, entryDistance, components of -0", "components of +0", GetParam());
}

TEST_P(Case14, InAFaceIsAHit) {
  const Boxes boxes{GetParam()};
  const RayInterval interval = boxes.meet(kUnitBox, {-1.0f, 1.0f, 0.0f}, {1.0f, 0.0f, 0.0f});
  EXPECT_EQ(interval.tNear, 1.0f);
  EXPECT_EQ(interval.tFar, 2.0f);
  EXPECT_FALSE(boxes.meet(kUnitBox, {0.0f, 0.5f, -2.0f}, {0.0f, 0.0f, 1.0f}).isMiss());
  EXPECT_NEAR(boxes.entry(kUnitBox, {-1.0f, 1.0f, 0.0f}, {1.0f, 0.0f, 0.0f}), 1.0f, 1e-5f);
  EXPECT_NEAR(boxes.entry(kUnitBox, {0.0f, 0.5f, -2.0f}, {0.0f, 0.0f, 1.0f}), 2.0f, 1e-5f);
  EXPECT_EQ(boxes.entry(kUnitBox, {0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}), 0.0f);  // begins in a corner
  recordExact("intersectBox, a ray in a face", "closed form", GetParam());
}

TEST_P(Case15, AFlatBoxIsHit) {
  const Boxes boxes{GetParam()};
  const Box flat{{0.0f, 0.0f, 0.5f}, {1.0f, 1.0f, 0.5f}};
  const RayInterval interval = boxes.meet(flat, {0.5f, 0.5f, 0.0f}, {0.0f, 0.0f, 1.0f});
  EXPECT_EQ(interval.tNear, 0.5f);
  EXPECT_EQ(interval.tFar, 0.5f);
  EXPECT_FALSE(boxes.meet({glm::vec3(0.5f), glm::vec3(0.5f)}, glm::vec3(0.0f), glm::vec3(1.0f)).isMiss());
  EXPECT_NEAR(boxes.entry(flat, {0.5f, 0.5f, 0.0f}, {0.0f, 0.0f, 1.0f}), 0.5f, 1e-5f);
  EXPECT_GE(boxes.entry({glm::vec3(0.5f), glm::vec3(0.5f)}, glm::vec3(0.0f), glm::normalize(glm::vec3(1.0f))), 0.0f);
  recordExact("intersectBox, a flat box", "closed form", GetParam());
}

TEST_P(Case16, EmptyAndInvertedBoxesAreMissed) {
  const Boxes boxes{GetParam()};
  EXPECT_TRUE(boxes.meet(Box{}, glm::vec3(0.5f), {0.0f, 0.0f, 1.0f}).isMiss());
  for (int axis = 0; axis < 3; ++axis) {
    Box inverted = kUnitBox;
    std::swap(inverted.lower[axis], inverted.upper[axis]);
    EXPECT_TRUE(boxes.meet(inverted, {0.5f, 0.5f, -1.0f}, {0.0f, 0.0f, 1.0f}).isMiss()) << axis;
    EXPECT_TRUE(boxes.meet(inverted, glm::vec3(0.5f), {0.0f, 0.0f, 1.0f}).isMiss()) << axis;
  }
  recordExact("intersectBox, empty and inverted boxes", "definition", GetParam());
}

TEST_P(Case17, AnEndlessRayHasTheBoxsInterval) {
  const Boxes boxes{GetParam()};
  const RayInterval interval = boxes.meet(kUnitBox, {0.5f, 0.5f, 0.5f}, {0.0f, 1.0f, 0.0f});
  EXPECT_EQ(interval.tNear, 0.0f);
  EXPECT_EQ(interval.tFar, 0.5f);
  EXPECT_TRUE(boxes.meet(kUnitBox, {0.5f, 2.0f, 0.5f}, {0.0f, 1.0f, 0.0f}).isMiss());
  EXPECT_EQ(boxes.entry(kUnitBox, {0.5f, 0.5f, 0.5f}, {0.0f, 1.0f, 0.0f}), 0.0f);
  EXPECT_LT(boxes.entry(kUnitBox, {0.5f, 2.0f, 0.5f}, {0.0f, 1.0f, 0.0f}), 0.0f);
  recordExact("intersectBox, tMax infinite", "closed form", GetParam());
}

TEST_P(Case17, BoundsThatAreNoNumbersAreMissed) {
  const Boxes boxes{GetParam()};
  for (int axis = 0; axis < 3; ++axis)
    for (const bool isUpper : {false, true}) {
      Box box = kUnitBox;
      (isUpper ? box.upper : box.lower)[axis] = std::nanf("");
      EXPECT_TRUE(boxes.meet(box, {0.5f, 0.5f, -1.0f}, {0.0f, 0.0f, 1.0f}).isMiss()) << axis;
    }
  recordExact("intersectBox, NaN bounds", "definition", GetParam());
}

TEST_P(Case18, SharedEdgesHaveNoCracks) {
  // Four boxes around the edge x = y = 1/3; rays from anywhere to points on that edge.
  constexpr int kRays = 100000;
  const float third = 1.0f / 3.0f;
  std::mt19937 random(18);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  std::vector<BoxProbe::Input> inputs;
  for (int i = 0; i < kRays; ++i) {
    const glm::vec3 target(third, third, 0.9f * unit(random));
    const glm::vec3 origin =
        target + std::pow(10.0f, 3.0f * unit(random)) * glm::vec3(unit(random), unit(random), unit(random));
    for (const glm::vec2 corner : {glm::vec2(-1, -1), glm::vec2(-1, 1), glm::vec2(1, -1), glm::vec2(1, 1)}) {
      const glm::vec3 far(corner, 1.0f), near(third, third, -1.0f);
      inputs.push_back({origin, glm::normalize(target - origin), {glm::min(far, near), glm::max(far, near)}});
    }
  }
  const std::vector<float> entries = evaluate<CullProbe>(GetParam(), inputs);
  size_t cracks = 0;
  for (size_t i = 0; i < entries.size(); i += 4)
    cracks += entries[i] < 0.0f && entries[i + 1] < 0.0f && entries[i + 2] < 0.0f && entries[i + 3] < 0.0f;
  record({"entryDistance, rays along a shared edge (seed 18)", "definition", "cracks in 1e5",
          static_cast<double>(cracks), 0.0, GetParam()});
}

struct TrueInterval {
  Exact tNear = 0, tFar = Exact("1e300");
};

TrueInterval trueInterval(const BoxCase& c) {
  TrueInterval truth;
  for (int axis = 0; axis < 3; ++axis) {
    if (c.direction[axis] == 0.0f) {
      // Parallel to the slab: all of the ray, or none.
      if (c.origin[axis] < c.box.lower[axis] || c.origin[axis] > c.box.upper[axis]) truth.tFar = -1;
      continue;
    }
    const Exact a = (Exact(c.box.lower[axis]) - c.origin[axis]) / Exact(c.direction[axis]);
    const Exact b = (Exact(c.box.upper[axis]) - c.origin[axis]) / Exact(c.direction[axis]);
    truth.tNear = std::max(truth.tNear, std::min(a, b));
    truth.tFar = std::min(truth.tFar, std::max(a, b));
  }
  return truth;
}

TEST_P(Case17, PropertyIsTheTrueIntervalAndCullingLosesNothing) {
  Worst worst;
  checkProperty([&] {
    const auto cases = *rc::gen::container<std::vector<BoxCase>>(anyBoxCase(-30, 30));
    std::vector<BoxProbe::Input> inputs;
    for (const BoxCase& c : cases) inputs.push_back({c.origin, c.direction, c.box});
    const std::vector<RayInterval> intervals = evaluate<BoxProbe>(GetParam(), inputs);
    const std::vector<float> entries = evaluate<CullProbe>(GetParam(), inputs);
    for (size_t i = 0; i < cases.size(); ++i) {
      const TrueInterval truth = trueInterval(cases[i]);
      const Exact tolerance = abs(truth.tFar) * Exact(2 * kBoxDistanceError);  // of both ends together
      const RayInterval& interval = intervals[i];
      RC_ASSERT(!std::isnan(interval.tNear));
      RC_ASSERT(!std::isnan(interval.tFar));
      if (truth.tFar < 0 || truth.tNear - truth.tFar > tolerance) {
        RC_ASSERT(interval.isMiss());
        continue;
      }
      if (truth.tNear <= truth.tFar) {
        RC_ASSERT(entries[i] >= 0.0f);
        RC_ASSERT(Exact(entries[i]) <= truth.tNear);
      }
      if (truth.tFar - truth.tNear > tolerance) RC_ASSERT(!interval.isMiss());
      if (interval.isMiss()) continue;  // a tie
      for (const auto& [found, exact] :
           {std::pair(Exact(interval.tNear), truth.tNear), std::pair(Exact(interval.tFar), truth.tFar)}) {
        const double error = exact == 0 ? (found == 0 ? 0.0 : kNoHit) : roundoffs(found, exact, exact);
        RC_ASSERT(error * kUnitRoundoff <= kBoxDistanceError);
        worst.see(error);
      }
    }
  });
  record(
      {"intersectBox, the ends", "100 digits", "u of t", worst.value(), kBoxDistanceError / kUnitRoundoff, GetParam()});
}

TEST_P(Case17, PropertyNeverNotANumberWhateverTheMagnitude) {
  checkProperty([&] {
    std::vector<BoxProbe::Input> inputs;
    for (const auto& [origin, direction, a, b] :
         *rc::gen::container<std::vector<std::tuple<glm::vec3, glm::vec3, glm::vec3, glm::vec3>>>(
             rc::gen::tuple(anyVector(), anyDirection(), anyVector(), anyVector())))
      inputs.push_back({origin, direction, {glm::min(a, b), glm::max(a, b)}});
    for (const RayInterval& interval : evaluate<BoxProbe>(GetParam(), inputs)) {
      RC_ASSERT(!std::isnan(interval.tNear));
      RC_ASSERT(!std::isnan(interval.tFar));
      RC_ASSERT(interval.tNear >= 0.0f);
    }
  });
  recordExact("intersectBox, never NaN from 1e-30 to 1e30", "IEEE 754", GetParam());
}

TEST_P(Case18, PropertyBoxesNeverCullAHit) {
  checkProperty([&] {
    const auto cases = *rc::gen::container<std::vector<SphereCase>>(anySphereCase(-20, 20));
    std::vector<SphereProbe::Input> spheres;
    std::vector<BoxProbe::Input> boxes;
    for (const SphereCase& c : cases) {
      spheres.push_back({c.ray, c.center, c.radius});
      boxes.push_back({c.ray.origin, c.ray.direction, sphereBounds({c.center, c.radius})});
    }
    const std::vector<float> hits = evaluate<SphereProbe>(GetParam(), spheres),
                             entries = evaluate<CullProbe>(GetParam(), boxes);
    for (size_t i = 0; i < cases.size(); ++i) {
      if (hits[i] == kNoHit) continue;
      RC_ASSERT(entries[i] >= 0.0f);
      RC_ASSERT(entries[i] <= hits[i]);
    }
  });
  recordExact("entryDistance of spheres' boxes: no hit is lost", "intersectSphere", GetParam());
}

}  // namespace
}  // namespace warpscope
