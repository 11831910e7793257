// A volume that is marched slab by slab: its frames are those of a marcher that has all of it, bit for bit.
// Mirrors render/march/streamed_marcher.h, and relay_share.h, by which two work at one relay.
#include "render/march/streamed_marcher.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>

#include "marcher_cases.h"
#include "render/base/error.h"
#include "render/march/marcher_cpu.h"
#include "render/march/relay_share.h"
#include "spread_cases.h"
#include "spread_volume.h"
#include "test_volumes.h"

namespace warpscope {
namespace {

/// Counts what it is asked for, and marches it on the CPU.
class CountingPieces final : public PieceMarcher {
 public:
  CountingPieces(MarchedVolumePtr marched, std::atomic<int>& slabs, std::atomic<int>& mostSlices)
      : marched_(marched), pieces_(makePieceMarcher(std::move(marched))), slabs_(slabs), mostSlices_(mostSlices) {}
  void setLightCopy(const ProxyPtr& copy) override { pieces_->setLightCopy(copy); }
  void marchPieces(const Camera& camera, const RenderSettings& settings, const SampleSettings* sample, RayRelay& relay, const std::stop_token& stop) override {
    ++slabs_;
    const VoxelRows rows = rowsOf(relay.block(), settings, marched_->volume->geometry());
    mostSlices_ = std::max(mostSlices_.load(), static_cast<int>(rows.upper.y - rows.lower.y));
    pieces_->marchPieces(camera, settings, sample, relay, stop);
  }

