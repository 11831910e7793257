// As large as it gets: cases 24 and 55, and volumes of more voxels than 32 bits count. Truth: brute force, closed forms, the frame's own picture.
// Skipped, visibly, where memory is short, and in builds that are not optimised.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "render/gl/context.h"
#include "render/march/marcher_cpu.h"
#include "render/volume/reader.h"
#include "render/warp/lbvh/sphere_tracer.h"
#include "render/warp/splats/splat_tracer.h"
#include "render/warp/warp.h"
#include "tests/frame_samples.h"
#include "tests/marcher_cases.h"
#include "tests/sphere_clouds.h"
#include "tests/test_folder.h"
#include "tests/test_volumes.h"

namespace warpscope {
namespace {

/// Memory that could be had now, in GiB; 0 where the system does not say.
[[maybe_unused]] double availableGiB() {
  std::ifstream file("/proc/meminfo");
  std::string word;
  while (file >> word)
    if (word == "MemAvailable:") {
      double kiB = 0.0;
      file >> kiB;
      return kiB / (1 << 20);
    }
  return 0.0;
}

#if defined(NDEBUG)
#define WARPSCOPE_SKIP_WHERE_TOO_LARGE(gib) \
  if (availableGiB() < (gib)) GTEST_SKIP() << "needs " << (gib) << " GiB of memory, of which " << availableGiB() << " are there"
#else
#define WARPSCOPE_SKIP_WHERE_TOO_LARGE(gib) GTEST_SKIP() << "takes minutes where compilers do not optimise"
#endif

/// Draws without a window, for the techniques that need OpenGL.
class Pictures {
 public:
  explicit Pictures(MarcherPtr marcher) {
    resources_.marcher = std::move(marcher);
    resources_.backend = Backend::cpu;
    resources_.context = [this]() -> gl::Context& {
      if (!context_) context_ = gl::makeHeadlessContext();
      context_->makeCurrent();
      return *context_;
    };
  }
  WarpedImage draw(const WarpDescriptor& technique, const SampleFramePtr& frame, const Camera& camera) const {
    const std::unique_ptr<Warp> warp = makeWarp(technique, resources_);
    WarpedImage image;
    warp->setFrame(frame, {});
    warp->draw(camera, {}, image);
    return image;
  }

 private:
  std::unique_ptr<gl::Context> context_;
  WarpResources resources_;
};

/// Every technique draws a frame of that size for its own camera, its samples as large as their pixels: they show themselves.
void expectOwnPictures(uint32_t width, uint32_t height, float distance, float tanHalfFovY, size_t atLeast) {
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, {16, 16, 16}, [](const glm::ivec3&) { return 50.0; });
  const MarcherPtr marcher = makeCpuMarcher(volume, everywhere(1.0f));
  MarchSettings settings;
  settings.sample.heuristic = Heuristic::entrance;
  settings.sample.radiusPolicy = RadiusPolicy::pixel;
  settings.sample.segments = 1;
  const Camera camera = lookingFrom(distance * glm::normalize(glm::vec3(0.3f, 0.2f, 1.0f)), {}, width, height, tanHalfFovY);
  const auto frame = std::make_shared<SampleFrame>(marcher->march(camera, settings));
  ASSERT_GE(frame->size(), atLeast);
  const Pictures pictures(marcher);
  for (const WarpDescriptor& technique : warpRegistry()) {
    SCOPED_TRACE(technique.name);
#if defined(WARPSCOPE_TRAPS)
    if (technique.usesOpenGl) continue;  // OpenGL's own arithmetic traps in Mesa
#endif
    if (technique.name == "proxy") continue;  // there is none
    const WarpedImage image = pictures.draw(technique, frame, camera);
    ASSERT_EQ(image.color.width(), width);
    ASSERT_EQ(image.color.height(), height);
    size_t covered = 0, own = 0, beside = 0;
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) {
        if (image.color(x, y).a > 0.0f) ++covered;
        const uint32_t id = image.samples(x, y);
        if (id >= frame->size()) continue;
        const int64_t columns = int64_t{columnOf(frame->samples[id])} - x, rows = int64_t{rowOf(frame->samples[id])} - y;
        own += columns == 0 && rows == 0;
        beside += std::abs(columns) <= 1 && std::abs(rows) <= 1;
      }
    if (!technique.usesFrame) {
      EXPECT_EQ(covered, frame->size());
    } else if (technique.uses.segments) {
      // Where a ray grazes a corner for less than codes can tell, it may miss what lies there.
      EXPECT_LE(covered, frame->size());
      EXPECT_GE((covered + 1) * 100'000, frame->size() * 99'999);
    } else if (technique.name == "mesh") {
      EXPECT_EQ(covered, frame->size());  // but it blends them
    } else if (technique.name == "points") {
      // Two pixels wide: they cover neighbours, beyond the outline as well.
      EXPECT_GE(covered, frame->size());
      EXPECT_EQ(beside, covered);
    } else {
      EXPECT_EQ(covered, frame->size());
      EXPECT_GE(own * 1000, frame->size() * 999);
    }
  }
}

