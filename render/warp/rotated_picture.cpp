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

/// From the image's centre to its edges, on the plane at distance 1 from the eye.
glm::dvec2 halfExtentOf(const Camera& camera) {
  const double y = camera.tanHalfFovY;
  return {y * camera.width / camera.height, y};
}

/// Two neighbours along one axis, and how much the second one counts.
struct Between {
  uint32_t first, second;
  float share;
};

/// Shares are so fine: a centre that is met but for rounding is met, so that its neighbours, which may be uncovered,
/// have no share.
constexpr double kShares = 1024.0;

/// `place` in pixels, centres at +0.5, from 0 to `count`.
Between betweenCentres(double place, uint32_t count) {
  const double centre = std::round(std::clamp(place - 0.5, 0.0, static_cast<double>(count - 1)) * kShares) / kShares;
  const auto first = static_cast<uint32_t>(centre);
  return {first, std::min(first + 1, count - 1), static_cast<float>(centre - first)};
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
                 const std::stop_token& stop) {
  requireUsable(camera);
  requireUsable(from);
  image.samples.reshape(camera.width, camera.height);
  image.color.reshape(camera.width, camera.height);
  // The inverse and not the transpose: bases are orthonormal but for rounding, and equal ones are to give equal
  // directions.
  const glm::dmat3 fromOfCamera = glm::inverse(basisOf(from)) * basisOf(camera);
  const glm::dvec2 half = halfExtentOf(camera), halfOfFrom = halfExtentOf(from);
  const glm::dvec2 sizeOfFrom(from.width, from.height);
  constexpr size_t kRows = 8;
  parallelForRanges(camera.height, kRows, stop, [&](size_t begin, size_t end) {
    for (size_t row = begin; row < end; ++row) {
      const double y = half.y * (1.0 - (2.0 * static_cast<double>(row) + 1.0) / camera.height);
      for (uint32_t column = 0; column < camera.width; ++column) {
        const double x = half.x * ((2.0 * column + 1.0) / camera.width - 1.0);
        const glm::dvec3 direction = fromOfCamera * glm::dvec3(x, y, 1.0);
        const double placeX = 0.5 * sizeOfFrom.x * (1.0 + direction.x / (direction.z * halfOfFrom.x));
        const double placeY = 0.5 * sizeOfFrom.y * (1.0 - direction.y / (direction.z * halfOfFrom.y));
        const bool isSeen =
            direction.z > 0.0 && placeX >= 0.0 && placeX <= sizeOfFrom.x && placeY >= 0.0 && placeY <= sizeOfFrom.y;
        const Mixed mixed = isSeen ? mixedAt(own, placeX, placeY) : Mixed{};
        const size_t pixel = row * camera.width + column;
        image.color[pixel] = mixed.color;
        image.samples[pixel] = mixed.sample;
      }
    }
  });
}

}  // namespace warpscope
