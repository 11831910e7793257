// Rows of the effects' knobs.
// See effect_knobs.h.
#include "render/effects/effect_knobs.h"

namespace warpscope {
namespace {

constexpr Shading kShading;

bool isLit(const MarchSettings& settings) { return settings.render.effects.shading.strength > 0.0f; }
bool hasHighlights(const MarchSettings& settings) { return isLit(settings) && settings.render.effects.shading.specular > 0.0f; }
constexpr bool always(const MarchSettings&) { return true; }

/// A row for a float of the effects.
template <auto kPart, auto kMember>
constexpr MarchKnob row(const Knob& knob, bool (*matters)(const MarchSettings&)) {
  return {{&knob, [](const MarchSettings& s) { return double{s.render.effects.*kPart.*kMember}; },
           [](MarchSettings& s, double value) { s.render.effects.*kPart.*kMember = static_cast<float>(value); }},
          FramePart::picture,
          matters};
}

}  // namespace

constinit const Knob kShadingKnob{.key = "shading",
                                  .option = "--shading",
                                  .label = "Shading",
                                  .noun = "strength of shading",
                                  .help = "How much matter is lit instead of shining by itself (Phong 1975, Blinn 1977); 0: not at all",
                                  .owner = KnobOwner::effect,
                                  .stale = KnobStage::march,
                                  .range = {0.0, 1.0},
                                  .track = {0.0, 1.0},
                                  .defaultValue = kShading.strength,
                                  .axis = {"shadings", "--shadings", "Strengths of shading"},
                                  .phrase = ", shading {}",
                                  .naming = KnobNaming::whereDiffering};

constinit const Knob kAmbientKnob{.key = "ambient",
                                  .option = "--ambient",
                                  .label = "Ambient",
                                  .noun = "ambient light",
                                  .help = "Share of its colour that lit matter has in any light",
                                  .owner = KnobOwner::effect,
                                  .stale = KnobStage::march,
                                  .range = {0.0, 4.0},
                                  .track = {0.0, 1.0},
                                  .defaultValue = kShading.ambient};

constinit const Knob kDiffuseKnob{.key = "diffuse",
                                  .option = "--diffuse",
                                  .label = "Diffuse",
                                  .noun = "diffuse light",
                                  .help = "Share of its colour that lit matter has more where it faces a light",
                                  .owner = KnobOwner::effect,
                                  .stale = KnobStage::march,
                                  .range = {0.0, 4.0},
                                  .track = {0.0, 1.0},
                                  .defaultValue = kShading.diffuse};

constinit const Knob kSpecularKnob{.key = "specular",
                                   .option = "--specular",
                                   .label = "Specular",
                                   .noun = "specular light",
                                   .help = "White that lit matter has more where it mirrors a light; 0: no highlights",
                                   .owner = KnobOwner::effect,
                                   .stale = KnobStage::march,
                                   .range = {0.0, 4.0},
                                   .track = {0.0, 1.0},
                                   .defaultValue = kShading.specular,
                                   .axis = {"speculars", "--speculars", "Strengths of specular light"},
                                   .phrase = ", specular {}",
                                   .naming = KnobNaming::whereDiffering};

constinit const Knob kExponentKnob{.key = "exponent",
                                   .option = "--exponent",
                                   .label = "Exponent",
                                   .noun = "exponent of highlights",
                                   .help = "How sharp highlights are: power of the cosine between normal and half vector",
                                   .owner = KnobOwner::effect,
                                   .stale = KnobStage::march,
                                   .range = {1.0, 1000.0},
                                   .track = {1.0, 200.0},
                                   .scale = KnobScale::logarithmic,
                                   .decimals = 0,
                                   .defaultValue = kShading.exponent};

std::span<const MarchKnob> effectKnobs() {
  static constexpr MarchKnob kRows[] = {
      row<&Effects::shading, &Shading::strength>(kShadingKnob, always),
      row<&Effects::shading, &Shading::ambient>(kAmbientKnob, isLit),
      row<&Effects::shading, &Shading::diffuse>(kDiffuseKnob, isLit),
      row<&Effects::shading, &Shading::specular>(kSpecularKnob, isLit),
      row<&Effects::shading, &Shading::exponent>(kExponentKnob, hasHighlights),
  };
  return kRows;
}

std::span<const MarchText> effectTexts() {
  static constexpr MarchText kTexts[] = {
      {"lights", "--lights", "Lights", "lights", "Where light comes from: headlight (at the eye), far away in a direction that goes with the camera or with the world, or from a point",
       "KIND[:X,Y,Z][@STRENGTH] of headlight, camera, world, point; up to 4 with blanks between them; none",
       [](const MarchSettings& s) { return textOf(s.render.effects.lights); },
       [](MarchSettings& s, std::string_view text, std::string_view name) { s.render.effects.lights = parseLights(text, name); }, isLit},
  };
  return kTexts;
}

}  // namespace warpscope
