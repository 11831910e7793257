// What arrives of lights: closed forms in uniform matter, a march in double by small steps, and pictures that change where they should and nowhere else.
// Mirrors render/effects/light_volume.h and light_volume_march.h.
#include "render/effects/light_volume_march.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "headless.h"
#include "marcher_cases.h"
#include "render/base/error.h"
#include "render/march/march_setup.h"
#include "render/march/volume_source_scalar.h"
#include "test_volumes.h"

namespace warpscope {
namespace {

/// Of a value that is found out: half a step of it, and light that is left where a march ends.
constexpr double kValueError = 0x1p-16 + LightVolumeJob::kLeastLight;
/// What steps of half a voxel add: below, 0.0076 in all, with a function that rises from 0 to 0.6 within 80 of 100 values.
constexpr double kStepError = 0.01;

Camera someCamera(uint32_t side = 96) { return lookingFrom({60.0f, 42.0f, 70.0f}, glm::vec3(0.0f), side, side); }

MarchSettings shadowedBy(std::string_view lights, float shadows, float occlusion = 0.0f) {
  MarchSettings settings;
  settings.render.effects.shading.strength = 1.0f;
  settings.render.effects.lights = parseLights(lights, "it");
  settings.render.effects.shadows.strength = shadows;
  settings.render.effects.shadows.occlusion = occlusion;
  return settings;
}

/// A light volume of voxels of 8 bits, found out here, one sample at a time.
struct Filled {
  Filled(const VolumePtr& volume, const TransferFunction& function, const RenderSettings& settings, const Camera& camera = someCamera())
      : marched(volume, function), baked(bakeTransfer(marched, settings)), view(makeVolumeView<uint8_t>(marched)) {
    view.voxels = volume->voxelsAs<uint8_t>();
    view.transfer = baked.table.lookup();
    const EffectPlan plan = planFor(marched, baked, baked.visibleCells, settings, std::nullopt);
    if (plan.has(PlanStage::skipping)) view.cells.distances = baked.emptyDistances.data();
    job = lightVolumeFor(marched, camera, settings, plan);
    values.resize(job.volume.places() * static_cast<size_t>(job.volume.channels));
    for (size_t i = 0; i < job.volume.places(); ++i) fillPlace<ScalarVolumeSource<uint8_t, false, false>>(job, view, i, values.data());
    job.volume.values = values.data();
  }
  double at(int channel, const glm::vec3& voxel) const {
    const float place[3] = {voxel.x, voxel.y, voxel.z};
    return static_cast<double>(job.volume.at(channel, place));
  }

