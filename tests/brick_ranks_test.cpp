// A volume that is spread over ranks: its frames are those of one process, bit for bit. The ranks are threads here.
// Mirrors render/bricks/brick_ranks.h.
#include "render/bricks/brick_ranks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <deque>
#include <numeric>
#include <thread>

#include "marcher_cases.h"
#include "render/base/error.h"
#include "render/march/march_setup.h"
#include "spread_cases.h"
#include "spread_volume.h"
#include "test_volumes.h"

namespace warpscope {
namespace {

const std::vector<int> kCounts{1, 2, 3, 4, 7, 16};

TEST(Ranks, SharesAreAllInOrder) {
  for (const int count : kCounts)
    for (const size_t things : {size_t{0}, size_t{1}, size_t{5}, size_t{16}, size_t{1} << 40}) {
      size_t next = 0;
      for (const RanksPtr& own : makeLocalRanks(count)) {
        const auto [begin, end] = own->shareOf(things);
        EXPECT_EQ(begin, next);
        EXPECT_LE(end - begin, things / static_cast<size_t>(count) + 1);
        next = end;
      }
      EXPECT_EQ(next, things);
    }
}

TEST(Ranks, WhatAllBringIsByRankAndOtherMessagesWait) {
  onAll(5, [](const RanksPtr& own) {
    own->send((own->rank() + 1) % 5, 7, std::vector<std::byte>(3));
    for (int round = 0; round < 20; ++round) {
      std::vector<int> brought(static_cast<size_t>(own->rank()), own->rank() + 100 * round);
      own->allGather(brought);
      std::vector<int> expected;
      for (int rank = 0; rank < 5; ++rank) expected.insert(expected.end(), static_cast<size_t>(rank), rank + 100 * round);
      EXPECT_EQ(brought, expected);
    }
    const std::optional<RankMessage> message = own->receive(std::chrono::seconds(10));
    ASSERT_TRUE(message);
    EXPECT_EQ(message->from, (own->rank() + 4) % 5);
    EXPECT_EQ(message->kind, 7);
    EXPECT_FALSE(own->receive(std::chrono::microseconds(10)));
  });
}

TEST(Ranks, OneHasTheLastWord) {
  using namespace std::chrono_literals;
  // All fail alike: the first one says it, however late it is.
  onAll(4, [](const RanksPtr& own) {
    if (own->isFirst()) std::this_thread::sleep_for(300ms);
    EXPECT_EQ(own->claimLastWord(20s), own->isFirst());
  });
  // Only one fails, and another one later; the others are at work.
  onAll(4, [](const RanksPtr& own) {
    if (own->rank() == 1) {
      EXPECT_TRUE(own->claimLastWord(50ms));
    }
    if (own->rank() == 3) {
      EXPECT_FALSE(own->claimLastWord(20s));
    }
    if (own->rank() == 0 || own->rank() == 2) {
      const auto from = std::chrono::steady_clock::now();
      EXPECT_FALSE(own->receive(20s)) << "heard of, but nothing to work at";
      EXPECT_LT(std::chrono::steady_clock::now() - from, 10s);
    }
  });
  // The first one is told to end for what another one has said.
  onAll(2, [](const RanksPtr& own) {
    if (own->isFirst()) {
      EXPECT_FALSE(own->claimLastWord(20s, true));
      return;
    }
    EXPECT_TRUE(own->claimLastWord(50ms));
  });
  onAll(2, [](const RanksPtr& own) {
    if (own->isFirst()) {
      EXPECT_TRUE(own->claimLastWord(50ms, true)) << "nobody else says anything";
    }
  });
  // All but the first one fail alike.
  for (int round = 0; round < 5; ++round) {
    std::atomic<int> speakers = 0;
    onAll(4, [&](const RanksPtr& own) {
      if (!own->isFirst() && own->claimLastWord(30ms)) ++speakers;
    });
    EXPECT_EQ(speakers, 1);
  }
}

TEST(SpreadVolume, IsKnownAsTheWholeOneIs) {
  for (const VoxelType type : kAllVoxelTypes) {
    SCOPED_TRACE(nameOf(type));
    const bool isFloat = type == VoxelType::float32 || type == VoxelType::float64;
    const FieldFunction field = blobs(kDims, 3);
    const VolumePtr whole = makeTestVolume(type, kDims, [&](const glm::ivec3& p) { return isFloat && p.x + p.y < 9 ? std::nan("") : field(p); });
    const TransferFunction function = band(20, 70, 0.2f);
    const MarchedVolume expected(whole, function);
    const ProxyPtr proxy = expected.proxyFor(11, {});
    for (const int count : kCounts)
      onAll(count, [&](const RanksPtr& own) {
        const VolumePtr volume = sharedBy(whole, own);
        EXPECT_EQ(volume->statistics().lowest, whole->statistics().lowest);
        EXPECT_EQ(volume->statistics().highest, whole->statistics().highest);
        EXPECT_EQ(volume->statistics().rangeLower, whole->statistics().rangeLower);
        EXPECT_EQ(volume->statistics().rangeUpper, whole->statistics().rangeUpper);
        EXPECT_EQ(volume->statistics().nonFinite, whole->statistics().nonFinite);
        EXPECT_EQ(volume->statistics().histogram, whole->statistics().histogram);
        const MarchedVolume marched(volume, function);
        ASSERT_EQ(marched.macrocells.count(), expected.macrocells.count());
        for (size_t cell = 0; cell < marched.macrocells.count(); ++cell) ASSERT_EQ(marched.macrocells.range(cell), expected.macrocells.range(cell)) << cell;
        const ProxyPtr own_proxy = marched.proxyFor(11, {});
        ASSERT_EQ(own_proxy->volume->sizeBytes(), proxy->volume->sizeBytes());
        EXPECT_EQ(std::memcmp(own_proxy->volume->voxels(), proxy->volume->voxels(), proxy->volume->sizeBytes()), 0);
      });
  }
}

TEST(SpreadVolume, FramesAreThoseOfOneProcessByEveryHeuristic) {
  const VolumePtr whole = makeTestVolume(VoxelType::uint8, kDims, blobs(kDims, 5));
  const TransferFunction function = band(15, 80, 0.08f);
  const MarcherPtr alone = makeCpuMarcher(whole, function);
  for (const int count : kCounts) {
    SCOPED_TRACE(count);
    const Spread spread(whole, function, count);
    for (const Camera& camera : cameras())
      for (const auto& heuristic : kHeuristics) {
        MarchSettings settings;
        settings.sample.heuristic = heuristic.value;
        settings.sample.radiusPolicy = RadiusPolicy::uncertainty;
        settings.sample.sendsSpread = true;
        const SampleFrame expected = alone->march(camera, settings);
        ASSERT_GT(expected.size(), 100u);
        ASSERT_TRUE(sameFrame(spread->march(camera, settings), expected)) << heuristic.name;
      }
  }
}

TEST(SpreadVolume, FramesAndPicturesAreThoseOfOneProcessWhateverIsAskedOfThem) {
  const FieldFunction field = blobs(kDims, 11);
  for (const VoxelType type : {VoxelType::uint8, VoxelType::int16, VoxelType::float32}) {
    SCOPED_TRACE(nameOf(type));
    const VolumePtr whole =
        makeTestVolume(type, kDims, [&](const glm::ivec3& p) { return type == VoxelType::float32 && (p.x * 7 + p.y * 3 + p.z) % 41 == 0 ? std::nan("") : field(p); });
    const TransferFunction function = band(15, 80, 0.3f);
    const MarcherPtr alone = makeCpuMarcher(whole, function);
    for (const int count : {2, 5, 16}) {
      SCOPED_TRACE(count);
      const Spread spread(whole, function, count);
      for (const auto& [name, settings] : variants())
        for (const Camera& camera : cameras()) {
          ASSERT_TRUE(sameFrame(spread->march(camera, settings), alone->march(camera, settings))) << name;
          ASSERT_TRUE(sameBits(rendered(*spread, camera, settings), rendered(*alone, camera, settings))) << name;
        }
    }
  }
}

/// Found in a copy of 8 bits, with as many voxels here: the same however the volume is cut, and near to those of one process.
TEST(SpreadVolume, ShadowsAndOcclusionAreTheSameHoweverItIsCutAndNearThoseOfOneProcess) {
  for (const VoxelType type : {VoxelType::uint8, VoxelType::float32}) {
    SCOPED_TRACE(nameOf(type));
    const VolumePtr whole = makeTestVolume(type, kDims, blobs(kDims, 11));
    const TransferFunction function = band(15, 80, 0.3f);
    const MarcherPtr alone = makeCpuMarcher(whole, function);
    MarchSettings settings;
    settings.sample.segments = 4;
    settings.sample.proxy = 9;
    settings.render.effects.shading.strength = 1.0f;
    settings.render.effects.lights = parseLights("world:1,2,3 camera:0,1,1", "lights");
    settings.render.effects.shadows.strength = 1.0f;
    settings.render.effects.shadows.occlusion = 0.7f;
    MarchSettings unshadowed = settings;
    unshadowed.render.effects.shadows = {};
    const std::vector<Camera> views = cameras();
    std::vector<SampleFrame> first;
    for (const int count : {1, 2, 5, 16}) {
      SCOPED_TRACE(count);
      const Spread spread(whole, function, count);
      for (size_t i = 0; i < views.size(); ++i) {
        const Camera& camera = views[i];
        SampleFrame frame = spread->march(camera, settings);
        const Image<glm::vec4> picture = rendered(*spread, camera, settings), expected = rendered(*alone, camera, settings), bright = rendered(*alone, camera, unshadowed);
        double off = 0.0, shadow = 0.0;
        for (size_t pixel = 0; pixel < picture.size(); ++pixel)
          for (int channel = 0; channel < 3; ++channel) {
            off += static_cast<double>(std::abs(picture.data()[pixel][channel] - expected.data()[pixel][channel]));
            shadow += static_cast<double>(std::abs(bright.data()[pixel][channel] - expected.data()[pixel][channel]));
          }
        EXPECT_LT(off, 0.02 * shadow) << "of what shadows and occlusion take away";
        EXPECT_GT(shadow, 0.0);
        if (first.size() < views.size())
          first.push_back(std::move(frame));
        else
          ASSERT_TRUE(sameFrame(frame, first[i]));
      }
    }
  }
}

/// Balls that shade each other and a slab, in 520 x 40 x 52 edges of the smallest voxel; slices are so many apart.
VolumePtr longVolume(unsigned apart) {
  VolumeGeometry geometry;
  geometry.dims = {520, 40, 52 / apart};
  geometry.spacing.z = apart;
  return makeTestVolume(VoxelType::uint8, geometry, [&](const glm::ivec3& p) {
    const glm::dvec3 place(p.x, p.y, p.z * static_cast<int>(apart));
    double value = std::clamp(30.0 * (11.0 - place.z), 0.0, 90.0);
    for (const glm::dvec4& ball : {glm::dvec4(120, 20, 36, 15), glm::dvec4(300, 20, 34, 17), glm::dvec4(345, 22, 34, 16), glm::dvec4(430, 20, 36, 15)})
      value = std::max(value, 6.0 * (ball.w - glm::length(place - glm::dvec3(ball))));
    return std::min(value, 100.0);
  });
}

/// In a volume that is twice as long as the copy: as dark as in one process, about.
TEST(SpreadVolume, ShadowsAndOcclusionOfALongVolumeAreNearThoseOfOneProcess) {
  const TransferFunction function = band(15, 100, 0.2f);
  const Camera camera = lookingFrom({90.0f, 160.0f, 260.0f}, {}, 120, 60);
  struct Case {
    unsigned apart;
    float shadows, occlusion, gridEdge;
    double most;  // of what shadows and occlusion take away
  };
  // Where light is found at every voxel, the copy has half of the places; where at every fifth, or where voxels are twice as long along an axis
  // on which the copy has as many, what skips them wants them farther apart in it.
  for (const auto& [apart, shadows, occlusion, gridEdge, most] :
       {Case{1, 1.0f, 0.0f, 2.0f, 0.1}, {1, 0.0f, 1.0f, 2.0f, 0.05}, {1, 1.0f, 0.7f, 1.0f, 0.16}, {1, 1.0f, 0.7f, 5.0f, 0.36}, {2, 1.0f, 0.0f, 2.0f, 0.25}, {2, 0.0f, 1.0f, 2.0f, 0.17}}) {
    const VolumePtr whole = longVolume(apart);
    const MarcherPtr alone = makeCpuMarcher(whole, function);
    SCOPED_TRACE(testing::Message() << apart << ", " << shadows << ", " << occlusion << ", " << gridEdge);
    RenderSettings settings;
    settings.effects.shading.strength = 1.0f;
    settings.effects.lights = parseLights("world:2,1,1", "lights");
    settings.effects.shadows.strength = shadows;
    settings.effects.shadows.occlusion = occlusion;
    settings.effects.shadows.gridEdge = gridEdge;
    RenderSettings bright = settings;
    bright.effects.shadows = {};
    const Spread spread(whole, function, 3);
    Image<glm::vec4> picture, expected, unshadowed;
    spread->render(camera, settings, picture, {});
    alone->render(camera, settings, expected, {});
    alone->render(camera, bright, unshadowed, {});
    double off = 0.0, shadow = 0.0;
    for (size_t pixel = 0; pixel < picture.size(); ++pixel)
      for (int channel = 0; channel < 3; ++channel) {
        off += static_cast<double>(std::abs(picture.data()[pixel][channel] - expected.data()[pixel][channel]));
        shadow += static_cast<double>(unshadowed.data()[pixel][channel] - expected.data()[pixel][channel]);
      }
    EXPECT_GT(shadow, 1.0);
    EXPECT_LT(off, most * shadow);
    // Another light, and the first one again: nothing of the other stays.
    RenderSettings other = settings;
    other.effects.lights = parseLights("world:-1,0,1", "lights");
    Image<glm::vec4> ignored, again;
    spread->render(camera, other, ignored, {});
    spread->render(camera, settings, again, {});
    EXPECT_TRUE(sameBits(again, picture));
  }
}

TEST(SpreadVolume, AnotherFunctionAndTheProxyAreThoseOfOneProcess) {
  const VolumePtr whole = makeTestVolume(VoxelType::int32, kDims, blobs(kDims, 2));
  const Camera camera = cameras().front();
  const Spread spread(whole, band(10, 30, 0.2f), 4);
  MarchSettings settings;
  settings.sample.proxy = 9;
  for (const TransferFunction& function : {band(40, 90, 0.5f), everywhere(0.01f), band(200, 300, 1.0f)}) {
    const MarcherPtr alone = makeCpuMarcher(whole, function);
    const MarcherPtr other = spread->withTransferFunction(function)->twin();
    const SampleFrame expected = alone->march(camera, settings), frame = other->march(camera, settings);
    EXPECT_TRUE(sameFrame(frame, expected));
    ASSERT_TRUE(frame.proxy);
    EXPECT_EQ(std::memcmp(frame.proxy->volume->voxels(), expected.proxy->volume->voxels(), expected.proxy->volume->sizeBytes()), 0);
  }
}

TEST(SpreadVolume, AMarchThatIsStoppedLeavesRanksThatWork) {
  const VolumePtr whole = makeTestVolume(VoxelType::uint8, kDims, blobs(kDims, 5));
  const MarcherPtr alone = makeCpuMarcher(whole, everywhere(0.001f));
  const Spread spread(whole, everywhere(0.001f), 3);
  expectWorksWhenStopped(*spread, *alone);
}

TEST(SpreadVolume, RanksSayWhatTheyHaveDone) {
  const VolumePtr whole = makeTestVolume(VoxelType::uint8, kDims, blobs(kDims, 5));
  std::vector<RanksPtr> ranks = makeLocalRanks(3);
  std::vector<std::jthread> others;
  for (int rank = 1; rank < 3; ++rank) others.emplace_back([whole, own = ranks[static_cast<size_t>(rank)]] { followRanks(sharedBy(whole, own)); });
  const BrickLeaderPtr leader = leadRanks(sharedBy(whole, ranks[0]));
  const MarcherPtr marcher = makeRanksMarcher(leader, band(15, 80, 0.08f));
  for (uint64_t frame = 1; frame < 4; ++frame) {
    marcher->march(cameras().front(), {});
    const auto isOfFrame = [&](const RankWork& one) { return one.frame == frame; };
    for (int i = 0; i < 2000 && !std::ranges::all_of(knownWork(leader), isOfFrame); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_TRUE(std::ranges::all_of(knownWork(leader), isOfFrame)) << "it comes although no other frame is marched";
    const std::vector<RankWork> work = lastWork(leader);
    ASSERT_EQ(work.size(), 3u);
    int cells = 0;
    for (const RankWork& one : work) {
      EXPECT_EQ(one.frame, frame);
      EXPECT_GT(one.tiles, 0u);
      EXPECT_GT(one.marchMs, 0.0);
      const auto& slots = one.timeline.marchMs;
      EXPECT_NEAR(std::accumulate(slots.begin(), slots.end(), 0.0), one.marchMs, 1e-3 * one.marchMs) << "when it marched";
      const glm::ivec3 extent = one.block.upper - one.block.lower;
      cells += extent.x * extent.y * extent.z;
    }
    EXPECT_EQ(cells, 43 * 36 * 39);
    EXPECT_GT(work[1].sentBytes + work[2].sentBytes, 1000u);  // results at least
  }
}

TEST(SpreadVolume, IsCutAnewWhereOneRankHasMoreToDoAndFramesStayTheSame) {
  // Opaque: rays end in what is near, and ranks behind it have nothing to do.
  const VolumePtr whole = makeTestVolume(VoxelType::uint8, glm::uvec3(96), [](const glm::ivec3& p) { return 30.0 + (p.x * 7 + p.y * 5 + p.z * 3) % 50; });
  const TransferFunction function = everywhere(0.4f);
  std::vector<RanksPtr> ranks = makeLocalRanks(4);
  std::vector<std::jthread> others;
  for (int rank = 1; rank < 4; ++rank) others.emplace_back([whole, own = ranks[static_cast<size_t>(rank)]] { followRanks(sharedBy(whole, own)); });
  const BrickLeaderPtr leader = leadRanks(sharedBy(whole, ranks[0]));
  const MarcherPtr marcher = makeRanksMarcher(leader, function), alone = makeCpuMarcher(whole, function);
  MarchSettings fine;
  fine.render.step = 0.02f;
  fine.sample.segments = 4;
  const Camera camera = lookingFrom({20.0f, 15.0f, 190.0f}, {}, 160, 120);
  const SampleFrame expected = alone->march(camera, fine);
  std::vector<CellBlock> first;
  for (int frame = 0; frame < 6; ++frame) {
    ASSERT_TRUE(sameFrame(marcher->march(camera, fine), expected)) << frame;
    std::vector<CellBlock> blocks;
    for (const RankWork& work : lastWork(leader)) blocks.push_back(work.block);
    if (frame == 0) first = blocks;
    if (frame == 5) {
      EXPECT_NE(blocks, first);
    }
  }
}

TEST(SpreadVolume, ARankThatDoesNotAnswerIsNotWaitedForForEver) {
  const VolumePtr whole = makeTestVolume(VoxelType::uint8, kDims, blobs(kDims, 5));
  std::vector<RanksPtr> ranks = makeLocalRanks(2);
  const TransferFunction function = band(15, 80, 0.08f);
  const std::jthread other([&] {  // makes what all make, and no more
    const MarchedVolume marched(sharedBy(whole, ranks[1]), function);
  });
  const MarcherPtr marcher = makeRanksMarcher(leadRanks(sharedBy(whole, ranks[0]), std::chrono::milliseconds(300)), function);
  const auto from = std::chrono::steady_clock::now();
  try {
    marcher->march(cameras().front(), {});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("process 1 of 2 does not answer"), std::string::npos) << error.what();
  }
  EXPECT_LT(std::chrono::steady_clock::now() - from, std::chrono::seconds(5));
}

/// Of voxels that are there, but for so long as they are said to be read.
class SlowSource final : public VoxelSource {
 public:
  explicit SlowSource(const std::atomic<int>& readMs) : readMs_(readMs) {}
  void provide(const VoxelRows&, const std::stop_token& stop) override {
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(readMs_.load());
    for (; std::chrono::steady_clock::now() < end; std::this_thread::sleep_for(std::chrono::milliseconds(5)))
      if (stop.stop_requested()) throw OperationCancelled();
  }
  void release() override {}

