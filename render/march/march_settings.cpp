// Checks of the server's knobs.
// See march_settings.h.
#include "render/march/march_settings.h"

#include <cstdio>
#include <string>

#include "render/core/error.h"

namespace warpscope {
namespace {

void requireRange(float value, float lowest, float highest, const char* name) {
  if (value >= lowest && value <= highest) return;  // false for NaN
  char range[96];
  std::snprintf(range, sizeof range, " must be between %g and %g, not %g", lowest, highest, value);
  throw UsageError(name + std::string(range));
}

}  // namespace

void validate(const MarchSettings& settings) {
  requireRange(settings.step, 1e-3f, 1e3f, "the step");
  requireRange(settings.radiusScale, 1e-3f, 1e3f, "the radius scale");
  requireRange(settings.contribution, 1e-6f, 0.5f, "the least contribution");
  requireRange(settings.threshold, 1e-3f, 1.0f, "the threshold");
}

}  // namespace warpscope
