// Lights of a scene as a setting: where they are, whether they go with the camera, how strong they are; and their text form.
// Kinds after what volume renderers offer: headlight, directional, positional.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include <glm/vec3.hpp>

#include "render/base/named_value.h"
#include "render/base/short_list.h"

namespace warpscope {

enum class LightKind {
  headlight,  ///< at the eye
  camera,     ///< infinitely far, in a direction that goes with the camera: right, up, backward
  world,      ///< infinitely far, in a direction of the world
  point,      ///< at a place in the world
};

inline constexpr std::array<NamedValue<LightKind>, 4> kLightKinds{{
    {LightKind::headlight, "headlight", "at the eye"},
    {LightKind::camera, "camera", "far away, towards X,Y,Z: right, up and backward of the camera, with which it goes"},
    {LightKind::world, "world", "far away, towards X,Y,Z of the world"},
    {LightKind::point, "point", "at X,Y,Z of the world"},
}};

struct Light {
  LightKind kind = LightKind::headlight;
  glm::vec3 vector{0.0f};  ///< towards the light, not 0; of a point light its place, in the volume's world units
  float strength = 1.0f;   ///< of its diffuse and specular light, >= 0

  bool operator==(const Light&) const = default;
};

/// The lights of a scene; without any there is ambient light alone.
struct Lights : ShortList<Light, 4> {
  static constexpr float kMostStrength = 16.0f;
  /// No component of a direction or place is greater.
  static constexpr float kFarthest = 1e12f;
};

/// "headlight" alone.
constexpr Lights defaultLights() {
  Lights lights;
  lights.add({});
  return lights;
}

/// "headlight@0.5 camera:-1,1,1": lights with blanks between them, KIND[:X,Y,Z][@STRENGTH]; "none" for none. Reads back as the same.
std::string textOf(const Lights& lights);
/// Back. Throws UsageError that begins with `name` and says which light is wrong and why.
Lights parseLights(std::string_view text, std::string_view name);

}  // namespace warpscope
