// Footprints of spheres against every pixel's ray, and against exact tangents: nothing that is hit lies outside, little else inside.
// Grazing, enclosing, far and tiny spheres, and those behind the eye. Mirrors render/warp/splats/sphere_footprint.h.
#include "render/warp/splats/sphere_footprint.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <limits>

#include "render/core/simd.h"
#include "tests/dice.h"
#include "tests/frame_samples.h"

namespace warpscope {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();

std::string textOf(const PixelRect& rect) {
  return "[" + std::to_string(rect.x0) + ", " + std::to_string(rect.x1) + ") x [" + std::to_string(rect.y0) + ", " +
         std::to_string(rect.y1) + ")";
}

bool contains(const PixelRect& rect, int x, int y) { return x >= rect.x0 && x < rect.x1 && y >= rect.y0 && y < rect.y1; }

/// Counts the pixels that are hit; fails if one of them lies outside the footprint, or the footprint beyond the image.
size_t expectHitsInside(const Camera& camera, const Sphere& sphere) {
  const PixelRect rect = sphereFootprint(camera, sphere);
  EXPECT_TRUE(rect.x0 >= 0 && rect.y0 >= 0 && rect.x1 <= static_cast<int>(camera.width) && rect.y1 <= static_cast<int>(camera.height))
      << textOf(rect);
  size_t hits = 0, outside = 0;
  std::string first;
  for (int y = 0; y < static_cast<int>(camera.height); ++y)
    for (int x = 0; x < static_cast<int>(camera.width); ++x) {
      const Ray ray = pixelRay(camera, {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f});
      // A hit may be infinitely far only by overflow; what no distance tells from a miss is none.
      if (intersectSphere(ray, sphere.center, sphere.radius) == kNoHit) continue;
      ++hits;
      if (contains(rect, x, y)) continue;
      if (outside++ == 0) first = "(" + std::to_string(x) + ", " + std::to_string(y) + ")";
    }
  EXPECT_EQ(outside, 0u) << "of " << hits << " pixels lie outside " << textOf(rect) << ", the first is " << first;
  return hits;
}

/// Any orientation, handedness, size up to 40 and field of view; the basis orthonormal, or just good enough for isUsable.
Camera anyCamera(Dice& dice) {
  Camera camera;
  camera.forward = dice.direction();
  camera.right = glm::normalize(glm::cross(camera.forward, dice.direction()));
  camera.up = glm::cross(camera.right, camera.forward);
  if (dice.below(2) == 0) camera.right = -camera.right;
  if (dice.below(4) == 0) {
    camera.right = glm::normalize(camera.right + 4e-4f * dice.direction());
    camera.up = 1.0004f * glm::normalize(camera.up + 4e-4f * dice.direction());
  }
  camera.eye = dice.below(3) == 0 ? glm::vec3(0.0f) : dice.magnitude(-3, 7) * dice.direction();
  camera.width = 1 + dice.below(40);
  camera.height = 1 + dice.below(40);
  camera.tanHalfFovY = dice.below(3) == 0 ? dice.magnitude(-6, 3.9f) : dice.uniform(0.1f, 1.5f);
  return camera;
}

/// A sphere that a pixel's ray passes at about its radius, or one anywhere, of any size.
Sphere anySphere(Dice& dice, const Camera& camera) {
  const float distance = dice.magnitude(-4, 7);
  const float radius = distance * (dice.below(2) == 0 ? dice.magnitude(-7, 0.5f) : dice.uniform(0.9f, 1.0001f));
  if (dice.below(4) == 0) return {camera.eye + distance * dice.direction(), radius};
  const Ray ray = pixelRay(camera, {static_cast<float>(dice.below(camera.width)) + 0.5f, static_cast<float>(dice.below(camera.height)) + 0.5f});
  const glm::vec3 side = glm::normalize(glm::cross(ray.direction, dice.direction()));
  const float grazing = 1.0f + std::ldexp(dice.uniform(-1, 1), -static_cast<int>(dice.below(24)));
  return {camera.eye + distance * ray.direction + grazing * radius * side, radius};
}

RC_GTEST_PROP(SphereFootprint, HoldsEveryPixelThatIsHit, (uint32_t seed)) {
  Dice dice(seed);
  const Camera camera = anyCamera(dice);
  for (int i = 0; i < 40; ++i) {
    const Sphere sphere = anySphere(dice, camera);
    expectHitsInside(camera, sphere);
    if (testing::Test::HasFailure()) {
      const glm::vec3 toCenter = sphere.center - camera.eye;
      RC_FAIL("sphere " + std::to_string(i) + " at " + std::to_string(glm::length(toCenter)) + ", radius " + std::to_string(sphere.radius) +
              ", in front of the eye's plane by " + std::to_string(glm::dot(toCenter, camera.forward)));
    }
  }
}

/// The rectangle that exact tangents give, in long double, for a sphere in front of the eye's plane; lines whose centres lie between.
struct ExactSpan {
  long double low, high;  // image positions
};

ExactSpan exactSpan(const glm::dvec3& toCenter, const glm::dvec3& across, const glm::dvec3& along, const glm::dvec3& forward, double radius,
                    double edge, double pixels) {
  // |c . n| = r |n| with n = (forward + x across) x along, a quadratic in x.
  const glm::dvec3 p = glm::cross(forward, along), q = glm::cross(across, along);
  const long double a = glm::dot(toCenter, p), b = glm::dot(toCenter, q), r2 = static_cast<long double>(radius) * radius;
  const long double c2 = b * b - r2 * glm::dot(q, q), c1 = a * b - r2 * glm::dot(p, q), c0 = a * a - r2 * glm::dot(p, p);
  const long double root = std::sqrt(std::max(0.0L, c1 * c1 - c2 * c0));
  const long double x0 = (-c1 - root) / c2, x1 = (-c1 + root) / c2;
  return {0.5L * pixels + std::min(x0, x1) / edge, 0.5L * pixels + std::max(x0, x1) / edge};
}

RC_GTEST_PROP(SphereFootprint, IsNoLargerThanTheTangentsSay, (uint32_t seed)) {
  Dice dice(seed);
  Camera camera = anyCamera(dice);
  // In float, coordinates far from their origin hide where a sphere is.
  camera.eye = glm::vec3(0.0f);
  camera.tanHalfFovY = dice.uniform(0.1f, 1.5f);
  camera.width = 1 + dice.below(2000);
  camera.height = 1 + dice.below(2000);
  for (int i = 0; i < 100; ++i) {
    const float depth = dice.magnitude(-2, 5);
    const float radius = depth * dice.magnitude(-6, -0.1f);
    const Ray ray = pixelRay(camera, {dice.uniform(0.0f, static_cast<float>(camera.width)), dice.uniform(0.0f, static_cast<float>(camera.height))});
    const Sphere sphere{depth / glm::dot(ray.direction, camera.forward) * ray.direction, radius};
    if (glm::dot(sphere.center, camera.forward) < 1.01f * radius) continue;
    const glm::dvec3 right(camera.right), down(-camera.up), forward(camera.forward);
    const double edge = pixelEdge(camera);
    const ExactSpan spans[2] = {exactSpan(glm::dvec3(sphere.center), right, down, forward, radius, edge, camera.width),
                                exactSpan(glm::dvec3(sphere.center), down, right, forward, radius, edge, camera.height)};
    const PixelRect rect = sphereFootprint(camera, sphere);
    const int begins[2] = {rect.x0, rect.y0}, ends[2] = {rect.x1, rect.y1};
    const int sizes[2] = {static_cast<int>(camera.width), static_cast<int>(camera.height)};
    for (int axis = 0; axis < 2; ++axis) {
      // A tangent's slope grows with the margin times its steepness, squared, over the tangent's length.
      const ExactSpan& span = spans[axis];
      const auto slack = [&](long double position) {
        const long double slope = (position - 0.5L * sizes[axis]) * edge;
        const long double distance = glm::length(glm::dvec3(sphere.center));
        const long double tangent = std::sqrt(std::max(1e-12L, 1.0L - static_cast<long double>(radius) * radius / (distance * distance)));
        return 0.05L + 8.0L * kFootprintMargin * (1.0L + slope * slope) / (edge * tangent);
      };
      const int low = static_cast<int>(std::clamp(std::ceil(span.low - slack(span.low) - 0.5L), 0.0L, static_cast<long double>(sizes[axis])));
      const int high =
          static_cast<int>(std::clamp(std::floor(span.high + slack(span.high) + 0.5L), 0.0L, static_cast<long double>(sizes[axis])));
      if (rect.isEmpty()) continue;
      RC_ASSERT(begins[axis] >= low);
      RC_ASSERT(ends[axis] <= high);
    }
  }
}

TEST(SphereFootprint, OfASphereStraightAhead) {
  // 64 pixels for a slope of -1 to 1; the tangents' slope is 1.4 / sqrt(25 - 1.96) = 7 / 24: pixel centres from 22.67 to 41.33.
  Camera camera = frontCamera(64, 64, 0.0f);
  camera.tanHalfFovY = 1.0f;
  EXPECT_EQ(sphereFootprint(camera, {{0.0f, 0.0f, -5.0f}, 1.4f}), (PixelRect{23, 23, 41, 41}));
  // Around the eye: seen as one of half the distance, with a slope of 1 / sqrt(3).
  EXPECT_EQ(sphereFootprint(camera, {{0.0f, 0.0f, -5.0f}, 6.0f}), (PixelRect{14, 14, 50, 50}));
  // To the right and up: columns only move to the right, rows to the top.
  const PixelRect moved = sphereFootprint(camera, {{2.0f, 1.0f, -5.0f}, 1.0f});
  EXPECT_GT(moved.x0, 32);
  EXPECT_LT(moved.y1, 33);
  camera.right = -camera.right;
  const PixelRect mirrored = sphereFootprint(camera, {{2.0f, 1.0f, -5.0f}, 1.0f});
  EXPECT_EQ(mirrored, (PixelRect{64 - moved.x1, moved.y0, 64 - moved.x0, moved.y1}));
}

TEST(SphereFootprint, WhatNothingHitsIsEmpty) {
  const Camera camera = frontCamera(33, 21, 0.0f);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const Sphere& sphere : {
           Sphere{{0.0f, 0.0f, 5.0f}, 1.0f},       // behind
           Sphere{{100.0f, 0.0f, 1.0f}, 0.5f},     // behind and beside
           Sphere{{0.0f, 0.0f, 0.0f}, 1.0f},       // at the eye
           Sphere{{50.0f, 0.0f, -5.0f}, 1.0f},     // to the right of the image
           Sphere{{0.0f, 0.0f, -5.0f}, 0.0f}, Sphere{{0.0f, 0.0f, -5.0f}, -1.0f}, Sphere{{0.0f, 0.0f, -5.0f}, nan},
           Sphere{{nan, 0.0f, -5.0f}, 1.0f},
           Sphere{{0.0f, kInf, -5.0f}, 1.0f}, Sphere{{0.0f, 0.0f, -kInf}, 1.0f}}) {
    EXPECT_TRUE(sphereFootprint(camera, sphere).isEmpty())
        << textOf(sphereFootprint(camera, sphere)) << " at " << sphere.center.x << " " << sphere.center.z << " radius " << sphere.radius;
    EXPECT_EQ(expectHitsInside(camera, sphere), 0u);
  }
}

