// Moving views.
// See orbit.h. y grows downwards, as pointers do.
#include "app/scene/orbit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace warpscope {
namespace {

constexpr double kDegreesPerHeight = 180.0;
constexpr double kZoomPerNotch = 0.12;  // natural logarithm of the factor on the distance
constexpr double kNearest = 0.05, kFarthest = 20.0;
constexpr double kFarthestPan = 20.0;

}  // namespace

View orbited(View view, const glm::dvec2& dragHeights) {
  view.angleDeg = std::remainder(view.angleDeg - kDegreesPerHeight * dragHeights.x, 360.0);
  view.elevationDeg = std::clamp(view.elevationDeg + kDegreesPerHeight * dragHeights.y, -90.0, 90.0);
  return view;
}

View panned(View view, double fovYDeg, double widthOverHeight, const glm::dvec2& dragHeights) {
  // The height of the picture at the distance of the point looked at, in radii of the bounding sphere; see makeCamera.
  const double tanHalfFovY = std::tan(fovYDeg * std::numbers::pi / 360.0);
  const double narrower = std::atan(tanHalfFovY * std::min(1.0, widthOverHeight));
  const double height = 2.0 * tanHalfFovY * view.distance / std::sin(narrower);
  view.pan.x = std::clamp(view.pan.x - height * dragHeights.x, -kFarthestPan, kFarthestPan);
  view.pan.y = std::clamp(view.pan.y + height * dragHeights.y, -kFarthestPan, kFarthestPan);
  return view;
}

View zoomed(View view, double notches) {
  view.distance = std::clamp(view.distance * std::exp(-kZoomPerNotch * notches), kNearest, kFarthest);
  return view;
}

}  // namespace warpscope
