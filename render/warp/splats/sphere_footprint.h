// Which pixels can a sphere cover? A rectangle outside of which no pixel's ray is a hit of intersectSphere, for host and device.
// Tangent planes from the eye, one axis of the image at a time: Mara, McGuire, "2D Polyhedral Bounds of a Clipped,
// Perspective-Projected 3D Sphere", JCGT 2013, section 2; ours takes directions instead of a near plane, and any of camera.h's bases.
#pragma once

#include "render/core/host_device.h"

#include "render/core/camera.h"
#include "render/core/numeric.h"
#include "render/core/ray_sphere.h"
#include "render/core/sample.h"

namespace warpscope {

/// Half-open: pixels x0 <= x < x1, y0 <= y < y1, inside the image. Empty where x0 >= x1 or y0 >= y1.
struct PixelRect {
  int x0, y0, x1, y1;

  WARPSCOPE_HD bool isEmpty() const { return x0 >= x1 || y0 >= y1; }
  bool operator==(const PixelRect&) const = default;
};

/// What footprints need of a camera: make it once for all spheres.
struct FootprintView {
  /// Pixel lines (columns or rows) are planes through the eye. Seen along their common direction they are lines of some
  /// slope: lateral distance over depth.
  struct Axis {
    glm::vec3 lateral;     ///< unit, at right angles to `depth` and to the pixel lines; towards higher pixels
    float centerSlope;     ///< of the image's middle: 0 for an orthonormal basis
    float pixelsPerSlope;  ///< positive
    float pixels;          ///< in the image along this axis
  };