TEST(SphereFootprint, AcrossTheEyesPlane) {
  const Camera camera = frontCamera(40, 30, 0.0f);
  for (const float side : {-1.0f, 1.0f})
    for (const float depth : {-0.9f, -0.5f, -0.1f, 0.0f, 0.1f, 0.5f, 0.9f, 0.999f}) {
      SCOPED_TRACE(std::to_string(side) + ", " + std::to_string(depth));
      // Beside the eye, a little larger than its distance from the axis allows to pass unseen.
      expectHitsInside(camera, {{side * 1.2f, 0.0f, depth}, 1.0f});
      expectHitsInside(camera, {{0.0f, side * 1.2f, depth}, 1.0f});
      expectHitsInside(camera, {{side * 0.8f, 0.8f, depth}, 1.0f});
    }
  // Around the eye, seen from 40 to 100 degrees aside.
  Camera wide = camera;
  wide.tanHalfFovY = 4.0f;
  for (const float side : {-1.0f, 1.0f}) EXPECT_GT(expectHitsInside(wide, {{side * 2.75f, 0.0f, -1.0f}, 10.0f}), 0u);
}

TEST(SphereFootprint, AtTheEdgesOfFloat) {
  for (const float scale : {1e-38f, 1e-30f, 1e-22f, 1e-19f, 1e-12f, 1e12f, 1e18f, 1e25f, 1e30f, 1e37f})
    for (const float radius : {1e-30f, 1e-9f, 1e-3f, 0.5f, 0.999f})
      for (const float tanHalfFov : {1e-45f, 1e-38f, 1e-20f, 1e-7f, 0.4f, 9.9e3f}) {
        SCOPED_TRACE(std::to_string(std::log10(scale)) + ", " + std::to_string(radius) + ", " + std::to_string(tanHalfFov));
        Camera camera = frontCamera(7, 5, 0.0f);
        camera.tanHalfFovY = tanHalfFov;
        expectHitsInside(camera, {scale * glm::vec3(0.0f, 0.0f, -1.0f), scale * radius});
        expectHitsInside(camera, {scale * glm::vec3(1e-7f, -1e-9f, -1.0f), scale * radius});
        expectHitsInside(camera, {scale * glm::vec3(0.3f, 0.2f, -1.0f), scale * radius});
      }
  // From an eye, and at a sphere, far from the coordinates' origin.
  Camera camera = frontCamera(64, 48, 0.0f);
  camera.eye = {1e7f, -1e7f, 1e7f};
  EXPECT_GT(expectHitsInside(camera, {{1e7f + 2.0f, -1e7f, 1e7f - 16.0f}, 4.0f}), 0u);
  expectHitsInside(camera, {{0.0f, 0.0f, 0.0f}, 9.99e6f});
}

