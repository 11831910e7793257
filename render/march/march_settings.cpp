// Checks of the server's knobs.
// See march_settings.h.
#include "render/march/march_settings.h"

namespace warpscope {

void validate(const RenderSettings& settings) {
  requireRange(settings.step, kStepRange, "the step");
  requireRange(settings.contribution, kContributionRange, "the least contribution");
}

void validate(const SampleSettings& settings) {
  requireRange(settings.radiusScale, kRadiusScaleRange, "the radius scale");
  requireRange(settings.threshold, kThresholdRange, "the threshold");
  requireRange(static_cast<double>(settings.samplesPerRay), kSamplesPerRayRange, "the number of samples a ray");
}

void validate(const MarchSettings& settings) {
  validate(settings.render);
  validate(settings.sample);
}

}  // namespace warpscope