  MarchedVolume marched;
  BakedTransfer baked;
  VolumeView<uint8_t> view;
  LightVolumeJob job;
  std::vector<uint16_t> values;
};

/// By definition, in double: steps of a 16th of a voxel from voxel coordinates `from`, in a volume of cubic voxels with its lower corner at -1/2.
double lightByDefinition(const FieldFunction& value, const glm::ivec3& dims, const TransferFunction& function, const glm::dvec3& from, const glm::dvec3& towards,
                         double length) {
  constexpr double kStep = 1.0 / 16;
  double through = 1.0;
  for (double t = 0.5 * kStep; t < length; t += kStep) {
    const glm::dvec3 p = from + t * towards;
    for (int axis = 0; axis < 3; ++axis)
      if (p[axis] < -0.5 || p[axis] > dims[axis] - 0.5) return through;
    const glm::dvec3 inside = glm::clamp(p, glm::dvec3(0.0), glm::dvec3(dims - 1));
    const glm::ivec3 low = glm::min(glm::ivec3(inside), dims - 2);
    const glm::dvec3 weight = inside - glm::dvec3(low);
    double blended = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
      const glm::ivec3 upper(corner & 1, corner >> 1 & 1, corner >> 2);
      double share = 1.0;
      for (int axis = 0; axis < 3; ++axis) share *= upper[axis] ? weight[axis] : 1.0 - weight[axis];
      blended += share * value(low + upper);
    }
    through *= std::pow(1.0 - static_cast<double>(function.at(blended).a), kStep);
  }
  return through;
}

TEST(LightVolume, LightThroughUniformMatterIsTheExponential) {
  const glm::uvec3 dims(20, 24, 16);
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, dims, [](const glm::ivec3&) { return 50.0; });
  for (const float alpha : {0.0f, 0.01f, 0.1f, 0.5f}) {
    const Filled filled(volume, everywhere(std::max(alpha, 1e-7f)), shadowedBy("world:1,0,0 point:9.5,1000,7.5 headlight", 1.0f, 1.0f).render);
    ASSERT_EQ(filled.job.volume.channels, 3);
    const double tau = -std::log(1.0 - static_cast<double>(alpha));
    for (const float x : {0.0f, 4.0f, 10.0f, 18.0f}) {
      EXPECT_NEAR(filled.at(0, {x, 10.0f, 8.0f}), std::exp(-tau * (19.5 - static_cast<double>(x))), kValueError) << alpha;
      EXPECT_NEAR(filled.at(1, {10.0f, x, 8.0f}), std::exp(-tau * (23.5 - static_cast<double>(x))), kValueError + 1e-4) << alpha << ": nearly straight up";
    }
    // A ball of radius 8 around the middle is cut by no side; the matter within it is 8 deep in every direction but along z.
    double around = 0.0;
    for (const double depth : {8.0, 8.0, 8.0, 8.0, 7.5, 8.0}) around += std::exp(-tau * depth) / 15.0;
    around += 8 * 3.0 / 40 * std::exp(-tau * 8.0);
    EXPECT_NEAR(filled.at(2, {10.0f, 12.0f, 8.0f}), around, kValueError) << alpha;
  }
}

TEST(LightVolume, PlacesAreTheDefinitionsWithinTheirBound) {
  const glm::uvec3 dims(28, 24, 26);
  const FieldFunction value = blobs(dims, 11);
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, dims, value);
  const TransferFunction function{{{10.0, glm::vec3(1.0f), 0.0f}, {90.0, glm::vec3(1.0f), 0.6f}}};
  const glm::dvec3 sun = glm::normalize(glm::dvec3(1.0, 2.0, -0.5));
  RenderSettings settings = shadowedBy("world:1,2,-0.5", 1.0f).render;
  settings.skipEmpty = false;
  const Filled filled(volume, function, settings);
  const LightVolume& grid = filled.job.volume;
  double largest = 0.0;
  for (int z = 1; z + 1 < grid.dims.z; ++z)
    for (int y = 1; y + 1 < grid.dims.y; ++y)
      for (int x = 1; x + 1 < grid.dims.x; ++x) {
        const glm::vec3 voxel = grid.edge * glm::vec3(x, y, z);
        const double truth = lightByDefinition(value, glm::ivec3(dims), function, glm::dvec3(voxel), sun, 1e9);
        largest = std::max(largest, std::abs(filled.at(0, voxel) - truth));
      }
  EXPECT_LE(largest, kValueError + kStepError);
  RecordProperty("largest", std::to_string(largest));
  EXPECT_GE(largest, 1e-4) << "or nothing was compared";
}

TEST(LightVolume, BetweenPlacesErrorsShrinkWithTheGrid) {
  const glm::uvec3 dims(28, 24, 26);
  const FieldFunction value = blobs(dims, 11);
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, dims, value);
  const TransferFunction function{{{10.0, glm::vec3(1.0f), 0.0f}, {90.0, glm::vec3(1.0f), 0.6f}}};
  const glm::dvec3 sun = glm::normalize(glm::dvec3(1.0, 2.0, -0.5));
  const auto meanError = [&](float edge) {
    RenderSettings settings = shadowedBy("world:1,2,-0.5", 1.0f).render;
    settings.effects.shadows.gridEdge = edge;
    settings.skipEmpty = false;
    const Filled filled(volume, function, settings);
    std::mt19937 random(3);
    std::uniform_real_distribution<float> place(2.0f, 22.0f);
    double sum = 0.0;
    constexpr int kPlaces = 2000;
    for (int i = 0; i < kPlaces; ++i) {
      const glm::vec3 voxel(place(random), place(random), place(random));
      sum += std::abs(filled.at(0, voxel) - lightByDefinition(value, glm::ivec3(dims), function, glm::dvec3(voxel), sun, 1e9));
    }
    return sum / kPlaces;
  };
  const double fine = meanError(1.0f), middle = meanError(2.0f), coarse = meanError(4.0f);
  EXPECT_LE(fine, 0.006);    // 0.0044
  EXPECT_LE(middle, 0.016);  // 0.0125
  EXPECT_LE(coarse, 0.045);  // 0.0351
  EXPECT_LT(fine, middle);
  EXPECT_LT(middle, coarse);
}

