// Surfaces along rays against every piece of every sample, by brute force; how samples are grouped to surfaces, and how large they are; what is really behind.
// Mirrors render/warp/multihit/nearest_hits.h, surface_radii.h, surface_hits.h and multihit_trace.h.
#include "render/warp/multihit/multihit_trace.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <random>

#include "render/base/error.h"
#include "render/march/own_picture.h"
#include "tests/frame_samples.h"
#include "tests/layered_frames.h"

namespace warpscope {
namespace {

using Hit = std::pair<float, uint32_t>;

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


// --- Frames

/// A picture of 24x18 pixels from z = 100, its samples within 60 of the origin (a box that holds them all: what lies beside it would be moved off its ray); some pixels have several,
/// near to far, some none. Colours of every opacity.
SampleFrame someFrame(uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  SampleFrame frame;
  frame.camera.eye = {0.0f, 0.0f, 100.0f};
  frame.camera.width = 24;
  frame.camera.height = 18;
  frame.quantization = {{glm::vec3(-60.0f), glm::vec3(60.0f)}, 4.0f, 50.0f, 100.0f * 0x1p-18f};
  std::vector<uint8_t> layers;
  const bool isLayered = seed % 3 != 0;
  const float radius = std::exp2(4.0f * unit(random) - 1.0f);
  for (uint32_t row = 0; row < frame.camera.height; ++row)
    for (uint32_t column = 0; column < frame.camera.width; ++column) {
      const uint32_t count = isLayered ? random() % 4 : random() % 4 > 0;
      float behind = 15.0f + 10.0f * std::sin(0.3f * static_cast<float>(column)) + 4.0f * std::sin(0.9f * static_cast<float>(row)) + unit(random);
      for (uint32_t layer = 0; layer < count; ++layer) {
        frame.samples.push_back(packSample(column, row, behind, radius, frame.quantization));
        frame.colors.push_back(static_cast<Rgba8>(random()));
        layers.push_back(static_cast<uint8_t>(layer));
        behind += 0.01f + 15.0f * unit(random) * unit(random);
      }
    }
  if (isLayered) frame.planes.push_back(layerPlane(layers));
  return frame;
}

std::vector<Sphere> spheresOf(std::span<const PackedSample> samples, const SampleGrid& grid) {
  std::vector<Sphere> spheres;
  for (const PackedSample sample : samples) spheres.push_back(unpackSample(sample, grid));
  return spheres;
}

struct Picture {
  Image<uint32_t> ids;
  Image<glm::vec4> color;
};

Picture picture(const SampleFrame& frame, const Camera& camera, int most, std::stop_token stop = {}) {
  SurfaceTracer tracer;
  tracer.build(frame, spheresOf(frame.samples, frame.grid()));
  Picture result;
  tracer.trace(camera, most, result.ids, result.color, stop);
  return result;
}

/// What a frame has, a sample at a time.
struct Searched {
  const SampleFrame& frame;
  Image<uint32_t> firstOf = ownPicture(frame);
  SampleRays rays{frame.samples.data(), frame.layers().empty() ? nullptr : frame.layers().data(),
                  firstOf.data(),       static_cast<uint32_t>(frame.size()),
                  firstOf.width(),      firstOf.height(),
                  frame.grid()};
  std::vector<PackedSample> closed = [this] {
    std::vector<PackedSample> all;
    for (uint32_t i = 0; i < frame.size(); ++i) all.push_back(withSurfaceRadius(rays, i));
    return all;
  }();

