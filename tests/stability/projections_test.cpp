// Rays of pixels and projections: case 51 and the bounds of both. Truth: 100 decimal digits, of the camera's axes as
// they are. Mirrors render/core/camera.h.
#include "render/core/camera.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "tests/stability/backends.h"
#include "tests/stability/device_probe.h"
#include "tests/stability/exact.h"
#include "tests/stability/magnitudes.h"
#include "tests/stability/probes.h"
#include "tests/stability/record.h"

namespace warpscope {
namespace {

struct PixelCase {
  Camera camera;
  glm::vec2 pixel;
};
void showValue(const PixelCase& c, std::ostream& out) {
  showValue(c.camera, out);
  out << ", pixel " << c.pixel.x << " " << c.pixel.y;
}
rc::Gen<PixelCase> anyPixel(int least, int most) {
  return rc::gen::map(rc::gen::tuple(anyCamera(least, most), anyFraction(), anyFraction()), [](const auto& parts) {
    const Camera& camera = std::get<0>(parts);
    return PixelCase{camera,
                     {std::get<1>(parts) * static_cast<float>(camera.width),
                      std::get<2>(parts) * static_cast<float>(camera.height)}};
  });
}

/// In 100 digits, of the axes as they are.
ExactVec exactDirection(const Camera& camera, const glm::vec2& pixel) {
  const Exact edge = 2 * Exact(camera.tanHalfFovY) / camera.height;
  const ExactVec v = ExactVec(camera.forward) +
                     ExactVec(camera.right) * ((Exact(pixel.x) - Exact(camera.width) / 2) * edge) +
                     ExactVec(camera.up) * ((Exact(camera.height) / 2 - Exact(pixel.y)) * edge);
  return v * (1 / length(v));
}

TEST_P(Case51, PropertyRaysAreWithinTheirBound) {
  Worst worst, ofLength;
  checkProperty([&] {
    const auto cases = *rc::gen::container<std::vector<PixelCase>>(anyPixel(kLeastExponent, kLargestExponent));
    std::vector<PixelRayProbe::Input> inputs;
    for (const PixelCase& c : cases) inputs.push_back({c.camera, c.pixel});
    const auto found = evaluate<PixelRayProbe>(GetParam(), inputs);
    for (size_t i = 0; i < cases.size(); ++i) {
      RC_ASSERT(found[i].origin == cases[i].camera.eye);
      const ExactVec truth = exactDirection(cases[i].camera, cases[i].pixel);
      const ExactVec direction(found[i].direction);
      for (const Exact& off : {direction.x - truth.x, direction.y - truth.y, direction.z - truth.z}) {
        const double error = roundoffs(off, 0, 1);
        RC_ASSERT(error * kUnitRoundoff <= kRayDirectionError);
        worst.see(error);
      }
      const double lengthError = roundoffs(length(direction), 1, 1);
      RC_ASSERT(lengthError * kUnitRoundoff <= kRayDirectionError);
      ofLength.see(lengthError);
    }
  });
  record({"pixelRay, components of the direction", "100 digits", "u", worst.value(), kRayDirectionError / kUnitRoundoff,
          GetParam()});
  record({"pixelRay, length of the direction", "100 digits", "u", ofLength.value(), kRayDirectionError / kUnitRoundoff,
          GetParam()});
}

TEST_P(Case51, PropertyProjectionsAreWithinTheirBound) {
  Worst ofDepth, ofPixel, ofClip;
  checkProperty([&] {
    std::vector<ProjectProbe::Input> inputs;
    for (const auto& [c, away] : *rc::gen::container<std::vector<std::pair<PixelCase, float>>>(
             rc::gen::pair(anyPixel(-10, 20), anyPositive(-10, 20)))) {
      const ExactVec direction = exactDirection(c.camera, c.pixel);
      const Exact distance(away);
      const auto at = [&](const Exact& eye, const Exact& d) { return static_cast<float>(eye + d * distance); };
      const ExactVec eye(c.camera.eye);
      inputs.push_back({c.camera, {at(eye.x, direction.x), at(eye.y, direction.y), at(eye.z, direction.z)}, 1e-3f});
    }
    const auto found = evaluate<ProjectProbe>(GetParam(), inputs);
    for (size_t i = 0; i < inputs.size(); ++i) {
      const Camera& camera = inputs[i].camera;
      const ExactVec offset = ExactVec(inputs[i].point) - ExactVec(camera.eye);
      const Exact distance = length(offset), z = dot(offset, ExactVec(camera.forward)),
                  edge = 2 * Exact(camera.tanHalfFovY) / camera.height;
      const Projection& projection = found[i].projection;
      if (distance == 0) continue;
      const double depthError = roundoffs(projection.forwardDepth, z, distance);
      RC_ASSERT(depthError * kUnitRoundoff <= kForwardDepthError);
      ofDepth.see(depthError);
      const Exact across[2] = {dot(offset, ExactVec(camera.right)), dot(offset, ExactVec(camera.up))};
      // Clip coordinates, whatever side of the eye.
      const Exact reach = length(ExactVec(camera.eye)) + length(ExactVec(inputs[i].point)),
                  scaleY = 1 / Exact(camera.tanHalfFovY);
      const Exact scaleX = scaleY * camera.height / camera.width;
      for (const auto& [value, truth, scale] :
           {std::tuple(found[i].clip.x, Exact(scaleX * across[0]), scaleX),
            std::tuple(found[i].clip.y, Exact(scaleY * across[1]), scaleY), std::tuple(found[i].clip.w, z, Exact(1))}) {
        const double error = roundoffs(value, truth, scale * reach);
        RC_ASSERT(error * kUnitRoundoff <= kClipError);
        ofClip.see(error);
      }
      RC_ASSERT(found[i].clip.z == 1e-3f);
      // Where the depth is known at all.
      if (z < distance * Exact(0x1p-12)) continue;
      const Exact sizes[2] = {Exact(camera.width), Exact(camera.height)};
      for (int axis = 0; axis < 2; ++axis) {
        const Exact q = across[axis] / (z * edge), truth = sizes[axis] / 2 + (axis == 0 ? q : Exact(-q));
        const Exact scale = distance / z * (1 / edge + abs(q)),
                    rounded = abs(Exact(projection.pixel[axis]) - truth) - sizes[axis] * Exact(kUnitRoundoff);
        const double error = rounded <= 0 ? 0.0 : static_cast<double>(rounded / (scale * Exact(kUnitRoundoff)));
        RC_ASSERT(error * kUnitRoundoff <= kProjectError);
        ofPixel.see(error);
      }
    }
  });
  record({"project, forward depth", "100 digits", "u of the distance", ofDepth.value(),
          kForwardDepthError / kUnitRoundoff, GetParam()});
  record({"project, the pixel", "100 digits", "u of (d / z) (1 / e + q)", ofPixel.value(),
          kProjectError / kUnitRoundoff, GetParam()});
  record({"clipFromVolume", "100 digits", "u of eye's and point's distances", ofClip.value(),
          kClipError / kUnitRoundoff, GetParam()});
}

TEST_P(Case51, PropertyProjectionIsTheInverseOfRays) {
  checkProperty([&] {
    const PixelCase c = *anyPixel(-10, 7);
    const float t = *anyPositive(-3, 12);
    const Ray ray = evaluate<PixelRayProbe>(GetParam(), PixelRayProbe::Input{c.camera, c.pixel});
    const Projection back =
        evaluate<ProjectProbe>(GetParam(), ProjectProbe::Input{c.camera, ray.at(t), 1e-3f}).projection;
    const double cosine = glm::dot(glm::dvec3(ray.direction), glm::dvec3(c.camera.forward)),
                 edge = static_cast<double>(pixelEdge(c.camera));
    // The point is rounded; then both bounds, of axes that are orthogonal up to a u.
    const double pointError =
        3.0 * kUnitRoundoff * (static_cast<double>(glm::length(c.camera.eye)) + 2.0 * static_cast<double>(t));
    const double q = std::max(static_cast<double>(c.camera.width), static_cast<double>(c.camera.height));
    const double errorPx = (pointError / static_cast<double>(t) + 2.0 * kRayDirectionError + kProjectError) / cosine *
                               (1.0 / edge + q) / cosine +
                           2.0 * kUnitRoundoff * q;
    RC_ASSERT(static_cast<double>(std::abs(back.pixel.x - c.pixel.x)) <= errorPx);
    RC_ASSERT(static_cast<double>(std::abs(back.pixel.y - c.pixel.y)) <= errorPx);
  });
  recordExact("project of pixelRay is the pixel, within both bounds", "itself", GetParam());
}

TEST(Case51, ReverseDepthTellsAThousandStepsApartAtDepthAThousand) {
  Camera camera;
  camera.eye = glm::vec3(0.0f);
  camera.width = camera.height = 1;
  const glm::mat4 clip = clipFromVolume(camera, 1e-3f);
  std::set<float> depths;
  float before = 2.0f;
  for (int i = 0; i < 1000; ++i) {
    const glm::vec4 place = clip * glm::vec4(0.0f, 0.0f, -(1000.0f + static_cast<float>(i) * 1e-3f), 1.0f);
    const float depth = place.z / place.w;
    EXPECT_LT(depth, before);  // farther is less
    before = depth;
    depths.insert(depth);
  }
  EXPECT_EQ(depths.size(), 1000u);
  const auto depthAt = [&](float z) {
    const glm::vec4 place = clip * glm::vec4(0.0f, 0.0f, -z, 1.0f);
    return place.z / place.w;
  };
  EXPECT_FLOAT_EQ(depthAt(1e-3f), 1.0f);
  EXPECT_GT(depthAt(1e5f), 0.0f);
  EXPECT_GT(depthAt(99999.0f), depthAt(1e5f));
  recordExact("clipFromVolume, 1000 depths a thousandth apart at 1000", "definition");
}

}  // namespace
}  // namespace warpscope