TEST(LightVolume, FourteenDirectionsStandForAll) {
  const glm::uvec3 dims(28, 24, 26);
  const FieldFunction value = blobs(dims, 11);
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, dims, value);
  const TransferFunction function{{{10.0, glm::vec3(1.0f), 0.0f}, {90.0, glm::vec3(1.0f), 0.6f}}};
  RenderSettings settings = shadowedBy("none", 0.0f, 1.0f).render;
  settings.skipEmpty = false;
  const Filled filled(volume, function, settings);
  double sum = 0.0, largest = 0.0;
  int places = 0;
  for (int z = 1; z < 12; z += 3)
    for (int y = 1; y < 11; y += 3)
      for (int x = 1; x < 13; x += 3) {
        const glm::vec3 voxel = filled.job.volume.edge * glm::vec3(x, y, z);
        double truth = 0.0;
        constexpr int kDirections = 300;  // a spiral over the sphere: Swinbank, Purser 2006
        for (int i = 0; i < kDirections; ++i) {
          const double height = 1.0 - (2.0 * i + 1.0) / kDirections, angle = 2.399963229728653 * i, across = std::sqrt(1.0 - height * height);
          truth += lightByDefinition(value, glm::ivec3(dims), function, glm::dvec3(voxel), {across * std::cos(angle), across * std::sin(angle), height}, 8.0) / kDirections;
        }
        const double error = std::abs(filled.at(0, voxel) - truth);
        sum += error;
        largest = std::max(largest, error);
        ++places;
      }
  RecordProperty("mean", std::to_string(sum / places));
  RecordProperty("largest", std::to_string(largest));
  EXPECT_LE(sum / places, 0.007);  // 0.0046
  EXPECT_LE(largest, 0.035);       // 0.0227
  EXPECT_GE(largest, 1e-4) << "or nothing was compared";
}

TEST(LightVolume, PlacesThatNobodySeesCastNoRays) {
  const glm::uvec3 dims(96, 96, 96);
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, dims, [](const glm::ivec3& p) { return p.x < 20 ? 200.0 : 0.0; });
  const TransferFunction function{{{90.0, glm::vec3(0.8f), 0.0f}, {110.0, glm::vec3(0.8f), 0.05f}}};
  RenderSettings settings = shadowedBy("world:-1,0,0", 1.0f).render;
  const Filled filled(volume, function, settings);
  settings.skipEmpty = false;
  const Filled whole(volume, function, settings);
  EXPECT_LT(whole.at(0, {80.0f, 40.0f, 40.0f}), 0.5) << "behind all of the matter";
  EXPECT_EQ(filled.at(0, {80.0f, 40.0f, 40.0f}), 1.0) << "not asked for";
  for (const float x : {2.0f, 10.0f, 19.0f, 21.0f}) EXPECT_EQ(filled.at(0, {x, 40.0f, 40.0f}), whole.at(0, {x, 40.0f, 40.0f}));
}

TEST(LightVolume, TakesBoundedMemory) {
  const LightVolume large = lightVolumeLayout(glm::uvec3(2048), 5, 1.0f);
  EXPECT_EQ(large.edge, 7.0f);
  EXPECT_LE(large.places() * 5 * sizeof(uint16_t), LightVolume::kMostBytes);
  const LightVolume longest = lightVolumeLayout({65536, 65536, 65536}, 5, 64.0f);
  EXPECT_LE(longest.places() * 5 * sizeof(uint16_t), LightVolume::kMostBytes);
  EXPECT_EQ(lightVolumeLayout(glm::uvec3(256), 5, 2.0f).edge, 2.0f);
  EXPECT_EQ(lightVolumeLayout({1, 1, 1}, 1, 2.0f).dims, glm::ivec3(1));
  const LightVolume covered = lightVolumeLayout({10, 11, 2}, 1, 3.0f);
  EXPECT_EQ(covered.dims, glm::ivec3(4, 5, 2)) << "the last places are not before the last voxels";
}

