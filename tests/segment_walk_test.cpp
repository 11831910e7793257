// Rays through segments of another camera's pixels: random frames against brute force in double, every pixel's frustum against every ray; and eyes and rays
// that are hard to tell apart.
// Mirrors render/warp/segments/: field_line.h, segment_walk.h, nearest_walk.h, segment_field.h, segment_field_build.h, segment_look.h.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <tuple>
#include <utility>
#include <vector>

#include "marcher_cases.h"
#include "render/warp/segments/segment_field_build.h"
#include "render/warp/segments/segment_look.h"
#include "render/warp/segments/segment_walk.h"
#include "segment_frames.h"

namespace warpscope {
namespace {

struct Found {
  WalkedRay walked;
  double unknown = 0.0;
  int pieces = 0;
};

Found walk(const SampleFrame& frame, const Ray& ray, float tNear, float tFar, bool isLinear) {
  BuiltSegmentField built;
  built.build(frame);
  Found found;
  float last = tNear;
  const auto note = [&](WalkedRay&, float from, float to, FillReason) {
    EXPECT_GE(from, last - 1e-4f);  // front to back
    EXPECT_LE(from, to);
    last = to;
    found.unknown += static_cast<double>(to) - static_cast<double>(from);
    ++found.pieces;
  };
  found.walked = isLinear ? walkSegments<Between::linear>(built.field(), ray, tNear, tFar, 0.0f, note) : walkSegments<Between::nearest>(built.field(), ray, tNear, tFar, 0.0f, note);
  return found;
}

/// As if none of its rays had ended.
SampleFrame withoutEnds(SampleFrame frame) {
  for (RaySegmentCount& ray : frame.segments.rays) ray = {ray.count(), false};
  return frame;
}

/// Every pixel's ray of `camera`, as techniques make them.
/// Blended ones are met with the mean weights of each piece: they are as far off as pixels are large, half of them by less than 0.006. Of rays that did not end, since whether a pixel that has ended counts is decided for a piece as well.
void expectLikeBruteForce(const SampleFrame& frame, const Camera& camera, const char* what, double ofNearest = 0.012, double ofLinear = 0.045, double ofLinearThrough = 0.04) {
  const PixelGrid pixels = makePixelGrid(camera, depthRangeOf(camera, kFrameBounds).nearDepth);
  const SampleFrame open = withoutEnds(frame);
  std::vector<double> offLinear;
  for (uint32_t y = 0; y < camera.height; ++y)
    for (uint32_t x = 0; x < camera.width; ++x) {
      const Ray ray = pixels.ray(x, y).ray;
      const RayInterval inside = intersectBox(reciprocalOf(ray.origin, ray.direction), kFrameBounds, 0.0f, INFINITY);
      if (inside.isMiss()) continue;
      for (const bool isLinear : {false, true}) {
        const SampleFrame& walked = isLinear ? open : frame;
        const Found found = walk(walked, ray, inside.tNear, inside.tFar, isLinear);
        const MetByRay expected = bruteForce(walked, ray, static_cast<double>(inside.tNear), static_cast<double>(inside.tFar), isLinear, 4000);
        const double tolerance = isLinear ? ofLinear : ofNearest;
        const double length = static_cast<double>(inside.tFar) - static_cast<double>(inside.tNear);
        ASSERT_NEAR(static_cast<double>(found.walked.through), expected.through, isLinear ? ofLinearThrough : ofNearest) << what << " at " << x << ", " << y << (isLinear ? " linear" : "");
        for (int channel = 0; channel < 3; ++channel) ASSERT_NEAR(static_cast<double>(found.walked.color[channel]), expected.color[channel], tolerance) << what;
        ASSERT_NEAR(found.unknown, expected.unknown, 0.004 * length + 1e-3) << what << " at " << x << ", " << y << (isLinear ? " linear" : "");
        if (isLinear) offLinear.push_back(std::abs(static_cast<double>(found.walked.through) - expected.through));
      }
    }
  if (offLinear.size() < 10) return;
  std::ranges::nth_element(offLinear, offLinear.begin() + static_cast<std::ptrdiff_t>(offLinear.size() / 2));
  EXPECT_LT(offLinear[offLinear.size() / 2], 0.006) << what;
}

TEST(SegmentWalk, RandomFramesAreMetAsByBruteForce) {
  int round = 0;
  for (const glm::vec3& eye : {glm::vec3(4.0f, 4.0f, 30.0f), glm::vec3(20.0f, 5.0f, 22.0f), glm::vec3(30.0f, 2.0f, 1.0f), glm::vec3(-9.0f, -25.0f, -14.0f),
                               glm::vec3(2.0f, 1.0f, -28.0f)})
    for (const uint32_t side : {13u, 130u}) {
      Camera server = kServer;
      server.width = side;
      server.height = side * 9 / 13;
      expectLikeBruteForce(randomFrame(server, static_cast<uint32_t>(++round)), lookingFrom(eye, glm::vec3(0.0f), 7, 5, 0.45f), "an eye outside");
    }
}

TEST(SegmentWalk, FromInsideTheOldFrustumAndBesideItAndBehindTheOldEye) {
  for (const glm::vec3& eye : {glm::vec3(1.0f, 2.0f, 6.0f), glm::vec3(9.0f, -8.0f, 3.0f), glm::vec3(5.0f, 6.0f, 50.0f), glm::vec3(0.0f, 0.0f, -8.0f)})
    expectLikeBruteForce(randomFrame(kServer, 5), lookingFrom(eye, {0.3f, 0.1f, 0.0f}, 6, 6, 0.9f), "an eye inside");
}

TEST(SegmentWalk, FromTheOldEyeARayBetweenPixelsShowsTheMeanOfWhatTheyShow) {
  const SampleFrame open = withoutEnds(randomFrame(kServer, 31));
  const FrameContent content(open);
  const PixelGrid pixels = makePixelGrid(kServer, open.quantization.nearDepth);
  // As bright as a pixel is along the ray, whose length in it is that along its own times the quotient of cosines.
  const auto shownBy = [&](int x, int y, double cosine) {
    MetByRay shown;
    content.forEachOf(x, y, [&](double begin, double end, double extinction, const glm::dvec3& color) {
      const double opacity = -std::expm1(-extinction * (end - begin) / cosine);
      shown.color += shown.through * opacity * color;
      shown.through *= 1.0 - opacity;
    });
    return shown;
  };
  for (int y = 0; y + 1 < static_cast<int>(kServer.height); ++y)
    for (int x = 0; x + 1 < static_cast<int>(kServer.width); ++x) {
      const double a = ((x * 7 + y * 3) % 10 + 0.5) / 10, b = ((x * 3 + y * 7) % 11 + 0.5) / 11;  // not on the border of a cell, where rounding decides which it is in
      const auto at = [&](uint32_t column, uint32_t row, float behind) { return glm::dvec3(pixels.at(static_cast<uint32_t>(x) + column, static_cast<uint32_t>(y) + row, behind)); };
      const auto between = [&](float behind) { return glm::mix(glm::mix(at(0, 0, behind), at(1, 0, behind), a), glm::mix(at(0, 1, behind), at(1, 1, behind), a), b); };
      const glm::dvec3 from = between(0.0f), direction = glm::normalize(between(30.0f) - from);
      const double cosine = glm::dot(direction, glm::dvec3(kServer.forward));
      MetByRay expected;
      expected.through = 0.0;
      for (int i = 0; i < 4; ++i) {
        const double weight = (i % 2 == 1 ? a : 1 - a) * (i >= 2 ? b : 1 - b);
        const MetByRay shown = shownBy(x + i % 2, y + i / 2, cosine);
        expected.color += weight * shown.color;
        expected.through += weight * shown.through;
      }
      const Found found = walk(open, {glm::vec3(from), glm::vec3(direction)}, 0.0f, 60.0f, true);
      EXPECT_NEAR(static_cast<double>(found.walked.through), expected.through, 2e-5) << x << ", " << y;
      for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(static_cast<double>(found.walked.color[channel]), expected.color[channel], 2e-5) << x << ", " << y;
    }
}

TEST(SegmentWalk, AServerInsideTheVolumeAndWithAWiderView) {
  const Camera inside = lookingFrom({2.0f, 1.0f, 3.0f}, {-4.0f, 0.0f, -9.0f}, 21, 17, 1.2f);
  for (const glm::vec3& eye : {glm::vec3(2.1f, 1.0f, 3.0f), glm::vec3(25.0f, 3.0f, 9.0f), glm::vec3(-6.0f, 1.0f, -5.0f)})
    expectLikeBruteForce(randomFrame(inside, 9), lookingFrom(eye, glm::vec3(0.0f), 6, 5, 0.6f), "a server inside", 0.02, 0.06, 0.06);
}

TEST(SegmentWalk, AFrameOfOnePixel) {
  Camera one = kServer;
  one.width = one.height = 1;
  for (uint32_t seed = 0; seed < 6; ++seed)
    expectLikeBruteForce(randomFrame(one, seed, 16), lookingFrom({12.0f, 3.0f, 26.0f}, glm::vec3(0.0f), 5, 5, 0.45f), "one pixel");
}

/// A walk that is interrupted where nothing is known, and goes on from there: the same bits.
TEST(SegmentWalk, InTwoPartsItIsTheSame) {
  int inTwo = 0, doubted = 0;  // the latter: of walks whose first interruption was by a doubt
  for (uint32_t seed = 30; seed < 34; ++seed) {
    BuiltSegmentField built;
    built.build(randomFrame(kServer, seed));
    const SegmentField field = built.field();
    for (const glm::vec3& eye : {glm::vec3(3.0f, 4.0f, 30.0f), glm::vec3(20.0f, 5.0f, 22.0f), glm::vec3(2.0f, 1.0f, -28.0f), glm::vec3(1.0f, 2.0f, 6.0f)}) {
      const Camera camera = lookingFrom(eye, glm::vec3(0.0f), 16, 16, 0.45f);
      const PixelGrid pixels = makePixelGrid(camera, depthRangeOf(camera, kFrameBounds).nearDepth);
      for (uint32_t y = 0; y < camera.height; ++y)
        for (uint32_t x = 0; x < camera.width; ++x) {
          const Ray ray = pixels.ray(x, y).ray;
          const RayInterval inside = intersectBox(reciprocalOf(ray.origin, ray.direction), kFrameBounds, 0.0f, INFINITY);
          if (inside.isMiss()) continue;
          std::vector<std::tuple<float, float, FillReason>> fills;
          const auto fill = [&](WalkedRay& walked, float from, float to, FillReason reason) {
            fills.emplace_back(from, to, reason);
            walked.fill({glm::dvec3(0.02f * (to - from), 0.1f, from), reason == FillReason::unknown ? 0.8 : 0.5}, reason);
          };
          const auto expectSame = [&]<Between kBetween>(std::integral_constant<Between, kBetween>) {
            constexpr float kStopBelow = 0.01f;
            const WalkedRay expected = walkSegments<kBetween>(field, ray, inside.tNear, inside.tFar, kStopBelow, fill);
            const auto ofOne = std::exchange(fills, {});
            InterruptedWalk walk;
            const bool isAll = walkKnown<kBetween>(field, ray, inside.tNear, inside.tFar, kStopBelow, walk);
            const WalkedRay walked = isAll ? walk.walked : walkRest<kBetween>(field, ray, inside.tNear, inside.tFar, kStopBelow, walk, fill);
            inTwo += !isAll && walk.place.x >= 0;
            doubted += !isAll && walk.place.x >= 0 && !fills.empty() && std::get<FillReason>(fills.front()) == FillReason::doubted;
            ASSERT_EQ(fills, ofOne);
            fills.clear();
            ASSERT_EQ(walked.seen(), expected.seen()) << x << ", " << y;
            ASSERT_EQ(walked.guessed, expected.guessed);
          };
          for (const Between between : {Between::nearest, Between::linear, Between::refined}) visitBetween(between, expectSame);
        }
    }
  }
  EXPECT_GT(inTwo, 500);
  EXPECT_GT(doubted, 100);
}

TEST(SegmentWalk, WhatFillsNothingChangesNothing) {
  const Camera camera = lookingFrom({9.0f, -8.0f, 20.0f}, {0.3f, 0.1f, 0.0f}, 24, 20, 0.6f);
  const SampleFrame frame = randomFrame(kServer, 41);
  BuiltSegmentField built;
  built.build(frame);
  const PixelGrid pixels = makePixelGrid(camera, depthRangeOf(camera, kFrameBounds).nearDepth);
  int filled = 0;
  for (uint32_t y = 0; y < camera.height; ++y)
    for (uint32_t x = 0; x < camera.width; ++x) {
      const Ray ray = pixels.ray(x, y).ray;
      const RayInterval inside = intersectBox(reciprocalOf(ray.origin, ray.direction), kFrameBounds, 0.0f, INFINITY);
      if (inside.isMiss()) continue;
      const WalkedRay alone = walkSegments<Between::linear>(built.field(), ray, inside.tNear, inside.tFar, 0.0f);
      const WalkedRay other = walkSegments<Between::linear>(built.field(), ray, inside.tNear, inside.tFar, 0.0f, [&](WalkedRay&, float, float, FillReason) { ++filled; });
      EXPECT_EQ(other.through, alone.through) << x << ", " << y;
      EXPECT_EQ(other.color, alone.color) << x << ", " << y;
    }
  EXPECT_GT(filled, 100);
}

/// What the frame's own camera sees, whatever lies beside: its segments over one another.
TEST(SegmentWalk, TheServersOwnViewIsTheFrames) {
  for (const float farAway : {30.0f, 3e3f, 3e5f}) {
    Camera server = lookingFrom(farAway * glm::normalize(glm::vec3(3.0f, 4.0f, 30.0f)), {0.5f, 0.2f, 0.0f}, 40, 30, 14.0f / farAway);
    const SampleFrame frame = randomFrame(server, 3);
    const PixelGrid pixels = makePixelGrid(server, depthRangeOf(server, kFrameBounds).nearDepth);
    size_t at = 0;
    for (uint32_t y = 0; y < server.height; ++y)
      for (uint32_t x = 0; x < server.width; ++x) {
        const int count = frame.segments.rays[size_t{y} * server.width + x].count();
        glm::dvec3 color(0.0);
        double through = 1.0;
        for (int i = 0; i < count; ++i) {
          const glm::dvec4 segment(segmentColor(ColorTables::instance(), frame.segments.colors[at + static_cast<size_t>(i)]));
          color += through * glm::dvec3(segment);
          through *= 1.0 - segment.a;
        }
        at += static_cast<size_t>(count);
        const Ray ray = pixels.ray(x, y).ray;
        // All that has depth codes, which may be more than the bounds: what is seen does not end with them here.
        for (const bool isLinear : {false, true}) {
          const Found found = walk(frame, ray, 0.0f, 60.0f, isLinear);
          EXPECT_NEAR(static_cast<double>(found.walked.through), through, 0.006) << x << ", " << y << ", from " << farAway << (isLinear ? " linear" : "");
          for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(static_cast<double>(found.walked.color[channel]), color[channel], 0.006);
        }
      }
  }
}

/// In figures: in the frame's own view how many segments its rays have, and where they are.
TEST(SegmentWalk, LooksCountSegmentsAndTellWhereTheyAre) {
  const Camera server = lookingFrom({3.0f, 4.0f, 30.0f}, {0.5f, 0.2f, 0.0f}, 40, 30, 0.45f);
  const SampleFrame frame = randomFrame(server, 3);
  const SegmentLook look = lookAtSegments(frame, server);
  ASSERT_EQ(look.count.width(), 40u);
  size_t at = 0, compared = 0;
  for (size_t i = 0; i < frame.segments.rays.size(); ++i) {
    const int count = frame.segments.rays[i].count();
    int seen = 0;
    double through = 1.0, weights = 0.0, depths = 0.0;
    const Ray ray = makePixelGrid(server, depthRangeOf(server, kFrameBounds).nearDepth).ray(static_cast<uint32_t>(i % 40), static_cast<uint32_t>(i / 40)).ray;
    const RayInterval inside = intersectBox(reciprocalOf(ray.origin, ray.direction), kFrameBounds, 0.0f, INFINITY);
    bool isInside = !inside.isMiss();  // of segments that reach out of the bounds a part counts
    for (int k = 0; k < count; ++k, ++at) {
      const double opacity = segmentColor(ColorTables::instance(), frame.segments.colors[at]).a;
      const SegmentDepths ends = frame.segments.depths[at];
      const double perForward = 1.0 / static_cast<double>(glm::dot(ray.direction, server.forward));
      const auto place = [&](uint32_t code) { return static_cast<double>(decodeDepth(code, frame.quantization.depthStep)) * perForward; };
      isInside &= place(ends.begin) >= static_cast<double>(inside.tNear) && place(ends.end) <= static_cast<double>(inside.tFar);
      if (opacity == 0.0 || through < 0.02) continue;
      ++seen;
      weights += through * opacity;
      depths += through * opacity * (0.5 * (place(ends.begin) + place(ends.end)) + static_cast<double>(glm::length(ray.origin - server.eye)));
      through *= 1.0 - opacity;
    }
    if (!isInside || through < 0.02) continue;
    ++compared;
    EXPECT_EQ(look.count[i], static_cast<float>(seen)) << i;
    EXPECT_EQ(std::isnan(look.depth[i]), seen == 0) << i;
    if (seen > 0) EXPECT_NEAR(static_cast<double>(look.depth[i]), depths / weights, 0.02) << i;
  }
  EXPECT_GT(compared, 300u);
}

/// Through corners and along edges of pixels, whichever pixel those are counted to: nothing is lost and nothing counts twice.
TEST(SegmentWalk, AlongEdgesAndThroughCorners) {
  SampleFrame frame;
  frame.camera = lookingFrom({0.0f, 0.0f, 30.0f}, glm::vec3(0.0f), 8, 8, 0.4f);
  frame.quantization = quantizationFor(frame.camera, kFrameBounds, 1.0f);
  frame.settings.sample.segments = 1;
  const DepthRange range = depthRangeOf(frame.camera, kFrameBounds);
  const auto last = encodeDepth(range.farDepth - range.nearDepth, frame.quantization.depthStep);
  for (int i = 0; i < 64; ++i) {
    frame.segments.rays.push_back({1, false});
    frame.segments.depths.push_back({0, last});
    frame.segments.colors.push_back(0x80ffffffu);
  }
  // All of space in front of the eye has the same extinction but for the pixels' cosines.
  for (const glm::vec3& direction : {glm::vec3(0.0f, 0.0f, -1.0f), glm::vec3(1.0f, 0.0f, 0.0f), glm::vec3(1.0f, 1.0f, 0.0f), glm::vec3(0.0f, 1.0f, -1.0f),
                                     glm::vec3(0.3f, 0.0f, -1.0f), glm::vec3(0.0f, 1.0f, 0.0f)})
    for (const glm::vec3& through : {glm::vec3(0.0f), glm::vec3(0.0f, 1.5f, 0.0f), glm::vec3(3.0f, 3.0f, 0.0f)}) {
      const Ray ray{through - 8.0f * glm::normalize(direction), glm::normalize(direction)};
      for (const bool isLinear : {false, true}) {
        const Found found = walk(frame, ray, 0.0f, 16.0f, isLinear);
        const MetByRay expected = bruteForce(frame, ray, 0.0, 16.0, isLinear, 8000);
        EXPECT_NEAR(static_cast<double>(found.walked.through), expected.through, 5e-3);
        EXPECT_NEAR(found.unknown, expected.unknown, 0.02);
      }
    }
}

/// As thin as codes can tell, and one behind the other: however short they are, rays meet all that they have.
TEST(SegmentWalk, ThinSegmentsAreAsOpaqueAsTheySay) {
  for (const float farAway : {30.0f, 3e3f, 3e5f}) {
    SampleFrame frame;
    frame.camera = lookingFrom({0.0f, 0.0f, farAway}, glm::vec3(0.0f), 8, 8, 14.0f / farAway);
    frame.quantization = quantizationFor(frame.camera, kFrameBounds, 1.0f);
    frame.settings.sample.segments = 3;
    const DepthRange range = depthRangeOf(frame.camera, kFrameBounds);
    const uint32_t middle = encodeDepth(0.5f * (range.farDepth - range.nearDepth), frame.quantization.depthStep);
    double expected = 1.0;
    for (int i = 0; i < 64; ++i) {
      frame.segments.rays.push_back({3, false});
      for (const uint32_t code : {middle, middle, middle + 3}) {
        frame.segments.depths.push_back({code, code});
        frame.segments.colors.push_back(0x90ffffffu);
      }
    }
    for (int i = 0; i < 3; ++i) expected *= 1.0 - static_cast<double>(segmentOpacity(0x90ffffffu));
    const PixelGrid own = makePixelGrid(frame.camera, range.nearDepth);
    for (const bool isLinear : {false, true}) {
      EXPECT_NEAR(static_cast<double>(walk(frame, own.ray(3, 4).ray, 0.0f, 40.0f, isLinear).walked.through), expected, 0.004) << farAway;
      // From beside: a layer that is met at an angle is passed for longer. Pixels' rays from far away are nearly the axis.
      const glm::vec3 aslant = glm::normalize(glm::vec3(0.6f, 0.0f, -0.8f));
      const double through = static_cast<double>(walk(frame, {-12.0f * aslant, aslant}, 0.0f, 24.0f, isLinear).walked.through);
      EXPECT_NEAR(through, std::pow(expected, 1.0 / 0.8), 0.006) << farAway;
    }
  }
}

/// Of four pixels that lie about a ray, those that have ended in front of a place are not asked what is there.
TEST(SegmentWalk, BetweenPixelsThoseThatKnowSayWhatIsThere) {
  SampleFrame frame;
  frame.camera = lookingFrom({0.0f, 0.0f, 30.0f}, glm::vec3(0.0f), 2, 1, 0.3f);
  frame.quantization = quantizationFor(frame.camera, kFrameBounds, 1.0f);
  frame.settings.sample.segments = 1;
  const auto codeOf = [&](float depth) { return encodeDepth(depth, frame.quantization.depthStep); };
  frame.segments.rays = {{1, true}, {1, false}};
  frame.segments.depths = {{codeOf(2.0f), codeOf(4.0f)}, {codeOf(10.0f), codeOf(12.0f)}};
  frame.segments.colors = {0xff0000ffu, 0xffff0000u};
  const PixelGrid pixels = makePixelGrid(frame.camera, frame.quantization.nearDepth);
  // Between both centres, three quarters on the left one's side: it ends at 4, and the right one alone is asked behind.
  const Ray left = pixels.ray(0, 0).ray, right = pixels.ray(1, 0).ray;
  const Ray between{glm::mix(left.origin, right.origin, 0.25f), glm::normalize(glm::mix(left.direction, right.direction, 0.25f))};
  const Found found = walk(frame, between, 0.0f, 18.0f, true);
  const MetByRay expected = bruteForce(frame, between, 0.0, 18.0, true, 100000);
  EXPECT_EQ(found.pieces, 0);
  EXPECT_NEAR(static_cast<double>(found.walked.through), expected.through, 1e-6);
  EXPECT_NEAR(static_cast<double>(found.walked.through), 0.25 / 1024, 1e-4);  // what passes the right one, where it is that one's; about, since it is longer aside
  EXPECT_NEAR(found.walked.color.r, 0.75f, 1e-2f);
  // On the left one's own ray nobody else is asked.
  const Found own = walk(frame, left, 0.0f, 18.0f, true);
  EXPECT_EQ(own.pieces, 1);
  EXPECT_NEAR(own.unknown, 18.0 - 4.0 / 0.9, 0.5);
}

TEST(SegmentWalk, AnEyeAtInfinityMeetsWhatOneFarAwayMeets) {
  const SampleFrame frame = randomFrame(kServer, 21);
  const glm::vec3 towards = glm::normalize(glm::vec3(1.0f, 0.3f, 2.0f));
  const auto seenFrom = [&](float distance) { return lookingFrom(distance * towards, glm::vec3(0.0f), 9, 9, 14.0f / distance); };
  const auto pictureOf = [&](const Camera& camera) {
    const PixelGrid pixels = makePixelGrid(camera, depthRangeOf(camera, kFrameBounds).nearDepth);
    std::vector<float> all;
    for (uint32_t y = 0; y < camera.height; ++y)
      for (uint32_t x = 0; x < camera.width; ++x) {
        const Ray ray = pixels.ray(x, y).ray;
        const RayInterval inside = intersectBox(reciprocalOf(ray.origin, ray.direction), kFrameBounds, 0.0f, INFINITY);
        all.push_back(inside.isMiss() ? 1.0f : walk(frame, ray, inside.tNear, inside.tFar, true).walked.through);
      }
    return all;
  };
  const std::vector<float> far = pictureOf(seenFrom(1e5f)), farther = pictureOf(seenFrom(4e6f));
  for (size_t i = 0; i < far.size(); ++i) EXPECT_NEAR(far[i], farther[i], 0.02f) << i;
}

/// Of a server inside a volume of thousands of units, whose eye a ray passes through from far behind: the frustum begins there, neither behind nor in it.
TEST(SegmentWalk, ARayThroughTheOldEyeFromFarBehindIt) {
  const Camera server = lookingFrom(glm::vec3(0.0f), {0.0f, 0.0f, -1.0f}, 9, 9, 0.6f);
  SampleFrame frame;
  frame.camera = server;
  frame.quantization = quantizationFor(server, {glm::vec3(-9000.0f), glm::vec3(9000.0f)}, 1.0f);
  frame.settings.sample.segments = 1;
  frame.segments.rays.assign(9 * 9, RaySegmentCount{});
  ASSERT_EQ(frame.quantization.nearDepth, 0.0f);
  BuiltSegmentField built;
  built.build(frame);
  std::mt19937 random(1);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  for (int i = 0; i < 500; ++i) {
    const float behind = std::exp2(4.0f + 9.0f * unit(random));
    const glm::vec3 towards = glm::normalize(glm::vec3(0.1f * unit(random), 0.1f * unit(random), -1.0f));
    const FieldLine line = makeFieldLine(built.field(), {-behind * towards, towards}, 0.0f, behind + 5000.0f, 0.5f);
    ASSERT_LT(line.t0, line.t1) << behind;
    ASSERT_NEAR(line.t0, behind - built.field().depths.leastFromEye() / towards.z, 1e-4f * behind) << behind;
    for (const float number : {line.x0, line.y0, line.dx, line.dy, line.depth0, line.depths, line.ratio}) ASSERT_TRUE(std::isfinite(number)) << behind;
    ASSERT_GE(line.ratio, 1.0f);
  }
}

TEST(SegmentWalk, WithoutSegmentsAllIsKnownToBeEmptyOrUnknown) {
  SampleFrame frame;
  frame.camera = kServer;
  frame.quantization = quantizationFor(kServer, kFrameBounds, 1.0f);
  frame.settings.sample.segments = 2;
  frame.segments.rays.assign(13 * 9, RaySegmentCount{});
  const Found found = walk(frame, {{0.0f, 0.0f, 20.0f}, {0.0f, 0.0f, -1.0f}}, 10.0f, 30.0f, true);
  EXPECT_EQ(found.walked.through, 1.0f);
  EXPECT_NEAR(found.unknown, 0.0, 1e-3);
  const Found beside = walk(frame, {{-100.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -1.0f}}, 0.0f, 5.0f, true);
  EXPECT_NEAR(beside.unknown, 5.0, 1e-6);
}

/// A frame whose first and last columns alone have something, far away. `width`: no multiple of any tile's.
SampleFrame borderFrame(uint32_t width) {
  const Camera camera = lookingFrom({0.0f, 0.0f, 30.0f}, glm::vec3(0.0f), width, width, 0.5f);
  SampleFrame frame = randomFrame(camera, 1, 0);
  frame.settings.sample.segments = 1;
  const DepthRange range = depthRangeOf(camera, kFrameBounds);
  const auto code = [&](float share) { return encodeDepth(share * (range.farDepth - range.nearDepth), frame.quantization.depthStep); };
  frame.segments = {};
  for (uint32_t i = 0; i < width * width; ++i) {
    const bool isBorder = i % width == 0 || i % width == width - 1;
    frame.segments.rays.push_back({isBorder ? 1 : 0, false});
    if (!isBorder) continue;
    frame.segments.depths.push_back({code(0.6f), code(0.8f)});
    frame.segments.colors.push_back(0xc0ffffffu);
  }
  return frame;
}

template <Between kBetween>
void expectBordersAlike(uint32_t width) {
  BuiltSegmentField built;
  built.build(borderFrame(width));
  const SegmentField field = built.field();
  // Rays in the planes of the left and the right border, aslant.
  const float tangent = 0.5f * static_cast<float>(width) * field.pixels.edge, nearest = 22.0f, farthest = 38.0f;
  int met = 0;
  for (int i = 1; i < 200; ++i) {
    const float slope = (static_cast<float>(i) / 100.0f - 1.0f) * 0.9f * tangent;
    float through[2];
    for (const int side : {0, 1}) {
      const float x = side == 0 ? -tangent : tangent;
      const glm::vec3 from(x * nearest, slope * nearest, 30.0f - nearest), to(x * farthest, -slope * farthest, 30.0f - farthest);
      through[side] = walkSegments<kBetween>(field, {from, glm::normalize(to - from)}, 0.0f, glm::length(to - from), 0.0f).through;
    }
    EXPECT_NEAR(through[0], through[1], 0.02f) << width << ", " << i << (blends(kBetween) ? " linear" : " nearest");
    met += through[0] < 0.9f;
  }
  EXPECT_GT(met, 150);
}

TEST(SegmentWalk, LinesAlongTheRightBorderMeetWhatThoseAlongTheLeftOneMeet) {
  for (const uint32_t width : {64u, 66u, 250u, 270u}) {
    expectBordersAlike<Between::nearest>(width);
    expectBordersAlike<Between::linear>(width);
  }
}

}  // namespace
}  // namespace warpscope
