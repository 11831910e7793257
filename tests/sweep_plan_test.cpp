// Configurations and plans: names that tell them apart, what is equal work, reading and writing, what is refused.
// Mirrors app/experiment/configuration.h and app/experiment/sweep_plan.h.
#include "app/experiment/sweep_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "app/scene/json_document.h"
#include "app/scene/scene.h"
#include "render/base/error.h"
#include "render/warp/multihit_warp.h"
#include "render/warp/points_warp.h"

namespace warpscope {
namespace {

Configuration configurationOf(std::string_view technique) {
  Configuration configuration;
  configuration.technique = &findWarp(technique);
  configuration.serverSidePx = 512;
  return configuration;
}

SweepPlan planOf(const std::string& json) {
  SweepPlan plan = defaultPlan({}, 512, 256);
  const JsonDocument document(json, "plan.json");
  applyPlanFile(document.root(), plan);
  return plan;
}

std::string refusal(const std::string& json) {
  try {
    planOf(json);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

std::string optionRefusal(std::string_view option, const std::string& text) {
  SweepPlan plan = defaultPlan({}, 512, 512);
  for (const SweepAxis& axis : sweepAxes()) {
    if (axis.option != option) continue;
    try {
      applyPlanOption(axis, text, plan);
    } catch (const UsageError& error) {
      return error.what();
    }
  }
  return "accepted";
}

TEST(Configuration, WhatATechniqueDoesNotDependOnIsNotPartOfIt) {
  Configuration a = configurationOf("hold"), b = a;
  b.march.sample.heuristic = Heuristic::exit;
  b.march.sample.radiusPolicy = RadiusPolicy::pixel;
  b.knobs.set(kPointSizeKnob, 7);
  b.knobs.set(kHitsKnob, 3);
  EXPECT_NE(a, b);
  EXPECT_EQ(normalized(a), normalized(b));
  EXPECT_EQ(keyOf(a), keyOf(b));
  b.march.render.step = 1.0f;
  EXPECT_NE(keyOf(a), keyOf(b));

  Configuration points = configurationOf("points"), larger = points;
  larger.knobs.set(kPointSizeKnob, 3);
  EXPECT_NE(keyOf(points), keyOf(larger));
  larger = points;
  larger.march.sample.radiusScale = 2.0f;
  EXPECT_EQ(keyOf(points), keyOf(larger));

  Configuration reference = configurationOf("reference"), smaller = reference;
  smaller.serverSidePx = 64;
  EXPECT_EQ(keyOf(reference), keyOf(smaller));
}

TEST(Configuration, AThresholdThatNobodyTakesTellsNothingApart) {
  Configuration a = configurationOf("spheres"), b = a;
  b.march.sample.threshold = 0.5f;
  EXPECT_EQ(normalized(a), normalized(b));  // gradient takes none
  a.march.sample.heuristic = b.march.sample.heuristic = Heuristic::threshold;
  EXPECT_NE(normalized(a), normalized(b));
  EXPECT_NE(keyOf(a), keyOf(b));
}

TEST(Configuration, KeysTellApartWhateverDiffers) {
  std::vector<Configuration> all;
  for (const WarpDescriptor& technique : warpRegistry())
    for (const auto& heuristic : kHeuristics)
      for (const auto& radius : kRadiusPolicies)
        for (const float scale : {1.0f, 1.5f})
          for (const int size : {1, 2})
            for (const char* codec : {"raw", "lossless", "jpeg90", "jpeg95"}) {
              Configuration configuration = configurationOf(technique.name);
              configuration.march.sample.heuristic = heuristic.value;
              configuration.march.sample.radiusPolicy = radius.value;
              configuration.march.sample.radiusScale = scale;
              configuration.knobs.set(kPointSizeKnob, size);
              configuration.knobs.set(kHitsKnob, size);
              configuration.codec = codecOfWord(codec);
              all.push_back(normalized(configuration));
            }
  std::set<std::string> keys;
  std::vector<Configuration> distinct;
  for (const Configuration& configuration : all) {
    const bool isNew = std::find(distinct.begin(), distinct.end(), configuration) == distinct.end();
    EXPECT_EQ(keys.insert(keyOf(configuration)).second, isNew) << keyOf(configuration);
    if (isNew) distinct.push_back(configuration);
  }
  EXPECT_GT(keys.size(), 700u);
}

TEST(Configuration, ComesBackFromJson) {
  for (const WarpDescriptor& technique : warpRegistry()) {
    Configuration configuration = configurationOf(technique.name);
    configuration.march.sample.heuristic = Heuristic::relThreshold;
    configuration.march.sample.threshold = 0.625f;
    configuration.march.sample.radiusPolicy = RadiusPolicy::opacity;
    configuration.march.sample.radiusScale = 0.75f;
    configuration.march.render.step = 0.25f;
    configuration.knobs.set(kPointSizeKnob, 5);
    configuration.knobs.set(kHitsKnob, 7);
    configuration.codec = codecOfWord("jpeg80");
    const JsonDocument document(toJson(configuration).dump(), "row");
    EXPECT_EQ(configurationFrom(document.root(), {}), normalized(configuration)) << technique.name;
  }
}

TEST(Configuration, FromJsonRefusesWhatCannotBe) {
  const auto refusal = [](const std::string& json) -> std::string {
    try {
      const JsonDocument document(json, "row");
      configurationFrom(document.root(), {});
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_THAT(refusal("{}"), testing::HasSubstr("technique"));
  EXPECT_THAT(refusal(R"({"technique": "sphere"})"), testing::HasSubstr("did you mean 'spheres'"));
  EXPECT_THAT(refusal(R"({"technique": "points", "pointSize": 17})"), testing::HasSubstr("between 1 and 16"));
  EXPECT_THAT(refusal(R"({"technique": "points", "heuristic": 3})"), testing::HasSubstr("must be a string"));
  EXPECT_THAT(refusal(R"({"technique": "points", "codec": "jpeg101"})"), testing::HasSubstr("jpeg1 to jpeg100"));
  EXPECT_THAT(refusal(R"({"technique": "points", "step": 0})"), testing::HasSubstr("between"));
  EXPECT_EQ(refusal(R"({"technique": "points", "step": null})"), "accepted");
}

TEST(Configuration, CodecWordsComeBack) {
  for (const char* word : {"raw", "lossless", "jpeg1", "jpeg95", "jpeg100"}) EXPECT_EQ(codecWord(codecOfWord(word)), word);
  for (const char* word : {"", "jpeg", "jpeg0", "jpeg101", "jpeg9x", "JPEG95", "png"}) EXPECT_THROW(codecOfWord(word), UsageError) << word;
}

TEST(SweepPlan, TheDefaultHoldsEveryTechniqueAndBothBaselines) {
  const SweepPlan plan = defaultPlan(defaultMarch(), 640, 480);
  const std::vector<Configuration> configurations = configurationsOf(plan);
  const auto has = [](const std::vector<Configuration>& all, const WarpDescriptor& technique) {
    return std::ranges::find(all, &technique, &Configuration::technique) != all.end();
  };
  for (const WarpDescriptor& technique : warpRegistry()) EXPECT_TRUE(has(configurations, technique)) << technique.name;
  // What would show nothing is no configuration.
  const std::vector<Configuration> bare = configurationsOf(defaultPlan(MarchSettings{}, 640, 480));
  for (const WarpDescriptor& technique : warpRegistry()) EXPECT_EQ(has(bare, technique), !technique.uses.segments && !technique.uses.proxy) << technique.name;
  EXPECT_TRUE(std::any_of(configurations.begin(), configurations.end(), isPapersMethod));
  EXPECT_TRUE(std::any_of(configurations.begin(), configurations.end(), isPointBaseline));
  std::set<std::string> keys;
  for (const Configuration& configuration : configurations) EXPECT_TRUE(keys.insert(keyOf(configuration)).second) << keyOf(configuration);
  EXPECT_EQ(plan.values(kServerSideKnob), (std::vector<double>{640.0, 320.0}));
}

TEST(SweepPlan, BaselinesAreThereWhateverIsAskedFor) {
  const SweepPlan plan = planOf(R"({"techniques": ["hold"], "serverSides": [64, 128], "steps": [2]})");
  const std::vector<Configuration> configurations = configurationsOf(plan);
  ASSERT_EQ(configurations.size(), 4u);  // hold at two sizes
  EXPECT_TRUE(isPapersMethod(configurations[2]));
  EXPECT_TRUE(isPointBaseline(configurations[3]));
  EXPECT_EQ(configurations[2].serverSidePx, 128u);
  EXPECT_EQ(configurations[2].march.render.step, 2.0f);
}

TEST(SweepPlan, BaselinesAreThePapersWhateverTheSceneSays) {
  MarchSettings scene;
  scene.sample.samplesPerRay = 4;
  scene.sample.radiusScale = 2.0f;
  scene.sample.radiusPolicy = RadiusPolicy::pixel;
  SweepPlan plan = defaultPlan(scene, 64, 48);
  for (const std::vector<double>& counts : {std::vector{4.0}, std::vector{1.0, 4.0}}) {
    plan.values(kSamplesPerRayKnob) = counts;
    plan.values(kServerSideKnob) = {64.0};
    plan.values(kRadiusScaleKnob) = {1.0};
    const std::vector<Configuration> configurations = configurationsOf(plan);
    EXPECT_EQ(std::count_if(configurations.begin(), configurations.end(), isPapersMethod), 1);
    EXPECT_EQ(std::count_if(configurations.begin(), configurations.end(), isPointBaseline), 1);
  }
}

TEST(SweepPlan, ComesBackFromJson) {
  const SweepPlan plan = planOf(R"({"techniques": ["points", "splats"], "heuristics": ["exit"], "radii": "pixel", "radiusScales": [0.5, 2],
    "pointSizes": [4], "hits": 16, "steps": [0.125], "serverSides": [100], "codecs": ["raw", "jpeg50"], "angles": [-30, 0.5],
    "links": ["lan", "delay=100,rate=20M"], "speedDegPerS": 12.5, "instants": 7, "draws": 9})");
  EXPECT_EQ(plan.values(kRadiusKnob), std::vector{static_cast<double>(RadiusPolicy::pixel)});
  EXPECT_EQ(plan.links[1].settings.down.rateBitPerS, 20e6);
  EXPECT_EQ(planOf(toJson(plan).dump()), plan);
  EXPECT_TRUE(planOf(R"({"links": []})").links.empty());
}

TEST(SweepPlan, RefusesFilesThatCannotBe) {
  EXPECT_THAT(refusal(R"({"technique": ["hold"]})"), testing::HasSubstr("did you mean 'techniques'"));
  EXPECT_THAT(refusal("{\n\"angles\": []}"), testing::HasSubstr("plan.json:2"));
  EXPECT_THAT(refusal(R"({"angles": [400]})"), testing::HasSubstr("-360"));
  EXPECT_THAT(refusal(R"({"pointSizes": [1.5]})"), testing::HasSubstr("whole number"));
  EXPECT_THAT(refusal(R"({"heuristics": ["medain"]})"), testing::HasSubstr("did you mean 'median'"));
  EXPECT_THAT(refusal(R"({"links": ["rate=fast"]})"), testing::HasSubstr("rate"));
  EXPECT_THAT(refusal(R"({"draws": 0})"), testing::HasSubstr("draws"));
  EXPECT_THAT(refusal(R"({"draws": [1, 2]})"), testing::HasSubstr("elements"));
  EXPECT_THAT(refusal(R"({"steps": [1e400]})"), testing::Not("accepted"));
  EXPECT_THAT(refusal("[]"), testing::HasSubstr("must be an object"));
}

TEST(SweepPlan, RefusesOptionsThatCannotBe) {
  EXPECT_THAT(optionRefusal("--techniques", "hold,point"), testing::HasSubstr("--techniques: unknown technique 'point'"));
  EXPECT_THAT(optionRefusal("--angles", "0,,5"), testing::HasSubstr("--angles: '' is no number"));
  EXPECT_THAT(optionRefusal("--angles", "nan"), testing::HasSubstr("--angles"));
  EXPECT_THAT(optionRefusal("--draws", "3,4"), testing::HasSubstr("at most 1 value"));
  EXPECT_THAT(optionRefusal("--server-sides", "99999"), testing::HasSubstr("--server-sides"));
  EXPECT_EQ(optionRefusal("--links", "4g;delay=10,rate=5M"), "accepted");
}

TEST(SweepPlan, EqualValuesCountOnce) {
  const SweepPlan plan = planOf(R"({"angles": [0, 10, 0.0, 10]})");
  EXPECT_EQ(plan.anglesDeg, (std::vector<double>{0.0, 10.0}));
}

}  // namespace
}  // namespace warpscope
