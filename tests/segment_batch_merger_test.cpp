// All pairs at once become what one pair after the other does, bit for bit.
// Mirrors render/march/segment_batch_merger.h.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <utility>
#include <vector>

#include "made_up_source.h"
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

/// Samples of many colours. It may leap over those that show nothing.
template <int kSize>
struct ColorfulSource : MadeUpSource<kSize> {
  bool leaps = false;

  int skip(int i) const {
    while (leaps && i < this->lattice.count && !(this->alphaAt(i) > 0.0f)) ++i;
    return i;
  }
  glm::vec3 color(int k) const {
    const int i = this->first + k;
    return this->alpha(k) * glm::vec3(0.5f + 0.5f * std::sin(0.1f * static_cast<float>(i)), 0.3f, 0.01f * static_cast<float>(i % 7));
  }
};

/// A piece of a ray, by any source into any merger.
template <class Source, class Merger>
void marchPieceInto(const RayPath& path, int begin, int end, Source source, float stopBelow, RayColor& color, Merger& merger) {
  SegmentedColor<StableMarch, Merger> gathered(&merger, path.lattice);
  static_cast<RayColor&>(gathered) = color;
  marchRay(path, begin, end, source, Unlit{}, {0.001f, stopBelow}, gathered, [](const CountingSample&) { return true; });
  color = gathered;
}

/// Whole rays by batches, as a CPU marches them; sample by sample, as devices do, told where groups end; and cut into pieces, each by one or the other.
TEST(SegmentBatchMerger, MarchesToldOfGroupsAndNotGiveTheSame) {
  std::mt19937 random(29);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  size_t segments = 0, ended = 0;
  for (int round = 0; round < 2000; ++round) {
    const RayLattice lattice = latticeOf(2.5f, 0.37f * (static_cast<float>(1 + round % 170) - unit(random)), 0.37f);
    const RayPath path = alongZ(lattice);
    const float stopBelow = round % 3 == 0 ? 0.05f : 0.0f;
    const int most = 1 + round % 16;
    std::vector<float> alphas;
    float alpha = 0.1f;
    for (int i = 0; i < lattice.count; ++i) {
      if (unit(random) < 0.2f) alpha = unit(random) < 0.3f ? 0.0f : std::pow(unit(random), 4.0f);
      alphas.push_back(alpha);
    }
    const auto alphaAt = [&](int i) { return alphas[static_cast<size_t>(i)]; };
    RayColor color, colorInPieces, colorOfSteps;
    SegmentBatchMerger found(mergerRoomFor(most));
    marchPieceInto(path, 0, lattice.count, ColorfulSource<8>{{alphaAt, lattice}, true}, stopBelow, color, found);
    SegmentMerger steps(mergerRoomFor(most)), pieces(mergerRoomFor(most));
    marchPieceInto(path, 0, lattice.count, ColorfulSource<1>{{alphaAt, lattice}, round % 2 == 0}, stopBelow, colorOfSteps, steps);
    for (int begin = 0; begin < lattice.count;) {
      if (colorInPieces.transmittance.value() < stopBelow) break;
      const int end = std::min(lattice.count, begin + std::uniform_int_distribution(1, 40)(random));
      if (unit(random) < 0.5f) {
        marchPieceInto(path, begin, end, ColorfulSource<1>{{alphaAt, lattice}, unit(random) < 0.5f}, stopBelow, colorInPieces, pieces);
      } else {
        SegmentBatchMerger here(mergerRoomFor(most));
        here.take(pieces);
        marchPieceInto(path, begin, end, ColorfulSource<8>{{alphaAt, lattice}, true}, stopBelow, colorInPieces, here);
        here.give(pieces);
      }
      begin = end;
    }
    ended += color.transmittance.value() < stopBelow;
    found.finish(most, lattice);
    steps.finish(most, lattice);
    pieces.finish(most, lattice);
    ASSERT_NO_FATAL_FAILURE(expectSame(found, steps, round));
    ASSERT_NO_FATAL_FAILURE(expectSame(found, pieces, round));
    segments += static_cast<size_t>(found.size());
  }
  EXPECT_GT(segments, 10000u);
  EXPECT_GT(ended, 200u);
}

/// Groups begin where the lattice says, not where a merger has become full.
TEST(SegmentBatchMerger, AFullMergerTakesTheStepsOfAGroupAsOne) {
  SegmentMerger told(8), byHand(8);
  SegmentBatchMerger found(8);
  RaySegment whole;
  bool any = false;
  const auto endByHand = [&] {
    if (any) byHand.add(whole);
    any = false;
  };
  // The first eight are kept as they are: the merger is full in the midst of a group, with step 10.
  for (int step = 3; step < 32; ++step) {
    const auto at = static_cast<float>(step);
    const bool isBright = step < 11;
    const RaySegment sample{at, at + 1.0f, isBright ? 0.5f : 0.01f, std::pow(0.5f, std::min(at - 3.0f, 8.0f)), isBright ? glm::vec3(0.5f * static_cast<float>(step % 2), 0.25f, 0.0f) : glm::vec3(0.005f)};
    addStep(told, sample, step);
    found.addStep(sample, step);
    if (step == 16 || step == 24) endByHand();
    if (isBright) {
      byHand.add(sample);
    } else if (std::exchange(any, true)) {
      mergeInto(whole, sample);
    } else {
      whole = sample;
    }
  }
  endByHand();
  told.endGroup(32);
  ASSERT_EQ(told.size(), byHand.size());
  for (int i = told.first(), j = byHand.first(); i != SegmentMerger::kNone; i = told.behind(i), j = byHand.behind(j)) {
    const RaySegment own = told[i], other = byHand[j];
    EXPECT_EQ(std::memcmp(&own, &other, sizeof own), 0) << i;
  }
  byHand.reduceTo(3);
  found.reduceTo(3);
  expectSame(found, byHand, 0);
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