 private:
  const MarchedVolumePtr marched_;
  const std::unique_ptr<PieceMarcher> pieces_;
  std::atomic<int>&slabs_, &mostSlices_;
};

TEST(StreamedMarcher, FramesAndPicturesAreThoseOfAllOfTheVolume) {
  const FieldFunction field = blobs(kDims, 11);
  for (const VoxelType type : {VoxelType::uint8, VoxelType::float32}) {
    SCOPED_TRACE(nameOf(type));
    const VolumePtr whole =
        makeTestVolume(type, kDims, [&](const glm::ivec3& p) { return type == VoxelType::float32 && (p.x * 7 + p.y * 3 + p.z) % 41 == 0 ? std::nan("") : field(p); });
    const auto marched = std::make_shared<const MarchedVolume>(whole, band(15, 80, 0.3f));
    const MarcherPtr alone = makeCpuMarcherOf(marched, nullptr);
    for (const int slices : {-5, 12, 23, 1000}) {
      SCOPED_TRACE(slices);
      std::atomic<int> slabs = 0, mostSlices = 0;
      const MarcherPtr streamed =
          makeStreamedMarcher(marched, {[&](MarchedVolumePtr one) { return std::make_unique<CountingPieces>(std::move(one), slabs, mostSlices); }}, {slices});
      for (const auto& [name, settings] : variants())
        for (const Camera& camera : cameras()) {
          ASSERT_TRUE(sameFrame(streamed->march(camera, settings), alone->march(camera, settings))) << name;
          ASSERT_TRUE(sameBits(rendered(*streamed, camera, settings), rendered(*alone, camera, settings))) << name;
          if (name == "coarse" && slices == 12) {
            EXPECT_LE(mostSlices, slices) << "rows of no slab are more than there is room for";
          }
        }
      EXPECT_GT(slabs, static_cast<int>(slices < 23 ? 8 : 2) * static_cast<int>(cameras().size()));
    }
  }
}

TEST(StreamedMarcher, NothingIsMarchedWholeWhereNothingMayBe) {
  for (const VoxelType type : {VoxelType::uint8, VoxelType::float32}) {
    SCOPED_TRACE(nameOf(type));
    const auto marched = std::make_shared<const MarchedVolume>(makeTestVolume(type, kDims, blobs(kDims, 11)), band(15, 80, 0.3f));
    const MarcherPtr alone = makeCpuMarcherOf(marched, nullptr);
    std::atomic<int> slabs = 0, mostSlices = 0;
    const PieceMaker counting{[&](MarchedVolumePtr one) { return std::make_unique<CountingPieces>(std::move(one), slabs, mostSlices); }};
    const MarcherPtr streamed = makeStreamedMarcher(marched, counting, {.slices = 16, .isForAll = true});
    for (const auto& [name, settings] : variants())
      for (const Camera& camera : cameras()) {
        slabs = 0;
        ASSERT_TRUE(sameFrame(streamed->march(camera, settings), alone->march(camera, settings))) << name;
        ASSERT_TRUE(sameBits(rendered(*streamed, camera, settings), rendered(*alone, camera, settings))) << name;
        EXPECT_GT(slabs, 2) << name;
      }
    MarchSettings textbook;
    textbook.render.arithmetic = Arithmetic::textbook;
    EXPECT_THROW(streamed->march(cameras().front(), textbook), UsageError);
  }
}

TEST(StreamedMarcher, ShadowsWithoutTheWholeVolumeAreThoseOfItsCopy) {
  const glm::uvec3 dims(300, 24, 40);  // longer than its copy
  const auto marched = std::make_shared<const MarchedVolume>(makeTestVolume(VoxelType::uint8, dims, blobs(dims, 11)), band(15, 80, 0.3f));
  MarchSettings settings;
  settings.sample.segments = 4;
  settings.render.effects.shading.strength = 1.0f;
  settings.render.effects.shadows.strength = 1.0f;
  settings.render.effects.shadows.occlusion = 0.7f;
  const MarcherPtr alone = makeCpuMarcherOf(marched, nullptr), streamed = makeStreamedMarcher(marched, {}, {.slices = 16, .isForAll = true});
  const Spread spread(marched->volume, band(15, 80, 0.3f), 3);
  for (const Camera& camera : cameras()) {
    const SampleFrame frame = streamed->march(camera, settings);
    EXPECT_TRUE(sameFrame(frame, spread->march(camera, settings)));
    EXPECT_FALSE(sameFrame(frame, alone->march(camera, settings)));
  }
}

TEST(StreamedMarcher, LargePicturesAreMarchedSomeTilesAfterTheOther) {
  const auto marched = std::make_shared<const MarchedVolume>(makeTestVolume(VoxelType::uint8, kDims, blobs(kDims, 11)), band(15, 80, 0.3f));
  const MarcherPtr alone = makeCpuMarcherOf(marched, nullptr);
  std::atomic<int> slabs = 0, mostSlices = 0;
  const PieceMaker counting{[&](MarchedVolumePtr one) { return std::make_unique<CountingPieces>(std::move(one), slabs, mostSlices); }};
  const Camera camera = lookingFrom({70.0f, 30.0f, 45.0f}, {}, 300, 321);  // 110 tiles, of which 64 are under way at least
  for (const int samples : {1, 3}) {
    SCOPED_TRACE(samples);
    MarchSettings settings;
    settings.sample.segments = 2;
    settings.sample.samplesPerRay = samples;  // several: rays go twice
    int atATime[2] = {};
    for (const bool isShort : {false, true}) {
      StreamRoom room{.slices = 16};
      if (isShort) room.rayBytes = 1;
      slabs = 0;
      EXPECT_TRUE(sameFrame(makeStreamedMarcher(marched, counting, room)->march(camera, settings), alone->march(camera, settings)));
      atATime[isShort] = slabs;
    }
    EXPECT_EQ(atATime[1], 2 * atATime[0]);
  }
}

TEST(StreamedMarcher, WhereASegmentIsLitMayBeInNothingThatIsVisible) {
  // Two sheets of matter and a slope between them that shows nothing: their one segment's place lies there.
  const VolumePtr whole = makeTestVolume(VoxelType::uint8, glm::uvec3(48), [](const glm::ivec3& p) {
    const double fromMiddle = std::abs(p.z - 23.5);
    return fromMiddle > 18.0 ? 120.0 + p.x % 7 : 10.0 + p.z + 0.3 * p.x;
  });
  const auto marched = std::make_shared<const MarchedVolume>(whole, band(100, 140, 0.05f));
  const MarcherPtr alone = makeCpuMarcherOf(marched, nullptr);
  MarchSettings settings;
  settings.render.effects.shading.strength = 1.0f;
  for (const int segments : {1, 2})
    for (const int slices : {-5, 12, 30}) {
      settings.sample.segments = segments;
      const Camera camera = lookingFrom({4.0f, 3.0f, 90.0f}, {}, 40, 40);
      const SampleFrame expected = alone->march(camera, settings);
      ASSERT_FALSE(expected.segments.normals.empty());
      EXPECT_TRUE(sameFrame(makeStreamedMarcher(marched, {}, {slices})->march(camera, settings), expected)) << segments << " " << slices;
    }
}

TEST(StreamedMarcher, ByEveryHeuristic) {
  const VolumePtr whole = makeTestVolume(VoxelType::int16, kDims, blobs(kDims, 5));
  const auto marched = std::make_shared<const MarchedVolume>(whole, band(15, 80, 0.08f));
  const MarcherPtr alone = makeCpuMarcherOf(marched, nullptr), streamed = makeStreamedMarcher(marched, {}, {16});
  for (const Camera& camera : cameras())
    for (const auto& heuristic : kHeuristics) {
      MarchSettings settings;
      settings.sample.heuristic = heuristic.value;
      settings.sample.sendsSpread = true;
      const SampleFrame expected = alone->march(camera, settings);
      ASSERT_GT(expected.size(), 100u);
      ASSERT_TRUE(sameFrame(streamed->march(camera, settings), expected)) << heuristic.name;
    }
}

TEST(StreamedMarcher, OthersOfItsVolumeMarchInTheirTurns) {
  const VolumePtr whole = makeTestVolume(VoxelType::uint8, kDims, blobs(kDims, 5));
  const TransferFunction other = band(40, 90, 0.5f);
  const MarcherPtr streamed = makeStreamedMarcher(std::make_shared<const MarchedVolume>(whole, band(15, 80, 0.08f)), {}, {14}), alone = makeCpuMarcher(whole, other);
  const auto turns = std::make_shared<Turns>();
  const MarcherPtr twin = streamed->withTransferFunction(other)->twin(turns);
  const Camera camera = cameras().front();
  EXPECT_TRUE(sameFrame(twin->march(camera, {}), alone->march(camera, {})));
  MarchSettings settings;
  settings.sample.samplesPerRay = 3;  // rays go twice
  settings.sample.segments = 2;
  EXPECT_TRUE(sameFrame(twin->march(camera, settings), alone->march(camera, settings)));
  const auto few = std::make_shared<Turns>(TurnSettings{.slice = std::chrono::nanoseconds(1), .limit = std::chrono::nanoseconds(1)});
  EXPECT_THROW(streamed->twin(few)->march(camera, {}), WorkLimitExceeded);
}

TEST(StreamedMarcher, NothingToSeeIsSeen) {
  const VolumePtr whole = makeTestVolume(VoxelType::uint8, kDims, blobs(kDims, 5));
  const MarcherPtr streamed = makeStreamedMarcher(std::make_shared<const MarchedVolume>(whole, band(300, 400, 1.0f)), {}, {14});
  EXPECT_EQ(streamed->march(cameras().front(), {}).size(), 0u);
  for (const glm::vec4& pixel : rendered(*streamed, cameras().front(), MarchSettings{})) ASSERT_EQ(pixel, glm::vec4(0.0f));
}

TEST(StreamedMarcher, IsStopped) {
  const VolumePtr whole = makeTestVolume(VoxelType::uint8, kDims, blobs(kDims, 5));
  const MarcherPtr streamed = makeStreamedMarcher(std::make_shared<const MarchedVolume>(whole, everywhere(0.001f)), {}, {14});
  expectStops(*streamed, std::chrono::milliseconds(30), 512);
}

/// Two on the CPU, each for every second tile.
class SharedPieces final : public PieceMarcher {
 public:
  SharedPieces(const MarchedVolumePtr& marched, bool fails) : first_(makePieceMarcher(marched)), second_(makePieceMarcher(marched)), fails_(fails) {}
  void setLightCopy(const ProxyPtr&) override {}
  void marchPieces(const Camera& camera, const RenderSettings& settings, const SampleSettings* sample, RayRelay& relay, const std::stop_token& stop) override {
    RelayShare shares[] = {RelayShare(relay), RelayShare(relay)};
    const auto march = [&](PieceMarcher& marcher, RelayShare& share) {
      try {
        marcher.marchPieces(camera, settings, sample, share, stop);
      } catch (const OperationCancelled&) {  // when the frame is done
      }
    };
    const std::jthread first([&] { march(*first_, shares[0]); });
    const std::jthread second([&] {
      if (fails_)
        shares[1].close();
      else
        march(*second_, shares[1]);
    });
    for (int turn = 0; std::unique_ptr<RelayedTile> tile = relay.take(); turn = 1 - turn) shares[turn].give(std::move(tile));
    for (RelayShare& share : shares) share.end();
  }

