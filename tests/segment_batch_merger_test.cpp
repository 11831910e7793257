// Rays side by side become what each does for itself, bit for bit; so do their codes.
// Mirrors render/march/segment_batch_merger.h and segment_batch_encoder.h.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <random>
#include <utility>
#include <vector>

#include "made_up_source.h"
#include "render/core/color_lanes.h"
#include "render/march/segment_batch_encoder.h"
#include "render/march/segment_batch_merger.h"
#include "render/march/segment_encoder.h"

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

void expectSame(const SegmentBatchMerger& found, int lane, const SegmentMerger& expected, int round) {
  ASSERT_EQ(found.size(lane), expected.size()) << round;
  int i = 0;
  for (int j = expected.first(); j != SegmentMerger::kNone; j = expected.behind(j), ++i) {
    const RaySegment own = found.segment(lane, i), other = expected[j];
    ASSERT_EQ(std::memcmp(&own, &other, sizeof own), 0) << "round " << round << ", lane " << lane << ", segment " << i << " of " << found.size(lane);
    ASSERT_EQ(found.placeOf(lane, i), j) << round;
  }
  EXPECT_EQ(i, found.size(lane));
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

/// So many of them, of which the last batch's may be fewer than there are lanes.
std::vector<SampledRay> raysOf(int round, std::mt19937& random) {
  std::vector<SampledRay> rays;
  const int count = round % 3 == 0 ? 1 + round % SegmentBatchMerger::kRays : SegmentBatchMerger::kRays;
  for (int lane = 0; lane < count; ++lane) rays.push_back(rayOf(static_cast<int>(random() % 3000), random));
  return rays;
}

TEST(SegmentBatchMerger, BecomesWhatEachRayDoesForItself) {
  std::mt19937 random(17);
  int merged = 0;
  for (const int most : {1, 2, 3, 4, 5, 8, 16}) {
    SegmentBatchMerger found(mergerRoomFor(most));
    for (int round = 0; round < 60; ++round) {
      const std::vector<SampledRay> rays = raysOf(round, random);
      const int count = static_cast<int>(rays.size());
      std::vector<SegmentMerger> expected(rays.size(), SegmentMerger(mergerRoomFor(most)));
      std::vector<const RayLattice*> lattices;
      for (int lane = 0; lane < count; ++lane) {
        const SampledRay& ray = rays[static_cast<size_t>(lane)];
        SegmentBatchMerger::Ray& own = found.begin(lane);
        for (const RaySegment& sample : ray.samples) {
          own.add(sample);
          expected[static_cast<size_t>(lane)].add(sample);
        }
        lattices.push_back(&ray.lattice);
      }
      found.merge(count);
      for (int lane = 0; lane < count; ++lane) ASSERT_NO_FATAL_FAILURE(expectSame(found, lane, expected[static_cast<size_t>(lane)], round));
      found.finish(most, lattices.data());
      for (int lane = 0; lane < count; ++lane) {
        SegmentMerger& other = expected[static_cast<size_t>(lane)];
        merged += static_cast<int>(rays[static_cast<size_t>(lane)].samples.size()) - other.size();
        other.finish(most, rays[static_cast<size_t>(lane)].lattice);
        ASSERT_NO_FATAL_FAILURE(expectSame(found, lane, other, round));
        EXPECT_LE(found.size(lane), most);
      }
    }
  }
  EXPECT_GT(merged, 50000);
}

/// One that has met more than is kept of it until it is merged, beside others.
TEST(SegmentBatchMerger, AVeryLongRayIsMergedByItselfBeforeTheOthers) {
  std::mt19937 random(41);
  for (const int most : {4, 16}) {
    SegmentBatchMerger found(mergerRoomFor(most));
    std::vector<SegmentMerger> expected(static_cast<size_t>(SegmentBatchMerger::kRays), SegmentMerger(mergerRoomFor(most)));
    std::vector<RayLattice> lattices(expected.size());
    std::vector<const RayLattice*> ofRays;
    for (size_t lane = 0; lane < expected.size(); ++lane) {
      lattices[lane].dt = 0.25f, lattices[lane].count = lane % 2 == 0 ? 5000 : 50;
      lattices[lane].length = 0.25f * static_cast<float>(lattices[lane].count);
      ofRays.push_back(&lattices[lane]);
      const std::vector<RaySegment> samples = randomRay(random, lattices[lane], lattices[lane].count, false);
      SegmentBatchMerger::Ray& own = found.begin(static_cast<int>(lane));
      float through = 1.0f;
      for (RaySegment sample : samples) {
        sample.opacity *= 0.01f, sample.color *= 0.01f, sample.through = through;  // so thin that something is left at the end
        through *= 1.0f - sample.opacity;
        own.add(sample);
        expected[lane].add(sample);
      }
    }
    found.merge(SegmentBatchMerger::kRays);
    for (size_t lane = 0; lane < expected.size(); ++lane) ASSERT_NO_FATAL_FAILURE(expectSame(found, static_cast<int>(lane), expected[lane], most));
    found.finish(most, ofRays.data());
    for (size_t lane = 0; lane < expected.size(); ++lane) {
      expected[lane].finish(most, lattices[lane]);
      ASSERT_NO_FATAL_FAILURE(expectSame(found, static_cast<int>(lane), expected[lane], most));
    }
  }
}

/// From process to process, or device, and back, wherever along the ray; whatever the rays beside it do.
TEST(SegmentBatchMerger, IsHandedOnAsItIs) {
  std::mt19937 random(19);
  for (int round = 0; round < 200; ++round) {
    const std::vector<SampledRay> rays = raysOf(round, random);
    const int count = static_cast<int>(rays.size()), most = 1 + round % 16;
    SegmentBatchMerger found(mergerRoomFor(most));
    std::vector<SegmentMerger> handed(rays.size(), SegmentMerger(mergerRoomFor(most))), expected = handed;
    std::vector<size_t> next(rays.size(), 0);
    for (bool any = true; any;) {
      any = false;
      for (int lane = 0; lane < count; ++lane) {
        const auto which = static_cast<size_t>(lane);
        const std::vector<RaySegment>& samples = rays[which].samples;
        size_t end = std::min(samples.size(), next[which] + random() % 30);
        if (random() % 4 == 0)  // one that goes on where each is merged by itself
          for (; next[which] < end; ++next[which]) handed[which].add(samples[next[which]]), expected[which].add(samples[next[which]]);
        end = std::min(samples.size(), next[which] + random() % 30);
        SegmentBatchMerger::Ray& own = found.begin(lane, handed[which]);
        for (; next[which] < end; ++next[which]) own.add(samples[next[which]]), expected[which].add(samples[next[which]]);
        any = any || next[which] < samples.size();
      }
      found.merge(count);
      for (int lane = 0; lane < count; ++lane) {
        ASSERT_NO_FATAL_FAILURE(expectSame(found, lane, expected[static_cast<size_t>(lane)], round));
        found.give(lane, handed[static_cast<size_t>(lane)]);
      }
    }
    for (int lane = 0; lane < count; ++lane) {
      const auto which = static_cast<size_t>(lane);
      handed[which].finish(most, rays[which].lattice);
      expected[which].finish(most, rays[which].lattice);
      found.begin(lane, handed[which]);
    }
    found.merge(count);
    for (int lane = 0; lane < count; ++lane) ASSERT_NO_FATAL_FAILURE(expectSame(found, lane, expected[static_cast<size_t>(lane)], round));
  }
}

/// One ray by itself, in any lane.
class SingleRay {
 public:
  SingleRay(int room, int lane) : batch_(room), lane_(lane) { clear(); }
  SegmentBatchMerger::Ray& ray() { return *ray_; }
  void clear() { ray_ = &batch_.begin(lane_); }
  void take(const SegmentMerger& other) { ray_ = &batch_.begin(lane_, other); }
  void give(SegmentMerger& other) {
    batch_.merge(lane_ + 1);
    batch_.give(lane_, other);
  }
  void finish(int most, const RayLattice& lattice) {
    ray_->endGroup();
    batch_.merge(lane_ + 1);
    const std::vector<const RayLattice*> lattices(SegmentBatchMerger::kRays, &lattice);
    batch_.finish(most, lattices.data());
  }
  void expectSame(const SegmentMerger& expected, int round) const { warpscope::expectSame(batch_, lane_, expected, round); }

 private:
  SegmentBatchMerger batch_;
  int lane_;
  SegmentBatchMerger::Ray* ray_ = nullptr;
};

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
    SingleRay found(mergerRoomFor(most), round % SegmentBatchMerger::kRays);
    SegmentMerger expected(mergerRoomFor(most)), handed(mergerRoomFor(most)), single(mergerRoomFor(most));
    for (const RaySegment& sample : ray.samples) {
      const int step = static_cast<int>(std::lround((sample.begin - ray.lattice.t0) / ray.lattice.dt));
      if (std::uniform_int_distribution(0, 9)(random) == 0) {
        found.give(handed);
        if (round % 2 == 0) addStep(handed, sample, step);
        found.take(handed);
        if (round % 2 == 1) found.ray().addStep(sample, step);
      } else {
        found.ray().addStep(sample, step);
      }
      addStep(expected, sample, step);
      single.add(sample);
    }
    found.give(handed);
    handed.finish(most, ray.lattice);
    expected.finish(most, ray.lattice);
    single.finish(most, ray.lattice);
    found.take(handed);
    found.finish(16, ray.lattice);
    ASSERT_NO_FATAL_FAILURE(found.expectSame(expected, round));
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
    SingleRay found(mergerRoomFor(most), round % SegmentBatchMerger::kRays), here(mergerRoomFor(most), 0);
    marchPieceInto(path, 0, lattice.count, ColorfulSource<8>{{alphaAt, lattice}, true}, stopBelow, color, found.ray());
    SegmentMerger steps(mergerRoomFor(most)), pieces(mergerRoomFor(most));
    marchPieceInto(path, 0, lattice.count, ColorfulSource<1>{{alphaAt, lattice}, round % 2 == 0}, stopBelow, colorOfSteps, steps);
    for (int begin = 0; begin < lattice.count;) {
      if (colorInPieces.transmittance.value() < stopBelow) break;
      const int end = std::min(lattice.count, begin + std::uniform_int_distribution(1, 40)(random));
      if (unit(random) < 0.5f) {
        marchPieceInto(path, begin, end, ColorfulSource<1>{{alphaAt, lattice}, unit(random) < 0.5f}, stopBelow, colorInPieces, pieces);
      } else {
        here.take(pieces);
        marchPieceInto(path, begin, end, ColorfulSource<8>{{alphaAt, lattice}, true}, stopBelow, colorInPieces, here.ray());
        here.give(pieces);
      }
      begin = end;
    }
    ended += color.transmittance.value() < stopBelow;
    found.finish(most, lattice);
    steps.finish(most, lattice);
    pieces.finish(most, lattice);
    ASSERT_NO_FATAL_FAILURE(found.expectSame(steps, round));
    ASSERT_NO_FATAL_FAILURE(found.expectSame(pieces, round));
    segments += static_cast<size_t>(steps.size());
  }
  EXPECT_GT(segments, 10000u);
  EXPECT_GT(ended, 200u);
}

