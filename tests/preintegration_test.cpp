// Marches whose steps are classified by the values at their ends: as good at a step of 1 voxel as without at a quarter, the same whatever is left out.
// Mirrors render/effects/segment_batch_source.h.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "app/scene/scene.h"
#include "headless.h"
#include "marcher_cases.h"
#include "real_data.h"
#include "render/base/error.h"
#include "test_volumes.h"

namespace warpscope {
namespace {

using testing::HasSubstr;

RenderSettings preIntegrated(RenderSettings settings, float step) {
  settings.effects.preIntegration = true;
  settings.step = step;
  return settings;
}

double rootMeanSquare(const Image<glm::vec4>& a, const Image<glm::vec4>& b) {
  double sum = 0.0;
  for (size_t i = 0; i < a.size(); ++i)
    for (int channel = 0; channel < 4; ++channel) sum += std::pow(static_cast<double>(a.data()[i][channel]) - b.data()[i][channel], 2);
  return std::sqrt(sum / static_cast<double>(4 * a.size()));
}

/// Pictures of a scene, and how far from one of a step of 0.02 they are.
class Pictures {
 public:
  Pictures(const Scene& scene, uint32_t side)
      : marcher_(makeCpuMarcher(scene.volume, scene.transferFunction)), camera_(makeCamera(scene, scene.views.front(), side, side)), settings_(scene.march.render) {
    settings_.contribution = 1e-5f;
    truth_ = picture(0.02f, false);
  }
  double errorOf(float step, bool isPreIntegrated) const { return rootMeanSquare(picture(step, isPreIntegrated), truth_); }

 private:
  Image<glm::vec4> picture(float step, bool isPreIntegrated) const {
    RenderSettings settings = settings_;
    settings.step = step;
    settings.effects.preIntegration = isPreIntegrated;
    Image<glm::vec4> image;
    marcher_->render(camera_, settings, image);
    return image;
  }