  glm::vec3 eye;
  glm::vec3 depth;  ///< unit normal of the eye's plane (that of right and up), towards what is seen
  Axis columns;
  Axis rows;
};

/// For a camera that isUsable, whose basis need be neither right-handed nor orthonormal beyond what that asks for.
WARPSCOPE_HD inline FootprintView footprintViewOf(const Camera& camera);

/// Every pixel whose pixelRay through its centre is a hit of intersectSphere is inside, rounding included. For a sphere in front of the
/// eye's plane the rectangle is otherwise the smallest, but for pixel lines whose centres pass the outline within kFootprintSlackPixels
/// and kFootprintMargin. A sphere that crosses that plane covers everything on its side of the image. Empty for what nothing can hit:
/// spheres behind the eye or around it, radii that are no positive number, anything beyond float's range.
WARPSCOPE_HD inline PixelRect sphereFootprint(const FootprintView& view, const Sphere& sphere);

/// As above, for a single sphere.
WARPSCOPE_HD inline PixelRect sphereFootprint(const Camera& camera, const Sphere& sphere) {
  return sphereFootprint(footprintViewOf(camera), sphere);
}

/// How much larger than its radius a sphere is taken, relative to |centre - eye| + radius. With u = 2^-24 and in that unit:
/// intersectSphere's own error is at most 8u (see its test), that of a pixel's direction 6u (scale, sum, normalisation), the axes' rounding
/// and the projections onto them 7u, scaling, radius and tangent length 7u, the products and sums of the tangents 5u, the slope 2u. As
/// every error counts as an angle seen from the eye or as a distance, and a larger radius turns both tangents by as much at least, 35u
/// suffice; this is 64u.
inline constexpr float kFootprintMargin = 64.0f / 16777216.0f;

/// Squares below this underflow, flushed to zero or not: intersectSphere then takes any distance for a hit. As a distance: 2^-62.
inline constexpr float kFootprintTiny = 2.1684043e-19f;

/// What rounding of image positions up to kMaxImageSide can move them by, several times over.
inline constexpr float kFootprintSlackPixels = 1.0f / 64.0f;

// --- Implementation, on float and on vectors of them (numeric.h, simd.h)

/// A PixelRect of a number, or of a batch of numbers.
template <class Int>
struct FootprintBounds {
  Int x0, y0, x1, y1;
};

namespace footprint {

template <class Int>
struct Span {
  Int begin, end;
};

WARPSCOPE_HD inline FootprintView::Axis axisOf(const glm::dvec3& across, const glm::dvec3& along, const glm::dvec3& forward,
                                               const glm::dvec3& depth, float edge, float pixels) {
  const glm::dvec3 normal = glm::normalize(glm::cross(along, depth));
  const glm::dvec3 lateral = glm::dot(normal, across) < 0.0 ? -normal : normal;
  // Where all pixels lie within a hair's breadth, a wider pixel changes nothing: the margin covers the whole image either way.
  constexpr double smallestEdge = 1.0 / (1ull << 60);
  const double pixelEdge = edge > smallestEdge ? edge : smallestEdge;
  const double forwardDepth = glm::dot(forward, depth);
  return {glm::vec3(lateral), static_cast<float>(glm::dot(forward, lateral) / forwardDepth),
          static_cast<float>(forwardDepth / (glm::dot(across, lateral) * pixelEdge)), pixels};
}

/// The pixel lines between the tangents from the eye to a circle at (lateral, depth), which is not wholly behind the eye.
template <class Real>
WARPSCOPE_HD inline auto spanOf(const FootprintView::Axis& axis, const Real& lateral, const Real& depth, const Real& radius) {
  const Real zero(0.0f), infinity(kNoHit);
  // The centre's direction turned either way by the angle whose sine is radius / distance and whose cosine is tangent / distance. Seen from
  // the eye, what the difference of squares loses weighs as much as an error of a few u of the radius.
  const Real tangentSquared = lateral * lateral + depth * depth - radius * radius;
  const Real tangent = sqrtOf(maxOf(tangentSquared, zero));
  const Real lowRun = depth * tangent + lateral * radius, highRun = depth * tangent - lateral * radius;
  const Real lowRise = lateral * tangent - depth * radius, highRise = lateral * tangent + depth * radius;
  // A tangent that touches behind the eye's plane bounds nothing; from inside the circle there is none.
  const auto hasTangents = tangentSquared > zero;
  const Real low = selected(hasTangents & (lowRun > zero), lowRise / lowRun, -infinity);
  const Real high = selected(hasTangents & (highRun > zero), highRise / highRun, infinity);
  const auto position = [&](const Real& slope) {
    return (slope - Real(axis.centerSlope)) * Real(axis.pixelsPerSlope) + Real(0.5f * axis.pixels);
  };
  // Centres lie at +0.5; clamping comes before the conversion, which is undefined beyond the integers.
  const Real begin = position(low) + Real(0.5f - kFootprintSlackPixels), end = position(high) + Real(0.5f + kFootprintSlackPixels);
  const Real pixels(axis.pixels);
  return Span<decltype(truncated(begin))>{truncated(minOf(maxOf(begin, zero), pixels)), truncated(minOf(maxOf(end, zero), pixels))};
}

template <class Real>
WARPSCOPE_HD inline Real projected(const Real& x, const Real& y, const Real& z, const glm::vec3& onto) {
  return x * Real(onto.x) + y * Real(onto.y) + z * Real(onto.z);
}

/// (x, y, z): from the eye to the centre.
template <class Real>
WARPSCOPE_HD inline auto boundsOf(const FootprintView& view, const Real& x, const Real& y, const Real& z, const Real& wholeRadius) {
  const Real zero(0.0f);
  // What intersectSphere takes the sphere for, and asks: is the eye outside? In the same words.
  const Real squaredDistance = x * x + y * y + z * z;
  const auto isNear = (wholeRadius > zero) & (Real(4.0f) * wholeRadius * wholeRadius > squaredDistance);
  const Real radius = selected(isNear, Real(0.5f) * sqrtOf(squaredDistance), wholeRadius);
  const Real outside = squaredDistance - radius * radius;
  // One factor brings all lengths to about 1, so that no square leaves float's range.
  const Real sizeX = maxOf(x, -x), sizeY = maxOf(y, -y), sizeZ = maxOf(z, -z);
  const Real largest = maxOf(maxOf(sizeX, sizeY), maxOf(sizeZ, radius));
  constexpr float smallestScale = 7.8886091e-31f;  // 2^-100: far below kFootprintTiny, and its reciprocal is finite
  const Real scale = Real(1.0f) / maxOf(largest, Real(smallestScale));
  const Real grown =
      (radius + Real(kFootprintMargin) * (sizeX + sizeY + sizeZ + radius) + Real(kFootprintTiny)) * scale;
  const Real cx = x * scale, cy = y * scale, cz = z * scale;
  const Real depth = projected(cx, cy, cz, view.depth);
  const auto columns = spanOf(view.columns, projected(cx, cy, cz, view.columns.lateral), depth, grown);
  const auto rows = spanOf(view.rows, projected(cx, cy, cz, view.rows.lateral), depth, grown);
  const auto isSeen = (outside > zero) & (radius > zero) & (largest < Real(kNoHit)) & (depth > -grown);
  const auto end = [&](const auto& last) { return truncated(selected(isSeen, converted(last), zero)); };
  return FootprintBounds<decltype(truncated(x))>{columns.begin, rows.begin, end(columns.end), end(rows.end)};
}

}  // namespace footprint

WARPSCOPE_HD inline FootprintView footprintViewOf(const Camera& camera) {
  // In double, so that rounding to float is the axes' only error.
  const glm::dvec3 right(camera.right), down(-camera.up), forward(camera.forward);
  const glm::dvec3 normal = glm::normalize(glm::cross(right, down));
  const glm::dvec3 depth = glm::dot(normal, forward) < 0.0 ? -normal : normal;
  const float edge = pixelEdge(camera);
  return {camera.eye, glm::vec3(depth), footprint::axisOf(right, down, forward, depth, edge, static_cast<float>(camera.width)),
          footprint::axisOf(down, right, forward, depth, edge, static_cast<float>(camera.height))};
}

WARPSCOPE_HD inline PixelRect sphereFootprint(const FootprintView& view, const Sphere& sphere) {
  const glm::vec3 toCenter = sphere.center - view.eye;
  const auto bounds = footprint::boundsOf(view, toCenter.x, toCenter.y, toCenter.z, sphere.radius);
  return {bounds.x0, bounds.y0, bounds.x1, bounds.y1};
}

}  // namespace warpscope