TEST(LightVolume, AllLightIsExactlyAll) {
  EXPECT_EQ(LightVolume::valueOf(1.0f), 32768);
  EXPECT_EQ(LightVolume::factorOf(static_cast<float>(LightVolume::valueOf(1.0f)) / LightVolume::kWhole, 0.3f), 1.0f);
  EXPECT_EQ(LightVolume::factorOf(0.0f, 1.0f), 0.0f);
}

TEST(Shadows, AtStrengthNoneChangeNoBit) {
  const Scene scene = smallScene("vessels");
  const MarcherPtr marcher = makeCpuMarcher(scene.volume, scene.transferFunction);
  const Camera camera = makeCamera(scene, scene.views.front(), 96, 96);
  const char* lights = "world:1,1,0 point:3,70,20 headlight@0.5";
  const Image<glm::vec4> lit = rendered(*marcher, camera, shadowedBy(lights, 0.0f));
  MarchSettings strange = shadowedBy(lights, 0.0f);
  strange.render.effects.shadows.gridEdge = 5.0f;
  strange.render.effects.shadows.occlusionRadius = 3.0f;
  EXPECT_TRUE(sameBits(lit, rendered(*marcher, camera, strange)));
  EXPECT_FALSE(sameBits(lit, rendered(*marcher, camera, shadowedBy(lights, 1.0f))));
  EXPECT_FALSE(sameBits(lit, rendered(*marcher, camera, shadowedBy(lights, 0.0f, 1.0f))));
  MarchSettings unlit = shadowedBy(lights, 1.0f, 1.0f);
  unlit.render.effects.shading.strength = 0.0f;
  EXPECT_TRUE(sameBits(rendered(*marcher, camera, {}), rendered(*marcher, camera, unlit)));
  EXPECT_TRUE(sameBits(rendered(*marcher, camera, shadowedBy("headlight", 0.0f)), rendered(*marcher, camera, shadowedBy("headlight", 1.0f))))
      << "the eye sees no shadow of a light that it carries";
}

TEST(Shadows, OnlyTakeLightAndNoOpacity) {
  const Scene scene = smallScene("block");
  const MarcherPtr marcher = makeCpuMarcher(scene.volume, scene.transferFunction);
  const Camera camera = makeCamera(scene, scene.views.front(), 96, 96);
  const char* lights = "world:1,1,0.3 camera:-1,2,1";
  const MarchSettings plain = shadowedBy(lights, 0.0f), shadowed = shadowedBy(lights, 0.8f, 0.7f);
  EXPECT_EQ(marcher->march(camera, plain).samples, marcher->march(camera, shadowed).samples);
  const Image<glm::vec4> before = rendered(*marcher, camera, plain), after = rendered(*marcher, camera, shadowed);
  for (size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(before[i].a, after[i].a);
    for (int c = 0; c < 3; ++c) EXPECT_LE(after[i][c], before[i][c] + 1e-6f);
  }
}