  MarcherPtr marcher_;
  Camera camera_;
  RenderSettings settings_;
  Image<glm::vec4> truth_;
};

/// Sees three thin shells of values alone.
Scene withThinShells(Scene scene) {
  const VoxelStatistics& statistics = scene.volume->statistics();
  const auto at = [&](double share) { return std::lerp(statistics.rangeLower, statistics.rangeUpper, share); };
  const glm::vec3 color(1.0f, 0.6f, 0.2f);
  scene.transferFunction = {};
  for (const double share : {0.2, 0.45, 0.7})
    for (const auto& [beyond, alpha] : {std::pair(0.0, 0.0f), std::pair(0.01, 0.5f), std::pair(0.02, 0.0f)})
      scene.transferFunction.points.push_back({at(share + beyond), color, alpha});
  return scene;
}

TEST(PreIntegration, OfThinShellsAStepOfOneIsAsGoodAsAQuarterWithout) {
  // Values of the other scenes change within a voxel by as much as from one to the next: what is between both ends of a step is not on the way.
  for (const char* name : {"vessels", "block"}) {
    const Pictures pictures(withThinShells(smallScene(name, 128)), 160);
    const double with = pictures.errorOf(1.0f, true), without = pictures.errorOf(0.25f, false);
    EXPECT_LE(with, without) << name;
  }
}

TEST(PreIntegration, OfThinShellsInRealVolumesToo) {
  for (const char* name : {"engine_256x256x128_uint8.raw", "spm152.nii.gz"}) {
    const RealData file(name);
    if (!file.whyMissing().empty()) GTEST_SKIP() << file.whyMissing();
    const Pictures pictures(withThinShells(openScene(file.path().string(), {}, {})), 160);
    const double with = pictures.errorOf(1.0f, true), without = pictures.errorOf(0.25f, false);
    EXPECT_LE(with, without) << name;
  }
}

TEST(PreIntegration, ShorterStepsComeToWhatIsThere) {
  for (const BuiltinScene& builtin : builtinScenes()) {
    const Pictures pictures(smallScene(builtin.name, 64), 160);
    EXPECT_LT(pictures.errorOf(0.25f, true), 0.25 * pictures.errorOf(1.0f, true)) << builtin.name;
    EXPECT_LT(pictures.errorOf(0.1f, true), 5e-4) << builtin.name;
  }
}

class PreIntegratedVolumes : public testing::TestWithParam<VoxelType> {};

TEST_P(PreIntegratedVolumes, SkippingChangesNoBit) {
  const glm::uvec3 dims(42, 38, 34);
  for (uint32_t seed = 1; seed <= 4; ++seed) {
    const VolumePtr volume = makeTestVolume(GetParam(), dims, blobs(dims, seed));
    for (const TransferFunction& function :
         {band(40.0, 60.0, 0.5f), band(99.0, 100.0, 1.0f), TransferFunction{{{30.0, glm::vec3(1.0f), 0.0f}, {50.0, {0.2f, 0.8f, 0.4f}, 0.1f}}}}) {
      const MarcherPtr marcher = makeCpuMarcher(volume, function);
      for (const float step : {0.5f, 1.0f, 3.7f, 8.0f, 24.0f})
        for (const float shading : {0.0f, 1.0f}) {
          MarchSettings settings;
          settings.render = preIntegrated({}, step);
          settings.render.effects.shading.strength = shading;
          settings.sample.heuristic = Heuristic::median;
          const Camera camera = lookingFrom({48.0f, 33.0f, 41.0f}, glm::vec3(0.0f), 67, 53);
          const Image<glm::vec4> skipped = rendered(*marcher, camera, settings);
          const SampleFrame frame = marcher->march(camera, settings);
          settings.render.skipEmpty = false;
          EXPECT_TRUE(sameBits(skipped, rendered(*marcher, camera, settings))) << seed << ", " << step;
          EXPECT_TRUE(sameFrame(frame, marcher->march(camera, settings))) << seed << ", " << step;
          if (function.points.front().value < 99.0) EXPECT_GT(largestAlpha(skipped), 0.0f);
        }
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Types, PreIntegratedVolumes, testing::ValuesIn(kAllVoxelTypes));

TEST(PreIntegration, ItsPlanIsThatOfTheSettings) {
  const Scene scene = smallScene("shells", 48);
  const MarcherPtr marcher = makeCpuMarcher(scene.volume, scene.transferFunction);
  RenderSettings settings = scene.march.render;
  EXPECT_FALSE(marcher->plan(settings, std::nullopt)->has(PlanStage::segments));
  settings.effects.preIntegration = true;
  EXPECT_TRUE(marcher->plan(settings, std::nullopt)->has(PlanStage::segments));
  settings.effects.mode = RenderMode::mip;
  EXPECT_FALSE(marcher->plan(settings, std::nullopt)->has(PlanStage::segments));
}

TEST(PreIntegration, WithMissingVoxelsStepsAreClassifiedByTheirMiddle) {
  const glm::uvec3 dims(20, 20, 20);
  const VolumePtr volume = makeTestVolume(VoxelType::float32, dims, [](const glm::ivec3& p) { return p == glm::ivec3(3) ? std::nan("") : p.x * 5.0; });
  const MarcherPtr marcher = makeCpuMarcher(volume, band(40.0, 60.0, 0.5f));
  const Camera camera = lookingFrom({30.0f, 20.0f, 40.0f}, glm::vec3(0.0f), 40, 40);
  MarchSettings settings;
  const Image<glm::vec4> without = rendered(*marcher, camera, settings);
  settings.render.effects.preIntegration = true;
  const EffectPlan plan = *marcher->plan(settings.render, settings.sample);
  EXPECT_FALSE(plan.has(PlanStage::segments));
  EXPECT_THAT(plan[PlanStage::segments].reason, HasSubstr("voxels are missing"));
  EXPECT_TRUE(sameBits(without, rendered(*marcher, camera, settings)));
}

TEST(PreIntegration, TextbooksHaveNone) {
  const Scene scene = smallScene("shells", 32);
  const MarcherPtr marcher = makeCpuMarcher(scene.volume, scene.transferFunction);
  RenderSettings settings = preIntegrated(scene.march.render, 1.0f);
  settings.arithmetic = Arithmetic::textbook;
  Image<glm::vec4> image;
  EXPECT_THROW(marcher->render(makeCamera(scene, scene.views.front(), 32, 32), settings, image), UsageError);
}

TEST(PreIntegration, AStepBetweenTwoEmptyRegionsIsLookedAt) {
  // What is visible lies between both halves' values, in one layer of cells.
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, glm::uvec3(64), [](const glm::ivec3& p) { return p.z < 32 ? 10.0 : 200.0; });
  const MarcherPtr marcher = makeCpuMarcher(volume, band(90.0, 110.0, 0.5f));
  const Camera camera = lookingFrom({10.0f, 7.0f, 110.0f}, glm::vec3(0.0f), 48, 48);
  for (const float step : {1.0f, 4.0f, 8.0f, 16.5f, 24.0f}) {
    MarchSettings settings;
    settings.render = preIntegrated({}, step);
    const Image<glm::vec4> skipped = rendered(*marcher, camera, settings);
    settings.render.skipEmpty = false;
    EXPECT_TRUE(sameBits(skipped, rendered(*marcher, camera, settings))) << step;
    EXPECT_GT(largestAlpha(skipped), 0.0f) << step;
  }
}

}  // namespace
}  // namespace warpscope