/// Groups begin where the lattice says, not where a merger has become full.
TEST(SegmentBatchMerger, AFullMergerTakesTheStepsOfAGroupAsOne) {
  SegmentMerger told(8), byHand(8);
  SingleRay found(8, 0);
  const RayLattice lattice = latticeOf(0.0f, 32.0f, 1.0f);
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
    found.ray().addStep(sample, step);
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
  byHand.finish(3, lattice);
  found.finish(3, lattice);
  found.expectSame(byHand, 0);
}

/// Samples that are the same cost the same: which two are merged is said by their places.
TEST(SegmentBatchMerger, OfEqualPairsTheOneInTheLowestPlaceIsMerged) {
  for (const int most : {4, 16}) {
    for (int count = 1; count < 200; count += 3) {
      const RayLattice lattice = latticeOf(0.0f, static_cast<float>(4 * count), 1.0f);
      SingleRay found(mergerRoomFor(most), count % SegmentBatchMerger::kRays);
      SegmentMerger expected(mergerRoomFor(most)), handed(mergerRoomFor(most));
      for (int i = 0; i < count; ++i) {
        const auto at = static_cast<float>(4 * i);
        const RaySegment sample{at, at + 1.0f, 1e-7f, 1.0f, glm::vec3(5e-8f)};
        found.ray().add(sample);
        expected.add(sample);
      }
      if (count % 2 == 0) {
        found.give(handed);
        ASSERT_NO_FATAL_FAILURE(found.expectSame(expected, count));
        found.take(handed);
      }
      found.finish(3, lattice);
      expected.finish(3, lattice);
      ASSERT_NO_FATAL_FAILURE(found.expectSame(expected, count));
    }
  }
}