TEST(Shadows, LieBehindWhatStandsInTheLight) {
  // A plate above half of a floor; the light is straight above, the eye beside it.
  const glm::uvec3 dims(40, 40, 40);
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, dims, [](const glm::ivec3& p) {
    const bool isFloor = p.y >= 6 && p.y < 10, isPlate = p.y >= 30 && p.y < 33 && p.x < 20;
    return isFloor || isPlate ? 200.0 : 0.0;
  });
  const TransferFunction function{{{90.0, glm::vec3(0.8f), 0.0f}, {110.0, glm::vec3(0.8f), 0.9f}}};
  const MarcherPtr marcher = makeCpuMarcher(volume, function);
  const Camera camera = lookingFrom({0.0f, 12.0f, 80.0f}, glm::vec3(0.0f, -10.0f, 0.0f), 128, 128, 0.25f);
  const auto lightOnFloor = [&](const MarchSettings& settings, bool isRight) {  // the picture's lower part
    const Image<glm::vec4> image = rendered(*marcher, camera, settings);
    double sum = 0.0;
    for (uint32_t y = 60; y < 70; ++y)
      for (uint32_t x = isRight ? 80 : 20; x < (isRight ? 108u : 48u); ++x) sum += static_cast<double>(image(x, y).r);
    return sum;
  };
  for (const char* light : {"world:0,1,0", "point:19.5,4000,19.5"}) {
    MarchSettings plain = shadowedBy(light, 0.0f), shadowed = shadowedBy(light, 1.0f);
    for (MarchSettings* settings : {&plain, &shadowed}) settings->render.effects.shading.ambient = 0.0f;
    EXPECT_GT(lightOnFloor(plain, false), 1.0) << light;
    EXPECT_LT(lightOnFloor(shadowed, false), 0.1 * lightOnFloor(plain, false)) << light << ": under the plate";
    EXPECT_GT(lightOnFloor(shadowed, true), 0.9 * lightOnFloor(plain, true)) << light << ": beside it, and not in its own";
  }
}

TEST(Shadows, SkippingChangesNoBit) {
  for (const char* name : {"vessels", "shells"}) {
    const Scene scene = smallScene(name);
    const MarcherPtr marcher = makeCpuMarcher(scene.volume, scene.transferFunction);
    const Camera camera = makeCamera(scene, scene.views.front(), 96, 96);
    for (const float edge : {1.0f, 2.0f, 5.0f}) {
      MarchSettings settings = shadowedBy("world:1,1,0.3 point:3,70,20", 1.0f, 1.0f);
      settings.render.effects.shadows.gridEdge = edge;
      MarchSettings whole = settings;
      whole.render.skipEmpty = false;
      EXPECT_TRUE(sameBits(rendered(*marcher, camera, settings), rendered(*marcher, camera, whole))) << name << " " << edge;
    }
  }
}

TEST(Shadows, OfLongStepsThatArePreIntegratedSkippingChangesNoBitEither) {
  // Such steps are lit in their middle, many voxels from the ends that show something.
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, glm::uvec3(64), [](const glm::ivec3& p) { return p.z < 20 ? 60.0 : p.z < 44 ? 10.0 : 100.0; });
  const MarcherPtr marcher = makeCpuMarcher(volume, band(50.0, 120.0, 0.2f));
  const Camera camera = lookingFrom({20.0f, 14.0f, 110.0f}, glm::vec3(0.0f), 64, 64);
  for (const float step : {0.5f, 8.0f, 17.0f, 30.5f}) {
    MarchSettings settings = shadowedBy("world:0.3,0.2,1", 1.0f);
    settings.render.effects.shadows.gridEdge = 1.0f;
    settings.render.effects.preIntegration = true;
    settings.render.step = step;
    MarchSettings whole = settings;
    whole.render.skipEmpty = false;
    EXPECT_TRUE(sameBits(rendered(*marcher, camera, settings), rendered(*marcher, camera, whole))) << step;
  }
}

TEST(Shadows, WhatIsKeptIsNeverThatOfOtherSettings) {
  const Scene scene = smallScene("vessels");
  const MarcherPtr marcher = makeCpuMarcher(scene.volume, scene.transferFunction);
  const MarchSettings first = shadowedBy("world:1,1,0.3 camera:0,1,0", 1.0f, 1.0f);
  std::vector<MarchSettings> cases(11, first);
  cases[10].render.effects.preIntegration = true;
  cases[1].render.effects.lights = parseLights("world:1,1,-0.3 camera:0,1,0", "it");
  cases[2].render.effects.shadows.occlusionRadius = 4.0f;
  cases[3].render.effects.shadows.gridEdge = 3.0f;
  cases[4].render.effects.clip.planes = parseClipPlanes("0,1,0,0", "it");
  cases[5].render.effects.clip.slab.thickness = 20.0f;
  cases[6].render.step = 0.8f;
  cases[7].render.effects.lights = parseLights("point:1,1,0.3 camera:0,1,0", "it");
  cases[8].render.effects.shadows.occlusion = 0.0f;
  cases[9].render.effects.shadows.strength = 0.4f;
  for (size_t i = 0; i < cases.size(); ++i)
    for (const double angle : {0.0, 70.0}) {
      const Camera camera = makeCamera(scene, {angle, 10.0, 1.0}, 64, 64);
      rendered(*marcher, camera, first);
      EXPECT_TRUE(sameBits(rendered(*marcher, camera, cases[i]), rendered(*makeCpuMarcher(scene.volume, scene.transferFunction), camera, cases[i]))) << i;
    }
}