 private:
  const std::atomic<int>& readMs_;
};

TEST(SpreadVolume, ARankThatReadsItsBrickForLongIsWaitedForAndEndsWhenItIsToldTo) {
  const VolumePtr whole = makeTestVolume(VoxelType::uint8, kDims, blobs(kDims, 5));
  std::atomic<int> readMs = 0;
  Spread spread(
      [&](RanksPtr ranks) {
        auto source = ranks->isFirst() ? nullptr : std::make_shared<SlowSource>(readMs);
        return std::make_shared<Volume>(whole->name(), whole->type(), whole->geometry(), whole, whole->voxels(), std::stop_token{}, std::move(ranks), std::move(source));
      },
      band(15, 80, 0.08f), 2, Spread::onHost, std::chrono::milliseconds(1500));
  readMs = 3000;
  EXPECT_GT(spread->march(cameras().front(), {}).size(), 100u) << "it says all the while that it is alive";
  readMs = 60'000;
  std::stop_source stop;
  const std::jthread stopper([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    stop.request_stop();
  });
  MarchSettings other;
  other.render.step = 0.3f;
  const auto from = std::chrono::steady_clock::now();
  EXPECT_THROW(spread->march(cameras()[1], other, stop.get_token()), OperationCancelled);
  readMs = 0;
  EXPECT_GT(spread->march(cameras().front(), {}).size(), 100u);
  EXPECT_LT(std::chrono::steady_clock::now() - from, std::chrono::seconds(20));
}

TEST(SpreadVolume, RanksThatHaveOtherVolumesAreFoundOut) {
  const VolumePtr whole = makeTestVolume(VoxelType::uint8, kDims, blobs(kDims, 5)), other = makeTestVolume(VoxelType::uint8, kDims, blobs(kDims, 6)),
                  larger = makeTestVolume(VoxelType::uint8, kDims + 1u, blobs(kDims, 5)), wider = makeTestVolume(VoxelType::uint16, kDims, blobs(kDims, 5));
  for (const VolumePtr& wrong : {other, larger, wider})
    onAll(3, [&](const RanksPtr& own) { EXPECT_THROW(sharedBy(own->rank() == 2 ? wrong : whole, own), InputError); });
}

TEST(SpreadVolume, WhatCannotBeMarchedInPiecesIsRefused) {
  const VolumePtr whole = makeTestVolume(VoxelType::uint8, kDims, blobs(kDims, 5));
  const Spread spread(whole, band(10, 90, 0.2f), 2);
  const Camera camera = cameras().front();
  MarchSettings settings;
  settings.render.arithmetic = Arithmetic::textbook;
  Image<glm::vec4> image;
  EXPECT_THROW(spread->render(camera, settings.render, image), UsageError);
  EXPECT_NO_THROW(spread->march(camera, {}));
}

TEST(SpreadVolume, MoreRanksThanThereIsWorkForAreRefusedWithTheNumberThatIs) {
  const VolumePtr whole = makeTestVolume(VoxelType::uint8, glm::uvec3(8, 4, 3), [](const glm::ivec3& p) { return 20.0 * p.x; });
  std::vector<RanksPtr> ranks = makeLocalRanks(3);
  std::vector<std::jthread> others;
  for (int rank = 1; rank < 3; ++rank) others.emplace_back([whole, own = ranks[static_cast<size_t>(rank)]] { followRanks(sharedBy(whole, own)); });
  const BrickLeaderPtr leader = leadRanks(sharedBy(whole, ranks[0]));
  try {
    makeRanksMarcher(leader, everywhere(0.1f));
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find("2 at most"), std::string::npos) << error.what();
  }
}

TEST(SpreadVolume, AProxyThatIsStoppedLeavesRanksThatWork) {
  const glm::uvec3 dims(150);
  const VolumePtr whole = makeTestVolume(VoxelType::uint8, dims, blobs(dims, 5));
  const TransferFunction function = band(15, 80, 0.2f);
  const Spread spread(whole, function, 3);
  const MarcherPtr alone = makeCpuMarcher(whole, function);
  const Camera camera = lookingFrom({270.0f, 90.0f, 145.0f}, {}, 40, 30);
  for (int i = 0; i < 12; ++i) {
    MarchSettings settings;
    settings.sample.proxy = 20 + 4 * i;
    std::stop_source source;
    const std::jthread stopper([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(i));
      source.request_stop();
    });
    try {
      spread->march(camera, settings, source.get_token());
    } catch (const OperationCancelled&) {
    }
  }
  MarchSettings settings;
  settings.sample.proxy = 30;
  const SampleFrame expected = alone->march(camera, settings), frame = spread->march(camera, settings);
  EXPECT_TRUE(sameFrame(frame, expected));
  EXPECT_EQ(std::memcmp(frame.proxy->volume->voxels(), expected.proxy->volume->voxels(), expected.proxy->volume->sizeBytes()), 0);
}

