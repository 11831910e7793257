// Pieces of spheres along a ray, as what they are of: surfaces, each of which counts once. For host and device.
// A sample tells of its own pixel's frustum and of no more: what a ray meets of its sphere beside that is its neighbours' to say. Pieces that follow one another and whose spheres touch
// are of one surface, as fragments within an interval of depth are where surfaces are splatted (Zwicker, Pfister, van Baar, Gross 2001, "Surface splatting", section 5); unless they are
// of one ray of the frame, whose samples lie behind one another.
#pragma once

#include "render/core/color.h"
#include "render/core/ray_sphere.h"
#include "render/warp/multihit/nearest_hits.h"
#include "render/warp/multihit/surface_radii.h"

namespace warpscope {

/// How many pieces of a ray are kept for so many surfaces: one surface may have a few. More show no other picture where it was measured.
WARPSCOPE_HD inline constexpr int piecesFor(int surfaces) { return surfaces + 2 > kMaxHits ? kMaxHits : surfaces + 2; }

/// What lies in a pixel of a frame, as rays from one origin see it: where distance[k] + t * dot(normal[k], direction) >= 0 for all k.
struct PixelFrustum {
  glm::vec3 normal[4];  ///< inwards, of any length
  float distance[4];    ///< in units of those
};

/// `origin` leads from the frame's eye to that of the rays.
WARPSCOPE_HD inline PixelFrustum frustumOf(const PixelGrid& pixels, PackedSample sample, const glm::vec3& origin) {
  const glm::vec2 middle = pixels.offsetOf(columnOf(sample), rowOf(sample));
  const float half = 0.5f * pixels.edge;
  PixelFrustum frustum{{pixels.right - (middle.x - half) * pixels.forward, (middle.x + half) * pixels.forward - pixels.right,
                        pixels.up - (middle.y - half) * pixels.forward, (middle.y + half) * pixels.forward - pixels.up},
                       {}};
  for (int k = 0; k < 4; ++k) frustum.distance[k] = glm::dot(frustum.normal[k], origin);
  return frustum;
}

/// How far along it a ray in `direction` (unit) passes the centre of the sphere that it enters at `entry`, if it meets what of it lies in the frustum; kNoHit if it does not, or `entry`
/// is. Never less than `entry`. By this, not by where they begin, samples are behind one another: a large sphere may begin in front of a small one whose centre is nearer.
WARPSCOPE_HD inline float pieceDistance(const PixelFrustum& frustum, const glm::vec3& direction, const glm::vec3& toCenter, float entry) {
  if (!(entry < kNoHit)) return kNoHit;
  const float along = glm::dot(toCenter, direction);
  float begin = entry, end = 2.0f * along - entry;
  for (int k = 0; k < 4; ++k) {
    const float rate = glm::dot(frustum.normal[k], direction);
    if (rate > 0.0f)
      begin = maxOf(-frustum.distance[k] / rate, begin);
    else if (rate < 0.0f)
      end = minOf(-frustum.distance[k] / rate, end);
    else if (frustum.distance[k] < 0.0f)
      return kNoHit;
  }
  return begin <= end ? along : kNoHit;
}

/// What a ray shows.
struct SurfacesSeen {
  uint32_t nearest = kNoSample;  ///< the sample that shows the first surface
  glm::vec4 color{0.0f};         ///< linear, premultiplied
};

/// The first `most` surfaces along `ray` (unit direction) over one another, each in the colour of that of its samples whose centre the ray passes most closely; of equally close ones the
/// first. `hits` are the ray's pieces by pieceDistance(): id(i) for i < count, kNoSample behind the last. Of `samples`: sphere(id), the one that the pieces are of; pixel(id), see
/// pixelKey(); color(id), linear and premultiplied.
template <class Samples, class Hits>
WARPSCOPE_HD inline SurfacesSeen surfacesOf(const Samples& samples, const Ray& ray, const Hits& hits, int count, int most) {
  SurfacesSeen seen;
  const auto idAt = [&](int i) { return i < count ? hits.id(i) : kNoSample; };
  const auto squaredDistance = [&](const glm::vec3& center) {
    const glm::vec3 toCenter = center - ray.origin, offset = toCenter - glm::dot(toCenter, ray.direction) * ray.direction;
    return glm::dot(offset, offset);
  };
  uint32_t id = idAt(0);
  for (int i = 1, surfaces = 0; id != kNoSample && surfaces < most; ++i, ++surfaces) {
    uint32_t best = id, next = idAt(i);
    if (next != kNoSample) {  // else nothing is to be compared
      const uint32_t firstPixel = samples.pixel(id);
      uint32_t lastPixel = firstPixel;
      Sphere last = samples.sphere(id);
      for (float least = squaredDistance(last.center); next != kNoSample; next = idAt(++i)) {
        const uint32_t pixel = samples.pixel(next);
        const Sphere sphere = samples.sphere(next);
        const glm::vec3 apart = sphere.center - last.center;
        const float touching = kRadiusSlack * (sphere.radius + last.radius);
        if (pixel == firstPixel || pixel == lastPixel || glm::dot(apart, apart) > touching * touching) break;
        const float distance = squaredDistance(sphere.center);
        if (distance < least) {
          least = distance;
          best = next;
        }
        last = sphere;
        lastPixel = pixel;
      }
    }
    seen.color = surfaces == 0 ? samples.color(best) : over(seen.color, samples.color(best));
    if (surfaces == 0) seen.nearest = best;
    id = next;
  }
  return seen;
}

}  // namespace warpscope
