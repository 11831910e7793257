// The k nearest hits against a sorted list of all hits, and their composition. Ties, equal spheres, few and none.
// Mirrors render/warp/multihit/nearest_hits.h and multihit_trace.h.
#include "render/warp/multihit/multihit_trace.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <random>

#include "render/base/error.h"
#include "render/warp/lbvh/sphere_tracer.h"
#include "tests/sphere_clouds.h"

namespace warpscope {
namespace {

using Hit = std::pair<float, uint32_t>;

/// All hits along the ray, sorted.
std::vector<Hit> allHits(std::span<const Sphere> cloud, const Ray& ray) {
  std::vector<Hit> hits;
  for (uint32_t id = 0; id < cloud.size(); ++id) {
    const float t = intersectSphere(ray, cloud[id].center, cloud[id].radius);
    if (t < kNoHit) hits.emplace_back(t, id);
  }
  std::sort(hits.begin(), hits.end());
  return hits;
}

std::vector<Rgba8> someColors(size_t count, uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<Rgba8> colors(count);
  for (Rgba8& color : colors) color = random();
  return colors;
}

struct Picture {
  Image<uint32_t> ids;
  Image<glm::vec4> color;
};

Picture picture(std::span<const Sphere> cloud, std::span<const Rgba8> colors, const Camera& camera, int hits) {
  Lbvh lbvh;
  lbvh.build(cloud);
  Picture result;
  traceNearestHits(lbvh.view(), colors, camera, hits, result.ids, result.color, {});
  return result;
}

/// Every pixel against the sorted list, which a single ray finds through the hierarchy too, composited from back to front.
void expectTheNearest(std::span<const Sphere> cloud, const Camera& camera, int hits, uint32_t seed) {
  const std::vector<Rgba8> colors = someColors(cloud.size(), seed);
  const Picture seen = picture(cloud, colors, camera, hits);
  Lbvh lbvh;
  lbvh.build(cloud);
  for (uint32_t y = 0; y < camera.height; ++y)
    for (uint32_t x = 0; x < camera.width; ++x) {
      const Ray ray = pixelRay(camera, {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f});
      std::vector<Hit> expected = allHits(cloud, ray);
      NearestHits<kMaxHits> single;
      ASSERT_TRUE(visitAlongRay(lbvh.view(), ray, single.farthest(), [&](uint32_t i) {
        const Sphere& sphere = lbvh.view().spheres[i];
        single.insert(intersectSphere(ray, sphere.center, sphere.radius), lbvh.view().ids[i]);
      }));
      for (int i = 0; i < kMaxHits; ++i) {
        const bool isHit = static_cast<size_t>(i) < expected.size();
        ASSERT_EQ(Hit(single.t(i), single.id(i)), isHit ? expected[static_cast<size_t>(i)] : Hit(kNoHit, kNoSample));
      }
      ASSERT_EQ(seen.ids(x, y), expected.empty() ? kNoSample : expected.front().second) << x << "," << y;
      expected.resize(std::min(expected.size(), static_cast<size_t>(hits)));
      glm::vec4 forward(0.0f);
      for (size_t i = 0; i < expected.size(); ++i) {
        const glm::vec4 next = decodeRgba8(colors[expected[i].second]);
        forward = i == 0 ? next : over(forward, next);
      }
      ASSERT_EQ(seen.color(x, y), forward) << x << "," << y << ", " << hits << " hits";
      glm::dvec4 color(0.0);
      for (size_t i = expected.size(); i-- > 0;) {
        const glm::dvec4 front(decodeRgba8(colors[expected[i].second]));
        color = front + (1.0 - front.a) * color;
      }
      for (int channel = 0; channel < 4; ++channel)
        ASSERT_NEAR(seen.color(x, y)[channel], color[channel], 1e-5) << x << "," << y << ", " << hits << " hits";
    }
}

template <int Capacity>
void expectListKeepsTheNearest(std::mt19937& random) {
  NearestHits<Capacity> nearest;
  std::vector<Hit> all;
  const uint32_t count = random() % 40;
  for (uint32_t i = 0; i < count; ++i) {
    // Few distances, so that ids decide; misses among them.
    const float t = random() % 8 == 0 ? kNoHit : static_cast<float>(random() % 6);
    all.emplace_back(t, i);
  }
  std::shuffle(all.begin(), all.end(), random);
  for (const auto& [t, id] : all) nearest.insert(t, id);
  nearest.insert(std::nanf(""), 1);
  std::erase_if(all, [](const Hit& hit) { return hit.first == kNoHit; });
  std::sort(all.begin(), all.end());
  for (int i = 0; i < Capacity; ++i) {
    const Hit expected = static_cast<size_t>(i) < all.size() ? all[static_cast<size_t>(i)] : Hit(kNoHit, kNoSample);
    ASSERT_EQ(Hit(nearest.t(i), nearest.id(i)), expected) << "hit " << i << " of " << Capacity;
  }
  ASSERT_EQ(nearest.farthest(), nearest.t(Capacity - 1));
}

RC_GTEST_PROP(NearestHits, AreTheFirstOfTheSortedList, (uint32_t seed)) {
  std::mt19937 random(seed);
  expectListKeepsTheNearest<1>(random);
  expectListKeepsTheNearest<2>(random);
  expectListKeepsTheNearest<3>(random);
  expectListKeepsTheNearest<4>(random);
  expectListKeepsTheNearest<7>(random);
  expectListKeepsTheNearest<16>(random);
  RC_ASSERT(!testing::Test::HasFailure());
}

RC_GTEST_PROP(Multihit, FindsTheNearestOnAllClouds, (uint32_t seed)) {
  std::mt19937 random(seed);
  const CloudShape shape = kCloudShapes[random() % kCloudShapes.size()];
  const float scale = std::pow(10.0f, std::uniform_real_distribution<float>(-4.0f, 4.0f)(random));
  auto cloud = makeCloud(shape, 1 + random() % 300, scale, seed);
  for (Sphere& sphere : cloud) sphere.radius *= 4.0f;
  const float distance = scale * std::uniform_real_distribution<float>(0.1f, 20.0f)(random);
  Camera camera = orbitCamera(distance, static_cast<float>(random() % 360), 1 + random() % 30, 1 + random() % 20);
  camera.tanHalfFovY = std::min(0.8f, 1.5f * scale / distance);
  expectTheNearest(cloud, camera, 1 + static_cast<int>(random() % kMaxHits), seed);
  RC_ASSERT(!testing::Test::HasFailure());
}

TEST(Multihit, NoneOneAndTwoSpheresAndEveryNumberOfHits) {
  const std::vector<Sphere> cloud{{{0.0f, 0.0f, 0.0f}, 1.0f}, {{1.0f, 0.0f, 0.5f}, 1.0f}};
  for (size_t count = 0; count <= 2; ++count)
    for (int hits = 1; hits <= kMaxHits; ++hits) expectTheNearest(std::span(cloud).first(count), orbitCamera(6.0f, 15.0f, 37, 23), hits, 4);
}

TEST(Multihit, CoincidentSpheresAreOrderedById) {
  const std::vector<Sphere> cloud(100, Sphere{{0.0f, 0.0f, 0.0f}, 1.0f});
  for (const int hits : {1, 4, 16}) expectTheNearest(cloud, orbitCamera(5.0f, 30.0f, 21, 17), hits, 8);
}

TEST(Multihit, OneHitIsTheTracedPicture) {
  const auto cloud = makeFrameCloud(orbitCamera(350.0f, 0.0f, 128, 128), 2);
  const Camera camera = orbitCamera(300.0f, 25.0f, 150, 140);
  LbvhTracer tracer;
  tracer.build(cloud);
  Image<uint32_t> ids;
  tracer.trace(camera, ids, nullptr, {});
  const auto colors = someColors(cloud.size(), 6);
  const Picture seen = picture(cloud, colors, camera, 1);
  EXPECT_EQ(seen.ids, ids);
  for (size_t i = 0; i < ids.size(); ++i)
    ASSERT_EQ(seen.color[i], ids[i] == kNoSample ? glm::vec4(0.0f) : decodeRgba8(colors[ids[i]]));
}

TEST(Multihit, IsTheSameForAnyNumberOfThreads) {
  const auto cloud = makeCloud(CloudShape::duplicate, 50'000, 10.0f, 53);
  const auto colors = someColors(cloud.size(), 7);
  Picture expected;
  for (const size_t threads : {1, 2, 7}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const Picture seen = picture(cloud, colors, orbitCamera(30.0f, 33.0f, 128, 96), 5);
    if (threads == 1) expected = seen;
    EXPECT_EQ(seen.ids, expected.ids);
    EXPECT_EQ(seen.color, expected.color);
  }
}

TEST(Multihit, RefusesWhatItCannotDo) {
  const std::vector<Sphere> cloud(2, Sphere{glm::vec3(0.0f), 1.0f});
  const auto colors = someColors(2, 1);
  const Camera camera = orbitCamera(5.0f, 0.0f, 8, 8);
  for (const int hits : {0, -1, 17}) EXPECT_THROW(picture(cloud, colors, camera, hits), std::invalid_argument) << hits;
  EXPECT_THROW(picture(cloud, std::span(colors).first(1), camera, 4), std::invalid_argument);
  Lbvh lbvh;
  lbvh.build(cloud);
  std::stop_source source;
  source.request_stop();
  Picture result;
  EXPECT_THROW(traceNearestHits(lbvh.view(), colors, camera, 4, result.ids, result.color, source.get_token()), OperationCancelled);
}

}  // namespace
}  // namespace warpscope