TEST(Sizes55, PicturesOfOneRowAndOfOneColumn) {
  expectOwnPictures(16384, 1, 40.0f, 0.5f / 16384, 8'000);
  expectOwnPictures(1, 16384, 40.0f, 0.5f, 8'000);
}

TEST(Sizes55, PicturesOf8192Squared) {
  WARPSCOPE_SKIP_WHERE_TOO_LARGE(6.0);
  expectOwnPictures(8192, 8192, 120.0f, 0.4f, 1'000'000);
}

TEST(Sizes24, TenMillionSpheresAreWhatBruteForceFinds) {
  WARPSCOPE_SKIP_WHERE_TOO_LARGE(3.0);
  for (const CloudShape shape : {CloudShape::clustered, CloudShape::planar}) {
    const std::vector<Sphere> cloud = makeCloud(shape, 10'000'000, 1000.0f, 24);
    const Camera camera = orbitCamera(1800.0f, 35.0f, 16, 10);
    Image<uint32_t> expected, ids, splats;
    Image<float> expectedDepth, depth, splatDepth;
    {
      BruteForceTracer brute;
      brute.build(cloud);
      brute.trace(camera, expected, &expectedDepth, {});
    }
    {
      LbvhTracer lbvh;
      lbvh.build(cloud);
      lbvh.trace(camera, ids, &depth, {});
    }
    SplatTracer splatter;
    splatter.build(cloud);
    splatter.trace(camera, splats, &splatDepth, {});
    EXPECT_EQ(ids, expected);
    EXPECT_EQ(depth, expectedDepth);
    EXPECT_EQ(splats, expected);
    EXPECT_EQ(splatDepth, expectedDepth);
    EXPECT_GT(std::count_if(ids.begin(), ids.end(), [](uint32_t id) { return id != kNoSample; }), 20);
  }
}

TEST(Sizes, AVolumeOf2048CubedIsSeenWhereItIs) {
  WARPSCOPE_SKIP_WHERE_TOO_LARGE(11.0);
  // Empty but for a block in its last corner, 2^33 bytes from the first voxel: the file has a hole where nothing is.
  constexpr uint32_t kSide = 2048, kBlock = 48;
  const TestFolder folder;
  const std::filesystem::path path = folder.path() / "large_2048x2048x2048_uint8.raw";
  {
    std::ofstream file(path, std::ios::binary);
    const std::string row(kBlock, '\xc8');
    for (uint32_t z = kSide - kBlock; z < kSide; ++z)
      for (uint32_t y = kSide - kBlock; y < kSide; ++y) {
        file.seekp(static_cast<std::streamoff>((size_t{z} * kSide + y) * kSide + kSide - kBlock));
        file << row;
      }
    ASSERT_TRUE(file.good());
  }
  const VolumePtr volume = openVolume(path, {});
  ASSERT_EQ(volume->voxelCount(), size_t{1} << 33);
  EXPECT_EQ(volume->statistics().histogram[0xc8], size_t{kBlock} * kBlock * kBlock);
  EXPECT_EQ(volume->statistics().histogram[0], volume->voxelCount() - size_t{kBlock} * kBlock * kBlock);
  const MarcherPtr marcher = makeCpuMarcher(volume, {{{100.0, glm::vec3(1.0f), 0.0f}, {100.0, glm::vec3(1.0f), 1.0f}}});
  MarchSettings settings;
  settings.sample.heuristic = Heuristic::entrance;
  // Towards the corner from beyond it: half the value is reached half way between the last voxel of nothing and the first of the block.
  const Box block{glm::vec3(0.5f * kSide - kBlock), glm::vec3(0.5f * kSide)};
  const Camera camera = lookingFrom(block.upper + glm::vec3(90.0f, 120.0f, 200.0f), 0.5f * (block.lower + block.upper), 64, 48, 0.2f);
  const SampleFrame frame = marcher->march(camera, settings);
  size_t inside = 0;
  for (size_t i = 0; i < frame.size(); ++i) {
    const PackedSample sample = frame.samples[i];
    const double length = lengthInside(camera, columnOf(sample), rowOf(sample), block);
    if (length < 2.0) continue;  // the outline, where blends and steps decide
    ++inside;
    const glm::vec3 center = sphereOf(frame, i).center;
    const glm::vec3 below = block.lower - center, above = center - block.upper;
    // On the front of the block, within a step.
    EXPECT_LT(std::max({below.x, below.y, below.z, above.x, above.y, above.z}), 0.51f);
    EXPECT_GT(std::max({above.x, above.y, above.z}), -1.01f);
  }
  size_t expected = 0;
  for (uint32_t y = 0; y < camera.height; ++y)
    for (uint32_t x = 0; x < camera.width; ++x) expected += lengthInside(camera, x, y, block) >= 2.0;
  EXPECT_EQ(inside, expected);
  EXPECT_GT(inside, 500u);
}

}  // namespace
}  // namespace warpscope
