// What a ray has met of a frame's segments, front to back. For host and device.
#pragma once

#include "render/march/ray_state.h"
#include "render/warp/segments/fill_reason.h"
#include "render/warp/warp.h"

namespace warpscope {

/// What a ray has met so far.
struct WalkedRay {
  glm::vec3 color{0.0f};  ///< linear, premultiplied
  float through = 1.0f;   ///< what is left of light from behind
  float guessed = 0.0f;   ///< the part of the opacity that what is not known was given

  /// What shines by `share` of that light, in front of what comes behind.
  WARPSCOPE_HD void pass(const glm::vec3& light, float share, float itsOpacity) {
    const float seen = through * share;
    for (int channel = 0; channel < 3; ++channel) color[channel] = mulAdd(seen, light[channel], color[channel]);
    through *= 1.0f - itsOpacity;
  }
  /// As pass, for light that no frame says anything about.
  WARPSCOPE_HD void guess(const glm::vec3& itsColor, float itsOpacity) {
    guessed = mulAdd(through, itsOpacity, guessed);
    pass(itsColor, 1.0f, itsOpacity);
  }

  /// What the copy has there.
  WARPSCOPE_HD void fill(const RayLight& light, FillReason reason) {
    const float opacity = static_cast<float>(1.0 - light.transmittance);
    if (reason == FillReason::unknown)
      guess(glm::vec3(light.color), opacity);
    else
      pass(glm::vec3(light.color), 1.0f, opacity);
  }

  WARPSCOPE_HD glm::vec4 seen() const { return {color, 1.0f - through}; }
  /// What its pixel is: a guess where that can be seen.
  WARPSCOPE_HD uint32_t id() const { return !(through < 1.0f) ? kNoSample : guessed >= kSeenGuess ? kFilled : kNotASample; }
  static constexpr float kSeenGuess = 1.0f / 32;
};

}  // namespace warpscope