  Sphere sphere(uint32_t id) const { return unpackSample(closed.at(id), rays.grid); }
  uint32_t pixel(uint32_t id) const { return pixelKey(closed.at(id)); }
  glm::vec4 color(uint32_t id) const { return decodeRgba8(frame.colors.at(id)); }
};

/// Every pixel against a search through all samples.
void expectTheSearched(const SampleFrame& frame, const Camera& camera, int most) {
  const Searched all{frame};
  const Picture seen = picture(frame, camera, most);
  for (uint32_t y = 0; y < camera.height; ++y)
    for (uint32_t x = 0; x < camera.width; ++x) {
      const Ray ray = pixelRay(camera, {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f});
      NearestHits<kMaxHits> pieces;
      NearestHits<1> wide;
      for (uint32_t id = 0; id < frame.size(); ++id) {
        const Sphere sphere = all.sphere(id);
        const PixelFrustum frustum = frustumOf(all.rays.grid.pixels, frame.samples[id], camera.eye - frame.camera.eye);
        pieces.insert(pieceDistance(frustum, ray.direction, sphere.center - ray.origin, intersectSphere(ray, sphere.center, sphere.radius)), id);
        const Sphere own = sphereOf(frame, id);
        wide.insert(intersectSphere(ray, own.center, own.radius), id);
      }
      SurfacesSeen expected = surfacesOf(all, ray, pieces, piecesFor(most), most);
      if (expected.nearest == kNoSample && wide.id(0) != kNoSample && !isSeenEmpty(all.rays, frame.camera, ray.at(wide.t(0))))
        expected = {wide.id(0), all.color(wide.id(0))};
      ASSERT_EQ(seen.ids(x, y), expected.nearest) << x << "," << y << ", " << most << " surfaces";
      ASSERT_EQ(seen.color(x, y), expected.color) << x << "," << y << ", " << most << " surfaces";
    }
}

Camera turned(const Camera& camera, float degrees, float distance = 100.0f) {
  Camera other = camera;
  const float angle = glm::radians(degrees);
  other.forward = {-std::sin(angle), 0.0f, -std::cos(angle)};
  other.right = {std::cos(angle), 0.0f, -std::sin(angle)};
  other.eye = -distance * other.forward;
  other.width = 37;
  other.height = 23;
  return other;
}

RC_GTEST_PROP(Multihit, ShowsWhatASearchThroughAllSamplesFinds, (uint32_t seed)) {
  const SampleFrame frame = someFrame(seed);
  std::mt19937 random(seed);
  const float degrees = static_cast<float>(random() % 360), distance = random() % 2 == 0 ? 100.0f : 5.0f;
  expectTheSearched(frame, turned(frame.camera, degrees, distance), 1 + static_cast<int>(random() % kMaxHits));
  RC_ASSERT(!testing::Test::HasFailure());
}

RC_GTEST_PROP(Multihit, IsTheFramesOwnPictureInItsView, (uint32_t seed)) {
  const SampleFrame frame = someFrame(seed);
  const Image<uint32_t> rays = ownPicture(frame);
  Image<glm::vec4> expected;
  resolveRayColors(frame, rays, expected);
  const Picture seen = picture(frame, frame.camera, 3);  // as many as rays have samples
  RC_ASSERT(seen.ids == rays);
  RC_ASSERT(seen.color == expected);
}

// --- Grouping

/// Samples of pixels in a row, seen along it: spheres that touch, then one apart.
struct Row {
  std::vector<Sphere> spheres;
  std::vector<uint32_t> pixels;

