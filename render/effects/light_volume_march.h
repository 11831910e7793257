// Fills a light volume: one place and channel at a time, by marches towards the light. For host and device.
// Directions of ambient light: Lebedev 1976, 14 points, exact for polynomials of degree 5 on the sphere.
#pragma once

#include "render/core/counters.h"
#include "render/core/floating_point.h"
#include "render/effects/clip.h"
#include "render/effects/light_volume.h"
#include "render/effects/shading.h"
#include "render/march/march.h"

namespace warpscope {

/// What the values are found out by.
struct LightVolumeJob {
  /// Transmittance below which the march towards a light ends: by so much is a value too great at most.
  static constexpr float kLeastLight = 1.0f / 1024;

  LightVolume volume;
  ShadingSetup shading;  ///< its lights
  ClipSetup clip;        ///< what is cut off casts no shadow
  glm::vec3 lower{0.0f};       ///< of the voxels' view, in volume space
  glm::vec3 voxelEdges{1.0f};  ///< units of volume space
  float step = 0.5f;           ///< along the rays, for which the transfer table was made
  float besideVisible = 0.0f;  ///< how far from cells that show something what is lit may lie, voxels: the middle of a step between two values
};

/// What arrives through the matter along a ray, up to `length`. Off by what marching by steps of job.step is off by, and kLeastLight.
template <class Source, class View>
WARPSCOPE_HD inline float lightAlong(const LightVolumeJob& job, const View& view, const Ray& ray, float length) {
  const auto interval = [&] { return intersectBox(reciprocalOf(ray.origin, ray.direction), job.clip.bounds, 0.0f, length); };
#if defined(__CUDA_ARCH__)
  const RayInterval inside = interval();
#else
  const RayInterval inside = exceptionsExpected(interval);  // parallel to slabs: as box.h says
#endif
  const RayPath path{ray, makeLattice(clipped(job.clip, ray, inside), job.step)};
  if (path.lattice.count == 0) return 1.0f;
  const auto makeSource = [&] { return Source(view, path.ray, path.lattice); };
#if defined(__CUDA_ARCH__)
  Source source = makeSource();
#else
  Source source = exceptionsExpected(makeSource);
#endif
  RayOpacity gathered;
  WARPSCOPE_COUNT(secondaryRays, 1);
  marchRay(path, 0, path.lattice.count, source, Unlit{}, RayLimits{2.0f, LightVolumeJob::kLeastLight}, gathered,
           [](const CountingSample&) { return true; });  // none contributes 2: none counts
  return gathered.transmittance.value();
}

/// The share of ambient light that arrives from within the radius: the mean over all directions.
template <class Source, class View>
WARPSCOPE_HD inline float ambientAt(const LightVolumeJob& job, const View& view, const glm::vec3& place) {
  constexpr float kFace = 1.0f / 15, kCorner = 3.0f / 40, kDiagonal = 0.577350269f;
  float sum = 0.0f;
  for (int i = 0; i < 14; ++i) {
    glm::vec3 direction(0.0f);
    if (i < 6)
      direction[i >> 1] = i & 1 ? 1.0f : -1.0f;
    else
      direction = glm::vec3((i - 6) & 1 ? kDiagonal : -kDiagonal, (i - 6) & 2 ? kDiagonal : -kDiagonal, (i - 6) & 4 ? kDiagonal : -kDiagonal);
    sum = mulAdd(i < 6 ? kFace : kCorner, lightAlong<Source>(job, view, Ray{place, direction}, job.volume.radius), sum);
  }
  return minOf(sum, 1.0f);
}

/// True if no sample that is seen reads the place: such are as far away as from place to place, once more towards the light, and as what is lit lies beside what is visible.
template <class View>
WARPSCOPE_HD inline bool isUnread(const LightVolumeJob& job, const View& view, const float (&voxel)[3]) {
  if (view.cells.distances == nullptr) return false;
  glm::ivec3 cell;
  for (int axis = 0; axis < 3; ++axis)
    cell[axis] = minOf(truncated(minOf(maxOf(voxel[axis], 0.0f), view.ends[axis].lastVoxel)) >> view.cells.edgeBits, view.cells.dims[axis] - 1);
  return converted((view.cells.distance(cell) - 1) * view.cells.edge()) >= 2.0f * job.volume.edge + 1.0f + job.besideVisible;
}

/// Writes the values of the `index`-th place.
template <class Source, class View>
WARPSCOPE_HD inline void fillPlace(const LightVolumeJob& job, const View& view, size_t index, uint16_t* values) {
  const LightVolume& volume = job.volume;
  const size_t x = static_cast<size_t>(volume.dims.x), y = static_cast<size_t>(volume.dims.y);
  const float voxel[3] = {static_cast<float>(index % x) * volume.edge, static_cast<float>(index / x % y) * volume.edge, static_cast<float>(index / (x * y)) * volume.edge};
  uint16_t* const own = values + index * static_cast<size_t>(volume.channels);
  if (isUnread(job, view, voxel)) {
    for (int i = 0; i < volume.channels; ++i) own[i] = LightVolume::valueOf(1.0f);
    return;
  }
  glm::vec3 place;
  for (int axis = 0; axis < 3; ++axis) place[axis] = mulAdd(voxel[axis] + 0.5f, job.voxelEdges[axis], job.lower[axis]);
  for (int i = 0; i < job.shading.lightCount; ++i) {
    if (volume.ofLight[i] < 0) continue;
    const PreparedLight& light = job.shading.lights[i];
    glm::vec3 toLight = light.vector;
    float distance = INFINITY;
    if (light.kind == LightKind::point) distance = unitTowards(light, place, toLight);
    own[volume.ofLight[i]] = LightVolume::valueOf(distance > 0.0f ? lightAlong<Source>(job, view, Ray{place, toLight}, distance) : 1.0f);
  }
  if (volume.ofAmbient >= 0) own[volume.ofAmbient] = LightVolume::valueOf(ambientAt<Source>(job, view, place));
}

}  // namespace warpscope
