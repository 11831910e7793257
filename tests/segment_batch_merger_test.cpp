// All pairs at once become what one pair after the other does, bit for bit.
// Mirrors render/march/segment_batch_merger.h.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include "render/march/segment_batch_merger.h"

namespace warpscope {
namespace {

/// What rays meet: haze, surfaces, stretches that are alike to the last bit, gaps, points, and what lies behind so much that hardly any light of it is left.
std::vector<RaySegment> randomRay(std::mt19937& random, const RayLattice& lattice, int count, bool arePoints) {
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  std::vector<RaySegment> samples;
  float opacity = 0.1f, through = 1.0f;
  glm::vec3 color(0.5f);
  for (int i = 0; i < count; ++i) {
    if (unit(random) < 0.3f) opacity = unit(random) < 0.2f ? 0.0f : std::pow(unit(random), 6.0f);
    if (unit(random) < 0.02f) opacity = 1.0f;
    if (unit(random) < 0.2f) color = {unit(random), unit(random), unit(random)};
    if (opacity > 0.0f) samples.push_back({lattice.border(i), arePoints ? lattice.border(i) : lattice.border(i + 1), opacity, through, color * opacity});
    through *= 1.0f - opacity;
  }
  return samples;
}

void expectSame(const SegmentBatchMerger& found, const SegmentMerger& expected, int round) {
  ASSERT_EQ(found.size(), expected.size()) << round;
  int i = found.first();
  for (int j = expected.first(); j != SegmentMerger::kNone; j = expected.behind(j), i = found.behind(i)) {
    const RaySegment own = found[i], other = expected[j];
    ASSERT_EQ(std::memcmp(&own, &other, sizeof own), 0) << "round " << round << ", segment " << i << " of " << found.size();
    ASSERT_EQ(found.placeOf(i), j) << round;
  }
  EXPECT_EQ(i, SegmentBatchMerger::kNone);
}

struct SampledRay {
  RayLattice lattice;
  std::vector<RaySegment> samples;
};
SampledRay rayOf(int round, std::mt19937& random) {
  SampledRay ray;
  ray.lattice.t0 = 2.7f, ray.lattice.dt = 0.37f, ray.lattice.count = 1 + round % 150;
  ray.lattice.length = 0.37f * (static_cast<float>(ray.lattice.count) - 0.4f);
  ray.samples = randomRay(random, ray.lattice, ray.lattice.count, round % 7 == 0);
  return ray;
}

TEST(SegmentBatchMerger, BecomesWhatOnePairAfterTheOtherDoes) {
  std::mt19937 random(17);
  int merged = 0;
  for (int round = 0; round < 3000; ++round) {
    const SampledRay ray = rayOf(round, random);
    const int most = 1 + round % 16;
    SegmentBatchMerger found(mergerRoomFor(most));
    SegmentMerger expected(mergerRoomFor(most));
    for (const RaySegment& sample : ray.samples) {
      found.add(sample);
      expected.add(sample);
      ASSERT_NO_FATAL_FAILURE(expectSame(found, expected, round));
    }
    merged += static_cast<int>(ray.samples.size()) - expected.size();
    found.finish(most, ray.lattice);
    expected.finish(most, ray.lattice);
    ASSERT_NO_FATAL_FAILURE(expectSame(found, expected, round));
    EXPECT_LE(found.size(), most);
  }
  EXPECT_GT(merged, 50000);
}

/// From process to process, or device, and back, wherever along the ray.
TEST(SegmentBatchMerger, IsHandedOnAsItIs) {
  std::mt19937 random(19);
  for (int round = 0; round < 1000; ++round) {
    const SampledRay ray = rayOf(round, random);
    const int most = 1 + round % 16;
    SegmentBatchMerger found(mergerRoomFor(most));
    SegmentMerger expected(mergerRoomFor(most)), handed(mergerRoomFor(most));
    for (const RaySegment& sample : ray.samples) {
      if (std::uniform_int_distribution(0, 9)(random) == 0) {
        found.give(handed);
        if (round % 2 == 0) handed.add(sample);
        found.clear();
        found.take(handed);
        if (round % 2 == 1) found.add(sample);
      } else {
        found.add(sample);
      }
      expected.add(sample);
      ASSERT_NO_FATAL_FAILURE(expectSame(found, expected, round));
    }
    found.give(handed);
    handed.finish(most, ray.lattice);
    expected.finish(most, ray.lattice);
    found.take(handed);
    ASSERT_NO_FATAL_FAILURE(expectSame(found, expected, round));
  }
}

/// As a march on a device does it: sample by sample, and the end of a group before the next one's.
void addStep(SegmentMerger& merger, const RaySegment& sample, int step) {
  merger.endGroup(step);
  merger.addStep(sample, step);
  if (merger.wantsGroupToEnd()) merger.endGroup(step);
}

/// Steps by groups, which a piece of a ray may end in the midst of.
TEST(SegmentBatchMerger, GroupsOfStepsAreTheSameWhoeverHasThem) {
  std::mt19937 random(23);
  int grouped = 0;
  for (int round = 0; round < 2000; ++round) {
    const SampledRay ray = rayOf(round - round % 7 + 1 + round % 6, random);  // no points
    const int most = 1 + round % 16;
    SegmentBatchMerger found(mergerRoomFor(most));
    SegmentMerger expected(mergerRoomFor(most)), handed(mergerRoomFor(most)), single(mergerRoomFor(most));
    for (const RaySegment& sample : ray.samples) {
      const int step = static_cast<int>(std::lround((sample.begin - ray.lattice.t0) / ray.lattice.dt));
      if (std::uniform_int_distribution(0, 9)(random) == 0) {
        found.give(handed);
        if (round % 2 == 0) addStep(handed, sample, step);
        found.clear();
        found.take(handed);
        if (round % 2 == 1) found.addStep(sample, step);
      } else {
        found.addStep(sample, step);
      }
      addStep(expected, sample, step);
      single.add(sample);
    }
    found.give(handed);
    handed.finish(most, ray.lattice);
    expected.finish(most, ray.lattice);
    single.finish(most, ray.lattice);
    found.take(handed);
    ASSERT_NO_FATAL_FAILURE(expectSame(found, expected, round));
    const auto last = [](const SegmentMerger& merger) {
      RaySegment segment;
      for (int i = merger.first(); i != SegmentMerger::kNone; i = merger.behind(i)) segment = merger[i];
      return segment;
    };
    grouped += last(expected).begin != last(single).begin;
    // All light is kept, however it was merged.
    float through = 1.0f, throughSingle = 1.0f;
    for (int i = expected.first(); i != SegmentMerger::kNone; i = expected.behind(i)) through *= 1.0f - expected[i].opacity;
    for (int i = single.first(); i != SegmentMerger::kNone; i = single.behind(i)) throughSingle *= 1.0f - single[i].opacity;
    ASSERT_NEAR(through, throughSingle, 1e-5f) << round;
  }
  EXPECT_GT(grouped, 200);
}

/// What a full merger is given of a group of steps is the homogeneous stretch that they become; of another group it knows nothing.
TEST(SegmentBatchMerger, AFullMergerTakesTheStepsOfAGroupAsOne) {
  SegmentMerger merger(8), byHand(8);
  // Eight that nothing is merged with for less than what follows costs: bright, of other colours, far apart.
  int step = 0;
  for (; step < 8; ++step) {
    const RaySegment bright{static_cast<float>(step), static_cast<float>(step) + 1.0f, 0.5f, std::pow(0.5f, static_cast<float>(step)), step % 2 == 0 ? glm::vec3(0.5f, 0.0f, 0.0f) : glm::vec3(0.0f, 0.5f, 0.0f)};
    addStep(merger, bright, step);
    byHand.add(bright);
  }
  ASSERT_EQ(merger.size(), 8);
  RaySegment whole;
  for (; step < 2 * kGroupedSteps; ++step) {
    const RaySegment faint{static_cast<float>(step), static_cast<float>(step) + 1.0f, 0.01f, std::pow(0.5f, 8.0f), glm::vec3(0.005f)};
    addStep(merger, faint, step);
    step == 8 ? void(whole = faint) : mergeInto(whole, faint);
  }
  byHand.add(whole);
  merger.endGroup(step);
  ASSERT_EQ(merger.size(), byHand.size());
  for (int i = merger.first(), j = byHand.first(); i != SegmentMerger::kNone; i = merger.behind(i), j = byHand.behind(j)) {
    const RaySegment own = merger[i], other = byHand[j];
    EXPECT_EQ(std::memcmp(&own, &other, sizeof own), 0) << i;
  }
}

/// Samples that are the same cost the same: which two are merged is said by their places.
TEST(SegmentBatchMerger, OfEqualPairsTheOneInTheLowestPlaceIsMerged) {
  for (const int most : {4, 16}) {
    SegmentBatchMerger found(mergerRoomFor(most));
    SegmentMerger expected(mergerRoomFor(most));
    for (int i = 0; i < 200; ++i) {
      const auto at = static_cast<float>(4 * i);
      const RaySegment sample{at, at + 1.0f, 1e-7f, 1.0f, glm::vec3(5e-8f)};
      found.add(sample);
      expected.add(sample);
      ASSERT_NO_FATAL_FAILURE(expectSame(found, expected, i));
    }
    found.reduceTo(3);
    expected.reduceTo(3);
    expectSame(found, expected, 0);
  }
}

}  // namespace
}  // namespace warpscope
