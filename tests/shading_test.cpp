// Gradients against their definition in double, highlights against the library's power, and what light makes of pictures: nothing but colours, and the
// right ones. Mirrors render/effects/gradient.h, shading.h and shading_setup.h.
#include "render/effects/shading.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "headless.h"
#include "marcher_cases.h"
#include "render/march/march_setup.h"
#include "test_volumes.h"
#include "view_cells.h"

namespace warpscope {
namespace {

/// At voxel coordinates `p`, along one axis, per voxel: central differences at the eight voxels around, interpolated. In double.
double slopeByDefinition(const FieldFunction& value, const glm::ivec3& dims, const glm::dvec3& p, int axis) {
  const auto clampedAt = [&](glm::ivec3 voxel) { return value(glm::clamp(voxel, glm::ivec3(0), dims - 1)); };
  const glm::dvec3 inside = glm::clamp(p, glm::dvec3(0.0), glm::dvec3(dims - 1));
  const glm::ivec3 low = glm::min(glm::ivec3(inside), glm::max(dims - 2, glm::ivec3(0)));
  const glm::dvec3 weight = inside - glm::dvec3(low);
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::ivec3 upper(corner & 1, corner >> 1 & 1, corner >> 2);
    double share = 1.0;
    for (int a = 0; a < 3; ++a) share *= upper[a] ? weight[a] : 1.0 - weight[a];
    glm::ivec3 side(0);
    side[axis] = 1;
    sum += share * 0.5 * (clampedAt(low + upper + side) - clampedAt(low + upper - side));
  }
  return sum;
}

template <bool kByCells, bool kHasHoles, class Voxel>
glm::vec3 gradientOn(const VolumeView<Voxel>& view, const Ray& ray, float t) {
  float gradient[3];
  gradientAt<kByCells, kHasHoles>(view, ray, t, gradient);
  return {gradient[0], gradient[1], gradient[2]};
}

TEST(Gradient, IsThatOfTheInterpolatedCentralDifferences) {
  std::mt19937 random(4);
  for (const glm::uvec3 dims : {glm::uvec3(7, 6, 5), glm::uvec3(2, 9, 3), glm::uvec3(1, 5, 4), glm::uvec3(3, 1, 1), glm::uvec3(1)}) {
    const FieldFunction value = [](const glm::ivec3& p) { return static_cast<double>((p.x * 31 + p.y * 17 + p.z * 53 + p.x * p.y * 7) % 101); };
    for (const VoxelType type : kAllVoxelTypes) {
      const VolumePtr volume = makeTestVolume(type, dims, value);
      const MarchedVolume marched(volume, everywhere(0.5f));
      visitVoxelType(type, [&](auto tag) {
        using Voxel = decltype(tag);
        VolumeView<Voxel> view = makeVolumeView<Voxel>(marched);
        view.voxels = volume->voxelsAs<Voxel>();
        std::uniform_real_distribution<float> place(-1.0f, 8.0f);
        for (int i = 0; i < 200; ++i) {
          const glm::vec3 p(place(random), place(random), place(random));
          const Ray ray{view.lower + (p + 0.5f) / view.voxelsPerUnit, {0.0f, 0.0f, 1.0f}};
          const glm::vec3 gradient = gradientOn<false, std::is_floating_point_v<Voxel>>(view, ray, 0.0f);
          // The ray's place is rounded; voxels of 100 values tell that apart.
          for (int axis = 0; axis < 3; ++axis)
            EXPECT_NEAR(gradient[axis], slopeByDefinition(value, glm::ivec3(dims), glm::dvec3(p), axis), 2e-3) << nameOf(type) << " axis " << axis;
        }
      });
    }
  }
}

TEST(Gradient, CellsAndVoxelsAgreeBitForBit) {
  const glm::uvec3 dims(5, 4, 6);
  const VolumePtr volume = makeTestVolume(VoxelType::uint16, dims, [](const glm::ivec3& p) { return p.x * 977 % 131 + p.y * 311 % 97 + p.z * p.x * 41; });
  const MarchedVolume marched(volume, everywhere(0.5f));
  auto voxels = makeVolumeView<uint16_t>(marched);
  voxels.voxels = volume->voxelsAs<uint16_t>();
  const ViewInCells<uint16_t> inCells(voxels);
  const VolumeView<uint16_t>& cells = inCells.view();
  std::mt19937 random(5);
  std::uniform_real_distribution<float> place(-4.0f, 4.0f);
  for (int i = 0; i < 1000; ++i) {
    const Ray ray{{place(random), place(random), place(random)}, {0.0f, 0.6f, 0.8f}};
    EXPECT_EQ((gradientOn<false, false>(voxels, ray, 0.25f)), (gradientOn<true, false>(cells, ray, 0.25f)));
  }
}

TEST(Gradient, LeavesOutWhatIsNotFinite) {
  const glm::uvec3 dims(6, 6, 6);
  const VolumePtr volume = makeTestVolume(VoxelType::float32, dims, [](const glm::ivec3& p) { return p == glm::ivec3(3, 3, 3) ? std::nan("") : 10.0 * p.x; });
  const MarchedVolume marched(volume, everywhere(0.5f));
  auto view = makeVolumeView<float>(marched);
  view.voxels = volume->voxelsAs<float>();
  std::mt19937 random(6);
  std::uniform_real_distribution<float> place(-3.0f, 3.0f);
  for (int i = 0; i < 1000; ++i) {
    const Ray ray{{place(random), place(random), place(random)}, {0.0f, 0.0f, 1.0f}};
    const glm::vec3 gradient = gradientOn<false, true>(view, ray, 0.0f);
    EXPECT_TRUE(std::isfinite(gradient.x + gradient.y + gradient.z));
    EXPECT_LE(glm::length(gradient), 40.0f);
  }
}

TEST(Shading, ReciprocalRootsAreWithinTheirBound) {
  std::mt19937 random(9);
  std::uniform_real_distribution<float> mantissa(1.0f, 4.0f);
  double worst = 0.0;
  for (int power = -100; power <= 98; power += 2)
    for (int i = 0; i < 2000; ++i) {
      const float x = std::ldexp(mantissa(random), power);
      worst = std::max(worst, std::abs(double{reciprocalRoot(x)} * std::sqrt(double{x}) - 1.0));
    }
  EXPECT_LE(worst, kReciprocalRootError);
  EXPECT_GE(worst, 0.25 * kReciprocalRootError);  // the bound says something
}

TEST(Shading, PowersOfCosinesAreTheLibrarys) {
  for (const float exponent : {1.0f, 2.5f, 20.0f, 31.0f, 32.0f, 33.0f, 200.0f, 1000.0f})
    for (int i = 0; i <= 20000; ++i) {
      const float x = static_cast<float>(i) / 20000.0f;
      EXPECT_NEAR(powerOfCosine(x, exponent), std::pow(static_cast<double>(x), static_cast<double>(exponent)), 2e-6) << x << "^" << exponent;
    }
  EXPECT_EQ(powerOfCosine(0.0f, 10.0f), 0.0f);
  EXPECT_EQ(powerOfCosine(1.0f, 10.0f), 1.0f);
  EXPECT_EQ(powerOfCosine(1e-30f, 1000.0f), 0.0f);
  EXPECT_LE(powerOfCosine(std::nextafter(1.0f, 0.0f), 1000.0f), 1.0f);
}

TEST(Shading, WhatIsNotLitHasNoLight) {
  ShadingSetup setup;
  visitLight(setup, LightVolume{}, [](auto light) { EXPECT_TRUE((std::is_same_v<decltype(light), Unlit>)); });
  setup.isLit = true;
  visitLight(setup, LightVolume{}, [](auto light) { EXPECT_TRUE((std::is_same_v<decltype(light), Lit>)); });
}

// --- Pictures.

constexpr uint32_t kSide = 96;

/// A ball of radius 12 in a volume of 40 voxels along each axis, opaque within a voxel or two.
Scene ball(const VolumeGeometry& geometry) {
  Scene scene;
  scene.volume = makeTestVolume(VoxelType::uint8, geometry, [&](const glm::ivec3& p) {
    const glm::dvec3 place = (glm::dvec3(p) - (glm::dvec3(geometry.dims) - 1.0) * 0.5) * geometry.spacing;
    return glm::clamp(100.0 + 40.0 * (12.0 - glm::length(place)), 0.0, 200.0);
  });
  scene.transferFunction = {{{80.0, glm::vec3(0.5f), 0.0f}, {120.0, glm::vec3(0.5f), 0.9f}}};
  scene.views = {{0.0, 0.0, 1.0}};
  return scene;
}
Scene ball() {
  VolumeGeometry geometry;
  geometry.dims = {40, 40, 40};
  return ball(geometry);
}

MarchSettings litBy(std::string_view lights, const Shading& shading = {.strength = 1.0f}) {
  MarchSettings settings;
  settings.render.effects.shading = shading;
  settings.render.effects.lights = parseLights(lights, "it");
  return settings;
}

Image<glm::vec4> picture(const Scene& scene, const MarchSettings& settings) {
  return rendered(*makeCpuMarcher(scene.volume, scene.transferFunction), makeCamera(scene, scene.views.front(), kSide, kSide), settings);
}

/// Where the picture's light is, in pixels from its centre: right and up.
glm::dvec2 centerOfLight(const Image<glm::vec4>& image) {
  glm::dvec2 sum(0.0);
  double weight = 0.0;
  for (uint32_t y = 0; y < image.height(); ++y)
    for (uint32_t x = 0; x < image.width(); ++x) {
      const double light = image(x, y).r;
      sum += light * glm::dvec2(x + 0.5 - 0.5 * image.width(), 0.5 * image.height() - y - 0.5);
      weight += light;
    }
  return sum / weight;
}

TEST(Shading, WithoutStrengthChangesNoBit) {
  const Scene scene = smallScene("shells");
  const Shading strange{.strength = 0.0f, .ambient = 4.0f, .diffuse = 3.0f, .specular = 2.0f, .exponent = 7.0f};
  EXPECT_TRUE(sameBits(picture(scene, {}), picture(scene, litBy("point:1,2,3@9 world:1,0,0", strange))));
}

TEST(Shading, ChangesColoursAlone) {
  for (const char* name : {"shells", "block", "vessels", "marschner-lobb"}) {
    const Scene scene = smallScene(name);
    const MarcherPtr marcher = makeCpuMarcher(scene.volume, scene.transferFunction);
    const Camera camera = makeCamera(scene, scene.views.front(), kSide, kSide);
    MarchSettings unlit = scene.march;
    unlit.render.effects = {};
    MarchSettings lit = unlit;
    lit.render.effects.shading.strength = 1.0f;
    const SampleFrame a = marcher->march(camera, unlit), b = marcher->march(camera, lit);
    EXPECT_EQ(a.samples, b.samples) << name;
    EXPECT_NE(a.colors, b.colors) << name;
    const Image<glm::vec4> before = rendered(*marcher, camera, unlit), after = rendered(*marcher, camera, lit);
    for (size_t i = 0; i < before.size(); ++i) EXPECT_EQ(before[i].a, after[i].a);
  }
}

TEST(Shading, ABallIsBrightWhereTheLightIs) {
  const Shading matt{.strength = 1.0f, .ambient = 0.0f, .diffuse = 1.0f, .specular = 0.0f};
  const auto at = [&](const char* light) { return centerOfLight(picture(ball(), litBy(light, matt))); };
  // Two-sided: what faces away from a light at the side is as bright as what faces it, but the eye sees both halves alike only from the front.
  EXPECT_NEAR(glm::length(at("headlight")), 0.0, 0.2);
  const glm::dvec2 fromAbove = at("camera:0,1,1"), fromRight = at("camera:1,0,1");
  EXPECT_NEAR(fromAbove.x, 0.0, 0.2);
  EXPECT_GT(fromAbove.y, 1.0);
  EXPECT_GT(fromRight.x, 1.0);
  EXPECT_NEAR(fromRight.y, 0.0, 0.2);
  const glm::dvec2 world = at("world:1,0,1"), point = at("point:1e6,0,1e6");  // the camera looks along -z, so the world's axes are its own
  EXPECT_NEAR(glm::distance(world, fromRight), 0.0, 1e-3);
  EXPECT_NEAR(glm::distance(point, fromRight), 0.0, 1e-2);
  EXPECT_GT(at("point:40,20,40").x, 0.5) << "the volume's corner is at the world's origin";
}

TEST(Shading, LightsOfTheWorldStayWhereTheyAre) {
  Scene scene = ball();
  const Shading matt{.strength = 1.0f, .ambient = 0.0f, .diffuse = 1.0f, .specular = 0.0f};
  const auto from = [&](double angleDeg, const char* light) {
    scene.views = {{angleDeg, 0.0, 1.0}};
    return centerOfLight(picture(scene, litBy(light, matt)));
  };
  EXPECT_NEAR(glm::distance(from(40.0, "camera:0.3,0,1"), from(0.0, "camera:0.3,0,1")), 0.0, 0.2);
  EXPECT_LT(from(40.0, "world:0,0,1").x, -1.0) << "the camera has gone to the right";
  EXPECT_NEAR(from(0.0, "world:0,0,1").x, 0.0, 0.2);
}

TEST(Shading, VolumesThatAreTurnedMirroredOrStretchedAreLitInTheWorld) {
  const Shading matt{.strength = 1.0f, .ambient = 0.0f, .diffuse = 1.0f, .specular = 0.0f};
  VolumeGeometry turned;
  turned.dims = {40, 40, 40};
  turned.direction = glm::dmat3(glm::dvec3(0, 1, 0), glm::dvec3(-1, 0, 0), glm::dvec3(0, 0, 1));
  VolumeGeometry mirrored = turned;
  mirrored.direction = glm::dmat3(glm::dvec3(-1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1));
  VolumeGeometry stretched = turned;
  stretched.direction = glm::dmat3(1.0);
  stretched.spacing = {1.0, 2.0, 0.8};
  stretched.dims = {40, 20, 50};
  const glm::dvec2 plain = centerOfLight(picture(ball(), litBy("world:1,0.5,1", matt)));
  for (const VolumeGeometry& geometry : {turned, mirrored}) EXPECT_NEAR(glm::distance(centerOfLight(picture(ball(geometry), litBy("world:1,0.5,1", matt))), plain), 0.0, 0.3);
  const glm::dvec2 other = centerOfLight(picture(ball(stretched), litBy("world:1,0.5,1", matt)));
  EXPECT_NEAR(glm::dot(glm::normalize(other), glm::normalize(plain)), 1.0, 0.02) << "gradients are those of the world, not of voxels";
}

TEST(Shading, HighlightsAreWhiteAndAddUp) {
  const Scene scene = ball();
  const Shading dull{.strength = 1.0f, .specular = 0.0f}, shiny{.strength = 1.0f, .specular = 0.5f, .exponent = 50.0f};
  const Image<glm::vec4> without = picture(scene, litBy("headlight", dull)), with = picture(scene, litBy("headlight", shiny));
  const glm::vec4 before = without(kSide / 2, kSide / 2), after = with(kSide / 2, kSide / 2);
  EXPECT_NEAR(after.r - before.r, 0.5f * after.a, 0.05f) << "in the middle the surface faces the eye";
  const Image<glm::vec4> twice = picture(scene, litBy("headlight headlight", shiny)), strong = picture(scene, litBy("headlight@2", shiny));
  for (size_t i = 0; i < twice.size(); ++i) EXPECT_NEAR(glm::distance(twice[i], strong[i]), 0.0f, 1e-6f);
}

TEST(Shading, HalfIsBetweenUnlitAndLit) {
  const Scene scene = ball();
  const Image<glm::vec4> unlit = picture(scene, {}), lit = picture(scene, litBy("headlight")),
                         half = picture(scene, litBy("headlight", {.strength = 0.5f}));
  for (size_t i = 0; i < half.size(); ++i) EXPECT_NEAR(glm::distance(half[i], 0.5f * (unlit[i] + lit[i])), 0.0f, 1e-6f);
}

TEST(Shading, RoundingOfAConstantIsNoSurface) {
  // 100.5 as whole numbers; spacing makes no difference.
  for (const glm::dvec3 spacing : {glm::dvec3(1.0), glm::dvec3(0.5, 1.0, 3.0)}) {
    VolumeGeometry geometry;
    geometry.dims = {20, 20, 20};
    geometry.spacing = spacing;
    Scene scene;
    std::mt19937 random(7);
    scene.volume = makeTestVolume(VoxelType::uint8, geometry, [&](const glm::ivec3&) { return 100.0 + static_cast<double>(random() & 1); });
    scene.transferFunction = everywhere(0.3f);
    scene.views = {{30.0, 20.0, 1.0}};
    EXPECT_TRUE(sameBits(picture(scene, {}), picture(scene, litBy("camera:1,1,1"))));
  }
}

TEST(Shading, ALightInTheMiddleOfMatterIsNoTrouble) {
  Scene scene = ball();
  const glm::dvec3 center = glm::dvec3(39.0) * 0.5;
  for (const std::string& light : {"point:" + std::to_string(center.x) + ",19.5,19.5", std::string("point:19,20,31")}) {
    const Image<glm::vec4> image = picture(scene, litBy(light));
    EXPECT_GT(largestAlpha(image), 0.9f) << "and no component is infinite";
  }
  EXPECT_TRUE(std::isfinite(largestAlpha(picture(scene, litBy("point:1e12,-1e12,1e12")))));
}

TEST(Shading, ALightSoFarAwayThatNoSquareHoldsItIsFromOneDirection) {
  Scene scene = ball();
  VolumeGeometry tiny = scene.volume->geometry();
  tiny.spacing = glm::dvec3(1e-9);
  const uint8_t* const voxels = scene.volume->voxelsAs<uint8_t>();
  const VolumePtr whole = scene.volume;
  scene.volume = makeTestVolume(VoxelType::uint8, tiny, [&](const glm::ivec3& p) { return voxels[(static_cast<size_t>(p.z) * 40 + static_cast<size_t>(p.y)) * 40 + static_cast<size_t>(p.x)]; });
  const Image<glm::vec4> far = picture(scene, litBy("point:1e11,0,0")), fromThere = picture(scene, litBy("world:1,0,0"));
  ASSERT_GT(largestAlpha(fromThere), 0.9f);
  for (size_t i = 0; i < far.size(); ++i) EXPECT_LT(glm::distance(far[i], fromThere[i]), 1e-4f);
}

TEST(Shading, HugeAndTinyValuesAreLitLikeOthers) {
  const Scene plain = ball();
  const Image<glm::vec4> expected = picture(plain, litBy("camera:1,0,1"));
  for (const double factor : {1e-30, 1e30}) {
    Scene scene = plain;
    const uint8_t* const voxels = plain.volume->voxelsAs<uint8_t>();
    scene.volume = makeTestVolume(VoxelType::float32, plain.volume->geometry(),
                                  [&](const glm::ivec3& p) { return factor * voxels[(static_cast<size_t>(p.z) * 40 + static_cast<size_t>(p.y)) * 40 + static_cast<size_t>(p.x)]; });
    for (TransferPoint& point : scene.transferFunction.points) point.value *= factor;
    const Image<glm::vec4> image = picture(scene, litBy("camera:1,0,1"));
    for (size_t i = 0; i < image.size(); ++i) EXPECT_NEAR(glm::distance(image[i], expected[i]), 0.0f, 0.02f) << factor;
  }
}

// --- Lights as text.

std::string refusal(const std::string& text) {
  try {
    parseLights(text, "--lights");
  } catch (const UsageError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Lights, ComeBackAsTheyAreWritten) {
  for (const char* text : {"headlight", "none", "headlight@0.25 camera:-1,1,0.5", "world:0,0,-3@16 point:1e+10,-2.5,0 headlight camera:0,1,0"}) {
    EXPECT_EQ(textOf(parseLights(text, "it")), text);
    EXPECT_EQ(parseLights(textOf(parseLights(text, "it")), "it"), parseLights(text, "it"));
  }
  EXPECT_EQ(textOf(defaultLights()), "headlight");
  EXPECT_EQ(parseLights("  headlight ; world:1,0,0 ", "it").size(), 2u);
  EXPECT_EQ(parseLights("", "it").size(), 0u);
}

TEST(Lights, WhatIsWrongIsSaid) {
  EXPECT_THAT(refusal("hedlight"), testing::HasSubstr("did you mean 'headlight'?"));
  EXPECT_EQ(refusal("world:0,0,0"), "--lights: 'world:0,0,0': a direction must not be a zero vector");
  EXPECT_THAT(refusal("world:nan,0,1"), testing::HasSubstr("each number"));
  EXPECT_THAT(refusal("world:inf,0,1"), testing::HasSubstr("each number"));
  EXPECT_THAT(refusal("camera:1,1"), testing::HasSubstr("wants 3 numbers with commas between them, not 2"));
  EXPECT_THAT(refusal("camera"), testing::HasSubstr("wants three numbers, camera:X,Y,Z"));
  EXPECT_THAT(refusal("headlight:1,0,0"), testing::HasSubstr("has no direction"));
  EXPECT_THAT(refusal("headlight@-1"), testing::HasSubstr("the strength must be between 0 and 16, not -1"));
  EXPECT_THAT(refusal("headlight@nan"), testing::HasSubstr("the strength"));
  EXPECT_EQ(refusal("headlight headlight headlight headlight headlight"), "--lights: at most 4 lights are possible");
  EXPECT_LT(refusal("world:" + std::string(100000, '1')).size(), 300u);
}

}  // namespace
}  // namespace warpscope