  Sphere sphere(uint32_t id) const { return spheres.at(id); }
  uint32_t pixel(uint32_t id) const { return pixels.at(id); }
  glm::vec4 color(uint32_t id) const { return 0.5f * glm::vec4(static_cast<float>(id), 0.0f, 0.0f, 1.0f); }
};

struct Ids {
  std::vector<uint32_t> ids;
  uint32_t id(int i) const { return static_cast<size_t>(i) < ids.size() ? ids[static_cast<size_t>(i)] : kNoSample; }
};

TEST(Multihit, SpheresThatTouchAreOneSurfaceInTheColourOfTheClosest) {
  const Ray ray{glm::vec3(0.0f), {0.0f, 0.0f, 1.0f}};
  const Row row{{{{0.3f, 0.0f, 9.0f}, 0.5f}, {{0.1f, 0.0f, 9.5f}, 0.5f}, {{0.2f, 0.0f, 10.0f}, 0.5f}, {{0.0f, 0.0f, 20.0f}, 0.5f}}, {0, 1, 2, 1}};
  const Ids ids{{0, 1, 2, 3}};
  const SurfacesSeen one = surfacesOf(row, ray, ids, 4, 1), two = surfacesOf(row, ray, ids, 4, 2);
  EXPECT_EQ(one.nearest, 1u);
  EXPECT_EQ(one.color, row.color(1));
  EXPECT_EQ(two.nearest, 1u);
  EXPECT_EQ(two.color, over(row.color(1), row.color(3)));
  EXPECT_EQ(surfacesOf(row, ray, ids, 4, 9).color, two.color);
  EXPECT_EQ(surfacesOf(row, ray, ids, 1, 9).nearest, 0u) << "no more than are gathered";
  EXPECT_EQ(surfacesOf(row, ray, Ids{}, 4, 9).nearest, kNoSample);
}

TEST(Multihit, SamplesOfOneRayAreSurfacesOfTheirOwn) {
  const Ray ray{glm::vec3(0.0f), {0.0f, 0.0f, 1.0f}};
  const Row row{{{{0.0f, 0.0f, 9.0f}, 0.5f}, {{0.0f, 0.0f, 9.5f}, 0.5f}, {{0.0f, 0.0f, 10.0f}, 0.5f}}, {7, 7, 7}};
  EXPECT_EQ(surfacesOf(row, ray, Ids{{0, 1, 2}}, 3, 3).color, over(over(row.color(0), row.color(1)), row.color(2)));
}

// --- Radii

/// A wall in front of the camera, one column of it far behind: its samples touch their neighbours, and none across the step.
TEST(SurfaceRadius, ReachesHalfWayToNeighboursOfTheSameSurface) {
  SampleFrame frame = someFrame(3);
  frame.samples.clear();
  for (uint32_t pixel = 0; pixel < 24 * 18; ++pixel)
    frame.samples.push_back(packSample(pixel % 24, pixel / 24, pixel % 24 == 12 ? 40.0f : 20.0f + 0.5f * static_cast<float>(pixel % 24), 6.0f, frame.quantization));
  frame.colors.assign(frame.samples.size(), 0xffffffffu);
  frame.planes.clear();
  const Searched all{frame};
  for (uint32_t pixel = 0; pixel < frame.size(); ++pixel) {
    const Sphere sphere = all.sphere(pixel);
    const float fills = 0.7071f * pixelEdge(frame.camera) * (100.0f - sphere.center.z);
    EXPECT_GE(sphere.radius, fills);
    EXPECT_LT(sphere.radius, std::max(1.05f * fills, 6.0f));
    if (pixel % 24 == 0 || pixel % 24 == 11 || pixel % 24 == 12 || pixel % 24 == 13) continue;
    EXPECT_GE(sphere.radius + all.sphere(pixel - 1).radius, glm::length(sphere.center - all.sphere(pixel - 1).center));
  }
}

// --- Several samples a ray

/// Two translucent walls: from the side, what is seen through the front wall is the back one, and no other part of the front one.
TEST(Multihit, WhatIsReallyBehindShowsThrough) {
  SampleFrame frame = someFrame(1);
  frame.samples.clear();
  frame.colors.clear();
  frame.planes.clear();
  std::vector<uint8_t> layers;
  constexpr Rgba8 kRed = 0x80000080u, kGreen = 0xff00ff00u;
  for (uint32_t pixel = 0; pixel < 24 * 18; ++pixel)
    for (const uint8_t layer : {uint8_t{0}, uint8_t{1}}) {
      frame.samples.push_back(packSample(pixel % 24, pixel / 24, layer == 0 ? 40.0f : 60.0f, 6.0f, frame.quantization));
      frame.colors.push_back(layer == 0 ? kRed : kGreen);
      layers.push_back(layer);
    }
  frame.planes.push_back(layerPlane(layers));
  const Camera camera = turned(frame.camera, 12.0f);
  const glm::vec4 both = over(decodeRgba8(kRed), decodeRgba8(kGreen));
  const Picture one = picture(frame, camera, 1), four = picture(frame, camera, 4);
  for (uint32_t y = 6; y < 17; ++y)
    for (uint32_t x = 12; x < 25; ++x) {
      ASSERT_EQ(one.color(x, y), decodeRgba8(kRed)) << x << "," << y;
      ASSERT_EQ(four.color(x, y), both) << x << "," << y;
    }
}

// --- The rest

TEST(Multihit, NoneOneAndTwoSamplesAndEveryNumberOfSurfaces) {
  const SampleFrame whole = someFrame(3);
  for (size_t count = 0; count <= 2; ++count)
    for (int most = 1; most <= kMaxHits; ++most) {
      SampleFrame frame = whole;
      frame.samples.resize(count);
      frame.colors.resize(count);
      expectTheSearched(frame, turned(frame.camera, 20.0f), most);
    }
}

TEST(Multihit, IsTheSameForAnyNumberOfThreads) {
  const SampleFrame frame = someFrame(4);
  Camera camera = turned(frame.camera, 33.0f);
  camera.width = camera.height = 200;  // several tiles
  Picture expected;
  for (const size_t threads : {1, 2, 7}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const Picture seen = picture(frame, camera, 5);
    if (threads == 1) expected = seen;
    EXPECT_EQ(seen.ids, expected.ids);
    EXPECT_EQ(seen.color, expected.color);
  }
}

TEST(Multihit, RefusesWhatItCannotDo) {
  const SampleFrame frame = someFrame(1);
  for (const int most : {0, -1, 17}) EXPECT_THROW(picture(frame, frame.camera, most), std::invalid_argument) << most;
  std::stop_source source;
  source.request_stop();
  EXPECT_THROW(picture(frame, frame.camera, 4, source.get_token()), OperationCancelled);
}

}  // namespace
}  // namespace warpscope
