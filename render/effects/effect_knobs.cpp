// Rows of the effects' knobs.
// See effect_knobs.h.
#include "render/effects/effect_knobs.h"

#include <algorithm>

namespace warpscope {
namespace {

constexpr Shading kShading;
constexpr Shadows kShadows;

// What the plan says of stages (effect_plan.cpp), as far as settings alone tell.
bool hasMode(const MarchSettings& settings, RenderMode mode) { return settings.render.effects.mode == mode; }
bool hasLight(const MarchSettings& settings, bool isBesideEye) {
  return std::ranges::any_of(settings.render.effects.lights, [&](const Light& light) { return light.strength > 0.0f && !(isBesideEye && light.kind == LightKind::headlight); });
}
bool mayBeLit(const MarchSettings& settings) { return !hasMode(settings, RenderMode::mip); }
bool isLit(const MarchSettings& settings) { return mayBeLit(settings) && settings.render.effects.shading.strength > 0.0f; }
bool isLitByLights(const MarchSettings& settings) { return isLit(settings) && hasLight(settings, false); }
bool hasHighlights(const MarchSettings& settings) { return isLitByLights(settings) && settings.render.effects.shading.specular > 0.0f; }
bool isComposite(const MarchSettings& settings) { return hasMode(settings, RenderMode::composite); }
bool isLitMatter(const MarchSettings& settings) { return isLit(settings) && isComposite(settings); }
bool mayCastShadows(const MarchSettings& settings) { return isLitMatter(settings) && hasLight(settings, true); }
bool isOccluded(const MarchSettings& settings) { return isLitMatter(settings) && settings.render.effects.shadows.occlusion > 0.0f; }
bool hasLightVolume(const MarchSettings& settings) { return isOccluded(settings) || (mayCastShadows(settings) && settings.render.effects.shadows.strength > 0.0f); }
constexpr auto kModeChoices = choicesOf(kRenderModes);
bool hasSurfaces(const MarchSettings& settings) { return settings.render.effects.mode == RenderMode::isosurface; }

bool hasSlab(const MarchSettings& settings) { return settings.render.effects.clip.slab.thickness > 0.0f; }

/// A row for a float of the effects: `Member` says where it is.
template <class Member>
constexpr MarchKnob row(const Knob& knob, Member, bool (*matters)(const MarchSettings&)) {
  return {{&knob, [](const MarchSettings& s) { return double{Member()(s.render.effects)}; },
           [](MarchSettings& s, double value) { Member()(s.render.effects) = static_cast<float>(value); }},
          FramePart::picture,
          matters};
}

}  // namespace

constinit const Knob kModeKnob{.key = "mode",
                               .option = "--mode",
                               .label = "Mode",
                               .noun = "mode of rendering",
                               .help = "What a ray makes of the values along it",
                               .type = KnobType::choice,
                               .owner = KnobOwner::effect,
                               .stale = KnobStage::march,
                               .defaultValue = static_cast<double>(RenderMode::composite),
                               .choices = kModeChoices};

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

constinit const Knob kShadowsKnob{.key = "shadows",
                                  .option = "--shadows",
                                  .label = "Shadows",
                                  .noun = "strength of shadows",
                                  .help = "How much of the light of camera, world and point lights the matter before them takes; 0: no shadows",
                                  .owner = KnobOwner::effect,
                                  .stale = KnobStage::march,
                                  .range = {0.0, 1.0},
                                  .track = {0.0, 1.0},
                                  .defaultValue = kShadows.strength,
                                  .axis = {"shadowStrengths", "--shadow-strengths", "Strengths of shadows"},
                                  .phrase = ", shadows {}",
                                  .naming = KnobNaming::unlessDefault};

constinit const Knob kOcclusionKnob{.key = "occlusion",
                                    .option = "--occlusion",
                                    .label = "Occlusion",
                                    .noun = "strength of ambient occlusion",
                                    .help = "How much of the ambient light the matter around takes; 0: no occlusion",
                                    .owner = KnobOwner::effect,
                                    .stale = KnobStage::march,
                                    .range = {0.0, 1.0},
                                    .track = {0.0, 1.0},
                                    .defaultValue = kShadows.occlusion,
                                    .axis = {"occlusions", "--occlusions", "Strengths of ambient occlusion"},
                                    .phrase = ", occlusion {}",
                                    .naming = KnobNaming::unlessDefault};

constinit const Knob kOcclusionRadiusKnob{.key = "occlusionRadius",
                                          .option = "--occlusion-radius",
                                          .label = "Occl. radius",
                                          .noun = "radius of ambient occlusion",
                                          .help = "How far matter takes ambient light away, in edges of the smallest voxel",
                                          .unit = " voxels",
                                          .owner = KnobOwner::effect,
                                          .stale = KnobStage::march,
                                          .range = {1.0, 256.0},
                                          .track = {1.0, 64.0},
                                          .decimals = 0,
                                          .defaultValue = kShadows.occlusionRadius};

constinit const Knob kLightGridKnob{.key = "lightGrid",
                                    .option = "--light-grid",
                                    .label = "Light's grid",
                                    .noun = "edge of the light's grid",
                                    .help = "Voxels between the places at which shadows and occlusion are found out",
                                    .unit = " voxels",
                                    .owner = KnobOwner::effect,
                                    .stale = KnobStage::march,
                                    .range = {1.0, 64.0},
                                    .track = {1.0, 16.0},
                                    .decimals = 0,
                                    .defaultValue = kShadows.gridEdge};

constinit const Knob kSlabKnob{.key = "slab",
                               .option = "--slab",
                               .label = "Slab",
                               .noun = "thickness of the slab",
                               .help = "Thickness of what is kept between two planes across the view, in edges of the smallest voxel; 0: no slab",
                               .unit = " voxels",
                               .owner = KnobOwner::effect,
                               .stale = KnobStage::march,
                               .range = {0.0, 1e6},
                               .track = {0.0, 256.0},
                               .decimals = 0,
                               .defaultValue = 0.0};

constinit const Knob kSlabDepthKnob{.key = "slabDepth",
                                    .option = "--slab-depth",
                                    .label = "Slab's depth",
                                    .noun = "depth of the slab",
                                    .help = "How far the slab's middle is behind the volume's centre, in edges of the smallest voxel",
                                    .unit = " voxels",
                                    .owner = KnobOwner::effect,
                                    .stale = KnobStage::march,
                                    .range = {-1e6, 1e6},
                                    .track = {-256.0, 256.0},
                                    .decimals = 0,
                                    .defaultValue = 0.0};

constinit const Knob kJitterKnob{.key = "jitter",
                                 .option = "--jitter",
                                 .label = "Jitter",
                                 .noun = "jitter",
                                 .help = "How far a pixel's samples are moved along its ray, of half a step: noise instead of rings; 0: not at all",
                                 .owner = KnobOwner::effect,
                                 .stale = KnobStage::march,
                                 .range = {0.0, 1.0},
                                 .track = {0.0, 1.0},
                                 .defaultValue = 0.0,
                                 .axis = {"jitters", "--jitters", "Strengths of jitter"},
                                 .phrase = ", jitter {}",
                                 .naming = KnobNaming::unlessDefault};

constinit const Knob kPreIntegrationKnob{.key = "preIntegration",
                                         .option = "--pre-integration",
                                         .label = "Pre-integrate",
                                         .noun = "pre-integrated classification",
                                         .help = "Classify each step by the values at both of its ends instead of the one in its middle (Engel, Kraus, Ertl 2001)",
                                         .type = KnobType::flag,
                                         .owner = KnobOwner::effect,
                                         .stale = KnobStage::march,
                                         .defaultValue = 0.0};

std::span<const MarchKnob> effectKnobs() {
  static constexpr MarchKnob kRows[] = {
      {{&kModeKnob, [](const MarchSettings& s) { return static_cast<double>(s.render.effects.mode); },
        [](MarchSettings& s, double value) { s.render.effects.mode = static_cast<RenderMode>(value); }},
       FramePart::picture,
       always},
      row(kShadingKnob, [](auto& effects) -> auto& { return effects.shading.strength; }, mayBeLit),
      row(kAmbientKnob, [](auto& effects) -> auto& { return effects.shading.ambient; }, isLit),
      row(kDiffuseKnob, [](auto& effects) -> auto& { return effects.shading.diffuse; }, isLitByLights),
      row(kSpecularKnob, [](auto& effects) -> auto& { return effects.shading.specular; }, isLitByLights),
      row(kExponentKnob, [](auto& effects) -> auto& { return effects.shading.exponent; }, hasHighlights),
      row(kShadowsKnob, [](auto& effects) -> auto& { return effects.shadows.strength; }, mayCastShadows),
      row(kOcclusionKnob, [](auto& effects) -> auto& { return effects.shadows.occlusion; }, isLitMatter),
      row(kOcclusionRadiusKnob, [](auto& effects) -> auto& { return effects.shadows.occlusionRadius; }, isOccluded),
      row(kLightGridKnob, [](auto& effects) -> auto& { return effects.shadows.gridEdge; }, hasLightVolume),
      row(kSlabKnob, [](auto& effects) -> auto& { return effects.clip.slab.thickness; }, always),
      row(kSlabDepthKnob, [](auto& effects) -> auto& { return effects.clip.slab.depth; }, hasSlab),
      row(kJitterKnob, [](auto& effects) -> auto& { return effects.jitter; }, always),
      {{&kPreIntegrationKnob, [](const MarchSettings& s) { return s.render.effects.preIntegration ? 1.0 : 0.0; },
        [](MarchSettings& s, double value) { s.render.effects.preIntegration = value != 0.0; }},
       FramePart::picture,
       isComposite},
  };
  return kRows;
}

std::span<const MarchText> effectTexts() {
  static constexpr MarchText kTexts[] = {
      {"lights", "--lights", "Lights", "lights", "Where light comes from: headlight (at the eye), far away in a direction that goes with the camera or with the world, or from a point",
       "KIND[:X,Y,Z][@STRENGTH] of headlight, camera, world, point; up to 4 with blanks between them; none",
       [](const MarchSettings& s) { return textOf(s.render.effects.lights); },
       [](MarchSettings& s, std::string_view text, std::string_view name) { s.render.effects.lights = parseLights(text, name); }, isLit},
      {"clipPlanes", "--clip-planes", "Cut by", "clip planes", "Planes that cut the volume: kept is what lies at least so far from its centre along a direction of the world",
       "X,Y,Z,DISTANCE, in the file's units; up to 6 with blanks between them; none",
       [](const MarchSettings& s) { return textOf(s.render.effects.clip.planes); },
       [](MarchSettings& s, std::string_view text, std::string_view name) { s.render.effects.clip.planes = parseClipPlanes(text, name); }, always},
      {"clipBox", "--clip-box", "Cut to", "clip box", "The part of the volume that is kept, along its own axes",
       "X0,Y0,Z0,X1,Y1,Z1, each 0 to 1; none",
       [](const MarchSettings& s) { return textOf(s.render.effects.clip.box); },
       [](MarchSettings& s, std::string_view text, std::string_view name) { s.render.effects.clip.box = parseClipBox(text, name); }, always},
      {"isovalues", "--isovalues", "Iso-values", "iso-values", "Values whose surfaces are shown by the mode isosurface",
       "VALUE[@OPACITY], in the file's units; up to 4 with blanks between them; none",
       [](const MarchSettings& s) { return textOf(s.render.effects.isoValues); },
       [](MarchSettings& s, std::string_view text, std::string_view name) { s.render.effects.isoValues = parseIsoValues(text, name); }, hasSurfaces},
  };
  return kTexts;
}

}  // namespace warpscope
