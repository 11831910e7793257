// The rules of the plan: one for each stage, after those that it depends on.
// See effect_plan.h.
#include "render/effects/effect_plan.h"

#include <algorithm>
#include <cmath>

#include "render/base/range.h"
#include "render/effects/light_volume.h"
#include "render/march/depth_heuristic.h"

namespace warpscope {
namespace {

PlannedStage in(std::string reason) { return {true, std::move(reason)}; }
PlannedStage out(std::string reason) { return {false, std::move(reason)}; }

PlannedStage planSkipping(const PlannedScene& scene, const RenderSettings& settings) {
  if (!settings.skipEmpty) return out("it is switched off");
  if (scene.visibleCells == scene.cells) return out("every cell shows something");
  return in(std::to_string(scene.cells - scene.visibleCells) + " of " + std::to_string(scene.cells) + " cells show nothing");
}

PlannedStage planEarlyEnd(const PlannedScene& scene, const RenderSettings& settings) {
  if (!settings.terminateEarly) return out("it is switched off");
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

/// How many lights of those that shine and are not at the eye go with the camera.
long lightsOfCamera(const Lights& lights) {
  return std::ranges::count_if(lights, [](const Light& light) { return light.strength > 0.0f && light.kind == LightKind::camera; });
}

PlannedStage planShadows(const Effects& effects, long besideEye) {
  if (!(effects.shadows.strength > 0.0f)) return out("the strength of shadows is 0");
  if (!(effects.shading.strength > 0.0f)) return out("nothing is lit: shading is 0");
  if (besideEye == 0) return out("the light is at the eye, which sees none of its shadows");
  if (!(effects.shading.diffuse > 0.0f || effects.shading.specular > 0.0f)) return out("there is no diffuse and no specular light");
  return in(std::to_string(besideEye) + (besideEye == 1 ? " light casts" : " lights cast") + " them");
}

PlannedStage planOcclusion(const Effects& effects) {
  if (!(effects.shadows.occlusion > 0.0f)) return out("the strength of ambient occlusion is 0");
  if (!(effects.shading.strength > 0.0f)) return out("nothing is lit: shading is 0");
  if (!(effects.shading.ambient > 0.0f)) return out("there is no ambient light");
  return in("matter within " + numberText(effects.shadows.occlusionRadius) + " voxels takes ambient light");
}

bool isTwoPass(Heuristic heuristic) {
  return visitHeuristic(heuristic, []<class Depth>(Depth) { return Depth::kTwoPass; });
}

}  // namespace

EffectPlan::EffectPlan(const PlannedScene& scene, const RenderSettings& settings, const std::optional<SampleSettings>& sample) {
  const Shading& shading = settings.effects.shading;
  if (scene.visibleCells == 0) {
    for (PlannedStage& stage : stages_) stage = out("the transfer function hides everything");
    return;
  }
  at(PlanStage::march) = in(std::to_string(scene.visibleCells) + " cells show something");
  const std::string cut = clippedBy(settings.effects.clip);
  at(PlanStage::clip) = cut.empty() ? out("nothing is cut off") : in(cut);
  at(PlanStage::skipping) = planSkipping(scene, settings);
  at(PlanStage::missingVoxels) =
      scene.missingVoxels > 0 ? in(std::to_string(scene.missingVoxels) + " voxels are not finite") : out("all voxels are finite");
  at(PlanStage::refinement) = scene.isRefined ? in("the transfer function changes faster than its table's entries") : out("the table's entries are fine enough");
  at(PlanStage::correction) = settings.step == 1.0f ? out("the step is the one that opacities are given for") : in("the step is " + numberText(settings.step));
  at(PlanStage::earlyEnd) = planEarlyEnd(scene, settings);

  const auto lights = std::ranges::count_if(settings.effects.lights, [](const Light& light) { return light.strength > 0.0f; });
  const auto besideEye =
      std::ranges::count_if(settings.effects.lights, [](const Light& light) { return light.strength > 0.0f && light.kind != LightKind::headlight; });
  if (!(shading.strength > 0.0f)) {
    for (const PlanStage stage : {PlanStage::gradient, PlanStage::diffuse, PlanStage::specular, PlanStage::halfVector}) at(stage) = out("nothing is lit: shading is 0");
  } else {
    at(PlanStage::gradient) = in("matter is lit");
    const bool isDiffuse = lights > 0 && shading.diffuse > 0.0f;
    at(PlanStage::diffuse) = in(isDiffuse ? std::to_string(lights) + (lights == 1 ? " light" : " lights") : "ambient light alone");
    at(PlanStage::specular) = lights == 0              ? out("there is no light")
                          : shading.specular > 0.0f ? in("specular light is " + numberText(shading.specular))
                                                    : out("specular light is 0");
    at(PlanStage::halfVector) = !has(PlanStage::specular) ? out("there are no highlights")
                            : besideEye == 0      ? out("the light is at the eye: the half vector is the viewer's")
                                                  : in(std::to_string(besideEye) + (besideEye == 1 ? " light is" : " lights are") + " not at the eye");
  }

  at(PlanStage::shadows) = planShadows(settings.effects, besideEye);
  at(PlanStage::occlusion) = planOcclusion(settings.effects);
  const bool casts = has(PlanStage::shadows);
  const int channels = (casts ? static_cast<int>(besideEye) : 0) + (has(PlanStage::occlusion) ? 1 : 0);
  if (channels == 0) {
    at(PlanStage::lightVolume) = out("there are no shadows and no occlusion");
  } else {
    const LightVolume volume = lightVolumeLayout(scene.dims, channels, settings.effects.shadows.gridEdge);
    const char* const lasts = casts && lightsOfCamera(settings.effects.lights) > 0 ? "made anew when the camera moves, since a light goes with it"
                              : settings.effects.clip.slab.thickness > 0.0f         ? "made anew when the camera moves, since the slab goes with it"
                                                                                    : "kept while the camera moves";
    at(PlanStage::lightVolume) = in("a place every " + numberText(volume.edge) + " voxels, " + std::to_string(volume.dims.x) + "x" + std::to_string(volume.dims.y) + "x" +
                                    std::to_string(volume.dims.z) + "; " + lasts);
  }

  const std::string pictureAlone = "no samples are wanted";
  if (!sample) {
    at(PlanStage::secondPass) = out(pictureAlone);
    at(PlanStage::severalSamples) = out(pictureAlone);
    return;
  }
  const std::string heuristic(nameOf(sample->heuristic));
  at(PlanStage::secondPass) = isTwoPass(sample->heuristic) ? in(heuristic + " compares with the ray's final opacity") : out(heuristic + " is known after one pass");
  at(PlanStage::severalSamples) = sample->samplesPerRay > 1 ? in("up to " + std::to_string(sample->samplesPerRay) + " samples a ray") : out("one sample a ray");
}

}  // namespace warpscope