TEST(SphereFootprint, OfTheLargestImages) {
  Camera camera = frontCamera(16384, 16384, 0.0f);
  const Sphere small{{1.0f, 2.0f, -10.0f}, 0.01f};
  const PixelRect rect = sphereFootprint(camera, small);
  ASSERT_FALSE(rect.isEmpty());
  size_t hits = 0;
  for (int y = rect.y0 - 20; y < rect.y1 + 20; ++y)
    for (int x = rect.x0 - 20; x < rect.x1 + 20; ++x) {
      if (intersectSphere(pixelRay(camera, {x + 0.5f, y + 0.5f}), small.center, small.radius) == kNoHit) continue;
      ++hits;
      ASSERT_TRUE(contains(rect, x, y)) << x << " " << y;
    }
  EXPECT_GT(hits, 1000u);
  EXPECT_EQ(sphereFootprint(camera, {{0.0f, 0.0f, -10.0f}, 9.999f}), (PixelRect{0, 0, 16384, 16384}));
}

RC_GTEST_PROP(SphereFootprint, BatchesHoldTheSameBits, (uint32_t seed)) {
  Dice dice(seed);
  const Camera camera = anyCamera(dice);
  const FootprintView view = footprintViewOf(camera);
  for (int i = 0; i < 50; ++i) {
    const Sphere sphere = anySphere(dice, camera);
    const glm::vec3 c = sphere.center - camera.eye;
    const auto bounds = footprint::boundsOf(view, FloatBatch(c.x), FloatBatch(c.y), FloatBatch(c.z), FloatBatch(sphere.radius));
    const size_t lane = static_cast<size_t>(i) % kBatchLanes;
    const PixelRect rect{bounds.x0.get(lane), bounds.y0.get(lane), bounds.x1.get(lane), bounds.y1.get(lane)};
    RC_ASSERT(rect == sphereFootprint(view, sphere));
  }
}

}  // namespace
}  // namespace warpscope
