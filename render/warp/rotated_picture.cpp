// Directions of pixels, taken back to where the frame's picture shows them.
// See rotated_picture.h.
#include "render/warp/rotated_picture.h"

#include <algorithm>
#include <cmath>

#include "render/core/parallel.h"
#include "render/march/own_picture.h"

namespace warpscope {
namespace {

glm::dmat3 basisOf(const Camera& camera) {
  return {glm::dvec3(camera.right), glm::dvec3(camera.up), glm::dvec3(camera.forward)};
}

/// From coordinates along right and up on the plane at distance 1 from the eye to pixels, of the image's size.
glm::dmat3 pixelFromPlane(const Camera& camera) {
  const double halfWidth = 0.5 * camera.width, halfHeight = 0.5 * camera.height;
  const double perUnit = halfHeight / camera.tanHalfFovY;
  return {glm::dvec3(perUnit, 0.0, 0.0), glm::dvec3(0.0, -perUnit, 0.0), glm::dvec3(halfWidth, halfHeight, 1.0)};
}

/// From a direction of `camera` to that in which `from` sees the point where it meets the plane, on whose side of its eye; without changing its sign where
/// the plane is in front of both.
glm::dmat3 seenOnPlane(const Camera& from, const Camera& camera, double nearness) {
  if (!(nearness > 0.0)) return glm::dmat3(1.0);
  // The point is eye + s direction with 1 / s = (direction . forward) / depth, depth being that of the plane from `camera`: all of it times depth / s.
  const glm::dvec3 offset = glm::dvec3(camera.eye) - glm::dvec3(from.eye), forward(from.forward);
  const double rest = 1.0 - nearness * glm::dot(offset, forward);
  const glm::dmat3 seen = rest * glm::dmat3(1.0) + glm::outerProduct(nearness * offset, forward);
  return rest < 0.0 ? -seen : seen;
}

/// Two neighbours along one axis, and how much the second one counts.
struct Between {
  uint32_t first, second;
  float share;
};

/// Shares are so fine: a centre that is met but for rounding is met, so that its neighbours, which may be uncovered,
/// have no share.
constexpr uint32_t kShares = 1024;

/// `place` in pixels, centres at +0.5, from 0 to `count`.
Between betweenCentres(double place, uint32_t count) {
  const double centre = std::clamp(place - 0.5, 0.0, static_cast<double>(count - 1));
  const auto shares = static_cast<uint32_t>(centre * kShares + 0.5);
  const uint32_t first = shares / kShares;
  return {first, std::min(first + 1, count - 1), static_cast<float>(shares % kShares) / kShares};
}

struct Mixed {
  glm::vec4 color{0.0f};
  uint32_t sample = kNoSample;
};

Mixed mixedAt(const WarpedImage& own, double column, double row) {
  const Between x = betweenCentres(column, own.color.width()), y = betweenCentres(row, own.color.height());
  Mixed mixed;
  float most = 0.0f;
  const auto add = [&](uint32_t atX, uint32_t atY, float weight) {
    const uint32_t sample = own.samples(atX, atY);
    if (sample == kNoSample) return;
    mixed.color += weight * own.color(atX, atY);
    if (weight > most) mixed.sample = sample;
    most = std::max(most, weight);
  };
  add(x.first, y.first, (1.0f - x.share) * (1.0f - y.share));
  add(x.second, y.first, x.share * (1.0f - y.share));
  add(x.first, y.second, (1.0f - x.share) * y.share);
  add(x.second, y.second, x.share * y.share);
  return mixed;
}

}  // namespace

WarpedImage ownImageOf(const SampleFrame& frame) {
  WarpedImage image;
  image.samples = ownPicture(frame);
  resolveRayColors(frame, image.samples, image.color);
  return image;
}

void drawRotated(const WarpedImage& own, const Camera& from, const Camera& camera, WarpedImage& image,
                 const std::stop_token& stop, double nearness) {
  requireUsable(camera);
  requireUsable(from);
  image.samples.reshape(camera.width, camera.height);
  image.color.reshape(camera.width, camera.height);
  // The inverse and not the transpose: bases are orthonormal but for rounding, and equal ones are to give equal
  // directions.
  const glm::dmat3 ownFromPixel =
      pixelFromPlane(from) * glm::inverse(basisOf(from)) * seenOnPlane(from, camera, nearness) * basisOf(camera) * glm::inverse(pixelFromPlane(camera));
  constexpr size_t kRows = 8;
  parallelForRanges(camera.height, kRows, stop, [&](size_t begin, size_t end) {
    for (size_t row = begin; row < end; ++row) {
      const glm::dvec3 first = ownFromPixel * glm::dvec3(0.5, static_cast<double>(row) + 0.5, 1.0);
      for (uint32_t column = 0; column < camera.width; ++column) {
        const glm::dvec3 scaled = first + static_cast<double>(column) * ownFromPixel[0];
        const double x = scaled.x / scaled.z, y = scaled.y / scaled.z;
        const bool isSeen = scaled.z > 0.0 && x >= 0.0 && x <= from.width && y >= 0.0 && y <= from.height;
        const Mixed mixed = isSeen ? mixedAt(own, x, y) : Mixed{};
        const size_t pixel = row * camera.width + column;
        image.color[pixel] = mixed.color;
        image.samples[pixel] = mixed.sample;
      }
    }
  });
}

}  // namespace warpscope
