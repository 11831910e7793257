// Segments of rays and what is drawn from them: cases 62 and 64 to 66. Truth: closed forms, and brute force in double
// (every step of every ray asks the pixels that it is between, segment_frames.h). Mirrors
// render/march/frame_segments.h, segment_encoder.h and render/warp/segments_warp.h.
#include "render/warp/segments_warp.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "render/warp/fill.h"
#include "tests/marcher_cases.h"
#include "tests/segment_frames.h"
#include "tests/stability/backends.h"
#include "tests/stability/magnitudes.h"
#include "tests/stability/record.h"
#include "tests/test_volumes.h"
#include "tests/warp_cases.h"

namespace warpscope {
namespace {

/// What a picture may be off by where each pixel's segments are the same all over its frustum: of thin ones by the ends
/// of pieces, which are places in single precision.
constexpr double kOfNearest = 2e-3;
/// Between pixels, whose weights are means over pieces of rays: as far off as pixels are large beside what they show,
/// and as steps of the truth are long.
constexpr double kOfLinear = 0.09;
/// By as much the truth is off that is found in steps, where pixels' segments are the same all over their frusta.
constexpr double kOfSteps = 0.012;
constexpr int kWalkedSteps = 4000;

WarpSettings between(Between kind) {
  WarpSettings settings;
  settings.knobs.set(kBetweenKnob, kind);
  settings.knobs.set(kFillKnob, Fill::none);
  return settings;
}

WarpedImage drawnOn(Backend backend, const SampleFramePtr& frame, const Camera& camera, Between kind) {
  const std::unique_ptr<Warp> warp = techniqueOn(backend, "segments");
  warp->setFrame(frame, between(kind));
  WarpedImage image;
  warp->draw(camera, between(kind), image);
  return image;
}

/// As drawnOn; on a device the picture is the CPU's to the bit.
WarpedImage drawn(Backend backend, const SampleFramePtr& frame, const Camera& camera, Between kind) {
  WarpedImage image = drawnOn(backend, frame, camera, kind);
  if (backend == Backend::cuda) {
    const WarpedImage onCpu = drawnOn(Backend::cpu, frame, camera, kind);
    EXPECT_EQ(image.samples, onCpu.samples);
    EXPECT_TRUE(sameBits(image.color, onCpu.color));
  }
  return image;
}

/// Every segment of a ray counts, however little is left of the light.
SampleFramePtr whole(SampleFrame frame) {
  frame.settings.render.terminateEarly = false;
  return std::make_shared<const SampleFrame>(std::move(frame));
}

/// By how much a picture of the frame is off from brute force, in every pixel that the frame's bounds are in.
/// `isTied`: rays lie in borders of pixels, which are in two frusta: pixels are told by places alone then.
double errorOf(Backend backend, const SampleFramePtr& frame, const Camera& camera, Between kind, bool isTied = false) {
  const WarpedImage image = drawn(backend, frame, camera, kind);
  const PixelGrid pixels = makePixelGrid(camera, depthRangeOf(camera, kFrameBounds).nearDepth);
  Worst worst;
  for (uint32_t y = 0; y < camera.height; ++y)
    for (uint32_t x = 0; x < camera.width; ++x) {
      const Ray ray = pixels.ray(x, y).ray;
      const RayInterval inside = intersectBox(reciprocalOf(ray.origin, ray.direction), kFrameBounds, 0.0f, INFINITY);
      const glm::vec4 shown = image.color(x, y);
      if (inside.isMiss()) {
        EXPECT_EQ(shown, glm::vec4(0.0f));
        continue;
      }
      const auto tNear = static_cast<double>(inside.tNear), tFar = static_cast<double>(inside.tFar);
      const MetByRay met = isTied || kind == Between::linear
                               ? bruteForce(*frame, ray, tNear, tFar, kind == Between::linear, kWalkedSteps)
                               : cutByFrusta(*frame, ray, tNear, tFar);
      worst.see(std::abs(static_cast<double>(shown.a) - (1.0 - met.through)));
      for (int channel = 0; channel < 3; ++channel)
        worst.see(std::abs(static_cast<double>(shown[channel]) - met.color[channel]));
    }
  return worst.value();
}

/// That of both ways between pixels, each beside its bound: at most 1. Whether a pixel that has ended counts is decided
/// for a piece of a ray, so that frames are to be without ends where pixels are blended.
double shareOfBound(Backend backend, const SampleFrame& frame, const Camera& camera, bool isTied = false) {
  SampleFrame open = frame;
  for (RaySegmentCount& ray : open.segments.rays) ray = {ray.count(), false};
  return std::max(errorOf(backend, whole(frame), camera, Between::nearest, isTied) / (isTied ? kOfSteps : kOfNearest),
                  errorOf(backend, whole(std::move(open)), camera, Between::linear, isTied) / kOfLinear);
}

/// A frame whose pixels all have the same segments.
SampleFrame evenFrame(const Camera& camera, const std::vector<std::pair<SegmentDepths, Rgba8>>& segments) {
  SampleFrame frame;
  frame.camera = camera;
  frame.quantization = quantizationFor(camera, kFrameBounds, 1.0f);
  frame.settings.sample.segments = static_cast<int>(segments.size());
  for (size_t i = 0; i < size_t{camera.width} * camera.height; ++i) {
    frame.segments.rays.push_back({static_cast<int>(segments.size()), false});
    for (const auto& [depths, color] : segments) {
      frame.segments.depths.push_back(depths);
      frame.segments.colors.push_back(color);
    }
  }
  return frame;
}

uint32_t codeAt(const Camera& camera, float depth) {
  return encodeDepth(depth, quantizationFor(camera, kFrameBounds, 1.0f).depthStep);
}

// --- 64: no length, opacity 1 and 1e-8, a thousand samples merged to one

/// In the frame's own view, however long they are; from elsewhere sheets, aslant or along them.
TEST_P(Case64, SegmentsAsThinAsCodesCanTell) {
  const Camera server =
      lookingFrom({0.0f, 0.0f, 30.0f}, glm::vec3(0.0f), 24, 18, 0.15f);  // no ray leaves the bounds sideways
  Worst own, beside;
  for (const uint32_t codes : {0u, 1u, 16u, 4096u})
    for (const uint32_t opacity : {0u, 1u, 16u, 128u, 254u, 255u})
      for (const float depth : {0.3f, 9.0f, 17.0f}) {
        SCOPED_TRACE(testing::Message() << codes << " codes at " << depth << ", opacity " << opacity);
        const uint32_t code = codeAt(server, depth);
        const SampleFramePtr frame = whole(evenFrame(server, {{{code, code + codes}, opacity << 24 | 0xc0a080u}}));
        const glm::dvec4 color(segmentColor(ColorTables::instance(), frame->segments.colors[0]));
        const double expected = std::min(color.a, static_cast<double>(kMostSegmentOpacity)),
                     share = color.a > 0.0 ? expected / color.a : 0.0;
        for (const Between kind : {Between::nearest, Between::linear}) {
          for (const glm::vec4& pixel : drawn(GetParam(), frame, server, kind).color) {
            own.see(std::abs(static_cast<double>(pixel.a) - expected));
            for (int channel = 0; channel < 3; ++channel)
              own.see(std::abs(static_cast<double>(pixel[channel]) - share * color[channel]));
          }
          for (const glm::vec3& eye :
               {glm::vec3(12.0f, 3.0f, 25.0f), glm::vec3(30.0f, 0.0f, 10.0f - depth), glm::vec3(0.0f, 0.0f, -30.0f)})
            for (const glm::vec4& pixel :
                 drawn(GetParam(), frame, lookingFrom(eye, {0.0f, 0.0f, 10.0f - depth}, 15, 11, 0.3f), kind).color) {
              beside.see(std::max({0.0, -static_cast<double>(pixel.a), static_cast<double>(pixel.a) - 1.0}));
              EXPECT_TRUE(std::isfinite(pixel.r + pixel.g + pixel.b));
              EXPECT_FALSE(pixel.a > 0.0f && opacity == 0);
            }
        }
      }
  record({"technique segments, of no length and of a code's in the frame's own view", "closed form", "", own.value(),
          1e-4, GetParam()});
  record({"technique segments, sheets without thickness from elsewhere: opacities within 0..1", "definition", "",
          beside.value(), 0.0, GetParam()});
}

/// A homogeneous block, whose rays take some thousand samples each.
TEST_P(Case64, AThousandSamplesAreOneSegmentOfTheClosedForm) {
  const VolumePtr block = makeTestVolume(VoxelType::uint8, {20, 20, 20}, [](const glm::ivec3&) { return 50.0; });
  const Camera server = lookingFrom({2.0f, 3.0f, 60.0f}, glm::vec3(0.0f), 64, 48, 0.25f);
  Worst ends, share;
  for (const float opacity : {1e-8f, 1e-4f, 0.05f, 1.0f}) {
    const MarcherPtr marcher = marcherOn(GetParam(), block, everywhere(opacity));
    MarchSettings settings;
    settings.render.step = 0.02f;
    settings.render.contribution = 1e-6f;
    settings.render.terminateEarly = false;
    settings.sample.segments = 1;
    const SampleFrame frame = marcher->march(server, settings);
    const Box& bounds = block->bounds();
    size_t at = 0;
    for (uint32_t y = 0; y < server.height; ++y)
      for (uint32_t x = 0; x < server.width; ++x) {
        const int count = frame.segments.rays[size_t{y} * server.width + x].count();
        const double length = lengthInside(server, x, y, bounds);
        const double expected = opacity >= 1.0f ? (length > 0.0 ? 1.0 : 0.0)
                                                : -std::expm1(length * std::log1p(-static_cast<double>(opacity)));
        ASSERT_LE(count, 1);
        const double found = count > 0 ? static_cast<double>(segmentOpacity(frame.segments.colors[at])) : 0.0;
        // Codes are of opacity's root.
        if (length > 0.05) share.see(std::abs(std::sqrt(found) - std::sqrt(expected)) * 255.0);
        if (count > 0 && opacity < 1.0f && length > 0.05) {
          const SegmentDepths& depths = frame.segments.depths[at];
          const double cosine =
              static_cast<double>(makePixelGrid(server, frame.quantization.nearDepth).ray(x, y).cosine);
          ends.see(std::abs((depths.end - depths.begin) * static_cast<double>(frame.quantization.depthStep) -
                            length * cosine) /
                   (3.0 * static_cast<double>(settings.render.step)));
        }
        at += static_cast<size_t>(count);
      }
    ASSERT_EQ(at, frame.segments.size());
  }
  record({"march, a thousand samples of 1e-8 to 1 merged to one segment: opacity", "closed form", "codes of its root",
          share.value(), 1.0, GetParam()});
  record({"march, a thousand samples merged to one segment: length", "closed form", "of three steps", ends.value(), 1.0,
          GetParam()});
}

TEST_P(Case64, SegmentsThatTouchAreMetOneBehindTheOther) {
  Worst worst;
  for (const glm::vec3& eye : {glm::vec3(4.0f, 4.0f, 30.0f), glm::vec3(20.0f, 5.0f, 22.0f),
                               glm::vec3(30.0f, 2.0f, 1.0f), glm::vec3(2.0f, 1.0f, -28.0f)}) {
    const uint32_t a = codeAt(kServer, 4.0f), b = codeAt(kServer, 9.0f), c = codeAt(kServer, 9.5f),
                   d = codeAt(kServer, 22.0f);
    const SampleFrame frame = evenFrame(kServer, {{{a, b}, 0x602040ffu}, {{b, c}, 0xa0ff4020u}, {{c, d}, 0x8020ff40u}});
    worst.see(shareOfBound(GetParam(), frame, lookingFrom(eye, glm::vec3(0.0f), 7, 5, 0.45f)));
  }
  record({"technique segments, three that touch in each pixel", "brute force", "of 0.002, blended 0.09", worst.value(),
          1.0, GetParam()});
}

TEST_P(Case64, RaysHaveNoMoreSegmentsThanSamples) {
  const VolumePtr block = makeTestVolume(VoxelType::uint8, {20, 20, 20}, blobs({20, 20, 20}, 3));
  const MarcherPtr marcher = marcherOn(GetParam(), block, band(20.0, 90.0, 0.1f));
  const Camera server = lookingFrom({9.0f, 5.0f, 50.0f}, glm::vec3(0.0f), 60, 40, 0.3f);
  MarchSettings settings;
  settings.render.step = 6.0f;  // six samples at most
  settings.sample.segments = 8;
  const SampleFrame few = marcher->march(server, settings);
  settings.sample.segments = 16;
  const SampleFrame many = marcher->march(server, settings);
  EXPECT_EQ(few.segments.rays, many.segments.rays);
  EXPECT_EQ(few.segments.depths, many.segments.depths);
  EXPECT_EQ(few.segments.colors, many.segments.colors);
  EXPECT_GT(few.segments.size(), 100u);
  for (const RaySegmentCount ray : many.segments.rays) EXPECT_LE(ray.count(), 6);
  recordExact("march with more segments a ray than it has samples", "definition", GetParam());
}

// --- 65: through a pixel's corner, along its edge, the new eye in the old eye, behind it, far away

TEST_P(Case65, AlongEdgesAndThroughCornersNothingIsLostOrMetTwice) {
  // The same in all pixels, so that it does not matter to which of them a border is counted.
  const Camera server = lookingFrom({0.0f, 0.0f, 30.0f}, glm::vec3(0.0f), 8, 8, 0.4f);
  const SampleFrame frame = evenFrame(server, {{{codeAt(server, 2.0f), codeAt(server, 8.0f)}, 0x80ff8040u},
                                               {{codeAt(server, 12.0f), codeAt(server, 20.0f)}, 0x604080ffu}});
  Worst worst;
  // From the old eye: through the corners of its pixels, and along their edges.
  for (const glm::uvec2& size : {glm::uvec2(4, 4), glm::uvec2(8, 4), glm::uvec2(2, 2)}) {
    Camera half = server;
    half.width = size.x;
    half.height = size.y;
    if (size.x == 8) {
      // As wide a view in twice as many columns as rows: every ray in a plane of an edge.
      half.tanHalfFovY = 0.2f;
    }
    worst.see(shareOfBound(GetParam(), frame, half, true));
  }
  // In the plane between two rows of pixels, to whatever side; and from above.
  for (const glm::vec3& eye :
       {glm::vec3(12.0f, 0.0f, 26.0f), glm::vec3(30.0f, 0.0f, 0.0f), glm::vec3(-7.0f, 0.0f, -30.0f),
        glm::vec3(0.0f, 30.0f, 0.0f), glm::vec3(20.0f, 20.0f, 0.0f)})
    worst.see(shareOfBound(GetParam(), frame, lookingFrom(eye, glm::vec3(0.0f), 7, 7, 0.4f), true));
  record({"technique segments, rays along pixels' edges and through their corners", "brute force",
          "of 0.012, blended 0.09", worst.value(), 1.0, GetParam()});
}

TEST_P(Case65, FromTheOldEyeAndFromBehindIt) {
  Worst worst;
  for (uint32_t seed = 1; seed <= 3; ++seed) {
    const SampleFrame frame = randomFrame(kServer, seed);
    // In the eye itself, looking elsewhere; all but there; behind it.
    const glm::vec3 back = -kServer.forward;
    for (const glm::vec3& eye :
         {kServer.eye, kServer.eye + glm::vec3(1e-5f, 0.0f, 0.0f), kServer.eye + 1e-3f * kServer.up,
          kServer.eye + 0.01f * back, kServer.eye + 8.0f * back, kServer.eye + 60.0f * back})
      for (const glm::vec3& at : {glm::vec3(0.5f, 0.2f, 0.0f), glm::vec3(-2.0f, 3.0f, 1.0f)})
        worst.see(shareOfBound(GetParam(), frame, lookingFrom(eye, at, 6, 5, 0.5f)));
  }
  record({"technique segments, from the frame's own eye and behind it", "brute force", "of 0.002, blended 0.09",
          worst.value(), 1.0, GetParam()});
}

TEST_P(Case65, AnEyeAtInfinityMeetsWhatOneFarAwayMeets) {
  Worst worst;
  for (const glm::vec3& towards :
       {glm::vec3(1.0f, 0.3f, 2.0f), glm::vec3(0.0f, 0.0f, 1.0f), glm::vec3(-1.0f, 0.2f, -0.5f)}) {
    const SampleFrame frame = randomFrame(kServer, 21);
    for (const float distance : {1e4f, 4e6f})
      worst.see(shareOfBound(GetParam(), frame,
                             lookingFrom(distance * glm::normalize(towards), glm::vec3(0.0f), 7, 5, 14.0f / distance)));
  }
  record({"technique segments, from up to 4e6 away", "brute force", "of 0.002, blended 0.09", worst.value(), 1.0,
          GetParam()});
}

/// Every pixel's frustum against every ray.
TEST_P(Case65, PropertyRandomFramesAreMetAsByBruteForce) {
  Worst worst;
  checkProperty([&] {
    std::mt19937 random(*rc::gen::arbitrary<uint32_t>());
    std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
    const auto place = [&](float far) { return far * glm::vec3(unit(random), unit(random), unit(random)); };
    const auto side = [&] { return 1 + static_cast<uint32_t>(random() % 24); };
    const Camera server = lookingFrom(place(25.0f), place(4.0f), side(), side(), 0.5f + 0.4f * unit(random));
    const Camera camera = lookingFrom(place(35.0f), place(6.0f), 4, 3, 0.6f + 0.5f * unit(random));
    const SampleFrame frame = randomFrame(server, static_cast<uint32_t>(random()), 1 + static_cast<int>(random() % 16));
    const double error = errorOf(GetParam(), whole(frame), camera, Between::nearest);
    worst.see(error);
    RC_ASSERT(error <= kOfNearest);
    for (const glm::vec4& shown : drawn(GetParam(), whole(frame), camera, Between::linear).color)
      RC_ASSERT(std::isfinite(shown.r + shown.g + shown.b) && shown.a >= 0.0f && shown.a <= 1.0f);
  });
  record({"technique segments, random frames and cameras", "brute force", "", worst.value(), kOfNearest, GetParam()});
}

// --- 62 and 66: an eye in a segment, a frame of one pixel

TEST_P(Case62, AnEyeInASegmentSeesWhatIsLeftOfIt) {
  Worst worst;
  const SampleFrame frame = evenFrame(kServer, {{{codeAt(kServer, 1.0f), codeAt(kServer, 25.0f)}, 0xa0ff8040u}});
  for (const glm::vec3& eye :
       {glm::vec3(0.5f, 0.5f, 2.0f), glm::vec3(1.0f, 2.0f, 6.0f), glm::vec3(-2.0f, -1.0f, -6.0f)})
    for (const glm::vec3& at : {glm::vec3(0.5f, 0.2f, -9.0f), glm::vec3(9.0f, 0.0f, 0.0f), glm::vec3(1.0f, 2.0f, 9.0f)})
      worst.see(shareOfBound(GetParam(), frame, lookingFrom(eye, at, 7, 6, 0.9f)));
  // Of frames that were marched from inside matter the own view is what was marched, to two codes.
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, {24, 24, 24}, blobs({24, 24, 24}, 5));
  const MarcherPtr marcher = marcherOn(GetParam(), volume, band(10.0, 100.0, 0.3f));
  Worst own;
  for (const glm::vec3& eye : {glm::vec3(0.0f), glm::vec3(3.0f, -2.0f, 5.0f), glm::vec3(0.01f, 11.9f, 0.0f)}) {
    const Camera inside = lookingFrom(eye, eye + glm::vec3(-0.3f, -0.2f, -0.9f), 64, 48);
    MarchSettings settings;
    settings.sample.segments = 4;
    const auto marched = std::make_shared<const SampleFrame>(marcher->march(inside, settings));
    const Image<glm::vec4> truth = rendered(*marcher, inside, settings);
    const WarpedImage image = drawn(GetParam(), marched, inside, Between::linear);
    for (size_t i = 0; i < truth.size(); ++i)
      own.see(std::abs(static_cast<double>(image.color[i].a) - static_cast<double>(truth[i].a)) * 255.0);
  }
  // So it is where matter begins at the eye itself, from which on rays have segments, and from elsewhere there is a picture.
  const VolumePtr even = makeTestVolume(VoxelType::uint8, {24, 24, 24}, [](const glm::ivec3&) { return 50.0; });
  const MarcherPtr throughFog = marcherOn(GetParam(), even, band(10.0, 100.0, 0.02f));
  for (const int segments : {1, 4, 16}) {
    const Camera inside = lookingFrom(glm::vec3(0.02f, 0.0f, 0.0f), glm::vec3(-3.0f, -2.0f, -9.0f), 33, 20);
    MarchSettings settings;
    settings.sample.segments = segments;
    const auto marched = std::make_shared<const SampleFrame>(throughFog->march(inside, settings));
    const Image<glm::vec4> truth = rendered(*throughFog, inside, settings);
    for (const Between kind : {Between::nearest, Between::linear}) {
      const WarpedImage image = drawn(GetParam(), marched, inside, kind);
      for (size_t i = 0; i < truth.size(); ++i)
        for (int channel = 0; channel < 4; ++channel)
          own.see(std::abs(static_cast<double>(image.color[i][channel]) - static_cast<double>(truth[i][channel])) * 255.0);
    }
    const Camera beside = lookingFrom(glm::vec3(1.0f, 0.5f, 3.0f), glm::vec3(-2.0f, -2.0f, -9.0f), 16, 16);
    for (const glm::vec4& shown : drawn(GetParam(), marched, beside, Between::linear).color)
      own.see(std::isfinite(shown.r + shown.g + shown.b + shown.a) ? 0.0 : std::numeric_limits<double>::quiet_NaN());
  }
  record(
      {"technique segments, from inside one", "brute force", "of 0.002, blended 0.09", worst.value(), 1.0, GetParam()});
  record({"technique segments, own view from inside matter", "march", "codes of 8 bits", own.value(), 2.0,
          GetParam()});
}

TEST_P(Case66, AFrameOfOnePixelOfSegments) {
  Camera one = kServer;
  one.width = one.height = 1;
  Worst worst;
  for (uint32_t seed = 0; seed < 6; ++seed)
    worst.see(shareOfBound(GetParam(), randomFrame(one, seed, 16),
                           lookingFrom({12.0f, 3.0f, 26.0f}, glm::vec3(0.0f), 5, 5, 0.45f)));
  record({"technique segments, frames of one pixel", "brute force", "of 0.002, blended 0.09", worst.value(), 1.0,
          GetParam()});
}

}  // namespace
}  // namespace warpscope
