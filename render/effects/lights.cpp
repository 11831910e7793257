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
  light.strength = takeShare(text, light.strength, kStrengthRange, what + ": the strength");
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
  return textOfList(lights, [](const Light& light) { return textOf(light); });
}

Lights parseLights(std::string_view text, std::string_view name) {
  return parseList<Lights>(text, name, "lights", [&](std::string_view word) { return parseLight(word, name); });
}

}  // namespace warpscope
