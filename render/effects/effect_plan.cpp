// The rules of the plan: one for each stage, after those that it depends on.
// See effect_plan.h.
#include "render/effects/effect_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "render/base/range.h"
#include "render/effects/jitter.h"
#include "render/effects/light_volume.h"
#include "render/march/depth_of_samples.h"

namespace warpscope {
namespace {

PlannedStage in(std::string reason) { return {true, std::move(reason)}; }
PlannedStage out(std::string reason) { return {false, std::move(reason)}; }

PlannedStage planSkipping(const PlannedScene& scene, const RenderSettings& settings) {
  if (!settings.skipEmpty) return out("it is switched off");
  if (settings.effects.mode == RenderMode::mip) return in("cells whose values are no greater than what a ray has met are left out");
  if (scene.visibleCells == scene.cells) return out("every cell shows something");
  return in(std::to_string(scene.cells - scene.visibleCells) + " of " + std::to_string(scene.cells) + " cells show nothing");
}

PlannedStage planEarlyEnd(const PlannedScene& scene, const RenderSettings& settings) {
  if (!settings.terminateEarly) return out("it is switched off");
  if (settings.effects.mode == RenderMode::isosurface &&
      std::ranges::none_of(settings.effects.isoValues, [](const IsoValue& value) { return value.opacity > 0.0f && value.opacity < 1.0f; }))
    return out("every surface is opaque and ends its ray by itself");
  if (settings.effects.mode == RenderMode::isosurface) return in("rays may end at a transmittance of " + numberText(settings.contribution));
  // The least that can be left behind a whole ray; twice, since it is rounded on the way.
  const double left = std::exp2(scene.mostSamples * std::log2(std::max(0.0, 1.0 - double{scene.mostOpacity})));
  if (left > 2.0 * double{settings.contribution}) return out("no ray is so long that hardly any light is left");
  return in("rays may end at a transmittance of " + numberText(settings.contribution));
}

std::string clippedBy(const Clip& clip) {
  std::string text;
  const auto add = [&](const std::string& what) { text += (text.empty() ? "" : ", ") + what; };
  if (clip.planes.size() > 0) add(std::to_string(clip.planes.size()) + (clip.planes.size() == 1 ? " plane" : " planes"));
  if (clip.box != ClipBox{}) add("a box");
  if (clip.slab.thickness > 0.0f) add("a slab");
  return text;  // empty if nothing is cut off
}

/// Why stages are out that make no difference to a greatest value.
constexpr std::array<std::pair<PlanStage, const char*>, 12> kOutOfMaximum{{
    {PlanStage::correction, "a greatest value has the opacity of one unit"},
    {PlanStage::gradient, "a greatest value is not lit"},
    {PlanStage::diffuse, "a greatest value is not lit"},
    {PlanStage::specular, "a greatest value is not lit"},
    {PlanStage::halfVector, "a greatest value is not lit"},
    {PlanStage::shadows, "a greatest value is not lit"},
    {PlanStage::occlusion, "a greatest value is not lit"},
    {PlanStage::lightVolume, "a greatest value is not lit"},
    {PlanStage::earlyEnd, "the greatest value may be the last"},
    {PlanStage::secondPass, "the depth is the greatest value's, by every heuristic"},
    {PlanStage::severalSamples, "a ray has one greatest value"},
    {PlanStage::spread, "the depth is the greatest value's, and certain"},
}};

/// Null for stages that may.
const char* whyNotOfMaximum(PlanStage stage) {
  for (const auto& [left, why] : kOutOfMaximum)
    if (left == stage) return why;
  return nullptr;
}

/// What a rule is asked about.
struct PlanQuestion {
  const PlannedScene& scene;
  const RenderSettings& settings;
  const std::optional<SampleSettings>& sample;
  const EffectPlan& plan;  ///< of the stages before this one