TEST(Shadows, RefuseWhatIsNoStrength) {
  const float kNan = std::numeric_limits<float>::quiet_NaN();
  for (const float bad : {-0.1f, 1.1f, kNan, std::numeric_limits<float>::infinity()}) {
    EXPECT_THROW(validate(shadowedBy("headlight", bad)), UsageError) << bad;
    EXPECT_THROW(validate(shadowedBy("headlight", 0.0f, bad)), UsageError) << bad;
  }
  for (const float bad : {0.0f, -1.0f, 1e9f, kNan}) {
    MarchSettings settings;
    settings.render.effects.shadows.occlusionRadius = bad;
    EXPECT_THROW(validate(settings), UsageError) << bad;
    settings = {};
    settings.render.effects.shadows.gridEdge = bad;
    EXPECT_THROW(validate(settings), UsageError) << bad;
  }
}

TEST(Shadows, ThePlanSaysWhyTheyAreInOrOut) {
  const PlannedScene scene{.cells = 100, .visibleCells = 40, .mostOpacity = 0.5f, .mostSamples = 200.0, .dims = {256, 256, 128}};
  const auto planOf = [&](const MarchSettings& settings) { return EffectPlan(scene, settings.render, std::nullopt); };
  const auto reason = [&](const MarchSettings& settings, PlanStage stage) { return planOf(settings)[stage].reason; };
  EXPECT_EQ(reason({}, PlanStage::shadows), "the strength of shadows is 0");
  MarchSettings unlit = shadowedBy("world:1,0,0", 1.0f, 1.0f);
  unlit.render.effects.shading.strength = 0.0f;
  for (const PlanStage stage : {PlanStage::shadows, PlanStage::occlusion}) EXPECT_EQ(reason(unlit, stage), "nothing is lit: shading is 0");
  EXPECT_FALSE(planOf(unlit).has(PlanStage::lightVolume));
  EXPECT_EQ(reason(shadowedBy("headlight world:1,0,0@0", 1.0f), PlanStage::shadows), "the light is at the eye, which sees none of its shadows");
  MarchSettings dark = shadowedBy("world:1,0,0", 1.0f, 1.0f);
  dark.render.effects.shading.diffuse = dark.render.effects.shading.specular = dark.render.effects.shading.ambient = 0.0f;
  EXPECT_FALSE(planOf(dark).has(PlanStage::lightVolume)) << "there is nothing to take";
  EXPECT_EQ(reason(shadowedBy("world:1,0,0 point:1,2,3", 1.0f), PlanStage::shadows), "2 lights cast them");
  EXPECT_EQ(reason(shadowedBy("world:1,0,0", 1.0f), PlanStage::lightVolume), "a place every 2 voxels, 129x129x65; kept while the camera moves");
  EXPECT_EQ(reason(shadowedBy("camera:1,0,0", 1.0f), PlanStage::lightVolume),
            "a place every 2 voxels, 129x129x65; made anew when the camera moves, since a light goes with it");
  EXPECT_TRUE(planOf(shadowedBy("none", 0.0f, 1.0f)).has(PlanStage::occlusion));
  MarchSettings slab = shadowedBy("world:1,0,0", 1.0f);
  slab.render.effects.clip.slab.thickness = 9.0f;
  EXPECT_EQ(reason(slab, PlanStage::lightVolume), "a place every 2 voxels, 129x129x65; made anew when the camera moves, since the slab goes with it");
}

}  // namespace
}  // namespace warpscope
