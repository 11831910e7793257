// Checks of the server's knobs.
// See march_settings.h.
#include "render/march/march_settings.h"

#include <string>

#include "render/core/error.h"

namespace warpscope {
namespace {

void requireRange(float value, float lowest, float highest, const char* name) {
  if (value >= lowest && value <= highest) return;  // false for NaN
  throw UsageError(std::string(name) + " must be between " + std::to_string(lowest) + " and " + std::to_string(highest) +
                   ", not " + std::to_string(value));
}

}  // namespace

void validate(const MarchSettings& settings) {
  requireRange(settings.step, 1e-3f, 1e3f, "the step");
  requireRange(settings.radiusScale, 1e-3f, 1e3f, "the radius scale");
  requireRange(settings.contribution, 1e-6f, 0.5f, "the least contribution");
  requireRange(settings.threshold, 1e-3f, 1.0f, "the threshold");
}

}  // namespace warpscope
