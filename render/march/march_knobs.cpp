// Rows of the marching's knobs.
// See march_knobs.h.
#include "render/march/march_knobs.h"

#include <algorithm>
#include <vector>

#include "render/effects/effect_knobs.h"
#include "render/march/depth_heuristic.h"

namespace warpscope {
namespace {

constexpr auto kHeuristicChoices = choicesOf(kHeuristics);
constexpr auto kRadiusChoices = choicesOf(kRadiusPolicies);

constexpr double place(Heuristic heuristic) { return static_cast<double>(heuristic); }
constexpr double place(RadiusPolicy policy) { return static_cast<double>(policy); }

constexpr double kSweptHeuristics[] = {place(Heuristic::gradient), place(Heuristic::median), place(Heuristic::expected)};
constexpr double kSweptRadii[] = {place(RadiusPolicy::voxel), place(RadiusPolicy::opacity)};

constexpr RenderSettings kRender;
constexpr SampleSettings kSample;

/// Else a ray has one greatest value, whose depth every heuristic gives.
bool isNoMaximum(const MarchSettings& settings) { return settings.render.effects.mode != RenderMode::mip; }

bool hasThreshold(const MarchSettings& settings) {
  return isNoMaximum(settings) && visitHeuristic(settings.sample.heuristic, []<class Depth>(Depth) { return requires { Depth::kTakesThreshold; }; });
}

}  // namespace

constinit const Knob kStepKnob{.key = "step",
                     .option = "--step",
                     .label = "Step",
                     .noun = "step",
                     .help = "Distance of samples along a ray, in edges of the smallest voxel",
                     .unit = " voxels",
                     .owner = KnobOwner::rendering,
                     .stale = KnobStage::march,
                     .range = kStepRange,
                     .track = {0.1, 4.0},
                     .scale = KnobScale::logarithmic,
                     .defaultValue = kRender.step,
                     .axis = {"steps", "--steps", "Distances of samples along a ray, voxels"},
                     .phrase = ", step {}",
                     .naming = KnobNaming::whereDiffering};

constinit const Knob kContributionKnob{.key = "contribution",
                             .option = "--contribution",
                             .noun = "least contribution",
                             .help = "Least share of full opacity that lets a sample count; a ray ends where less light is left",
                             .owner = KnobOwner::rendering,
                             .stale = KnobStage::march,
                             .range = kContributionRange,
                             .track = kContributionRange,
                             .scale = KnobScale::logarithmic,
                             .defaultValue = kRender.contribution};

constinit const Knob kSkipEmptyKnob{.key = "skipEmpty",
                          .noun = "leaving out of what is empty",
                          .help = "Leave out what the transfer function hides; never changes the picture",
                          .type = KnobType::flag,
                          .owner = KnobOwner::rendering,
                          .stale = KnobStage::march,
                          .defaultValue = kRender.skipEmpty};

constinit const Knob kTerminateEarlyKnob{.key = "terminateEarly",
                               .noun = "early end of rays",
                               .help = "End a ray where hardly any light is left (Levoy 1990); never changes a depth",
                               .type = KnobType::flag,
                               .owner = KnobOwner::rendering,
                               .stale = KnobStage::march,
                               .defaultValue = kRender.terminateEarly};

constinit const Knob kHeuristicKnob{.key = "heuristic",
                          .option = "--heuristic",
                          .label = "Heuristic",
                          .noun = "heuristic",
                          .help = "Which point of a ray stands for its pixel (Zellmann, Aumueller, Lang 2012)",
                          .type = KnobType::choice,
                          .owner = KnobOwner::sampling,
                          .stale = KnobStage::march,
                          .defaultValue = place(kSample.heuristic),
                          .choices = kHeuristicChoices,
                          .axis = {"heuristics", "--heuristics", "Heuristics, by name", kSweptHeuristics},
                          .phrase = ", {}"};

constinit const Knob kThresholdKnob{.key = "threshold",
                          .option = "--threshold",
                          .label = "Threshold",
                          .noun = "threshold",
                          .help = "Accumulated opacity at which the heuristics threshold and rel-threshold stop",
                          .owner = KnobOwner::sampling,
                          .stale = KnobStage::march,
                          .range = kThresholdRange,
                          .track = {0.05, 1.0},
                          .defaultValue = kSample.threshold,
                          .axis = {"thresholds", "--thresholds", "Opacities at which threshold and rel-threshold stop"},
                          .phrase = " at {}",
                          .naming = KnobNaming::unlessDefault};

constinit const Knob kRadiusKnob{.key = "radius",
                       .option = "--radius",
                       .label = "Radius",
                       .noun = "radius policy",
                       .help = "How large a sample is (voxel: Zellmann 2020)",
                       .type = KnobType::choice,
                       .owner = KnobOwner::sampling,
                       .stale = KnobStage::march,
                       .defaultValue = place(kSample.radiusPolicy),
                       .choices = kRadiusChoices,
                       .axis = {"radii", "--radii", "Radius policies, by name", kSweptRadii},
                       .phrase = ", {}"};

constinit const Knob kRadiusScaleKnob{.key = "radiusScale",
                            .option = "--radius-scale",
                            .label = "Radius scale",
                            .noun = "radius scale",
                            .help = "Factor on the radius",
                            .unit = " ×",
                            .owner = KnobOwner::sampling,
                            .stale = KnobStage::march,
                            .range = kRadiusScaleRange,
                            .track = {0.1, 4.0},
                            .scale = KnobScale::logarithmic,
                            .defaultValue = kSample.radiusScale,
                            .axis = {"radiusScales", "--radius-scales", "Factors on radii"},
                            .phrase = " x {}",
                            .naming = KnobNaming::unlessDefault};

constinit const Knob kSamplesPerRayKnob{.key = "samplesPerRay",
                                        .option = "--samples-per-ray",
                                        .label = "Samples",
                                        .noun = "number of samples a ray",
                                        .help = "How many samples a ray yields at most: its opacity in so many equal parts, a sample each",
                                        .unit = " a ray",
                                        .type = KnobType::whole,
                                        .owner = KnobOwner::sampling,
                                        .stale = KnobStage::march,
                                        .range = kSamplesPerRayRange,
                                        .track = kSamplesPerRayRange,
                                        .defaultValue = static_cast<double>(kSample.samplesPerRay),
                                        .axis = {"sampleCounts", "--sample-counts", "Samples that a ray yields at most"},
                                        .phrase = ", {} samples a ray",
                                        .naming = KnobNaming::unlessDefault};

constinit const Knob kSpreadKnob{.key = "spread",
                                 .option = "--spread",
                                 .noun = "spread of depth",
                                 .help = "Send with each sample how uncertain its depth is: the standard deviation of depth along its ray, by contribution",
                                 .type = KnobType::flag,
                                 .owner = KnobOwner::sampling,
                                 .stale = KnobStage::march,
                                 .defaultValue = kSample.sendsSpread};

constinit const Knob kSegmentsKnob{.key = "segments",
                                   .option = "--segments",
                                   .label = "Segments",
                                   .noun = "number of segments a ray",
                                   .help = "Segments of each ray that are sent beside its samples, at most: where light comes from along it, for the technique segments",
                                   .unit = " a ray",
                                   .type = KnobType::whole,
                                   .owner = KnobOwner::sampling,
                                   .stale = KnobStage::march,
                                   .range = kSegmentsRange,
                                   .track = kSegmentsRange,
                                   .defaultValue = static_cast<double>(kSample.segments),
                                   .axis = {"segmentCounts", "--segment-counts", "Segments of a ray that are sent at most"},
                                   .phrase = ", {} segments a ray",
                                   .naming = KnobNaming::unlessDefault};

constinit const Knob kProxyKnob{.key = "proxy",
                                .option = "--proxy",
                                .label = "Proxy",
                                .noun = "size of the volume's copy",
                                .help = "Voxels along the longest edge of a coarse copy of the volume that is sent once, for what no frame has seen; 0: none",
                                .unit = " voxels",
                                .type = KnobType::whole,
                                .owner = KnobOwner::sampling,
                                .stale = KnobStage::march,
                                .range = kProxyRange,
                                .track = kProxyRange,
                                .defaultValue = static_cast<double>(kSample.proxy),
                                .axis = {"proxySizes", "--proxy-sizes", "Voxels along the longest edge of the volume's copy"},
                                .phrase = ", a copy of {} voxels",
                                .naming = KnobNaming::unlessDefault};

namespace {

const MarchKnob kOwnRows[] = {
    {{&kHeuristicKnob, [](const MarchSettings& s) { return place(s.sample.heuristic); },
      [](MarchSettings& s, double value) { s.sample.heuristic = static_cast<Heuristic>(value); }},
     FramePart::depth,
     always},
    {{&kThresholdKnob, [](const MarchSettings& s) { return double{s.sample.threshold}; },
      [](MarchSettings& s, double value) { s.sample.threshold = static_cast<float>(value); }},
     FramePart::depth,
     hasThreshold},
    {{&kRadiusKnob, [](const MarchSettings& s) { return place(s.sample.radiusPolicy); },
      [](MarchSettings& s, double value) { s.sample.radiusPolicy = static_cast<RadiusPolicy>(value); }},
     FramePart::radius,
     always},
    {{&kRadiusScaleKnob, [](const MarchSettings& s) { return double{s.sample.radiusScale}; },
      [](MarchSettings& s, double value) { s.sample.radiusScale = static_cast<float>(value); }},
     FramePart::radius,
     always},
    {{&kSamplesPerRayKnob, [](const MarchSettings& s) { return static_cast<double>(s.sample.samplesPerRay); },
      [](MarchSettings& s, double value) { s.sample.samplesPerRay = static_cast<int>(value); }},
     FramePart::samples,
     isNoMaximum},
    {{&kSpreadKnob, [](const MarchSettings& s) { return s.sample.sendsSpread ? 1.0 : 0.0; },
      [](MarchSettings& s, double value) { s.sample.sendsSpread = value != 0.0; }},
     FramePart::planes,
     always},
    {{&kSegmentsKnob, [](const MarchSettings& s) { return static_cast<double>(s.sample.segments); },
      [](MarchSettings& s, double value) { s.sample.segments = static_cast<int>(value); }},
     FramePart::segments,
     always},
    {{&kProxyKnob, [](const MarchSettings& s) { return static_cast<double>(s.sample.proxy); },
      [](MarchSettings& s, double value) { s.sample.proxy = static_cast<int>(value); }},
     FramePart::proxy,
     always},
    {{&kStepKnob, [](const MarchSettings& s) { return double{s.render.step}; },
      [](MarchSettings& s, double value) { s.render.step = static_cast<float>(value); }},
     FramePart::picture,
     always},
    {{&kContributionKnob, [](const MarchSettings& s) { return double{s.render.contribution}; },
      [](MarchSettings& s, double value) { s.render.contribution = static_cast<float>(value); }},
     FramePart::picture,
     always},
    {{&kSkipEmptyKnob, [](const MarchSettings& s) { return s.render.skipEmpty ? 1.0 : 0.0; },
      [](MarchSettings& s, double value) { s.render.skipEmpty = value != 0.0; }},
     FramePart::picture,
     always},
    {{&kTerminateEarlyKnob, [](const MarchSettings& s) { return s.render.terminateEarly ? 1.0 : 0.0; },
      [](MarchSettings& s, double value) { s.render.terminateEarly = value != 0.0; }},
     FramePart::picture,
     always},
};

}  // namespace

std::span<const MarchKnob> marchKnobs() {
  static const std::vector<MarchKnob> kRows = [] {
    std::vector<MarchKnob> rows(std::begin(kOwnRows), std::end(kOwnRows));
    const std::span<const MarchKnob> ofEffects = effectKnobs();
    rows.insert(rows.end(), ofEffects.begin(), ofEffects.end());
    return rows;
  }();
  return kRows;
}

std::span<const MarchText> marchTexts() { return effectTexts(); }

const MarchText* findMarchText(std::string_view key) {
  for (const MarchText& text : marchTexts())
    if (text.key == key) return &text;
  return nullptr;
}

}  // namespace warpscope