/// Colours, opacities and depths of all rays at once are those of one after the other.
TEST(SegmentBatchMerger, CodesAreThoseOfEachRay) {
  std::mt19937 random(37);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  const SampleQuantization quantization;
  size_t sent = 0, leftOut = 0;
  for (int round = 0; round < 300; ++round) {
    const std::vector<SampledRay> rays = raysOf(round, random);
    const int count = static_cast<int>(rays.size()), most = 1 + round % 16;
    const bool hasNormals = round % 2 == 0;
    SegmentBatchMerger found(mergerRoomFor(most));
    std::vector<const RayLattice*> lattices;
    std::vector<float> cosines;
    std::vector<EncodedSegments> encoded(rays.size());
    std::vector<EncodedSegments*> to;
    std::vector<std::array<NormalCode, kMostMergerRoom>> normals(rays.size());
    std::vector<const NormalCode*> normalsOf;
    for (int lane = 0; lane < count; ++lane) {
      const auto which = static_cast<size_t>(lane);
      SegmentBatchMerger::Ray& own = found.begin(lane);
      for (const RaySegment& sample : rays[which].samples) own.add(sample);
      lattices.push_back(&rays[which].lattice);
      cosines.push_back(0.6f + 0.4f * unit(random));
      to.push_back(&encoded[which]);
      for (NormalCode& normal : normals[which]) normal = static_cast<NormalCode>(random());
      normalsOf.push_back(normals[which].data());
    }
    found.merge(count);
    found.finish(most, lattices.data());
    encodeSegments(found, count, cosines.data(), quantization, hasNormals ? normalsOf.data() : nullptr, to.data());
    for (int lane = 0; lane < count; ++lane) {
      const auto which = static_cast<size_t>(lane);
      SegmentList list;
      for (int i = 0; i < found.size(lane); ++i) list.add(found.segment(lane, i));
      EncodedSegments expected;
      const SegmentEncoder encoder(ColorTables::instance(), quantization, cosines[which], hasNormals);
      expected.count = storeSegments(list, false, encoder, {expected.depths, expected.colors, hasNormals ? expected.normals : nullptr}, [&](int i) { return normals[which][static_cast<size_t>(i)]; }).count();
      ASSERT_EQ(encoded[which].count, expected.count) << round;
      ASSERT_EQ(encoded[which].found, list.size()) << round;
      for (int i = 0; i < expected.count; ++i) {
        ASSERT_EQ(encoded[which].depths[i], expected.depths[i]) << round;
        ASSERT_EQ(encoded[which].colors[i], expected.colors[i]) << round << ", lane " << lane << ", segment " << i;
        if (hasNormals) ASSERT_EQ(encoded[which].normals[i], expected.normals[i]) << round;
      }
      sent += static_cast<size_t>(expected.count);
      leftOut += static_cast<size_t>(list.size() - expected.count);
    }
  }
  EXPECT_GT(sent, 5000u);
  EXPECT_GT(leftOut, 50u);
}

