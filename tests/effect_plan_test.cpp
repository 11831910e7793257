// Each stage is in where it can change a pixel and out where it cannot; what is out costs no picture a bit.
// Mirrors render/effects/effect_plan.h.
#include "render/effects/effect_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "headless.h"
#include "marcher_cases.h"
#include "render/core/counters.h"
#include "render/march/march_setup.h"
#include "test_volumes.h"

namespace warpscope {
namespace {

constexpr PlannedScene kScene{.cells = 100, .visibleCells = 40, .mostOpacity = 0.5f, .mostSamples = 200.0};

EffectPlan planOf(const RenderSettings& settings, const PlannedScene& scene = kScene) { return EffectPlan(scene, settings, SampleSettings{}); }

RenderSettings lit(std::string_view lights = "headlight") {
  RenderSettings settings;
  settings.effects.shading.strength = 1.0f;
  settings.effects.lights = parseLights(lights, "it");
  return settings;
}

std::set<std::string_view> stagesIn(const EffectPlan& plan) {
  std::set<std::string_view> names;
  for (const StageDescriptor& stage : kStages)
    if (plan.has(stage.stage)) names.insert(stage.name);
  return names;
}

TEST(EffectPlan, EveryStageHasAReason) {
  PlannedScene hidden = kScene;
  hidden.visibleCells = 0;
  for (const PlannedScene& scene : {kScene, hidden})
    for (const RenderSettings& settings : {RenderSettings{}, lit(), lit("none")})
      for (const StageDescriptor& stage : kStages) EXPECT_FALSE(planOf(settings, scene)[stage.stage].reason.empty()) << stage.name;
  for (size_t i = 0; i < kStages.size(); ++i) EXPECT_EQ(static_cast<size_t>(kStages[i].stage), i);
}

TEST(EffectPlan, ThePlainSceneHasTheLeast) {
  EXPECT_THAT(stagesIn(planOf({})), testing::UnorderedElementsAre("march", "skipping", "correction", "early-end"));
  RenderSettings reference;
  reference.step = 1.0f;
  EXPECT_FALSE(planOf(reference).has(PlanStage::correction));
}

TEST(EffectPlan, WhereEverythingIsHiddenNothingIsMarched) {
  PlannedScene hidden = kScene;
  hidden.visibleCells = 0;
  EXPECT_THAT(stagesIn(planOf(lit(), hidden)), testing::IsEmpty());
}

TEST(EffectPlan, CuttingIsInWhereSomethingCuts) {
  RenderSettings settings;
  settings.effects.clip.slab.depth = 5.0f;
  EXPECT_FALSE(planOf(settings).has(PlanStage::clip)) << "a slab without thickness is none";
  settings.effects.clip.slab.thickness = 1.0f;
  EXPECT_EQ(planOf(settings)[PlanStage::clip].reason, "a slab");
  settings.effects.clip.planes = parseClipPlanes("1,0,0,0 0,1,0,0", "it");
  settings.effects.clip.box = parseClipBox("0,0,0,1,1,0.5", "it");
  EXPECT_EQ(planOf(settings)[PlanStage::clip].reason, "2 planes, a box, a slab");
}

TEST(EffectPlan, SkippingNeedsSomethingToSkip) {
  PlannedScene full = kScene;
  full.visibleCells = full.cells;
  EXPECT_FALSE(planOf({}, full).has(PlanStage::skipping));
  EXPECT_FALSE(planOf({.skipEmpty = false}).has(PlanStage::skipping));
  EXPECT_TRUE(planOf({}).has(PlanStage::skipping));
}

TEST(EffectPlan, RaysEndEarlyOnlyWhereTheyCan) {
  EXPECT_TRUE(planOf({}).has(PlanStage::earlyEnd));
  EXPECT_FALSE(planOf({.terminateEarly = false}).has(PlanStage::earlyEnd));
  PlannedScene thin = kScene;
  thin.mostOpacity = 0.01f;  // 0.99^200 is 0.13
  EXPECT_FALSE(planOf({}, thin).has(PlanStage::earlyEnd));
  thin.mostSamples = 700.0;  // 0.0009
  EXPECT_TRUE(planOf({}, thin).has(PlanStage::earlyEnd));
  PlannedScene opaque = kScene;
  opaque.mostOpacity = 1.0f;
  EXPECT_TRUE(planOf({}, opaque).has(PlanStage::earlyEnd));
}

TEST(EffectPlan, MissingVoxelsAndRefinementAreTheVolumesAndTheTables) {
  PlannedScene scene = kScene;
  EXPECT_FALSE(planOf({}, scene).has(PlanStage::missingVoxels));
  EXPECT_FALSE(planOf({}, scene).has(PlanStage::refinement));
  scene.missingVoxels = 1;
  scene.isRefined = true;
  EXPECT_TRUE(planOf({}, scene).has(PlanStage::missingVoxels));
  EXPECT_TRUE(planOf({}, scene).has(PlanStage::refinement));
}

TEST(EffectPlan, LightComesPieceByPiece) {
  for (const PlanStage stage : {PlanStage::gradient, PlanStage::diffuse, PlanStage::specular, PlanStage::halfVector}) EXPECT_FALSE(planOf({}).has(stage));
  const EffectPlan byEye = planOf(lit());
  for (const PlanStage stage : {PlanStage::gradient, PlanStage::diffuse, PlanStage::specular}) EXPECT_TRUE(byEye.has(stage));
  EXPECT_FALSE(byEye.has(PlanStage::halfVector)) << "it is the direction to the eye";
  EXPECT_TRUE(planOf(lit("headlight world:1,0,0")).has(PlanStage::halfVector));
  EXPECT_FALSE(planOf(lit("headlight world:1,0,0@0")).has(PlanStage::halfVector)) << "a light of strength 0 is none";
  RenderSettings dull = lit("camera:1,0,0");
  dull.effects.shading.specular = 0.0f;
  EXPECT_FALSE(planOf(dull).has(PlanStage::specular));
  EXPECT_FALSE(planOf(dull).has(PlanStage::halfVector));
  EXPECT_FALSE(planOf(lit("none")).has(PlanStage::diffuse));
  RenderSettings flat = lit("camera:1,0,0");
  flat.effects.shading.diffuse = 0.0f;
  EXPECT_FALSE(planOf(flat).has(PlanStage::diffuse));
  EXPECT_TRUE(planOf(flat).has(PlanStage::halfVector));
  EXPECT_FALSE(planOf(lit("none")).has(PlanStage::specular));
  EXPECT_TRUE(planOf(lit("none")).has(PlanStage::gradient)) << "ambient light is less than its own";
}

TEST(EffectPlan, PassesAreTheHeuristics) {
  for (const auto& heuristic : kHeuristics) {
    const bool isTwoPass = heuristic.name == "rel-threshold" || heuristic.name == "en-ex-mean" || heuristic.name == "median";
    EXPECT_EQ(EffectPlan(kScene, {}, SampleSettings{.heuristic = heuristic.value}).has(PlanStage::secondPass), isTwoPass) << heuristic.name;
    EXPECT_FALSE(EffectPlan(kScene, {}, std::nullopt).has(PlanStage::secondPass));
  }
  EXPECT_FALSE(EffectPlan(kScene, {}, SampleSettings{}).has(PlanStage::severalSamples));
  EXPECT_TRUE(EffectPlan(kScene, {}, SampleSettings{.samplesPerRay = 2}).has(PlanStage::severalSamples));
}

TEST(EffectPlan, AGreatestValueIsNeitherLitNorFoldedOver) {
  RenderSettings settings = lit("camera:1,0,0");
  settings.effects.mode = RenderMode::mip;
  SampleSettings sample{.heuristic = Heuristic::median, .samplesPerRay = 4};
  const EffectPlan plan(kScene, settings, sample);
  EXPECT_THAT(stagesIn(plan), testing::UnorderedElementsAre("march", "maximum", "skipping"));
  EXPECT_THAT(plan[PlanStage::maximum].reason, testing::HasSubstr("every heuristic gives its depth"));
  for (const StageDescriptor& stage : kStages) EXPECT_FALSE(plan[stage.stage].reason.empty()) << stage.name;
  PlannedScene full = kScene;
  full.visibleCells = full.cells;
  EXPECT_TRUE(planOf(settings, full).has(PlanStage::skipping)) << "of cells that have no greater value, whatever they show";
  settings.skipEmpty = false;
  EXPECT_FALSE(planOf(settings).has(PlanStage::skipping));
  EXPECT_FALSE(planOf({}).has(PlanStage::maximum));
}

TEST(EffectPlan, SurfacesHaveNeitherThicknessNorFinerColours) {
  RenderSettings settings = lit();
  settings.effects.mode = RenderMode::isosurface;
  settings.effects.isoValues = parseIsoValues("10 20@0 30@0.5", "it");
  PlannedScene refined = kScene;
  refined.isRefined = true;
  refined.mostOpacity = 0.0f;
  EXPECT_THAT(stagesIn(planOf(settings, refined)),
              testing::UnorderedElementsAre("march", "surfaces", "skipping", "gradient", "diffuse", "specular", "early-end"));
  EXPECT_EQ(planOf(settings)[PlanStage::surfaces].reason, "2 values") << "one of opacity 0 is not looked for";
  settings.effects.shading.strength = 0.0f;
  EXPECT_FALSE(planOf(settings).has(PlanStage::gradient));
  settings.effects.isoValues = parseIsoValues("10 20@0 30", "it");
  EXPECT_FALSE(planOf(settings).has(PlanStage::earlyEnd)) << "an opaque surface ends its ray by itself";
  refined.visibleCells = 0;
  EXPECT_EQ(planOf(settings, refined)[PlanStage::march].reason, "no surface runs through any cell");
  EXPECT_FALSE(planOf({}).has(PlanStage::surfaces));
  EXPECT_TRUE(EffectPlan(kScene, settings, SampleSettings{.samplesPerRay = 2}).has(PlanStage::severalSamples));
}

#if !WARPSCOPE_COUNTERS
#define WARPSCOPE_TEXT_OF(...) #__VA_ARGS__
#define WARPSCOPE_EXPANDED(...) WARPSCOPE_TEXT_OF(__VA_ARGS__)
TEST(EffectPlan, CountersAreNoCodeHere) { EXPECT_STREQ(WARPSCOPE_EXPANDED(WARPSCOPE_COUNT(voxels, 8)), "static_cast<void>(0)"); }
#endif

TEST(EffectPlan, AStageCanBeDecidedForTests) {
  for (const StageDescriptor& stage : kStages)
    for (const bool isIn : {false, true}) EXPECT_EQ(EffectPlan(kScene, lit(), SampleSettings{}, DecidedStage{stage.stage, isIn}).has(stage.stage), isIn) << stage.name;
}

// --- Marchers go by it.

TEST(EffectPlan, WhatAMarcherPlansIsWhatItsSceneHas) {
  const Scene scene = smallScene("vessels");
  const MarcherPtr marcher = makeCpuMarcher(scene.volume, scene.transferFunction);
  const auto plan = marcher->plan(RenderSettings{}, SampleSettings{});
  ASSERT_TRUE(plan);
  EXPECT_TRUE(plan->has(PlanStage::march));
  EXPECT_TRUE(plan->has(PlanStage::skipping));
  EXPECT_FALSE(plan->has(PlanStage::missingVoxels));
}

TEST(EffectPlan, AHiddenVolumeGivesEmptyPicturesAndFrames) {
  Scene scene = smallScene("shells");
  for (TransferPoint& point : scene.transferFunction.points) point.alpha = 0.0f;
  const MarcherPtr marcher = makeCpuMarcher(scene.volume, scene.transferFunction);
  EXPECT_FALSE(marcher->plan(RenderSettings{}, std::nullopt)->has(PlanStage::march));
  const Camera camera = makeCamera(scene, scene.views.front(), 40, 30);
  EXPECT_EQ(marcher->march(camera, {}).size(), 0u);
  const Image<glm::vec4> image = rendered(*marcher, camera);
  EXPECT_EQ(image.width(), 40u);
  EXPECT_EQ(largestAlpha(image), 0.0f);
}

TEST(EffectPlan, ThinMatterIsTheSameWithoutEarlyEnds) {
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, {24, 24, 24}, blobs({24, 24, 24}, 3));
  const MarcherPtr marcher = makeCpuMarcher(volume, {{{1.0, glm::vec3(0.2f), 0.0f}, {100.0, glm::vec3(1.0f), 0.004f}}});
  EXPECT_FALSE(marcher->plan(RenderSettings{}, std::nullopt)->has(PlanStage::earlyEnd));
  const Camera camera = lookingFrom({30.0f, 22.0f, 35.0f}, glm::vec3(0.0f), 64, 64);
  MarchSettings never;
  never.render.terminateEarly = false;
  EXPECT_TRUE(sameBits(rendered(*marcher, camera), rendered(*marcher, camera, never)));
}

}  // namespace
}  // namespace warpscope
