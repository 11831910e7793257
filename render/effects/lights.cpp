// Reading and writing lights.
// See lights.h.
#include "render/effects/lights.h"

#include <cmath>
#include <optional>

#include "render/base/error.h"
#include "render/base/nearest_name.h"
#include "render/base/range.h"
#include "render/effects/setting_text.h"

namespace warpscope {
namespace {

constexpr Range kStrengthRange{0.0, Lights::kMostStrength};
constexpr Range kComponentRange{-Lights::kFarthest, Lights::kFarthest};

std::string textOf(const Light& light) {
  std::string text(nameOf(kLightKinds, light.kind));
  if (light.kind != LightKind::headlight) text += ":" + textOfNumbers({&light.vector.x, 3});
  if (light.strength != 1.0f) text += "@" + numberText(light.strength);
  return text;
}

Light parseLight(std::string_view text, std::string_view name) {
  const std::string what = std::string(name) + ": " + quotedSetting(text);
  Light light;
  const size_t at = text.find('@');
  if (at != std::string_view::npos) {
    const std::string ofStrength = what + ": the strength";
    light.strength = static_cast<float>(requireNumber(text.substr(at + 1), kStrengthRange, ofStrength));
    requireRange(light.strength, kStrengthRange, ofStrength);
    text = text.substr(0, at);
  }
  const size_t colon = text.find(':');
  const auto* kind = findNamed(kLightKinds, text.substr(0, colon));
  if (kind == nullptr) throw UsageError(std::string(name) + ": " + unknownNameIn(kLightKinds, "light", text.substr(0, colon).substr(0, 40)));
  light.kind = kind->value;
  if (light.kind == LightKind::headlight) {
    if (colon != std::string_view::npos) throw UsageError(what + ": a headlight is at the eye and has no direction");
    return light;
  }
  if (colon == std::string_view::npos) throw UsageError(what + ": wants three numbers, " + std::string(kind->name) + ":X,Y,Z");
  parseNumbers(text.substr(colon + 1), {&light.vector.x, 3}, kComponentRange, what);
  const glm::vec3& v = light.vector;
  if (light.kind != LightKind::point && !(std::hypot(v.x, v.y, v.z) > 1e-9f))
    throw UsageError(what + ": a direction must not be a zero vector");
  return light;
}

}  // namespace

std::string textOf(const Lights& lights) {
  std::string text;
  for (const Light& light : lights) text += (text.empty() ? "" : " ") + textOf(light);
  return text.empty() ? "none" : text;
}

Lights parseLights(std::string_view text, std::string_view name) {
  Lights lights;
  for (const std::string_view word : settingWords(text)) {
    if (lights.size() == Lights::kMost)
      throw UsageError(std::string(name) + ": at most " + std::to_string(Lights::kMost) + " lights are possible");
    lights.add(parseLight(word, name));
  }
  return lights;
}

}  // namespace warpscope
