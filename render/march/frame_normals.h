// Whether segments of a frame are sent with their normals. Host only.
#pragma once

#include "render/effects/relight.h"
#include "render/march/march_setup.h"

namespace warpscope {

/// Whether the plan has segments whose light changes with the eye.
inline bool wantsNormals(const MarchedVolume& marched, const Camera& camera, const RenderSettings& settings, const EffectPlan& plan) {
  return plan.has(PlanStage::raySegments) && dependsOnEye(shadingFor(marched, camera, settings, plan));
}

}  // namespace warpscope
