// Rows of knobs: values as text and back, what is refused, values of techniques, and that the program's rows are fit for use.
// Mirrors render/base/knob.h, render/march/march_knobs.h and the registry's part of render/warp/warp.h.
#include "app/scene/json_document.h"
#include "render/base/knob.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <set>

#include "app/experiment/configuration.h"
#include "app/frames/transport_knobs.h"
#include "app/scene/knob_json.h"
#include "render/base/error.h"
#include "render/march/march_knobs.h"
#include "render/warp/arithmetic_knob.h"
#include "render/warp/multihit_warp.h"
#include "render/warp/points_warp.h"
#include "render/warp/spheres_warp.h"
#include "tests/extra_technique.h"

namespace warpscope {
namespace {

/// Every row of the program.
std::vector<const Knob*> allKnobs() {
  std::vector<const Knob*> all;
  for (const MarchKnob& row : marchKnobs()) all.push_back(row.knob);
  for (const Knob* knob : warpKnobs()) all.push_back(knob);
  for (const auto& row : transportKnobs()) all.push_back(row.knob);
  all.push_back(&kServerSideKnob);
  return all;
}

/// Values that the knob can have, its default among them.
std::vector<double> valuesOf(const Knob& knob) {
  std::vector<double> values;
  if (knob.type == KnobType::choice)
    for (size_t i = 0; i < knob.choices.size(); ++i) values.push_back(static_cast<double>(i));
  else if (knob.type == KnobType::flag)
    values = {0.0, 1.0};
  else
    values = {knob.range.lowest, knob.range.highest};
  if (&knob != &kServerSideKnob) values.push_back(knob.defaultValue);  // of which there is none without pictures
  return values;
}

std::string refusal(const Knob& knob, std::string_view text) {
  try {
    parseKnob(knob, text, "--it");
  } catch (const UsageError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Knob, EveryRowSaysAllThatItsUsersNeed) {
  std::set<std::string_view> keys, options;
  for (const Knob* knob : allKnobs()) {
    SCOPED_TRACE(knob->key);
    EXPECT_FALSE(knob->key.empty());
    EXPECT_TRUE(keys.insert(knob->key).second) << "twice";
    EXPECT_FALSE(knob->noun.empty());
    EXPECT_FALSE(knob->help.empty());
    EXPECT_FALSE(knob->help.ends_with('.'));
    for (const std::string_view option : {knob->option, knob->axis.option}) {
      if (option.empty()) continue;
      EXPECT_TRUE(option.starts_with("--"));
      EXPECT_TRUE(options.insert(option).second) << option << " twice";
    }
    EXPECT_EQ(knob->axis.key.empty(), knob->axis.option.empty());
    EXPECT_EQ(knob->type == KnobType::choice, !knob->choices.empty());
    for (const KnobChoice& choice : knob->choices) EXPECT_FALSE(choice.name.empty() || choice.summary.empty());
    for (const double value : valuesOf(*knob)) EXPECT_NO_THROW(validate(*knob, value, "it")) << value;
    for (const double value : knob->axis.values) EXPECT_NO_THROW(validate(*knob, value, "it")) << value;
    // The server's side has widgets of its own: it is a part of the panels' size.
    if (knob != &kServerSideKnob && !knob->label.empty() && (knob->type == KnobType::number || knob->type == KnobType::whole)) {
      EXPECT_LT(knob->track.lowest, knob->track.highest);
      EXPECT_GE(knob->track.lowest, knob->range.lowest);
      EXPECT_LE(knob->track.highest, knob->range.highest);
    }
    if (!knob->phrase.empty()) EXPECT_THAT(std::string(knob->phrase), testing::HasSubstr("{}"));
  }
  EXPECT_GT(keys.size(), 12u);
}

TEST(Knob, TextsComeBack) {
  for (const Knob* knob : allKnobs())
    for (const double value : valuesOf(*knob)) {
      const double held = knob->type == KnobType::number ? static_cast<float>(value) : value;
      EXPECT_EQ(parseKnob(*knob, textOf(*knob, held), "it"), held) << knob->key << " " << value;
    }
}

TEST(Knob, RefusesWhatItCannotBe) {
  for (const char* text : {"", " 1", "1 ", "x", "1x", "nan", "inf", "-1", "1e400", "0x1"})
    EXPECT_NE(refusal(kStepKnob, text), "accepted") << text;
  EXPECT_EQ(refusal(kStepKnob, "1e-300"), "--it must be between 0.001 and 1000, not 1e-300");  // as typed, not as zero
  EXPECT_EQ(refusal(kPointSizeKnob, "2.5"), "--it must be a whole number, not 2.5");
  EXPECT_EQ(refusal(kPointSizeKnob, "17"), "--it must be between 1 and 16, not 17");
  EXPECT_THAT(refusal(kHeuristicKnob, "medain"), testing::HasSubstr("unknown heuristic 'medain'; did you mean 'median'?"));
  EXPECT_THAT(refusal(kHeuristicKnob, "0"), testing::HasSubstr("unknown heuristic"));  // places are no names
  EXPECT_EQ(refusal(kSkipEmptyKnob, "yes"), "--it must be true or false");
  for (const double value : {-1.0, 10.0, 0.5}) EXPECT_THROW(validate(kHeuristicKnob, value, "it"), UsageError) << value;
}

TEST(Knob, RowsOfTheMarchHoldWhatIsSet) {
  for (const MarchKnob& row : marchKnobs())
    for (const double value : valuesOf(*row.knob)) {
      MarchSettings settings;
      EXPECT_EQ(row.get(settings), row.knob->defaultValue) << row.knob->key;
      row.set(settings, value);
      EXPECT_EQ(row.get(settings), row.knob->type == KnobType::number ? static_cast<float>(value) : value) << row.knob->key;
      EXPECT_NO_THROW(validate(settings));
      // One row, one member: all others are as they were.
      for (const MarchKnob& other : marchKnobs())
        if (other.knob != row.knob) EXPECT_EQ(other.get(settings), other.knob->defaultValue) << row.knob->key << " turns " << other.knob->key;
    }
}

TEST(Knob, ListsComeBackAndAreRefusedByName) {
  for (const MarchText& text : marchTexts()) {
    MarchSettings settings;
    const std::string byItself = text.get(settings);
    text.set(settings, byItself, "it");
    EXPECT_EQ(settings, MarchSettings{}) << text.key;
    try {
      text.set(settings, "\x1b]no such thing", "--it");
      ADD_FAILURE() << text.key << " was set";
    } catch (const UsageError& error) {
      EXPECT_THAT(error.what(), testing::StartsWith("--it"));
      EXPECT_EQ(settings, MarchSettings{});
    }
    EXPECT_EQ(findMarchText(text.key), &text);
    for (const MarchKnob& row : marchKnobs()) EXPECT_NE(row.knob->key, text.key);
  }
  EXPECT_EQ(findMarchText("step"), nullptr);
}

TEST(Knob, TheThresholdMattersToThoseHeuristicsThatTakeOne) {
  const auto row = std::ranges::find(marchKnobs(), &kThresholdKnob, &MarchKnob::knob);
  ASSERT_NE(row, marchKnobs().end()) << "it has no row";
  for (const auto& heuristic : kHeuristics) {
    MarchSettings settings;
    settings.sample.heuristic = heuristic.value;
    EXPECT_EQ(row->matters(settings), heuristic.name == "threshold" || heuristic.name == "rel-threshold") << heuristic.name;
  }
}

TEST(Knob, ColoursAndQualityMatterWhereTheyTravel) {
  const auto matters = [](const Knob& knob, const TransportSettings& settings) {
    for (const TransportKnob& row : transportKnobs())
      if (row.knob == &knob) return row.matters(settings);
    ADD_FAILURE() << knob.key << " has no row";
    return false;
  };
  TransportSettings settings;
  for (const auto& format : kPayloadFormats)
    for (const auto& color : kColorCodings) {
      settings.codec.format = format.value;
      settings.codec.color = color.value;
      const bool isPacked = format.name == "packed";
      EXPECT_TRUE(matters(kFormatKnob, settings));
      EXPECT_TRUE(matters(kDepthKnob, settings));
      EXPECT_EQ(matters(kColorKnob, settings), isPacked);
      EXPECT_EQ(matters(kQualityKnob, settings), isPacked && color.name == "jpeg");
    }
}

/// 0.8 is no float: the nearest is a little more.
TEST(KnobJson, NumbersAreTheShortestThatReadBackAsTheSameFloat) {
  EXPECT_EQ(jsonOf(kThresholdKnob, 0.8f).dump(), "0.8");
  EXPECT_EQ(jsonOf(kThresholdKnob, 1.0f).dump(), "1.0");
  EXPECT_EQ(jsonOf(kContributionKnob, 1.0f / 1024).dump(), "0.0009765625");
  std::mt19937 random(11);
  for (const Knob* knob : allKnobs()) {
    if (knob->type != KnobType::number) continue;
    std::uniform_real_distribution<double> values(knob->range.lowest, knob->range.highest);
    for (int i = 0; i < 100; ++i) {
      const auto value = static_cast<float>(values(random));
      EXPECT_EQ(static_cast<float>(nlohmann::json::parse(jsonOf(*knob, value).dump()).get<double>()), value) << knob->key;
    }
  }
}

TEST(KnobValues, AreTheirDefaultsUntilTheyAreSet) {
  KnobValues values;
  EXPECT_EQ(values.whole(kPointSizeKnob), 2);
  EXPECT_EQ(values.choice<SphereTracing>(kSphereTracingKnob), SphereTracing::automatic);
  values.set(kPointSizeKnob, 5);
  values.set(kSphereTracingKnob, SphereTracing::embree);
  EXPECT_EQ(values.whole(kPointSizeKnob), 5);
  EXPECT_EQ(values.choice<SphereTracing>(kSphereTracingKnob), SphereTracing::embree);
  EXPECT_THROW(values.set(kPointSizeKnob, 0), UsageError);
  EXPECT_EQ(values.whole(kPointSizeKnob), 5);
}

TEST(KnobValues, AreEqualIfAllKnobsHaveEqualValues) {
  KnobValues a, b;
  a.set(kPointSizeKnob, 5);
  a.set(kHitsKnob, 7);
  b.set(kHitsKnob, 7);
  EXPECT_NE(a, b);
  b.set(kPointSizeKnob, 5);
  EXPECT_EQ(a, b);  // whatever the order
  a.set(kPointSizeKnob, kPointSizeKnob.defaultValue);
  a.set(kHitsKnob, kHitsKnob.defaultValue);
  EXPECT_EQ(a, KnobValues());
  const Knob* const hits[] = {&kHitsKnob};
  EXPECT_EQ(b.only(hits).whole(kHitsKnob), 7);
  EXPECT_EQ(b.only(hits).whole(kPointSizeKnob), 2);
}

TEST(WarpRegistration, LastsAsLongAsTheObject) {
  const size_t before = warpRegistry().size();
  EXPECT_THROW(findWarp("fog"), UsageError);
  {
    const WarpRegistration fog(extraTechnique());
    EXPECT_EQ(warpRegistry().size(), before + 1);
    EXPECT_EQ(findWarp("fog").knobs.size(), 2u);
    EXPECT_EQ(warpKnobs().back()->key, "fogTint");
    EXPECT_THROW(WarpRegistration again(extraTechnique()), std::logic_error);
  }
  EXPECT_EQ(warpRegistry().size(), before);
}

TEST(WarpRegistration, RefusesAKnobThatThereIsAlready) {
  static const Knob* const taken[] = {&kHitsKnob};
  WarpDescriptor technique = extraTechnique();
  technique.knobs = taken;
  EXPECT_THROW(WarpRegistration registration(technique), std::logic_error);
  EXPECT_THROW(findWarp("fog"), UsageError);
}

TEST(WarpRegistration, TakesAKnobThatSeveralTechniquesHave) {
  static const Knob* const shared[] = {&kArithmeticKnob};
  WarpDescriptor technique = extraTechnique();
  technique.knobs = shared;
  const WarpRegistration registration(technique);
  EXPECT_THAT(ownersOf(kArithmeticKnob), testing::ElementsAre("reference", "spheres", "fog"));
  const std::vector<const Knob*> knobs = warpKnobs();
  EXPECT_EQ(std::count(knobs.begin(), knobs.end(), &kArithmeticKnob), 1);
}

TEST(Configuration, HasAnyTechniquesKnobs) {
  const WarpRegistration registration(extraTechnique());
  const WarpDescriptor& fog = findWarp("fog");
  Configuration configuration{&fog, {}, 64, {}, {}};
  configuration.knobs.set(*fog.knobs[0], 0.5);
  configuration.knobs.set(*fog.knobs[1], 1);
  EXPECT_THAT(labelOf(configuration), "fog of density 0.5, red");
  EXPECT_THAT(keyOf(configuration), testing::HasSubstr(" fogDensity=0.5 fogTint=red "));
  const nlohmann::json json = toJson(configuration);
  EXPECT_EQ(json["fogDensity"], 0.5);
  EXPECT_EQ(json["fogTint"], "red");
  EXPECT_EQ(json["hits"], nullptr);
  const JsonDocument document(json.dump(), "row");
  EXPECT_EQ(configurationFrom(document.root(), {}), normalized(configuration));
  EXPECT_EQ(toJson(Configuration{&findWarp("points"), {}, 64, {}, {}})["fogTint"], nullptr);
}

TEST(Knob, WhatTheModeOrTheLightsLeaveOutDoesNotMatter) {
  const auto matters = [](const MarchSettings& settings, std::string_view key) {
    for (const MarchKnob& row : marchKnobs())
      if (row.knob->key == key) return row.matters(settings);
    throw std::invalid_argument(std::string(key));
  };
  MarchSettings lit;
  lit.render.effects.shading.strength = 1.0f;
  lit.render.effects.shadows.strength = 1.0f;
  lit.render.effects.lights = parseLights("world:1,1,1", "it");
  for (const char* const key : {"shading", "ambient", "diffuse", "specular", "shadows", "occlusion", "lightGrid", "preIntegration", "samplesPerRay"}) EXPECT_TRUE(matters(lit, key)) << key;
  MarchSettings greatest = lit;
  greatest.render.effects.mode = RenderMode::mip;
  for (const char* const key : {"shading", "ambient", "diffuse", "specular", "shadows", "occlusion", "lightGrid", "preIntegration", "samplesPerRay"})
    EXPECT_FALSE(matters(greatest, key)) << key;
  MarchSettings surfaces = lit;
  surfaces.render.effects.mode = RenderMode::isosurface;
  for (const char* const key : {"shading", "diffuse"}) EXPECT_TRUE(matters(surfaces, key)) << key;
  for (const char* const key : {"shadows", "occlusion", "lightGrid", "preIntegration"}) EXPECT_FALSE(matters(surfaces, key)) << key;
  MarchSettings fromEye = lit;
  fromEye.render.effects.lights = parseLights("headlight", "it");
  for (const char* const key : {"diffuse", "occlusion"}) EXPECT_TRUE(matters(fromEye, key)) << key;
  for (const char* const key : {"shadows", "lightGrid"}) EXPECT_FALSE(matters(fromEye, key)) << key;
  MarchSettings dark = lit;
  dark.render.effects.lights = parseLights("none", "it");
  EXPECT_TRUE(matters(dark, "ambient"));
  for (const char* const key : {"diffuse", "specular", "exponent", "shadows"}) EXPECT_FALSE(matters(dark, key)) << key;
}

}  // namespace
}  // namespace warpscope