 private:
  const std::unique_ptr<PieceMarcher> first_, second_;
  const bool fails_;
};

TEST(RelayShare, TwoThatWorkAtARelayAreAsOne) {
  const VolumePtr whole = makeTestVolume(VoxelType::uint8, kDims, blobs(kDims, 5));
  const TransferFunction function = band(15, 80, 0.3f);
  const MarcherPtr alone = makeCpuMarcher(whole, function);
  const Spread spread(whole, function, 3, [](int rank) { return rank == 2 ? PieceMaker{} : PieceMaker{[](const MarchedVolumePtr& marched) { return std::make_unique<SharedPieces>(marched, false); }}; });
  for (const auto& [name, settings] : variants())
    for (const Camera& camera : cameras()) ASSERT_TRUE(sameFrame(spread->march(camera, settings), alone->march(camera, settings))) << name;
}

TEST(RelayShare, WhereOneCannotGoOnNobodyWaitsForItsTiles) {
  const auto marched = std::make_shared<const MarchedVolume>(makeTestVolume(VoxelType::uint8, kDims, blobs(kDims, 5)), band(15, 80, 0.3f));
  const MarcherPtr streamed = makeStreamedMarcher(marched, {[](const MarchedVolumePtr& one) { return std::make_unique<SharedPieces>(one, true); }}, {1000});
  streamed->march(cameras().front(), {});  // comes to an end
}

}  // namespace
}  // namespace warpscope
