// Checks of the server's knobs.
// See march_settings.h.
#include "render/march/march_settings.h"

namespace warpscope {

void validate(const MarchSettings& settings) {
  requireRange(settings.step, kStepRange, "the step");
  requireRange(settings.radiusScale, kRadiusScaleRange, "the radius scale");
  requireRange(settings.contribution, kContributionRange, "the least contribution");
  requireRange(settings.threshold, kThresholdRange, "the threshold");
}

}  // namespace warpscope
