// Marches with and without.
// See stage_costs.h.
#include "app/experiment/stage_costs.h"

#include "render/base/error.h"

namespace warpscope {
namespace {

/// The camera, turned by hardly anything to one side and the other: what marches keep from one camera to the next they have, what goes with the camera is
/// made again, as while somebody moves.
Camera turnedAside(Camera camera, int run) {
  constexpr float kAngle = 1e-3f;
  const float side = run % 2 == 0 ? kAngle : -kAngle;
  const glm::vec3 forward = camera.forward;
  camera.forward = glm::normalize(forward + side * camera.right);
  camera.right = glm::normalize(camera.right - side * forward);
  return camera;
}

double marchMs(Marcher& marcher, const Camera& camera, const MarchSettings& settings, const std::stop_token& stop) {
  return marcher.march(camera, settings, stop).timings.marchMs;
}

}  // namespace

std::optional<MarchSettings> without(PlanStage stage, const MarchSettings& settings) {
  MarchSettings left = settings;
  switch (stage) {
    case PlanStage::skipping: left.render.skipEmpty = false; return left;
    case PlanStage::earlyEnd: left.render.terminateEarly = false; return left;
    case PlanStage::gradient: left.render.effects.shading.strength = 0.0f; return left;
    case PlanStage::clip: left.render.effects.clip = {}; return left;
    case PlanStage::segments: left.render.effects.preIntegration = false; return left;
    case PlanStage::jitter: left.render.effects.jitter = 0.0f; return left;
    case PlanStage::shadows: left.render.effects.shadows.strength = 0.0f; return left;
    case PlanStage::occlusion: left.render.effects.shadows.occlusion = 0.0f; return left;
    case PlanStage::specular: left.render.effects.shading.specular = 0.0f; return left;
    case PlanStage::secondPass: left.sample.heuristic = Heuristic::gradient; return left;
    case PlanStage::severalSamples: left.sample.samplesPerRay = 1; return left;
    case PlanStage::spread:
      left.sample.sendsSpread = false;
      if (left.sample.radiusPolicy == RadiusPolicy::uncertainty) left.sample.radiusPolicy = RadiusPolicy::voxel;
      return left;
    case PlanStage::raySegments: left.sample.segments = 0; return left;
    case PlanStage::march:
    case PlanStage::maximum:
    case PlanStage::surfaces:
    case PlanStage::missingVoxels:
    case PlanStage::refinement:
    case PlanStage::correction:
    case PlanStage::diffuse:
    case PlanStage::lightVolume:
    case PlanStage::halfVector: break;
  }
  return std::nullopt;
}

StageCosts measureStages(Marcher& marcher, const Camera& camera, const MarchSettings& settings, const EffectPlan& plan, int runs,
                         const std::function<void(std::string_view stage)>& onStage, const std::stop_token& stop) {
  StageCosts costs;
  std::vector<double> whole;
  int turn = 0;
  marchMs(marcher, camera, settings, stop);
  const auto measure = [&](const MarchSettings* left) {
    std::vector<double> added;
    if (left != nullptr) marchMs(marcher, camera, *left, stop);
    for (int run = 0; run < runs; ++run) {
      if (stop.stop_requested()) throw OperationCancelled();
      const Camera turned = turnedAside(camera, ++turn);
      const double with = marchMs(marcher, turned, settings, stop);
      whole.push_back(with);
      if (left != nullptr) added.push_back(with - marchMs(marcher, turned, *left, stop));
    }
    return added;
  };
  for (const StageDescriptor& stage : kStages) {
    if (!plan.has(stage.stage)) continue;
    const std::optional<MarchSettings> left = without(stage.stage, settings);
    if (!left) continue;
    onStage(stage.name);
    costs.added[stage.stage] = measuredOf(measure(&*left));
  }
  if (whole.empty()) measure(nullptr);
  costs.march = measuredOf(std::move(whole));
  return costs;
}

}  // namespace warpscope
