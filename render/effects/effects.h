// What a scene asks for beyond emission and absorption: the effects that change its picture, each out unless it is asked for.
// Which of them have work to do for a picture: effect_plan.h.
#pragma once

#include "render/effects/clip_settings.h"
#include "render/effects/lights.h"
#include "render/effects/mode_settings.h"

namespace warpscope {

/// How matter looks in light (shading.h). With strength 0 it shines by itself, as the transfer function says.
struct Shading {
  float strength = 0.0f;  ///< 0..1, from unlit to lit
  float ambient = 0.25f;  ///< share of its colour that it has in any light
  float diffuse = 0.75f;  ///< share that it has more where it faces a light of strength 1
  float specular = 0.2f;  ///< white that it has more where it mirrors one
  float exponent = 20.0f; ///< the greater, the smaller and sharper highlights are

  bool operator==(const Shading&) const = default;
};

/// What stands in the light's way (light_volume.h): in lit scenes alone.
struct Shadows {
  float strength = 0.0f;         ///< 0..1: share of each light beside the eye that matter before it may take
  float occlusion = 0.0f;        ///< 0..1: share of the ambient light that matter around may take
  float occlusionRadius = 8.0f;  ///< how far around, in edges of the smallest voxel
  float gridEdge = 2.0f;         ///< between the places at which that is found out, in voxels; greater where memory asks for it

  bool operator==(const Shadows&) const = default;
};

struct Effects {
  RenderMode mode = RenderMode::composite;
  IsoValues isoValues{};  ///< of the mode isosurface
  Shading shading;
  Shadows shadows;
  Lights lights = defaultLights();
  Clip clip{};
  bool preIntegration = false;  ///< steps are classified by the values at their ends (segment_table.h), not by the one in their middle
  float jitter = 0.0f;  ///< 0..1, of half a step: how far a pixel's samples are moved along its ray (jitter.h)

  bool operator==(const Effects&) const = default;
};

}  // namespace warpscope
