// Rays side by side through a frame's segments: each meets the same bits as alone.
// Mirrors render/warp/segments/packet_walk.h, pixel_packets.h.
#include "render/warp/segments/packet_walk.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <bit>

#include "marcher_cases.h"
#include "render/core/image.h"
#include "render/warp/segments/pixel_packets.h"
#include "render/warp/segments/pixel_rays.h"
#include "render/warp/segments/segment_field_build.h"
#include "segment_frames.h"

namespace warpscope {
namespace {

constexpr float kStopBelow = 0.01f;

/// What is not known looks like that: of the ray and of where it is.
void guessed(const Ray& ray, WalkedRay& walked, float from, float to, FillReason reason) {
  walked.fill({glm::dvec3(0.02f * (to - from), std::abs(ray.direction.x), 0.01f * from), reason == FillReason::unknown ? 0.8 : 0.5}, reason);
}

/// How many rays were compared, how many of them met anything, and guessed; how many stretches were doubted.
struct Compared {
  size_t rays = 0, met = 0, guessedAt = 0, doubted = 0;
};

template <Between kBetween, bool kFills>
void expectSame(const SampleFrame& frame, const Camera& camera, Compared& compared) {
  BuiltSegmentField built;
  built.build(frame);
  const SegmentField field = built.field();
  std::atomic<size_t> doubted = 0;
  Image<WalkedRay> alone(camera.width, camera.height), together(camera.width, camera.height);
  forEachPixelRay<WalkedRay>(
      frame, camera, {},
      [&](const Ray& ray, const RayInterval& inside) {
        if constexpr (kFills)
          return walkSegments<kBetween>(field, ray, inside.tNear, inside.tFar, kStopBelow, [&](WalkedRay& walked, float from, float to, FillReason reason) {
            doubted += reason == FillReason::doubted;
            guessed(ray, walked, from, to, reason);
          });
        else
          return walkSegments<kBetween>(field, ray, inside.tNear, inside.tFar, kStopBelow);
      },
      [&](uint32_t x, uint32_t y, const Ray&, const WalkedRay& walked) { alone(x, y) = walked; });
  forEachPixelPacket(
      frame, camera, {},
      [&](const RayPacket& rays, WalkedRay(&walked)[kBatchLanes]) {
        if constexpr (kFills)
          walkPacket<kBetween>(field, rays, kStopBelow, walked, [&](int lane, WalkedRay& ray, float from, float to, FillReason reason) { guessed(rays.ray(lane), ray, from, to, reason); });
        else
          walkPacket<kBetween>(field, rays, kStopBelow, walked, nullptr);
      },
      [&](uint32_t x, uint32_t y, const WalkedRay& walked) { together(x, y) = walked; });
  compared.doubted += doubted;
  for (uint32_t y = 0; y < camera.height; ++y)
    for (uint32_t x = 0; x < camera.width; ++x) {
      const WalkedRay &expected = alone(x, y), &found = together(x, y);
      for (int channel = 0; channel < 3; ++channel)
        ASSERT_EQ(std::bit_cast<uint32_t>(found.color[channel]), std::bit_cast<uint32_t>(expected.color[channel])) << x << ", " << y << " between " << static_cast<int>(kBetween) << (kFills ? " filled" : "");
      ASSERT_EQ(std::bit_cast<uint32_t>(found.through), std::bit_cast<uint32_t>(expected.through)) << x << ", " << y;
      ASSERT_EQ(std::bit_cast<uint32_t>(found.guessed), std::bit_cast<uint32_t>(expected.guessed)) << x << ", " << y;
      ++compared.rays;
      compared.met += expected.through < 1.0f;
      compared.guessedAt += expected.guessed > 0.0f;
    }
}

void expectSame(const SampleFrame& frame, const Camera& camera, Compared& compared) {
  expectSame<Between::refined, true>(frame, camera, compared);
  expectSame<Between::refined, false>(frame, camera, compared);
  expectSame<Between::linear, true>(frame, camera, compared);
  expectSame<Between::linear, false>(frame, camera, compared);
  expectSame<Between::nearest, true>(frame, camera, compared);
  expectSame<Between::nearest, false>(frame, camera, compared);
}

/// About what frames are of: in the frame's eye, near it, beside, behind what is seen, in the midst of it, behind the frame's eye.
const std::vector<glm::vec3> kEyes{{3.0f, 4.0f, 30.0f}, {3.01f, 4.0f, 30.0f}, {20.0f, 5.0f, 22.0f}, {30.0f, 2.0f, 1.0f}, {-9.0f, -25.0f, -14.0f}, {2.0f, 1.0f, -28.0f},
                                   {1.0f, 2.0f, 6.0f},  {5.0f, 6.0f, 50.0f},  {0.0f, 0.0f, -8.0f}, {3e4f, 2e4f, 1e3f}};

TEST(PacketWalk, RandomFramesAreMetAsByRaysAlone) {
  Compared compared;
  uint32_t seed = 100;
  for (const uint32_t side : {13u, 67u, 300u})
    for (const int most : {1, 4, 16})
      for (const glm::vec3& eye : kEyes) {
        Camera server = kServer;
        server.width = side;
        server.height = side * 9 / 13;
        const float fov = glm::length(eye) > 1000.0f ? 0.001f : 0.6f;
        expectSame(randomFrame(server, ++seed, most), lookingFrom(eye, {0.1f, 0.0f, 0.2f}, 37, 29, fov), compared);
        if (HasFatalFailure()) return;
      }
  // That it was about something.
  EXPECT_GT(compared.met, compared.rays / 4);
  EXPECT_GT(compared.guessedAt, compared.rays / 10);
  EXPECT_GT(compared.doubted, compared.rays / 10);
}

TEST(PacketWalk, LinesOfOneDepthAndSegmentsThatBeginThere) {
  Compared compared;
  constexpr uint32_t kEvery = 8192;
  // Rays of the middle column go along planes of one forward depth of the frame's camera, in which segments begin and end.
  const Camera server = lookingFrom({0.0f, 0.0f, 32.0f}, glm::vec3(0.0f), 33, 33, 0.6f);
  for (uint32_t seed = 0; seed < 8; ++seed) {
    SampleFrame frame = randomFrame(server, seed);
    for (size_t i = 0; i < frame.segments.size(); ++i) {
      SegmentDepths& depths = frame.segments.depths[i];
      depths.begin -= depths.begin % kEvery;
      depths.end += kEvery - depths.end % kEvery;
    }
    for (uint32_t plane = 0; plane < 28; ++plane) {
      const float behind = decodeDepth(kEvery * plane, frame.quantization.depthStep);
      const float z = 32.0f - frame.quantization.nearDepth - behind;
      expectSame(frame, lookingFrom({40.0f, 0.0f, z}, {0.0f, 0.0f, z}, 9, 9, 0.5f), compared);
      expectSame(frame, lookingFrom({0.0f, -40.0f, z}, {0.0f, 0.0f, z}, 9, 9, 0.5f), compared);
      if (HasFatalFailure()) return;
    }
  }
  EXPECT_GT(compared.met, compared.rays / 10);
}

TEST(PacketWalk, ServersInsideAndFramesOfOnePixel) {
  Compared compared;
  const Camera inside = lookingFrom({2.0f, 1.0f, 3.0f}, {-4.0f, 0.0f, -9.0f}, 21, 17, 1.2f);
  Camera one = kServer;
  one.width = one.height = 1;
  for (uint32_t seed = 0; seed < 4; ++seed)
    for (const glm::vec3& eye : {glm::vec3(2.1f, 1.0f, 3.0f), glm::vec3(25.0f, 3.0f, 9.0f), glm::vec3(-6.0f, 1.0f, -5.0f), glm::vec3(12.0f, 3.0f, 26.0f)}) {
      expectSame(randomFrame(inside, seed, 8), lookingFrom(eye, glm::vec3(0.0f), 19, 6, 0.9f), compared);
      expectSame(randomFrame(one, seed, 16), lookingFrom(eye, glm::vec3(0.0f), 9, 33, 0.9f), compared);
      if (HasFatalFailure()) return;
    }
  EXPECT_GT(compared.met, compared.rays / 4);
}

TEST(PacketWalk, FramesWithoutSegmentsAndPicturesOfOnePixel) {
  Compared compared;
  expectSame(randomFrame(kServer, 1, 0), lookingFrom({20.0f, 5.0f, 22.0f}, glm::vec3(0.0f), 11, 7, 0.6f), compared);
  EXPECT_EQ(compared.met - compared.guessedAt, 0u);
  expectSame(randomFrame(kServer, 2), lookingFrom({20.0f, 5.0f, 22.0f}, glm::vec3(0.0f), 1, 1, 0.1f), compared);
  EXPECT_GT(compared.met, compared.guessedAt);
  // Nothing of the frame's bounds is in sight.
  compared = {};
  expectSame(randomFrame(kServer, 2), lookingFrom({20.0f, 5.0f, 22.0f}, glm::vec3(60.0f, 0.0f, 70.0f), 8, 8, 0.3f), compared);
  EXPECT_EQ(compared.met, 0u);
}

}  // namespace
}  // namespace warpscope
