// Bricks that are marched by a device: frames are those of one CPU, bit for bit, whatever mixture of devices and CPUs has the bricks.
// Mirrors render/march/piece_marcher_cuda.h. The ranks are threads here, and share the device.
#include "render/march/piece_marcher_cuda.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

#include "render/base/error.h"
#include "render/base/memory_limit.h"
#include "render/cuda/devices.h"
#include "render/march/device_volume.h"
#include "render/march/marcher_cpu.h"
#include "render/march/streamed_marcher.h"
#include "tests/gpu/agreement.h"
#include "tests/gpu/device_memory.h"
#include "tests/headless.h"
#include "tests/marcher_cases.h"
#include "tests/slab_volume.h"
#include "tests/spread_cases.h"
#include "tests/spread_volume.h"
#include "tests/test_volumes.h"

namespace warpscope {
namespace {

PieceMaker onDevice(int /*rank*/) { return makeCudaPieces(false, {}); }
/// Every second one.
PieceMaker onSome(int rank) { return rank % 2 == 0 ? makeCudaPieces(false, {}) : PieceMaker{}; }

/// Tiles that a device marched for the last frame, and all.
std::pair<uint32_t, uint32_t> tilesOf(const Spread& spread) {
  std::pair<uint32_t, uint32_t> tiles{0, 0};
  for (const RankWork& work : spread.lastWork()) tiles.first += work.deviceTiles, tiles.second += work.tiles;
  return tiles;
}

TEST(PiecesOnDevice, FramesAreThoseOfOneProcessByEveryHeuristic) {
  WARPSCOPE_NEEDS_GPU();
  const VolumePtr whole = makeTestVolume(VoxelType::uint8, kDims, blobs(kDims, 5));
  const TransferFunction function = band(15, 80, 0.08f);
  const MarcherPtr alone = makeCpuMarcher(whole, function);
  for (const int count : {1, 2, 7}) {
    SCOPED_TRACE(count);
    const Spread spread(whole, function, count, onDevice), mixed(whole, function, count, onSome);
    for (const Camera& camera : cameras())
      for (const auto& heuristic : kHeuristics) {
        SCOPED_TRACE(heuristic.name);
        MarchSettings settings;
        settings.sample.heuristic = heuristic.value;
        settings.sample.radiusPolicy = RadiusPolicy::uncertainty;
        settings.sample.sendsSpread = true;
        const SampleFrame expected = alone->march(camera, settings);
        ASSERT_GT(expected.size(), 100u);
        ASSERT_TRUE(sameFrame(spread->march(camera, settings), expected));
        const auto [byDevice, all] = tilesOf(spread);
        EXPECT_EQ(byDevice, all);
        ASSERT_TRUE(sameFrame(mixed->march(camera, settings), expected));
      }
  }
}

TEST(PiecesOnDevice, FramesAndPicturesAreThoseOfOneProcessWhateverIsAskedOfThem) {
  WARPSCOPE_NEEDS_GPU();
  const FieldFunction field = blobs(kDims, 11);
  for (const VoxelType type : kAllVoxelTypes)
    for (const bool hasHoles : {false, true}) {
      if (hasHoles && type != VoxelType::float32) continue;
      SCOPED_TRACE(testing::Message() << nameOf(type) << ", holes " << hasHoles);
      const VolumePtr whole = makeTestVolume(type, kDims, [&](const glm::ivec3& p) { return hasHoles && (p.x * 7 + p.y * 3 + p.z) % 41 == 0 ? std::nan("") : field(p); });
      const TransferFunction function = band(15, 80, 0.3f);
      const MarcherPtr alone = makeCpuMarcher(whole, function);
      const Spread spread(whole, function, 5, onDevice), mixed(whole, function, 4, onSome);
      for (const auto& [name, settings] : variants())
        for (const Camera& camera : cameras()) {
          SCOPED_TRACE(name);
          ASSERT_TRUE(sameFrame(spread->march(camera, settings), alone->march(camera, settings)));
          const auto [byDevice, all] = tilesOf(spread);
          EXPECT_EQ(byDevice, all);
          ASSERT_TRUE(sameBits(rendered(*spread, camera, settings), rendered(*alone, camera, settings)));
          ASSERT_TRUE(sameFrame(mixed->march(camera, settings), alone->march(camera, settings)));
        }
    }
}

/// Found by the CPU in the same copy.
TEST(PiecesOnDevice, ShadowsAndOcclusionAreThoseOfTheCpu) {
  WARPSCOPE_NEEDS_GPU();
  for (const VoxelType type : {VoxelType::uint8, VoxelType::uint16, VoxelType::float32}) {
    SCOPED_TRACE(nameOf(type));
    const VolumePtr whole = makeTestVolume(type, kDims, blobs(kDims, 11));
    const TransferFunction function = band(15, 80, 0.3f), other = band(30, 90, 0.1f);
    const Spread device(whole, function, 3, onDevice), host(whole, function, 3);
    const MarcherPtr deviceByOther = device->withTransferFunction(other), hostByOther = host->withTransferFunction(other);
    MarchSettings settings;
    settings.render.effects.shading.strength = 1.0f;
    settings.render.effects.shadows.strength = 1.0f;
    for (const bool isPreIntegrated : {false, true})
      for (const char* const lights : {"world:1,2,3", "world:1,2,3 camera:0,1,1", "point:20,30,-40 headlight"})
        for (const float occlusion : {0.0f, 0.7f}) {
          SCOPED_TRACE(testing::Message() << lights << ", " << occlusion << ", " << isPreIntegrated);
          settings.render.effects.preIntegration = isPreIntegrated;
          settings.render.effects.lights = parseLights(lights, "lights");
          settings.render.effects.shadows.occlusion = occlusion;
          for (const Camera& camera : cameras()) {
            const SampleFrame expected = host->march(camera, settings);
            ASSERT_GT(expected.size(), 100u);
            ASSERT_TRUE(sameFrame(device->march(camera, settings), expected));
            EXPECT_EQ(tilesOf(device).first, tilesOf(device).second);
            ASSERT_TRUE(sameFrame(deviceByOther->march(camera, settings), hostByOther->march(camera, settings)));
          }
        }
    MarchSettings unshadowed = settings;
    unshadowed.render.effects.shadows = {};
    EXPECT_FALSE(sameFrame(device->march(cameras().front(), unshadowed), device->march(cameras().front(), settings)));
  }
}

/// Where each sample counts, and there is no room to list them.
TEST(PiecesOnDevice, MoreSamplesThanThereIsRoomForAreTheCpus) {
  WARPSCOPE_NEEDS_GPU();
  const VolumePtr whole = makeTestVolume(VoxelType::uint8, kDims, blobs(kDims, 5));
  const TransferFunction function = everywhere(1e-3f);
  const MarcherPtr alone = makeCpuMarcher(whole, function);
  const Spread spread(whole, function, 2, onDevice);
  const Camera camera = lookingFrom({70.0f, 30.0f, 45.0f}, {}, 300, 200);
  MarchSettings settings;
  settings.sample.heuristic = Heuristic::median;
  settings.render.contribution = 1e-6f;
  settings.render.step = 0.02f;
  EXPECT_TRUE(sameFrame(spread->march(camera, settings), alone->march(camera, settings)));
  const auto [byDevice, all] = tilesOf(spread);
  // How many tiles are the CPU's depends on which of them come together: those without room for one of them go there all.
  EXPECT_LT(byDevice, all) << "where rays are long there is no room";
  settings.render.step = 1.0f;
  EXPECT_TRUE(sameFrame(spread->march(camera, settings), alone->march(camera, settings)));
  EXPECT_EQ(tilesOf(spread).first, tilesOf(spread).second);
}

TEST(PiecesOnDevice, AnotherFunctionSharesTheVoxelsWhereValuesHaveTheSameScale) {
  WARPSCOPE_NEEDS_GPU();
  for (const VoxelType type : {VoxelType::uint16, VoxelType::int32}) {
    SCOPED_TRACE(nameOf(type));
    const VolumePtr whole = makeTestVolume(type, kDims, blobs(kDims, 2));
    const Camera camera = cameras().front();
    const Spread spread(whole, band(10, 30, 0.2f), 3, onDevice);
    for (const TransferFunction& function : {band(40, 90, 0.5f), everywhere(0.01f), band(200, 300, 1.0f), band(40, 90, 0.5f)}) {
      const MarcherPtr alone = makeCpuMarcher(whole, function), other = spread->withTransferFunction(function);
      EXPECT_TRUE(sameFrame(other->march(camera, {}), alone->march(camera, {})));
      EXPECT_TRUE(sameFrame(spread->march(camera, {}), makeCpuMarcher(whole, band(10, 30, 0.2f))->march(camera, {})));
    }
  }
}

TEST(PiecesOnDevice, AMarchThatIsStoppedLeavesRanksThatWork) {
  WARPSCOPE_NEEDS_GPU();
  const VolumePtr whole = makeTestVolume(VoxelType::uint8, kDims, blobs(kDims, 5));
  const MarcherPtr alone = makeCpuMarcher(whole, everywhere(0.001f));
  const Spread spread(whole, everywhere(0.001f), 3, onDevice);
  expectWorksWhenStopped(*spread, *alone);
}

TEST(StreamedOnDevice, FramesAndPicturesAreThoseOfAllOfTheVolume) {
  WARPSCOPE_NEEDS_GPU();
  const FieldFunction field = blobs(kDims, 11);
  for (const VoxelType type : {VoxelType::uint8, VoxelType::uint16, VoxelType::float32}) {
    SCOPED_TRACE(nameOf(type));
    const auto marched = std::make_shared<const MarchedVolume>(makeTestVolume(type, kDims, field), band(15, 80, 0.3f));
    const MarcherPtr alone = makeCpuMarcherOf(marched, nullptr);
    for (const int slices : {9, 17, 1000}) {
      SCOPED_TRACE(slices);
      const MarcherPtr streamed = makeStreamedMarcher(marched, makeCudaPieces(false, {}), {slices}), twin = streamed->twin();
      for (const auto& [name, settings] : variants())
        for (const Camera& camera : cameras()) {
          ASSERT_TRUE(sameFrame(streamed->march(camera, settings), alone->march(camera, settings))) << name;
          ASSERT_TRUE(sameBits(rendered(*twin, camera, settings), rendered(*alone, camera, settings))) << name;
        }
    }
  }
}

/// Memory runs out before the first ray, or when some have been marched; tiles then go on on the CPU, and so do those of functions that come later.
TEST(PiecesOnDevice, WhereTheDeviceFailsTheCpuGoesOn) {
  WARPSCOPE_NEEDS_GPU();
  const VolumePtr whole = makeTestVolume(VoxelType::uint8, kDims, blobs(kDims, 5));
  const TransferFunction function = band(15, 80, 0.08f), other = band(30, 90, 0.2f);
  const Camera camera = lookingFrom({70.0f, 30.0f, 45.0f}, {}, 900, 700);
  MarchSettings settings;
  settings.sample.segments = 4;  // and with them much memory
  const SampleFrame expected = makeCpuMarcher(whole, function)->march(camera, settings);
  for (const size_t left : {size_t{0}, size_t{4} << 20, size_t{24} << 20, size_t{60} << 20}) {
    SCOPED_TRACE(left);
    std::atomic<int> fallbacks = 0;
    const PieceMaker maker = makeCudaPieces(true, [&](const std::string& reason) {
      EXPECT_FALSE(reason.empty());
      ++fallbacks;
    });
    const Spread spread(whole, function, 1, [&](int) { return maker; });
    {
      const auto taken = takeMemory(left);
      ASSERT_TRUE(sameFrame(spread->march(camera, settings), expected));
    }
    EXPECT_EQ(fallbacks, 1);
    EXPECT_EQ(maker.backend(), Backend::cpu);
    EXPECT_EQ(spread->backend(), Backend::cpu);
    EXPECT_TRUE(sameFrame(spread->withTransferFunction(other)->march(camera, settings), makeCpuMarcher(whole, other)->march(camera, settings)));
    EXPECT_EQ(tilesOf(spread).first, 0u);
    EXPECT_EQ(fallbacks, 1) << "said once";
  }
  const PieceMaker firm = makeCudaPieces(false, {});
  const Spread spread(whole, function, 1, [&](int) { return firm; });
  const auto taken = takeMemory(0);
  EXPECT_THROW(spread->march(camera, settings), InputError);
}

TEST(StreamedOnDevice, AVolumeThatMayNotBeThereAsAWholeGoesThereInSlabs) {
  WARPSCOPE_NEEDS_GPU();
  const VolumePtr whole = makeTestVolume(VoxelType::uint16, kDims, blobs(kDims, 5));
  const TransferFunction function = band(15, 80, 0.08f);
  setDeviceMemoryLimit(size_t{2} * kDims.x * kDims.y * 16);
  EXPECT_EQ(slicesOnDevice(*whole), 16);
  const MarcherPtr marcher = makeFittingCudaMarcher(whole, function);
  for (const Camera& camera : cameras()) EXPECT_TRUE(sameFrame(marcher->march(camera, {}), makeCpuMarcher(whole, function)->march(camera, {})));
  EXPECT_EQ(marcher->capabilities().pace, MarchPace::afterRest) << "that of slabs";
  setDeviceMemoryLimit({});
  EXPECT_EQ(makeFittingCudaMarcher(whole, function)->capabilities().pace, MarchPace::followsCamera);
}

/// As one process does where --memory has no room for all of a volume, with room on the device for all of it, and without.
TEST(StreamedOnDevice, AVolumeThatIsMadeSlabBySlabIsTheWholeOne) {
  WARPSCOPE_NEEDS_GPU();
  const SlabVolume volumes;
  const TransferFunction function = band(200, 250, 0.05f);
  const MarcherPtr alone = makeCpuMarcher(volumes.whole(), function);
  const Camera camera = lookingFrom({500.0f, 300.0f, 600.0f}, {}, 120, 93, 0.8f);
  MarchSettings settings;
  settings.sample.segments = 2;
  settings.sample.proxy = 12;
  const SampleFrame expected = alone->march(camera, settings);
  ASSERT_GT(expected.size(), 1000u);
  for (const bool isLimited : {false, true}) {
    SCOPED_TRACE(isLimited);
    setDeviceMemoryLimit(isLimited ? std::optional<uint64_t>(volumes.whole()->sizeBytes() / 2) : std::nullopt);
    const MarcherPtr marcher = makeFittingCudaMarcher(volumes.slabs(), function);
    EXPECT_EQ(marcher->capabilities().pace, isLimited ? MarchPace::afterRest : MarchPace::followsCamera);
    EXPECT_TRUE(sameFrame(marcher->march(camera, settings), expected));
    MarchSettings greatest;
    greatest.render.effects.mode = RenderMode::mip;
    EXPECT_TRUE(sameBits(rendered(*marcher, camera, greatest), rendered(*alone, camera, greatest)));
  }
  setDeviceMemoryLimit({});
}

TEST(StreamedOnDevice, IsStopped) {
  WARPSCOPE_NEEDS_GPU();
  const auto marched = std::make_shared<const MarchedVolume>(makeTestVolume(VoxelType::uint8, kDims, blobs(kDims, 5)), everywhere(0.001f));
  const MarcherPtr streamed = makeStreamedMarcher(marched, makeCudaPieces(false, {}), {14});
  expectStops(*streamed, std::chrono::milliseconds(30), 1024);
}

/// Rows of a volume, compared where they were asked for; what lies in others does not matter.
TEST(DeviceBrick, HasWhatWasAskedForHoweverThatMoves) {
  WARPSCOPE_NEEDS_GPU();
  const glm::uvec3 dims(300, 250, 90);  // some pages a slice, with borders inside of rows
  for (const VoxelType type : {VoxelType::uint8, VoxelType::int16, VoxelType::float64}) {
    SCOPED_TRACE(nameOf(type));
    const VolumePtr whole = makeTestVolume(type, dims, [](const glm::ivec3& p) { return (p.x * 31 + p.y * 17 + p.z * 13) % 101; });
    const ValueScale scale = valueScaleOf(type, whole->statistics(), band(1, 99, 1.0f));
    DeviceBrick brick(whole, scale);
    EXPECT_EQ(brick.bytes(), 0u);
    for (const VoxelRows& rows : {VoxelRows{{10, 5}, {100, 40}}, VoxelRows{{0, 0}, {250, 90}}, VoxelRows{{200, 70}, {250, 90}}, VoxelRows{{20, 60}, {60, 80}}, VoxelRows{{50, 62}, {70, 81}},
                                  VoxelRows{{40, 62}, {69, 79}}, VoxelRows{{3, 3}, {3, 9}}}) {
      brick.provide(rows);
      const size_t pages = size_t{4} << 20, all = whole->voxelCount() * bytesOnDevice(type);
      EXPECT_LE(brick.bytes(), all + pages);
      for (uint32_t z = rows.lower.y; z < rows.upper.y; ++z) {
        const size_t first = (size_t{z} * dims.y + rows.lower.x) * dims.x, count = size_t{rows.upper.x - rows.lower.x} * dims.x;
        visitVoxelType(type, [&](auto voxelTag) {
          using Voxel = decltype(voxelTag);
          using Kept = std::conditional_t<(sizeof(Voxel) > 2), InterpolantVoxel, Voxel>;
          std::vector<Kept> has(count);
          ASSERT_EQ(cudaMemcpy(has.data(), brick.voxelsAs<Kept>() + first, count * sizeof(Kept), cudaMemcpyDeviceToHost), cudaSuccess);
          for (size_t i = 0; i < count; ++i)
            ASSERT_EQ(interpolant(has[i], scale), interpolant(whole->voxelsAs<Voxel>()[first + i], scale)) << z << ", " << i;
        });
      }
    }
  }
}

}  // namespace
}  // namespace warpscope