/// Of numbers at and about where codes end, and outside of what codes say.
TEST(ColorLanes, CodesAreThoseOfOneNumberAfterTheOther) {
  const ColorTables& tables = ColorTables::instance();
  std::vector<float> numbers{0.0f, -0.0f, -1.0f, 1.0f, 2.0f, INFINITY, -INFINITY, NAN, 1e-40f, std::nextafter(1.0f, 0.0f)};
  for (uint32_t code = 0; code < 256; ++code) {
    const float linear = tables.decode(code | 0xff000000u).r, bound = linearFromSrgb((static_cast<float>(code) + 0.5f) / 255.0f);
    for (const float near : {linear, bound}) {
      float below = near, above = near;
      for (int i = 0; i < 40; ++i) {
        numbers.push_back(below = std::nextafter(below, 0.0f));
        numbers.push_back(above = std::nextafter(above, 2.0f));
      }
      numbers.push_back(near);
    }
  }
  for (int i = 0; i <= 4096; ++i) numbers.push_back(static_cast<float>(i) / 4096.0f);
  while (numbers.size() % kBatchLanes != 0) numbers.push_back(0.5f);
  for (size_t i = 0; i < numbers.size(); i += kBatchLanes) {
    alignas(64) int32_t codes[kBatchLanes];
    alignas(64) float decoded[kBatchLanes];
    const IntBatch found = ColorLanes::encodeChannel(tables, FloatBatch::load_unaligned(&numbers[i]));
    found.store_aligned(codes);
    ColorLanes::decodeChannel(tables, found).store_aligned(decoded);
    for (size_t lane = 0; lane < kBatchLanes; ++lane) {
      const uint32_t expected = tables.encodeChannel(numbers[i + lane]);
      ASSERT_EQ(static_cast<uint32_t>(codes[lane]), expected) << numbers[i + lane];
      ASSERT_EQ(decoded[lane], tables.decode(expected | 0xff000000u).r);
    }
  }
}

}  // namespace
}  // namespace warpscope
