// Rays in packets: the same bits as one ray, and what lanes are told apart by.
// Mirrors render/warp/lbvh/ray_packet.h.
#include "render/warp/lbvh/ray_packet.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/stability/magnitudes.h"

namespace warpscope {
namespace {

TEST(RayPacket, HoldsTheSameBitsAsOneRay) {
  checkProperty([] {
    for (const SphereCase& c : *rc::gen::container<std::vector<SphereCase>>(anySphereCase(-20, 20))) {
      const glm::vec3& d = c.ray.direction;
      const FloatPack t = intersectSpherePack(Vec3Pack{FloatPack(d.x), FloatPack(d.y), FloatPack(d.z)},
                                              c.center - c.ray.origin, c.radius);
      for (uint32_t lane = 0; lane < kPackLanes; ++lane)
        RC_ASSERT(t.get(lane) == intersectSphere(c.ray, c.center, c.radius));
    }
  });
}

RC_GTEST_PROP(RayPacket, PixelsHaveTheSameDirections, (uint16_t tilt)) {
  Camera camera;
  const float angle = 1e-4f * tilt;
  camera.forward = {std::sin(angle), 0.0f, -std::cos(angle)};
  camera.right = {std::cos(angle), 0.0f, std::sin(angle)};
  camera.width = 1023;
  camera.height = 77;
  for (uint32_t x = 0; x < camera.width; x += kPackLanes) {
    const Vec3Pack pack = pixelDirections(camera, static_cast<float>(x) + laneNumbers() + 0.5f, FloatPack(13.5f));
    for (uint32_t lane = 0; lane < kPackLanes; ++lane) {
      const glm::vec3 expected = pixelRay(camera, {x + lane + 0.5f, 13.5f}).direction;
      RC_ASSERT(glm::vec3(pack.x.get(lane), pack.y.get(lane), pack.z.get(lane)) == expected);
    }
  }
}

TEST(RayPacket, LargestLane) {
  const FloatPack numbers = laneNumbers();
  EXPECT_EQ(largestLane(numbers), static_cast<float>(kPackLanes - 1));
  EXPECT_EQ(largestLane(-numbers - 1.0f), -1.0f);
  EXPECT_EQ(largestLane(xsimd::select(numbers == FloatPack(1.0f), FloatPack(kNoHit), numbers)), kNoHit);
}

TEST(RayPacket, NearerHitsComeFirstAndOfEqualOnesTheLowerId) {
  const auto bits = [](float t, int id, float bestT, int bestId) {
    return laneBits(isNearer({FloatPack(t), IntPack(id)}, {FloatPack(bestT), IntPack(bestId)}));
  };
  const uint32_t all = laneBits(laneNumbers() >= FloatPack(0.0f));
  EXPECT_EQ(bits(1.0f, 9, 2.0f, 3), all);
  EXPECT_EQ(bits(2.0f, 2, 2.0f, 3), all);
  EXPECT_EQ(bits(2.0f, 3, 2.0f, 3), 0u);
  EXPECT_EQ(bits(3.0f, 2, 2.0f, 3), 0u);
  EXPECT_EQ(bits(3.0f, 2, kNoHit, -1), all);
  EXPECT_EQ(bits(kNoHit, 2, kNoHit, 3), 0u) << "no hit is none, whatever its id";
}

TEST(RayPacket, LaneBitsNameTheLanes) {
  for (uint32_t lane = 0; lane < kPackLanes; ++lane)
    EXPECT_EQ(laneBits(laneNumbers() == FloatPack(static_cast<float>(lane))), 1u << lane);
  EXPECT_EQ(laneBits(laneNumbers() < FloatPack(0.0f)), 0u);
}

}  // namespace
}  // namespace warpscope
