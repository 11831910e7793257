// Samples as codes: cases 26 to 29. Truth: closed forms in 100 digits and long double from the bits that the header
// documents. Mirrors render/core/sample.h and pixel_grid.h; frames as bytes: render/codec/codec.h.
#include "render/core/sample.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "tests/codec_frames.h"
#include "tests/stability/backends.h"
#include "tests/stability/device_probe.h"
#include "tests/stability/exact.h"
#include "tests/stability/magnitudes.h"
#include "tests/stability/probes.h"
#include "tests/stability/record.h"

namespace warpscope {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Steps of depth as they occur, and far beyond.
constexpr float kSteps[] = {1.0f, 0x1p-18f, 1e-3f, 0.0007123f, 3e10f, 1e-30f, 7e-12f};

/// A depth and a radius on their way into a sample and back.
std::vector<SampleProbe::Output> packed(Backend backend, const std::vector<std::pair<float, float>>& depths,
                                        const std::vector<std::pair<float, float>>& radii = {}) {
  std::vector<SampleProbe::Input> inputs;
  for (size_t i = 0; i < std::max(depths.size(), radii.size()); ++i) {
    SampleProbe::Input input{};
    input.grid.bounds = {glm::vec3(-1.0f), glm::vec3(1.0f)};
    input.grid.depthStep = i < depths.size() ? depths[i].second : 1.0f;
    input.grid.radiusUnit = i < radii.size() ? radii[i].second : 1.0f;
    input.behind = i < depths.size() ? depths[i].first : 0.0f;
    input.radius = i < radii.size() ? radii[i].first : 1.0f;
    inputs.push_back(input);
  }
  return evaluate<SampleProbe>(backend, inputs);
}

TEST_P(Case26, PropertyDepthsComeBackWithinHalfAStep) {
  Worst worst;
  checkProperty([&] {
    // Depths of up to 2^26 steps, of every size that a step may have.
    const auto depths = *rc::gen::container<std::vector<std::pair<float, float>>>(rc::gen::map(
        rc::gen::tuple(anyPositive(-4, 25), anyPositive(-95, 70)),
        [](const std::tuple<float, float>& d) { return std::pair(std::get<0>(d) * std::get<1>(d), std::get<1>(d)); }));
    const auto found = packed(GetParam(), depths);
    for (size_t i = 0; i < depths.size(); ++i) {
      const auto& [behind, step] = depths[i];
      if (Exact(behind) / step > 67108860) continue;  // beyond the last code
      // Beyond half a step, in roundoffs of the depth.
      const double beyond = static_cast<double>((abs(Exact(found[i].behind) - behind) - Exact(step) / 2) /
                                                (Exact(behind) * kUnitRoundoff));
      RC_ASSERT(beyond * kUnitRoundoff <= kDepthCodeError);
      worst.see(std::max(0.0, beyond));
    }
  });
  record({"encodeDepth, decodeDepth", "100 digits", "u of the depth beyond half a step", worst.value(),
          kDepthCodeError / kUnitRoundoff, GetParam()});
}

TEST_P(Case26, EveryCodeThatFramesHaveComesBack) {
  for (const float step : kSteps) {
    std::vector<std::pair<float, float>> depths;
    std::vector<uint32_t> codes;
    for (uint32_t code = 0; code <= 1u << 22; code += 1 + code / 1000) {
      codes.push_back(code);
      depths.emplace_back(decodeDepth(code, step), step);
    }
    const auto found = packed(GetParam(), depths);
    for (size_t i = 0; i < codes.size(); ++i) {
      ASSERT_EQ(depthCode(found[i].packed), codes[i]) << step;
      ASSERT_EQ(found[i].behind, depths[i].first) << step;
      if (i > 0) ASSERT_GT(depths[i].first, depths[i - 1].first) << codes[i];
    }
  }
  // With a step that is a power of two all that floats can tell apart.
  std::vector<std::pair<float, float>> depths;
  for (const uint32_t first : {1u << 22, 1u << 23, (1u << 24) - 1000})
    for (uint32_t code = first; code < first + 1000; ++code)
      depths.emplace_back(0.25f * static_cast<float>(code), 0.25f);
  const auto found = packed(GetParam(), depths);
  for (size_t i = 0; i < depths.size(); ++i) ASSERT_EQ(found[i].behind, depths[i].first);
  recordExact("decodeDepth then encodeDepth, codes below 2^22", "identity", GetParam());
}

TEST_P(Case26, EndsAreExactWhatIsOutsideIsClampedAndNanIsNothing) {
  const auto codeOf = [&](float behind, float step) {
    return depthCode(packed(GetParam(), {{behind, step}}).front().packed);
  };
  for (const float behind : {0.0f, -0.0f, -1.0f, -kInfinity, kNan}) EXPECT_EQ(codeOf(behind, 0.5f), 0u) << behind;
  for (const float behind : {0x1p26f, 3e38f, kInfinity}) {
    EXPECT_LE(codeOf(behind, 1.0f), kDepthCodeMax) << behind;
    EXPECT_GE(codeOf(behind, 1.0f), kDepthCodeMax - 3) << behind;
  }
  for (const float step : {0.0f, -1.0f, kNan, kInfinity}) EXPECT_LE(codeOf(3.0f, step), kDepthCodeMax) << step;
  recordExact("encodeDepth of 0, of less, of NaN, beyond the codes", "definition", GetParam());
}

/// A sample of a camera far from what it looks at or near to it.
struct PositionCase {
  Camera camera;
  Box bounds;
  float along;  ///< of the depths
  float column, row;
};

void showValue(const PositionCase& c, std::ostream& out) {
  showValue(c.camera, out);
  showBits(out << ", bounds ", c.bounds.lower);
  showBits(out << " to ", c.bounds.upper) << ", depth " << c.along << ", pixel " << c.column << " " << c.row;
}

/// `isFlat`: bounds without extent along one axis.
rc::Gen<PositionCase> anyPosition(bool isFlat) {
  return rc::gen::map(rc::gen::tuple(anyCamera(0, 0), anyPositive(-10, 10), anyPositive(-4, 22), anyFraction(),
                                     anyFraction(), anyFraction(), rc::gen::inRange(0, 3)),
                      [isFlat](const auto& parts) {
                        auto [camera, size, sizes, along, column, row, axis] = parts;
                        glm::vec3 half(0.5f * size);
                        if (isFlat) half[axis] = 0.0f;
                        camera.eye = -(sizes * size) * camera.forward;
                        camera.tanHalfFovY = sizes > 2.0f ? 1.0f / sizes : 0.5f;
                        return PositionCase{camera, {-half, half}, along, column, row};
                      });
}

void checkPositions(Backend backend, bool isFlat, const char* what) {
  Worst worst;
  checkProperty([&] {
    const auto cases = *rc::gen::container<std::vector<PositionCase>>(anyPosition(isFlat));
    std::vector<SampleProbe::Input> inputs;
    for (const PositionCase& c : cases) {
      const SampleQuantization q = quantizationFor(c.camera, c.bounds, 1.0f);
      RC_ASSERT(isUsable(q));
      const DepthRange depths = depthRangeOf(c.camera, c.bounds);
      SampleProbe::Input input{makeSampleGrid(c.camera, q), 0, 0, c.along * (depths.farDepth - depths.nearDepth),
                               0.25f};
      input.column = std::min(c.camera.width - 1, static_cast<uint32_t>(c.column * static_cast<float>(c.camera.width)));
      input.row = std::min(c.camera.height - 1, static_cast<uint32_t>(c.row * static_cast<float>(c.camera.height)));
      inputs.push_back(input);
    }
    const auto found = evaluate<SampleProbe>(backend, inputs);
    for (size_t i = 0; i < cases.size(); ++i) {
      const Camera& camera = cases[i].camera;
      const SampleProbe::Input& in = inputs[i];
      const SampleProbe::Output& out = found[i];
      RC_ASSERT(columnOf(out.packed) == in.column);
      RC_ASSERT(rowOf(out.packed) == in.row);
      const Exact behind = Exact(out.behind), depth = Exact(in.grid.pixels.nearDepth) + behind;
      const Exact edge = Exact(2) * Exact(camera.tanHalfFovY) / camera.height;
      const ExactVec across =
          ExactVec(camera.right) * ((Exact(in.column) + Exact(0.5) - Exact(camera.width) / 2) * edge) +
          ExactVec(camera.up) * ((Exact(camera.height) / 2 - in.row - Exact(0.5)) * edge);
      const ExactVec anchor = ExactVec(camera.eye) + ExactVec(camera.forward) * Exact(in.grid.pixels.nearDepth);
      const ExactVec expected = anchor + ExactVec(camera.forward) * behind + across * depth;
      const Exact scale = length(anchor) + behind + length(across) * depth;
      for (const auto& [value, truth] : {std::pair(out.onRay.x, expected.x), std::pair(out.onRay.y, expected.y),
                                         std::pair(out.onRay.z, expected.z)}) {
        const double error = roundoffs(value, truth, scale);
        RC_ASSERT(error * kUnitRoundoff <= kPositionError);
        worst.see(error);
      }
      for (int axis = 0; axis < 3; ++axis)
        RC_ASSERT(out.sphere.center[axis] ==
                  std::clamp(out.onRay[axis], in.grid.bounds.lower[axis], in.grid.bounds.upper[axis]));
    }
  });
  record({what, "100 digits", "u of the place's terms", worst.value(), kPositionError / kUnitRoundoff, backend});
}

TEST_P(Case26, PropertyPositionsLieOnTheirPixelsRays) { checkPositions(GetParam(), false, "PixelGrid::at"); }

TEST(Case26, PropertyNoRayBeginsBehindTheBoxsFrontUnlessTheEyeDoes) {
  checkProperty([] {
    const PositionCase c = *anyPosition(false);
    const Box& bounds = c.bounds;
    const DepthRange depths = depthRangeOf(c.camera, bounds);
    const PixelGrid grid = makePixelGrid(c.camera, depths.nearDepth);
    // Depth is a coordinate along axes that rounding has left not quite orthonormal.
    const glm::dmat3 fromAxes = glm::inverse(glm::dmat3(c.camera.right, c.camera.up, c.camera.forward));
    RC_ASSERT(depths.nearDepth >= 0.0f);
    RC_ASSERT(depths.farDepth >= depths.nearDepth);
    for (int corner = 0; corner < 8; ++corner) {
      const glm::dvec3 point(glm::vec3(corner & 1 ? bounds.upper.x : bounds.lower.x,
                                       corner & 2 ? bounds.upper.y : bounds.lower.y,
                                       corner & 4 ? bounds.upper.z : bounds.lower.z));
      if (depths.farDepth > 0.0f)
        RC_ASSERT((fromAxes * (point - glm::dvec3(c.camera.eye))).z <= static_cast<double>(depths.farDepth));
      // From the rounded plane itself, where rays are.
      if (depths.nearDepth > 0.0f) RC_ASSERT((fromAxes * (point - glm::dvec3(grid.anchor))).z >= 0.0);
    }
    const PixelRay ray = grid.ray(0, 0);
    RC_ASSERT(ray.ray.direction == pixelRay(c.camera, {0.5f, 0.5f}).direction);
    if (depths.nearDepth == 0.0f) RC_ASSERT(ray.ray.origin == c.camera.eye);
  });
  recordExact("depthRangeOf holds its box", "double");
}

TEST_P(Case27, CodesFollowTheFormulaAndRiseAndComeBack) {
  for (const float unit : {1.0f, 0.25f, 0x1p-60f, 0x1p40f}) {
    std::vector<std::pair<float, float>> radii;
    for (uint32_t code = 1; code <= kRadiusCodeMax; ++code) {
      const float radius = decodeRadius(code, unit);
      const long double exact =
          unit * std::exp2(static_cast<long double>(code >> 6) - 15.0L) * (1.0L + (code & 63) / 64.0L);
      ASSERT_EQ(static_cast<long double>(radius), exact) << code;
      if (code > 1) ASSERT_GT(radius, radii.back().first) << code;
      radii.emplace_back(radius, unit);
    }
    EXPECT_LT(radii.back().first, 2.0f * unit);
    const auto found = packed(GetParam(), {}, radii);
    // Down to the code: anything up to the next code's radius keeps this one.
    for (size_t i = 0; i < radii.size(); ++i)
      radii[i].first =
          std::nextafter(i + 1 < radii.size() ? decodeRadius(static_cast<uint32_t>(i) + 2, unit) : 2.0f * unit, 0.0f);
    const auto below = packed(GetParam(), {}, radii);
    for (size_t i = 0; i < radii.size(); ++i) {
      ASSERT_EQ(radiusCode(found[i].packed), i + 1);
      ASSERT_EQ(radiusCode(below[i].packed), i + 1);
    }
  }
  EXPECT_EQ(decodeRadius(0, 1.0f), 0.0f);
  recordExact("encodeRadius, decodeRadius, every code", "closed form in long double", GetParam());
}

TEST_P(Case27, PropertyRadiiAreRoundedDownByLessThanAStep) {
  Worst worst;
  checkProperty([&] {
    auto radii = *rc::gen::container<std::vector<std::pair<float, float>>>(
        rc::gen::map(rc::gen::tuple(anyPositive(-15, 0), anyInteger(-80, 80)), [](const std::tuple<float, int>& r) {
          const float unit = std::ldexp(1.0f, std::get<1>(r));
          return std::pair(std::get<0>(r) * unit, unit);
        }));
    std::sort(radii.begin(), radii.end(),
              [](const auto& a, const auto& b) { return a.first / a.second < b.first / b.second; });
    const auto found = packed(GetParam(), {}, radii);
    for (size_t i = 0; i < radii.size(); ++i) {
      const uint32_t code = radiusCode(found[i].packed);
      RC_ASSERT(code >= 1u);
      RC_ASSERT(code <= kRadiusCodeMax);
      if (i > 0) RC_ASSERT(code >= radiusCode(found[i - 1].packed));
      if (radii[i].first / radii[i].second < 0x1p-15f * (1.0f + 1.0f / 64.0f)) continue;  // below the range
      RC_ASSERT(found[i].radius <= radii[i].first);
      const double lost = 1.0 - static_cast<double>(found[i].radius) / static_cast<double>(radii[i].first);
      RC_ASSERT(lost < kRadiusCodeError);
      worst.see(lost);
    }
  });
  record({"encodeRadius, decodeRadius", "double", "of the radius, downwards", worst.value(), kRadiusCodeError,
          GetParam()});
}

TEST_P(Case27, NeverZeroForASampleWhateverItsRadius) {
  const auto codeOf = [&](float radius, float unit) {
    return radiusCode(packed(GetParam(), {}, {{radius, unit}}).front().packed);
  };
  for (const float radius : {0.0f, -0.0f, -1.0f, -kInfinity, kNan, 1e-45f, 1e-38f, 0x1p-16f, 0x1p-15f})
    EXPECT_EQ(codeOf(radius, 1.0f), 1u) << radius;
  for (const float radius : {2.0f, 3.0f, 1e10f, std::numeric_limits<float>::max(), kInfinity})
    EXPECT_EQ(codeOf(radius, 1.0f), kRadiusCodeMax) << radius;
  EXPECT_EQ(codeOf(1e30f, 0x1p-100f), kRadiusCodeMax);  // the quotient overflows
  recordExact("encodeRadius of 0, of less, of NaN, beyond the codes", "definition", GetParam());
}

TEST_P(Case28, PropertyPositionsInFlatBoundsLieOnTheirPixelsRays) {
  checkPositions(GetParam(), true, "PixelGrid::at, flat bounds");
}

TEST_P(Case28, NeverOutsideTheBoundsWhateverTheBits) {
  std::mt19937_64 random(5);
  std::vector<SampleProbe::Input> inputs;
  for (const float bad : {kNan, kInfinity, 0.0f, 1e38f, 1e-30f, 1.0f})
    for (int i = 0; i < 1000; ++i) {
      SampleProbe::Input input{};
      input.grid.pixels.anchor = glm::vec3(bad, 0.0f, -bad);
      input.grid.pixels.edge = bad;
      input.grid.pixels.nearDepth = bad;
      input.grid.depthStep = bad;
      input.grid.bounds = {{-4.0f, 2.0f, -8.0f}, {4.0f, 2.0f, 8.0f}};  // flat
      input.column = static_cast<uint32_t>(random() % 16384);
      input.row = static_cast<uint32_t>(random() % 16384);
      input.behind = static_cast<float>(random() % (1u << 26));
      input.radius = 1.0f;
      inputs.push_back(input);
    }
  const auto found = evaluate<SampleProbe>(GetParam(), inputs);
  for (size_t i = 0; i < found.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      ASSERT_TRUE(found[i].sphere.center[axis] >= inputs[i].grid.bounds.lower[axis] &&
                  found[i].sphere.center[axis] <= inputs[i].grid.bounds.upper[axis])
          << i;
  recordExact("unpackSample stays in its bounds", "definition", GetParam());
}

TEST(Case29, FramesOfNoneOneAndAllSamplesComeBack) {
  for (const auto& [width, height] : {std::pair(1u, 1u), std::pair(0u, 0u), std::pair(640u, 480u)})
    expectRoundTrips(garbageFrame(width, height, 0, 0), "none of " + std::to_string(width));
  expectRoundTrips(framedPixels(1, 1, {0}), "one pixel");
  for (const auto& [width, height] :
       {std::pair(7u, 3u), std::pair(1u, 300u), std::pair(300u, 1u), std::pair(9u, 17u), std::pair(211u, 100u)}) {
    std::vector<uint32_t> all(width * height);
    for (uint32_t i = 0; i < all.size(); ++i) all[i] = i;
    expectRoundTrips(framedPixels(width, height, all), "all of " + std::to_string(width));
    expectRoundTrips(framedPixels(width, height, {width * height - 1}), "the last of " + std::to_string(width));
  }
  recordExact("FrameCodec: frames of none, one and all samples", "identity");
}

TEST(Case29, PropertyAnyFrameComesBack) {
  checkProperty([] {
    const auto width = *rc::gen::inRange<uint32_t>(1, 200), height = *rc::gen::inRange<uint32_t>(1, 200);
    SampleFrame frame =
        garbageFrame(width, height, *rc::gen::inRange<size_t>(0, 3000), *rc::gen::arbitrary<uint32_t>());
    frame.settings.sample.radiusPolicy =
        *rc::gen::elementOf(std::vector{RadiusPolicy::voxel, RadiusPolicy::opacity, RadiusPolicy::pixel, RadiusPolicy::uncertainty});
    frame.quantization.depthStep = *anyPositive();
    frame.quantization.nearDepth = *anyPositive();
    frame.camera.eye = *anyVector();
    for (const CodecSettings& settings : {kRaw, kLossless, kJpeg}) RC_ASSERT(roundTrip(frame, settings) == "");
  });
  recordExact("FrameCodec: any bits, depth steps and eyes from 1e-30 to 1e30", "identity");
}

}  // namespace
}  // namespace warpscope
