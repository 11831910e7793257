// Merging a ray's samples into segments: against the closed form, against the cheapest merges found by looking at all, and what rounding to codes leaves.
// Mirrors render/march/ray_segments.h and render/march/frame_segments.h.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "render/core/opacity.h"
#include "render/march/segment_encoder.h"
#include "render/march/ray_segments.h"

namespace warpscope {
namespace {

std::vector<RaySegment> listOf(const SegmentMerger& merger) {
  std::vector<RaySegment> all;
  for (int i = merger.first(); i != SegmentMerger::kNone; i = merger.behind(i)) all.push_back(merger[i]);
  return all;
}

/// Steps of a ray with these opacities and colours, one after the other from t on.
std::vector<RaySegment> stepsOf(const std::vector<std::pair<float, glm::vec3>>& samples, float t, float dt) {
  std::vector<RaySegment> steps;
  double through = 1.0;
  for (const auto& [opacity, color] : samples) {
    if (opacity > 0.0f) steps.push_back({t, t + dt, opacity, static_cast<float>(through), color * opacity});
    through *= 1.0 - static_cast<double>(opacity);
    t += dt;
  }
  return steps;
}

struct Whole {
  glm::dvec3 color{0.0};
  double through = 1.0;
};
template <class Segments>
Whole overAll(const Segments& segments) {
  Whole whole;
  for (const RaySegment& segment : segments) {
    whole.color += whole.through * glm::dvec3(segment.color);
    whole.through *= 1.0 - static_cast<double>(segment.opacity);
  }
  return whole;
}

std::vector<RaySegment> randomSteps(std::mt19937& random, int count) {
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  std::vector<std::pair<float, glm::vec3>> samples;
  float opacity = 0.0f;
  glm::vec3 color(0.5f);
  for (int i = 0; i < count; ++i) {
    if (unit(random) < 0.15f) opacity = unit(random) < 0.4f ? 0.0f : std::pow(unit(random), 4.0f);
    if (unit(random) < 0.2f) color = {unit(random), unit(random), unit(random)};
    samples.push_back({opacity, color});
  }
  return stepsOf(samples, 3.0f, 0.5f);
}

TEST(RaySegments, AThousandSamplesMergedToOneAreTheClosedForm) {
  for (const float opacity : {1e-8f, 1e-4f, 0.004f}) {
    SegmentMerger merger(kMostMergerRoom);
    for (const RaySegment& step : stepsOf(std::vector(1000, std::pair(opacity, glm::vec3(0.25f, 0.5f, 1.0f))), 2.0f, 0.25f)) merger.add(step);
    RayLattice lattice;
    lattice.t0 = 2.0f, lattice.length = 250.0f, lattice.dt = 0.25f, lattice.count = 1000;
    merger.finish(1, lattice);
    ASSERT_EQ(merger.size(), 1);
    const RaySegment& only = merger[merger.first()];
    const double expected = -std::expm1(1000.0 * std::log1p(-static_cast<double>(opacity)));
    EXPECT_NEAR(static_cast<double>(only.opacity), expected, 1e-4 * expected) << opacity;
    for (int channel = 0; channel < 3; ++channel)
      EXPECT_NEAR(static_cast<double>(only.color[channel]), expected * static_cast<double>(glm::vec3(0.25f, 0.5f, 1.0f)[channel]), 1e-4 * expected);
    // Of what is nearly opaque the depth that a merge weighs by is too small.
    const float most = expected < 0.5 ? 0.0f : 0.04f * lattice.length;
    EXPECT_NEAR(only.begin, 2.0f, most);
    EXPECT_NEAR(only.end, 252.0f, most);
  }
}

TEST(RaySegments, KeepLightAndOpacityHoweverTheyAreMerged) {
  std::mt19937 random(7);
  for (int round = 0; round < 300; ++round) {
    const std::vector<RaySegment> steps = randomSteps(random, 1 + round % 120);
    const Whole expected = overAll(steps);
    for (const int most : {1, 2, 4, 16}) {
      SegmentMerger merger(mergerRoomFor(most));
      for (const RaySegment& step : steps) merger.add(step);
      merger.reduceTo(most);
      EXPECT_LE(merger.size(), most);
      EXPECT_EQ(merger.size() == 0, steps.empty());
      const std::vector<RaySegment> segments = listOf(merger);
      const Whole found = overAll(segments);
      EXPECT_NEAR(found.through, expected.through, 2e-5) << round;
      for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(found.color[channel], expected.color[channel], 2e-5) << round;
      for (size_t i = 0; i < segments.size(); ++i) {
        EXPECT_LT(segments[i].begin, segments[i].end);
        if (i > 0) EXPECT_LE(segments[i - 1].end, segments[i].begin);
      }
    }
  }
}

TEST(RaySegments, NoMoreThanTheRayHasAreMade) {
  SegmentMerger merger(kMostMergerRoom);
  for (const RaySegment& step : stepsOf({{0.2f, glm::vec3(1.0f)}, {0.0f, glm::vec3(1.0f)}, {0.3f, glm::vec3(0.5f)}}, 0.0f, 1.0f)) merger.add(step);
  merger.reduceTo(16);
  EXPECT_EQ(merger.size(), 2);
}

/// While there is room for all, each merge is the one that costs least.
TEST(RaySegments, TheCheapestPairIsMergedFirst) {
  std::mt19937 random(11);
  for (int round = 0; round < 200; ++round) {
    std::vector<RaySegment> all = randomSteps(random, 16);
    if (all.size() > kMostMergerRoom) continue;
    SegmentMerger merger(kMostMergerRoom);
    for (const RaySegment& step : all) merger.add(step);
    merger.reduceTo(3);
    while (all.size() > 3) {
      size_t cheapest = 0;
      for (size_t i = 1; i + 1 < all.size(); ++i)
        if (squaredMergeCost(all[i], all[i + 1]) < squaredMergeCost(all[cheapest], all[cheapest + 1])) cheapest = i;
      mergeInto(all[cheapest], all[cheapest + 1]);
      all.erase(all.begin() + static_cast<ptrdiff_t>(cheapest) + 1);
    }
    const std::vector<RaySegment> found = listOf(merger);
    ASSERT_EQ(found.size(), all.size());
    for (size_t i = 0; i < all.size(); ++i) {
      EXPECT_EQ(found[i].begin, all[i].begin) << round;
      EXPECT_EQ(found[i].end, all[i].end) << round;
    }
  }
}

/// Light times length.
float mergeCost(const RaySegment& front, const RaySegment& back) { return std::sqrt(squaredMergeCost(front, back)); }

TEST(RaySegments, WhatIsAlikeCostsNothingAndGapsCost) {
  const RaySegment a{0.0f, 2.0f, 0.5f, 1.0f, glm::vec3(0.25f)};
  const RaySegment same{2.0f, 4.0f, 0.5f, 0.5f, glm::vec3(0.25f)}, apart{5.0f, 7.0f, 0.5f, 0.5f, glm::vec3(0.25f)}, red{2.0f, 4.0f, 0.5f, 0.5f, {0.5f, 0.0f, 0.0f}},
      dense{2.0f, 2.5f, 0.5f, 0.5f, glm::vec3(0.25f)}, hidden{5.0f, 7.0f, 0.5f, 0.0f, glm::vec3(0.25f)};
  const RaySegment faint{0.0f, 2.0f, 1e-3f, 1.0f, glm::vec3(1e-3f)}, faintToo{2.0f, 4.0f, 1e-3f, 0.999f, glm::vec3(1e-3f)};
  EXPECT_LT(mergeCost(faint, faintToo), 1e-3f * mergeCost(a, apart));
  EXPECT_LT(mergeCost(a, same), 0.5f * mergeCost(a, apart));  // of dense ones light comes from the front one
  EXPECT_GT(mergeCost(a, apart), 0.1f);
  EXPECT_GT(mergeCost(a, red), 0.05f);
  EXPECT_GT(mergeCost(a, dense), 0.05f);
  EXPECT_EQ(mergeCost(a, hidden), 0.0f);
}

/// Two neighbours with a gap or none, as long and as dense as it comes.
std::pair<RaySegment, RaySegment> randomPair(std::mt19937& random) {
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  const auto length = [&] { return 4.0f * unit(random) * unit(random); };
  RaySegment front{3.0f, 0.0f, 0.999f * unit(random) * unit(random), 0.7f, glm::vec3(0.1f)};
  front.end = front.begin + length();
  RaySegment back{front.end + (unit(random) < 0.5f ? 0.0f : length()), 0.0f, 0.999f * unit(random), 0.7f * (1.0f - front.opacity), glm::vec3(0.1f)};
  back.end = back.begin + length();
  return {front, back};
}

TEST(RaySegments, WhatTwoBecomeHasTheirMeanPlaceAndSpread) {
  std::mt19937 random(3);
  for (int round = 0; round < 2000; ++round) {
    const auto [front, back] = randomPair(random);
    const RayExtent both = mergedExtent(front, back);
    const auto depthOf = [](float opacity) { return static_cast<double>(opacity) / (1.0 - 0.5 * static_cast<double>(opacity)); };
    const double a = depthOf(front.opacity), b = depthOf(back.opacity), middleA = 0.5 * static_cast<double>(front.begin + front.end), middleB = 0.5 * static_cast<double>(back.begin + back.end);
    const double mean = (a * middleA + b * middleB) / (a + b);
    // Between any two places: both in the front one, both in the back one, one in each.
    const double apart = (a * a * static_cast<double>(front.length()) / 3.0 + b * b * static_cast<double>(back.length()) / 3.0 + 2.0 * a * b * (middleB - middleA)) / ((a + b) * (a + b));
    const double half = 1.5 * apart;  // of what is homogeneous
    EXPECT_NEAR(static_cast<double>(both.begin), std::max(static_cast<double>(front.begin), mean - half), 1e-5) << round;
    EXPECT_NEAR(static_cast<double>(both.end), std::min(static_cast<double>(back.end), mean + half), 1e-5) << round;
  }
  // A surface behind some haze stays thin, in front of it as well; what is homogeneous stays what it is.
  const RaySegment haze{0.0f, 8.0f, 0.02f, 1.0f, glm::vec3(0.02f)}, surface{8.0f, 8.5f, 0.98f, 0.98f, glm::vec3(0.98f)}, hazeBehind{8.5f, 16.5f, 0.02f, 0.0196f, glm::vec3(0.02f)};
  EXPECT_LT(mergedExtent(haze, surface).length(), 2.0f);
  EXPECT_LT(mergedExtent(surface, hazeBehind).length(), 2.0f);
  const RaySegment half{0.0f, 2.0f, 0.75f, 1.0f, glm::vec3(0.5f)}, otherHalf{2.0f, 4.0f, 0.75f, 0.25f, glm::vec3(0.5f)};
  EXPECT_EQ(mergedExtent(half, otherHalf).begin, 0.0f);
  EXPECT_EQ(mergedExtent(half, otherHalf).end, 4.0f);
}

TEST(RaySegments, LightIsMovedAboutByWhatTheIntegralSays) {
  std::mt19937 random(5);
  const auto squared = [](float cost) { return cost * cost; };
  int surely = 0, isFound = 0, isNear = 0, isClose = 0;  // distances, roots of the integral, are within 0.3 and 1.4 of it; within 0.8 and 1.2
  for (int round = 0; round < 300; ++round) {
    const auto [front, back] = randomPair(random);
    const RayExtent both = mergedExtent(front, back);
    const double light = static_cast<double>(front.contribution()) + static_cast<double>(back.contribution()), share = static_cast<double>(back.contribution()) / light;
    const auto sentUpTo = [](double t, const glm::dvec2& ends) { return std::clamp(ends.y > ends.x ? (t - ends.x) / (ends.y - ends.x) : t > ends.x ? 1.0 : 0.0, 0.0, 1.0); };
    constexpr int kPlaces = 4000;
    const auto from = static_cast<double>(front.begin), to = static_cast<double>(back.end);
    const glm::dvec2 ofFront(front.begin, front.end), ofBack(back.begin, back.end), ofBoth(both.begin, both.end);
    double sum = 0.0;
    for (int i = 0; i < kPlaces; ++i) {
      const double t = from + (i + 0.5) / kPlaces * (to - from);
      const double difference = (1.0 - share) * sentUpTo(t, ofFront) + share * sentUpTo(t, ofBack) - sentUpTo(t, ofBoth);
      sum += difference * difference * (to - from) / kPlaces;
    }
    const auto found = static_cast<double>(squaredDifference(front, back, both, 1.0f / both.length(), static_cast<float>(share)));
    const double distance = std::sqrt(std::max(found, 0.0)), expected = std::sqrt(sum);
    isNear += distance > 0.3 * expected - 0.01 && distance < 1.4 * expected + 0.01 ? 1 : 0;
    isClose += std::abs(distance - expected) < 0.2 * expected + 0.01 ? 1 : 0;
    EXPECT_LT(found, 12.0 * sum + 1e-3) << round;
    // They are of one colour, but for how much of it there is.
    RaySegment alikeFront = front, alikeBack = back;
    alikeFront.color = glm::vec3(front.opacity), alikeBack.color = glm::vec3(back.opacity);
    const double cost = static_cast<double>(mergeCost(alikeFront, alikeBack));
    EXPECT_NEAR(cost, light * std::sqrt((to - from) * found), 1e-3 * light * (to - from)) << round;
    // What is surely at most something hardly ever costs more; and is found out where there is some room.
    surely += isSurelyAtMost(alikeFront, alikeBack, squared(std::max(0.999f * mergeCost(alikeFront, alikeBack) - 1e-6f, 0.0f))) ? 1 : 0;
    isFound += isSurelyAtMost(alikeFront, alikeBack, squared(4.0f * mergeCost(alikeFront, alikeBack) + 1e-3f)) ? 1 : 0;
  }
  EXPECT_GE(isNear, 270);
  EXPECT_GE(isClose, 200);
  EXPECT_LT(surely, 30);
  EXPECT_GT(isFound, 150);
}

/// Points stay where they are.
TEST(RaySegments, FinishedOnesBeginAndEndWhereStepsDo) {
  std::mt19937 random(9);
  RayLattice lattice;
  lattice.t0 = 3.0f, lattice.dt = 0.5f, lattice.count = 100, lattice.length = 49.8f;
  int merged = 0;
  for (int round = 0; round < 300; ++round) {
    std::vector<RaySegment> steps = randomSteps(random, 100);
    const bool arePoints = round % 3 == 0;
    for (RaySegment& step : steps) {
      if (arePoints) step.end = step.begin += 0.123f;
      step.end = std::min(step.end, lattice.t0 + lattice.length);
    }
    SegmentMerger reduced(mergerRoomFor(4)), finished(mergerRoomFor(4));
    for (const RaySegment& step : steps) reduced.add(step), finished.add(step);
    reduced.reduceTo(4);
    finished.finish(4, lattice);
    const std::vector<RaySegment> before = listOf(reduced), after = listOf(finished);
    ASSERT_EQ(before.size(), after.size());
    for (size_t i = 0; i < after.size(); ++i) {
      EXPECT_EQ(after[i].opacity, before[i].opacity);
      if (i > 0) EXPECT_LE(after[i - 1].end, after[i].begin);
      if (!(before[i].length() > 0.0f)) {
        EXPECT_EQ(after[i].begin, before[i].begin);
        EXPECT_EQ(after[i].end, before[i].end);
        continue;
      }
      ++merged;
      for (const auto& [was, is] : {std::pair(before[i].begin, after[i].begin), std::pair(before[i].end, after[i].end)}) {
        EXPECT_LE(std::abs(is - was), 0.5f + 1e-5f);
        if (arePoints) continue;
        const int border = static_cast<int>(std::lround((is - lattice.t0) / lattice.dt));
        EXPECT_EQ(is, lattice.border(border)) << round;
      }
      EXPECT_LT(after[i].begin, after[i].end);
    }
  }
  EXPECT_GT(merged, 500);
}

/// Surfaces have no length, opacity 1 ends everything.
TEST(RaySegments, OfNoLengthAndOfFullOpacity) {
  SegmentMerger merger(kMostMergerRoom);
  float through = 1.0f;
  for (int i = 0; i < 40; ++i) {
    merger.add({static_cast<float>(i), static_cast<float>(i), 0.1f, through, glm::vec3(0.1f)});
    through *= 0.9f;
  }
  merger.add({40.0f, 40.5f, 1.0f, through, glm::vec3(1.0f)});
  merger.reduceTo(4);
  const Whole whole = overAll(listOf(merger));
  EXPECT_EQ(whole.through, 0.0);
  EXPECT_NEAR(whole.color.x, 1.0, 1e-5);
}

/// Of rays whose straight colours are at most `brightest`.
void expectCodesToShowWhatRaysShow(bool hasNormals, float brightest) {
  const ColorTables& tables = ColorTables::instance();
  std::mt19937 random(23);
  SampleQuantization quantization;
  quantization.depthStep = 1.0f / 512;
  double worst = 0.0;
  for (int round = 0; round < 2000; ++round) {
    std::vector<RaySegment> steps = randomSteps(random, 100);
    const int most = 1 + round % 16;
    SegmentMerger merger(mergerRoomFor(most));
    for (RaySegment& step : steps) {
      step.color *= brightest;
      merger.add(step);
    }
    const Whole expected = overAll(listOf(merger));
    merger.reduceTo(most);
    std::vector<SegmentDepths> depths(16);
    std::vector<Rgba8> colors(16);
    const RaySegmentCount count = storeSegments(merger, false, SegmentEncoder(tables, quantization, 0.8f, hasNormals), {depths.data(), colors.data(), nullptr},
                                                [](int) { return NormalCode{0}; });
    glm::dvec3 color(0.0);
    double through = 1.0;
    for (int i = 0; i < count.count(); ++i) {
      const glm::vec4 decoded = segmentColor(tables, colors[static_cast<size_t>(i)], segmentColorScale(hasNormals));
      color += through * glm::dvec3(decoded);
      through *= 1.0 - static_cast<double>(decoded.a);
      EXPECT_LE(depths[static_cast<size_t>(i)].begin, depths[static_cast<size_t>(i)].end);
      if (i > 0) EXPECT_LE(depths[static_cast<size_t>(i) - 1].end, depths[static_cast<size_t>(i)].begin);
    }
    // Where colours are scaled their codes are farther apart.
    const double apart = 1.0 / static_cast<double>(segmentColorScale(hasNormals));
    // A code, and what a segment was not given because it has hardly any opacity itself.
    EXPECT_NEAR(through, expected.through, 1.5 / 255) << round;
    const double opacity = 1.0 - through;
    for (int channel = 0; channel < 3; ++channel) {
      // Half a code of the colour, where the sRGB curve is steepest, and what opacity is off by.
      const double difference = std::abs(color[channel] - expected.color[channel]);
      worst = std::max(worst, difference);
      EXPECT_LT(difference, opacity * apart * 0.5 / 255 * 2.4 + apart * 1.5 / 255) << round;
    }
  }
  testing::Test::RecordProperty("worst", std::to_string(worst));
}

TEST(FrameSegments, RoundedToCodesTheyShowWhatTheRayShows) { expectCodesToShowWhatRaysShow(false, 1.0f); }

/// Highlights add to what is white.
TEST(FrameSegments, WhereTheyAreLitTheyMayBeBrighterThanWhite) { expectCodesToShowWhatRaysShow(true, 2.0f); }

TEST(Opacity, OfAnOpticalDepthIsOneMinusItsExponential) {
  double worst = 0.0;
  for (double depth = 1e-12; depth < 100.0; depth *= 1.001) {
    const auto given = static_cast<float>(depth);
    const double expected = -std::expm1(-static_cast<double>(given));
    worst = std::max(worst, std::abs(static_cast<double>(opacityOf(given)) - expected) / expected);
  }
  EXPECT_LT(worst, kDepthOpacityError);
  EXPECT_EQ(opacityOf(0.0f), 0.0f);
  EXPECT_EQ(opacityOf(-1.0f), 0.0f);
  EXPECT_EQ(opacityOf(NAN), 0.0f);
  EXPECT_EQ(opacityOf(INFINITY), 1.0f);
}

}  // namespace
}  // namespace warpscope