TEST(SpreadVolume, AMarchThatTakesLongerThanItMayEnds) {
  const VolumePtr whole = makeTestVolume(VoxelType::uint8, kDims, blobs(kDims, 5));
  const Spread spread(whole, everywhere(0.001f), 3);
  TurnSettings turns;
  turns.limit = std::chrono::milliseconds(100);
  const MarcherPtr limited = spread->twin(std::make_shared<Turns>(turns));
  MarchSettings fine;
  fine.render.step = 1e-3f;
  EXPECT_THROW(limited->march(lookingFrom({80.0f, 30.0f, 45.0f}, {}, 512, 512), fine), WorkLimitExceeded);
  EXPECT_NO_THROW(spread->march(cameras().front(), {}));
}

TEST(SpreadVolume, ManyMarchersOfItAreUsedSideBySide) {
  const VolumePtr whole = makeTestVolume(VoxelType::uint8, kDims, blobs(kDims, 5));
  const TransferFunction function = band(15, 80, 0.2f);
  const Spread spread(whole, function, 3);
  const MarcherPtr alone = makeCpuMarcher(whole, function);
  const SampleFrame expected = alone->march(cameras().front(), {});
  std::vector<std::jthread> users;
  for (int user = 0; user < 4; ++user)
    users.emplace_back([&, user] {
      for (int i = 0; i < 6; ++i) {
        const MarcherPtr own = i % 2 == 0 ? spread->twin() : spread->withTransferFunction(band(10.0 + user, 60.0 + i, 0.3f));
        const SampleFrame frame = own->march(cameras().front(), {});
        if (i % 2 == 0) {
          EXPECT_TRUE(sameFrame(frame, expected));
        }
      }
    });
}

}  // namespace
}  // namespace warpscope