  const Shading& shading() const { return settings.effects.shading; }
  /// How many shine, of those that `isCounted`.
  template <class F>
  std::ptrdiff_t lights(F&& isCounted) const {
    return std::ranges::count_if(settings.effects.lights, [&](const Light& light) { return light.strength > 0.0f && isCounted(light); });
  }
  std::ptrdiff_t lights() const {
    return lights([](const Light&) { return true; });
  }
  std::ptrdiff_t lightsBesideEye() const {
    return lights([](const Light& light) { return light.kind != LightKind::headlight; });
  }
  bool hasMode(RenderMode mode) const { return settings.effects.mode == mode; }
};

constexpr const char* kNothingLit = "nothing is lit: shading is 0";
constexpr const char* kOfComposites = "a light volume is of what is composited, not of surfaces";
constexpr const char* kPictureAlone = "no samples are wanted";

std::string countOf(std::ptrdiff_t count, const char* one, const char* several) { return std::to_string(count) + (count == 1 ? one : several); }

/// Why what another mode does is out.
std::string modeOf(const PlanQuestion& q) { return "the mode is " + std::string(nameOf(q.settings.effects.mode)); }

struct PlanRule {
  PlanStage stage;
  PlannedStage (*plan)(const PlanQuestion&);
};

/// One for each stage, in their order.
constexpr std::array<PlanRule, kStages.size()> kRules{{
    {PlanStage::march, [](const PlanQuestion& q) { return in(std::to_string(q.scene.visibleCells) + " cells show something"); }},
    {PlanStage::jitter,
     [](const PlanQuestion& q) {
       return isJittered(q.settings) ? in("jitter is " + numberText(q.settings.effects.jitter)) : out("samples begin where rays enter");
     }},
    {PlanStage::maximum,
     [](const PlanQuestion& q) {
       return q.hasMode(RenderMode::mip) ? in("it stands for its ray, and every heuristic gives its depth") : out(modeOf(q));
     }},
    {PlanStage::surfaces,
     [](const PlanQuestion& q) {
       if (!q.hasMode(RenderMode::isosurface)) return out(modeOf(q));
       return in(countOf(std::ranges::count_if(q.settings.effects.isoValues, [](const IsoValue& value) { return value.opacity > 0.0f; }), " value", " values"));
     }},
    {PlanStage::clip,
     [](const PlanQuestion& q) {
       const std::string cut = clippedBy(q.settings.effects.clip);
       return cut.empty() ? out("nothing is cut off") : in(cut);
     }},
    {PlanStage::skipping, [](const PlanQuestion& q) { return planSkipping(q.scene, q.settings); }},
    {PlanStage::missingVoxels,
     [](const PlanQuestion& q) {
       return q.scene.missingVoxels > 0 ? in(std::to_string(q.scene.missingVoxels) + " voxels are not finite") : out("all voxels are finite");
     }},
    {PlanStage::segments,
     [](const PlanQuestion& q) {
       if (!q.settings.effects.preIntegration) return out("a step is classified by the value in its middle");
       if (!q.hasMode(RenderMode::composite)) return out(modeOf(q));
       // Between a value and none there is no straight way.
       if (q.plan.has(PlanStage::missingVoxels)) return out("voxels are missing: steps are classified by the value in their middle");
       return in("a step is classified by the values at its ends");
     }},
    {PlanStage::refinement,
     [](const PlanQuestion& q) {
       if (q.plan.has(PlanStage::segments)) return out("steps are looked up between their ends' values");
       if (q.hasMode(RenderMode::isosurface)) return out("a surface's colour is that of its value");
       return q.scene.isRefined ? in("the transfer function changes faster than its table's entries") : out("the table's entries are fine enough");
     }},
    {PlanStage::correction,
     [](const PlanQuestion& q) {
       if (q.hasMode(RenderMode::isosurface)) return out("a surface has no thickness");
       return q.settings.step == 1.0f ? out("the step is the one that opacities are given for") : in("the step is " + numberText(q.settings.step));
     }},
    {PlanStage::gradient, [](const PlanQuestion& q) { return q.shading().strength > 0.0f ? in("matter is lit") : out(kNothingLit); }},
    {PlanStage::diffuse,
     [](const PlanQuestion& q) {
       if (!q.plan.has(PlanStage::gradient)) return out(kNothingLit);
       if (q.lights() == 0) return out("ambient light alone: there is no light");
       if (!(q.shading().diffuse > 0.0f)) return out("ambient light alone: diffuse light is 0");
       return in(countOf(q.lights(), " light", " lights"));
     }},
    {PlanStage::specular,
     [](const PlanQuestion& q) {
       if (!q.plan.has(PlanStage::gradient)) return out(kNothingLit);
       if (q.lights() == 0) return out("there is no light");
       return q.shading().specular > 0.0f ? in("specular light is " + numberText(q.shading().specular)) : out("specular light is 0");
     }},
    {PlanStage::halfVector,
     [](const PlanQuestion& q) {
       if (!q.plan.has(PlanStage::gradient)) return out(kNothingLit);
       if (!q.plan.has(PlanStage::specular)) return out("there are no highlights");
       const auto besideEye = q.lightsBesideEye();
       if (besideEye == 0) return out("the light is at the eye: the half vector is the viewer's");
       return in(countOf(besideEye, " light is", " lights are") + " not at the eye");
     }},
    {PlanStage::shadows,
     [](const PlanQuestion& q) {
       if (!(q.settings.effects.shadows.strength > 0.0f)) return out("the strength of shadows is 0");
       if (!q.plan.has(PlanStage::gradient)) return out(kNothingLit);
       if (q.hasMode(RenderMode::isosurface)) return out(kOfComposites);
       if (q.lightsBesideEye() == 0) return out("the light is at the eye, which sees none of its shadows");
       if (!q.plan.has(PlanStage::diffuse) && !q.plan.has(PlanStage::specular)) return out("there is no diffuse and no specular light");
       return in(countOf(q.lightsBesideEye(), " light casts", " lights cast") + " them");
     }},
    {PlanStage::occlusion,
     [](const PlanQuestion& q) {
       const Shadows& shadows = q.settings.effects.shadows;
       if (!(shadows.occlusion > 0.0f)) return out("the strength of ambient occlusion is 0");
       if (!q.plan.has(PlanStage::gradient)) return out(kNothingLit);
       if (q.hasMode(RenderMode::isosurface)) return out(kOfComposites);
       if (!(q.shading().ambient > 0.0f)) return out("there is no ambient light");
       return in("matter within " + numberText(shadows.occlusionRadius) + " voxels takes ambient light");
     }},
    {PlanStage::lightVolume,
     [](const PlanQuestion& q) {
       const bool casts = q.plan.has(PlanStage::shadows);
       const int channels = (casts ? static_cast<int>(q.lightsBesideEye()) : 0) + (q.plan.has(PlanStage::occlusion) ? 1 : 0);
       if (channels == 0) return out("there are no shadows and no occlusion");
       const LightVolume volume = lightVolumeLayout(q.scene.dims, channels, q.settings.effects.shadows.gridEdge);
       const bool goesWithCamera = casts && q.lights([](const Light& light) { return light.kind == LightKind::camera; }) > 0;
       const char* const lasts = goesWithCamera                                       ? "made anew when the camera moves, since a light goes with it"
                                 : q.settings.effects.clip.slab.thickness > 0.0f ? "made anew when the camera moves, since the slab goes with it"
                                                                                 : "kept while the camera moves";
       return in("a place every " + numberText(volume.edge) + " voxels, " + std::to_string(volume.dims.x) + "x" + std::to_string(volume.dims.y) + "x" +
                 std::to_string(volume.dims.z) + "; " + lasts);
     }},
    {PlanStage::earlyEnd, [](const PlanQuestion& q) { return planEarlyEnd(q.scene, q.settings); }},
    {PlanStage::secondPass,
     [](const PlanQuestion& q) {
       if (!q.sample) return out(kPictureAlone);
       const std::string heuristic(nameOf(q.sample->heuristic));
       return hasOnePass(q.sample->heuristic) ? out(heuristic + " is known after one pass") : in(heuristic + " compares with the ray's final opacity");
     }},
    {PlanStage::severalSamples,
     [](const PlanQuestion& q) {
       if (!q.sample) return out(kPictureAlone);
       return q.sample->samplesPerRay > 1 ? in("up to " + std::to_string(q.sample->samplesPerRay) + " samples a ray") : out("one sample a ray");
     }},
    {PlanStage::spread,
     [](const PlanQuestion& q) {
       if (!q.sample) return out(kPictureAlone);
       if (q.sample->radiusPolicy == RadiusPolicy::uncertainty) return in("samples are as large as their depth is uncertain");
       return q.sample->sendsSpread ? in("samples are sent with the spread of their depth") : out("nobody asked for it");
     }},
    {PlanStage::raySegments,
     [](const PlanQuestion& q) {
       if (!q.sample) return out(kPictureAlone);
       return q.sample->segments > 0 ? in("up to " + std::to_string(q.sample->segments) + " segments a ray") : out("nobody asked for any");
     }},
}};

constexpr bool areInOrder() {
  for (size_t i = 0; i < kRules.size(); ++i)
    if (kRules[i].stage != kStages[i].stage || static_cast<size_t>(kRules[i].stage) != i || kRules[i].plan == nullptr) return false;
  return true;
}
static_assert(areInOrder(), "each stage has a row and a rule, in the order of PlanStage");

}  // namespace

EffectPlan::EffectPlan(const PlannedScene& scene, const RenderSettings& settings, const std::optional<SampleSettings>& sample,
                       const std::optional<DecidedStage>& decided) {
  const auto isDecided = [&](PlanStage stage) { return decided && decided->stage == stage; };
  const RenderMode mode = settings.effects.mode;
  if (scene.visibleCells == 0 && !isDecided(PlanStage::march)) {
    const char* const why = mode == RenderMode::isosurface ? "no surface runs through any cell" : "the transfer function hides everything";
    for (PlannedStage& stage : stages_) stage = out(why);
    return;
  }
  const PlanQuestion question{scene, settings, sample, *this};
  for (const PlanRule& rule : kRules) {
    PlannedStage& stage = stages_[static_cast<size_t>(rule.stage)];
    const char* const notOfMaximum = mode == RenderMode::mip ? whyNotOfMaximum(rule.stage) : nullptr;
    if (isDecided(rule.stage))
      stage = {decided->isIn, "it was decided"};
    else
      stage = notOfMaximum != nullptr ? out(notOfMaximum) : rule.plan(question);
  }
}

}  // namespace warpscope
