// What is cut off is gone and the rest is as it was: planes, boxes and slabs against volumes of which that part is made empty.
// Mirrors render/effects/clip.h and clip_settings.h.
#include "render/effects/clip.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "headless.h"
#include "marcher_cases.h"
#include "render/base/error.h"
#include "test_volumes.h"

namespace warpscope {
namespace {

MarchSettings cutBy(std::string_view planes, std::string_view box = "none", const Slab& slab = {}) {
  MarchSettings settings;
  settings.render.effects.clip = {parseClipPlanes(planes, "it"), parseClipBox(box, "it"), slab};
  return settings;
}

/// The opacity of a homogeneous body, which tells how much of each ray is left.
double lengthSeen(float opacity, float perUnit) { return std::log1p(-static_cast<double>(opacity)) / std::log1p(-static_cast<double>(perUnit)); }

constexpr float kAlpha = 0.01f;

struct Body {
  explicit Body(VolumeGeometry geometry = cube()) : volume(makeTestVolume(VoxelType::uint8, geometry, [](const glm::ivec3&) { return 9.0; })) {}
  static VolumeGeometry cube() {
    VolumeGeometry geometry;
    geometry.dims = {20, 20, 20};
    return geometry;
  }
  Image<glm::vec4> picture(const Camera& camera, const MarchSettings& settings) const {
    MarchSettings whole = settings;
    whole.render.terminateEarly = false;
    return rendered(*makeCpuMarcher(volume, everywhere(kAlpha)), camera, whole);
  }
  VolumePtr volume;
};

TEST(Clip, APlaneLeavesWhatIsInFrontOfIt) {
  const Body body;
  const Camera camera = lookingFrom({0.0f, 0.0f, 60.0f}, glm::vec3(0.0f), 41, 41, 0.25f);
  // The camera looks along -z through the middle: 20 units of the body, of which the plane leaves those of z >= 4.
  EXPECT_NEAR(lengthSeen(body.picture(camera, {})(20, 20).a, kAlpha), 20.0, 1e-3);
  EXPECT_NEAR(lengthSeen(body.picture(camera, cutBy("0,0,1,4"))(20, 20).a, kAlpha), 6.0, 1e-3);
  EXPECT_NEAR(lengthSeen(body.picture(camera, cutBy("0,0,-5,4"))(20, 20).a, kAlpha), 6.0, 1e-3) << "its normal's length does not matter";
  EXPECT_NEAR(lengthSeen(body.picture(camera, cutBy("0,0,1,-3 0,0,-1,-2"))(20, 20).a, kAlpha), 5.0, 1e-3);
  EXPECT_EQ(body.picture(camera, cutBy("0,0,1,3 0,0,-1,-2"))(20, 20).a, 0.0f) << "nothing is in front of both";
  EXPECT_EQ(body.picture(camera, cutBy("0,0,1,10.5"))(20, 20).a, 0.0f);
  EXPECT_NEAR(lengthSeen(body.picture(camera, cutBy("0,1,1,0"))(20, 20).a, kAlpha), 10.0, 1e-3) << "slanted";
}

TEST(Clip, PlanesAreTheWorlds) {
  VolumeGeometry geometry = Body::cube();
  geometry.spacing = {2.0, 2.0, 2.0};  // a unit of volume space is 2 of the world's
  geometry.direction = glm::dmat3(glm::dvec3(0, 1, 0), glm::dvec3(-1, 0, 0), glm::dvec3(0, 0, 1));
  geometry.origin = {100.0, -50.0, 3.0};
  const Body body(geometry);
  const Camera alongX = lookingFrom({60.0f, 0.0f, 0.0f}, glm::vec3(0.0f), 41, 41, 0.25f);  // the grid's x is the world's y
  EXPECT_NEAR(lengthSeen(body.picture(alongX, cutBy("0,1,0,8"))(20, 20).a, kAlpha), 6.0, 1e-3);
}

TEST(Clip, ABoxIsAPartOfTheVolume) {
  const Body body;
  const Camera camera = lookingFrom({0.0f, 0.0f, 60.0f}, glm::vec3(0.0f), 41, 41, 0.25f);
  EXPECT_NEAR(lengthSeen(body.picture(camera, cutBy("none", "0,0,0.25,1,1,0.5"))(20, 20).a, kAlpha), 5.0, 1e-3);
  EXPECT_EQ(body.picture(camera, cutBy("none", "0.6,0,0,1,1,1"))(20, 20).a, 0.0f);
  EXPECT_TRUE(sameBits(body.picture(camera, cutBy("none", "0,0,0,1,1,1")), body.picture(camera, {})));
}

TEST(Clip, ASlabGoesWithTheCamera) {
  const Body body;
  for (const glm::vec3 eye : {glm::vec3(0.0f, 0.0f, 60.0f), glm::vec3(40.0f, 30.0f, 20.0f)}) {
    const Camera camera = lookingFrom(eye, glm::vec3(0.0f), 41, 41, 0.25f);
    EXPECT_NEAR(lengthSeen(body.picture(camera, cutBy("none", "none", {.thickness = 3.0f}))(20, 20).a, kAlpha), 3.0, 1e-3);
    EXPECT_EQ(body.picture(camera, cutBy("none", "none", {.thickness = 3.0f, .depth = 30.0f}))(20, 20).a, 0.0f);
  }
  const Camera camera = lookingFrom({0.0f, 0.0f, 60.0f}, glm::vec3(0.0f), 41, 41, 0.25f);
  EXPECT_NEAR(lengthSeen(body.picture(camera, cutBy("none", "none", {.thickness = 4.0f, .depth = 9.0f}))(20, 20).a, kAlpha), 3.0, 1e-3) << "behind the centre";
}

TEST(Clip, WhatCutsNothingChangesNoBit) {
  const Scene scene = smallScene("shells");
  const MarcherPtr marcher = makeCpuMarcher(scene.volume, scene.transferFunction);
  const Camera camera = makeCamera(scene, scene.views.front(), 80, 70);
  const Image<glm::vec4> whole = rendered(*marcher, camera);
  EXPECT_TRUE(sameBits(whole, rendered(*marcher, camera, cutBy("1,2,3,-1000 0,-1,0,-24.5"))));
  EXPECT_TRUE(sameBits(whole, rendered(*marcher, camera, cutBy("none", "none", {.thickness = 0.0f, .depth = 7.0f}))));
  EXPECT_TRUE(sameBits(whole, rendered(*marcher, camera, cutBy("none", "none", {.thickness = 1e6f}))));
}

/// What is left of each ray is what lies in front of all planes: by the definition, in double, point by point.
TEST(Clip, RaysAreCutWhereThePlanesAre) {
  std::mt19937 random(8);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  const auto direction = [&] { return glm::normalize(glm::vec3(unit(random), unit(random), unit(random)) + glm::vec3(0.0f, 0.0f, 1e-3f)); };
  for (int i = 0; i < 2000; ++i) {
    ClipSetup setup;
    for (setup.count = 0; setup.count < 3; ++setup.count) setup.planes[setup.count] = {direction(), 5.0f * unit(random)};
    const Ray ray{10.0f * direction(), direction()};
    const RayInterval interval = clipped(setup, ray, {0.0f, 40.0f});
    for (int step = 0; step <= 400; ++step) {
      const double t = 0.1 * step;
      const glm::dvec3 place = glm::dvec3(ray.origin) + t * glm::dvec3(ray.direction);
      double least = 1e300;  // height above the planes; what is within rounding of one is not asked
      for (int p = 0; p < setup.count; ++p) least = std::min(least, glm::dot(glm::dvec3(setup.planes[p].normal), place) - double{setup.planes[p].offset});
      if (std::abs(least) < 1e-3) continue;
      EXPECT_EQ(t >= double{interval.tNear} && t <= double{interval.tFar}, least > 0.0) << i << " at " << t;
    }
  }
}

TEST(Clip, TextsComeBackAndWhatIsWrongIsSaid) {
  for (const char* text : {"none", "1,0,0,-5", "0.5,-1,1e+10,3 0,0,1,0"}) EXPECT_EQ(textOf(parseClipPlanes(text, "it")), text);
  for (const char* text : {"none", "0,0,0,1,1,0.5"}) EXPECT_EQ(textOf(parseClipBox(text, "it")), text);
  const auto refusal = [](const auto& parse, const std::string& text) -> std::string {
    try {
      parse(text, "--it");
    } catch (const UsageError& error) {
      return error.what();
    }
    return "accepted";
  };
  std::string hundred;
  for (int i = 0; i < 100; ++i) hundred += "1,0,0," + std::to_string(i) + " ";
  EXPECT_EQ(refusal(parseClipPlanes, hundred), "--it: at most 6 planes are possible");
  EXPECT_EQ(refusal(parseClipPlanes, "0,0,0,1"), "--it: '0,0,0,1': a plane's normal must not be a zero vector");
  EXPECT_THAT(refusal(parseClipPlanes, "nan,0,1,1"), testing::HasSubstr("each number"));
  EXPECT_THAT(refusal(parseClipPlanes, "1,0,1"), testing::HasSubstr("wants 4 numbers with commas between them, not 3"));
  EXPECT_THAT(refusal(parseClipBox, "0,0,0,1,1,2"), testing::HasSubstr("must be between 0 and 1"));
  EXPECT_THAT(refusal(parseClipBox, "0,0.5,0,1,0.5,1"), testing::HasSubstr("the box is empty"));
  EXPECT_THAT(refusal(parseClipBox, "0,0,0,1,1,1 0,0,0,1,1,1"), testing::HasSubstr("wants one box"));
}

}  // namespace
}  // namespace warpscope
