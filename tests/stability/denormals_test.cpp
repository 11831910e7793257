// Numbers below the smallest normal one: no thread flushes them to zero, volumes of them are shown, and nothing depends on them being kept.
// Intel SDM 1, 10.2.3.3 and 10.2.3.4 (flush-to-zero, denormals-are-zeros); render/README.md states the policy.
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <cmath>
#include <memory>
#include <thread>
#include <vector>

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

#include "render/core/parallel.h"
#include "render/gl/context.h"
#include "render/march/marcher_cpu.h"
#include "render/warp/lbvh/embree_tracer.h"
#include "render/warp/warp.h"
#include "tests/marcher_cases.h"
#include "tests/sphere_clouds.h"
#include "tests/test_volumes.h"

namespace warpscope {
namespace {

/// Half of the smallest normal float, and twice that, on this thread. Compared are normal numbers: denormal ones may be equal to zero.
bool keepsDenormals() {
  volatile float smallest = 0x1p-126f;
  volatile float half = smallest * 0.5f;
  return half * 2.0f == 0x1p-126f;
}

/// On how many of many pieces, on all threads of the arena, denormals are lost.
size_t piecesThatFlush() {
  std::atomic<size_t> count = 0;
  parallelForRanges(4096, 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) count += keepsDenormals() ? 0 : 1;
  });
  return count;
}

/// A frame and the pictures of all techniques that draw samples, but for OpenGL's.
struct Drawn {
  SampleFramePtr frame;
  std::vector<WarpedImage> pictures;
};

Drawn drawn(const VolumePtr& volume, const TransferFunction& function) {
  const MarcherPtr marcher = makeCpuMarcher(volume, function);
  Drawn drawn{std::make_shared<SampleFrame>(marcher->march(lookingFrom({25.0f, 14.0f, 31.0f}, {}, 61, 47), {})), {}};
  WarpResources resources;
  resources.marcher = marcher;
  for (const WarpDescriptor& technique : warpRegistry()) {
    if (technique.usesOpenGl) continue;
    const std::unique_ptr<Warp> warp = makeWarp(technique, resources);
    warp->setFrame(drawn.frame, {});
    warp->draw(lookingFrom({31.0f, 8.0f, 22.0f}, {}, 67, 51), {}, drawn.pictures.emplace_back());
  }
  return drawn;
}

void expectSame(const Drawn& a, const Drawn& b) {
  ASSERT_GT(a.frame->size(), 400u);
  EXPECT_TRUE(sameFrame(*a.frame, *b.frame));
  for (size_t i = 0; i < a.pictures.size(); ++i) {
    EXPECT_EQ(a.pictures[i].samples, b.pictures[i].samples) << i;
    EXPECT_TRUE(sameBits(a.pictures[i].color, b.pictures[i].color)) << i;
  }
}

const glm::uvec3 kDims(24, 20, 16);

TransferFunction matter(double unit) {
  return {{{5.0 * unit, {1.0f, 0.3f, 0.1f}, 0.0f}, {70.0 * unit, {0.1f, 0.6f, 1.0f}, 0.6f}, {95.0 * unit, {0.2f, 0.2f, 0.3f}, 1.0f}}};
}

TEST(Denormals, NoThreadLosesThemWhateverHasRunOnIt) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 4);
  tbb::task_arena arena(4);
  arena.execute([] {
    ASSERT_TRUE(keepsDenormals());
    ASSERT_EQ(piecesThatFlush(), 0u);
    const Drawn some = drawn(makeTestVolume(VoxelType::uint8, kDims, blobs(kDims, 46)), matter(1.0));
    EXPECT_EQ(piecesThatFlush(), 0u) << "after marching and drawing";
    EXPECT_TRUE(keepsDenormals());
    EmbreeTracer embree;
    Image<uint32_t> ids;
    embree.build(makeCloud(CloudShape::random, 50'000, 10.0f, 7));
    embree.trace(orbitCamera(40.0f, 10.0f, 256, 256), ids, nullptr, {});
    EXPECT_EQ(piecesThatFlush(), 0u) << "after Embree";
    EXPECT_TRUE(keepsDenormals()) << "after Embree";
#if !defined(WARPSCOPE_TRAPS)
    const auto context = gl::makeHeadlessContext();
    EXPECT_TRUE(keepsDenormals()) << "after OpenGL";
#endif
    bool isKeptInNewThreads = false;
    std::thread([&] { isKeptInNewThreads = keepsDenormals(); }).join();
    EXPECT_TRUE(isKeptInNewThreads);
  });
}

TEST(Denormals, VolumesOfThemAreShownAsOthersAre) {
  // The same integers in units from the smallest denormal on: in all of them the values are exact.
  for (const VoxelType type : {VoxelType::float32, VoxelType::float64}) {
    const double smallest = type == VoxelType::float32 ? 0x1p-149 : 0x1p-1074;
    const auto volumeOf = [&](double unit) {
      const FieldFunction field = blobs(kDims, 46);
      return makeTestVolume(type, kDims, [&](const glm::ivec3& p) { return field(p) * unit; });
    };
    const double highest = volumeOf(1.0)->statistics().highest;
    const Drawn plain = drawn(volumeOf(1.0), matter(1.0));
    for (const double unit : {smallest, 8.0 * smallest, 0x1p20 * smallest}) {
      SCOPED_TRACE(unit);
      const VolumePtr volume = volumeOf(unit);
      EXPECT_EQ(volume->statistics().highest, highest * unit);
      EXPECT_EQ(volume->statistics().nonFinite, 0u);
      expectSame(plain, drawn(volume, matter(unit)));
    }
  }
}

#if defined(__SSE__)
TEST(Denormals, PicturesAreTheSameWhereAThreadLosesThem) {
  // A program that this one is a part of may have said so.
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, kDims, blobs(kDims, 46));
  const Drawn plain = drawn(volume, matter(1.0));
  std::thread([&] {
    _mm_setcsr(_mm_getcsr() | 0x8040);  // flush to zero, denormals are zeros
    ASSERT_FALSE(keepsDenormals());
    tbb::task_arena arena(2);
    arena.execute([&] {
      EXPECT_GT(piecesThatFlush(), 0u);
      expectSame(plain, drawn(volume, matter(1.0)));
    });
  }).join();
}
#endif

}  // namespace
}  // namespace warpscope
