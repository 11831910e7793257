// The hierarchy's sorting, its stack and its cancelling. What it has to get right of hard clouds:
// stability/hierarchy_test.cpp. Mirrors render/warp/lbvh/lbvh.h, lbvh_builder.h and sphere_tracer.h.
#include "render/warp/lbvh/lbvh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "render/base/error.h"
#include "render/warp/lbvh/sphere_tracer.h"
#include "tests/sphere_clouds.h"

namespace warpscope {
namespace {

TEST(Lbvh, RadixSortIsStable) {
  std::mt19937_64 random(3);
  std::vector<MortonItem> items(200'001), scratch;
  for (uint32_t i = 0; i < items.size(); ++i) items[i] = {random() % 3 ? random() >> 1 : random() % 5, i};
  std::vector<MortonItem> expected = items;
  std::stable_sort(expected.begin(), expected.end(), [](const auto& a, const auto& b) { return a.code < b.code; });
  sortByCode(items, scratch);
  for (size_t i = 0; i < items.size(); ++i) {
    ASSERT_EQ(items[i].code, expected[i].code);
    ASSERT_EQ(items[i].index, expected[i].index);
  }
}

TEST(Lbvh, AFullStackIsReported) {
  // A node that is its own child on both sides: no hierarchy, and the only way to overflow.
  const Box box{glm::vec3(-1.0f), glm::vec3(1.0f)};
  const LbvhNode node{{box, box}, {1.0f, 1.0f}, {0, 0}};
  const Sphere sphere{glm::vec3(0.0f), 1.0f};
  const uint32_t id = 0;
  EXPECT_TRUE(closestHit(LbvhView{&node, &sphere, &id, 2, 3.0f}, {{0.0f, 0.0f, 5.0f}, {0.0f, 0.0f, -1.0f}}).overflow);
}

TEST(Lbvh, CancelledTracingThrows) {
  LbvhTracer tracer;
  tracer.build(makeCloud(CloudShape::random, 100, 1.0f, 1));
  std::stop_source source;
  source.request_stop();
  Image<uint32_t> ids;
  EXPECT_THROW(tracer.trace(orbitCamera(3.0f, 0.0f, 64, 64), ids, nullptr, source.get_token()), OperationCancelled);
}

}  // namespace
}  // namespace warpscope
