// Lights into volume space, in double.
// See shading_setup.h.
#include "render/effects/shading_setup.h"

#include <algorithm>
#include <cmath>

namespace warpscope {
namespace {

/// The values' own steps, as interpolants: 1 for whole numbers, what single precision tells apart for others.
double quantumOf(const Volume& volume, const ValueScale& scale) {
  if (volume.type() != VoxelType::float32 && volume.type() != VoxelType::float64) return 1.0;
  const VoxelStatistics& statistics = volume.statistics();
  return std::max(std::abs(scale.interpolantOf(statistics.lowest)), std::abs(scale.interpolantOf(statistics.highest))) * 0x1p-24;
}

glm::vec3 unitOf(const glm::dvec3& v) { return glm::vec3(glm::normalize(v)); }

PreparedLight prepare(const Light& light, const VolumeGeometry& geometry, const Camera& camera) {
  PreparedLight prepared{light.kind, glm::vec3(0.0f), light.strength};
  const glm::dvec3 vector(light.vector);
  const glm::dmat3 volumeFromWorld = glm::transpose(geometry.direction);
  switch (light.kind) {
    case LightKind::headlight: break;
    case LightKind::camera:
      prepared.vector = unitOf(vector.x * glm::dvec3(camera.right) + vector.y * glm::dvec3(camera.up) - vector.z * glm::dvec3(camera.forward));
      break;
    case LightKind::world: prepared.vector = unitOf(volumeFromWorld * vector); break;
    case LightKind::point: {
      const glm::dvec3 center = geometry.origin + geometry.direction * (geometry.spacing * (glm::dvec3(geometry.dims) - 1.0) * 0.5);
      const glm::dvec3 place = volumeFromWorld * (vector - center) / geometry.unit();
      // So far away its light is everywhere from one direction, and squares of distances would leave single precision.
      constexpr double kFarAway = 0x1p40;
      prepared.vector = glm::length(place) < kFarAway ? glm::vec3(place) : unitOf(place);
      if (!(glm::length(place) < kFarAway)) prepared.kind = LightKind::world;
      break;
    }
  }
  return prepared;
}

}  // namespace

ShadingSetup prepareLights(const Shading& shading, const Lights& lights, const VolumeGeometry& geometry, const Camera& camera) {
  ShadingSetup setup;
  setup.shading = shading;
  setup.isLit = shading.strength > 0.0f;
  setup.hasDiffuse = shading.diffuse > 0.0f;
  setup.hasHighlights = shading.specular > 0.0f;
  for (const Light& light : lights) {
    if (!(light.strength > 0.0f)) continue;
    setup.lights[setup.lightCount++] = prepare(light, geometry, camera);
    setup.hasHalfVectors = setup.hasHalfVectors || (setup.hasHighlights && light.kind != LightKind::headlight);
  }
  setup.noiseSquared = 0x1p-100f;
  return setup;
}

ShadingSetup prepareShading(const Shading& shading, const Lights& lights, const Volume& volume, const ValueScale& scale, const Camera& camera) {
  ShadingSetup setup = prepareLights(shading, lights, volume.geometry(), camera);
  const VoxelStatistics& statistics = volume.statistics();
  const double range = scale.interpolantOf(statistics.highest) - scale.interpolantOf(statistics.lowest);
  const double power = range > 0.0 && std::isfinite(range) ? std::exp2(-std::ceil(std::log2(range))) : 1.0;
  const glm::dvec3 scaled = power / glm::dvec3(volume.geometry().voxelEdges());
  setup.gradientScale = glm::vec3(scaled);
  // Two values, each off by half a step at most, half of whose difference is taken; along three axes.
  const double noise = 0.5 * quantumOf(volume, scale) * glm::length(scaled);
  setup.noiseSquared = std::max(static_cast<float>(noise * noise), 0x1p-100f);
  return setup;
}

}  // namespace warpscope
