// How large a sample is, and its packing: what becomes of a ray that found a depth, for host and device.
// Radius policies: march_settings.h. Pixel footprint: an edge of the image plane's pixel, scaled to the sample's distance from the eye's plane.
#pragma once

#include "render/core/camera.h"
#include "render/core/sample.h"
#include "render/march/depth_heuristic.h"

namespace warpscope {

/// What all rays of a frame share.
struct SampleRule {
  RadiusPolicy policy = RadiusPolicy::voxel;
  float voxelRadius = 1.0f;  ///< half the diagonal of a voxel, volume units
  float scale = 1.0f;        ///< factor on the policy's radius
  SampleQuantization quantization;
};

/// The radius of a sample at distance t along a ray, in volume units. `cosine` is the angle's between ray and camera axis.
WARPSCOPE_HD inline float sampleRadius(const SampleRule& rule, const Camera& camera, float t, float cosine, float opacity) {
  const float pixel = 0.5f * pixelEdge(camera) * t * cosine;
  float radius = rule.voxelRadius;
  if (rule.policy == RadiusPolicy::constant) radius = 0.5f;
  if (rule.policy == RadiusPolicy::pixel) radius = pixel;
  if (rule.policy == RadiusPolicy::opacity) radius = glm::mix(glm::min(pixel, rule.voxelRadius), rule.voxelRadius, opacity);
  return radius * rule.scale;
}

/// A ray's sample; 0 where it has no depth.
WARPSCOPE_HD inline PackedSample packRaySample(const SampleRule& rule, const Camera& camera, const Ray& ray, const DepthResult& depth,
                                               float opacity) {
  if (!depth.hasDepth) return 0;
  const float radius = sampleRadius(rule, camera, depth.depth, glm::dot(ray.direction, camera.forward), opacity);
  return packSample(ray.at(depth.depth), radius, rule.quantization);
}

}  // namespace warpscope
