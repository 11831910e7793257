// Bounds of what is visible, and the cone of a camera around them.
// See fitting_view.h.
#include "app/scene/fitting_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/base/error.h"
#include "render/volume/macrocells.h"

namespace warpscope {
namespace {

constexpr double kMargin = 1.04;  // on the distance: some 2 % of the picture's side are left free on each
/// A speck in the middle would have the camera inside of it.
constexpr double kNearest = 0.2;

}  // namespace

Box visibleBounds(const Volume& volume, const TransferFunction& function, const std::stop_token& stop) {
  if (stop.stop_requested()) throw OperationCancelled();
  const ValueScale scale = valueScaleOf(volume.type(), volume.statistics(), function);
  const Macrocells cells(volume, scale);
  if (stop.stop_requested()) throw OperationCancelled();
  const std::vector<uint8_t> distances = cells.emptyDistances(bakeTransferTable(function, volume, scale, 1.0f));
  glm::ivec3 first(cells.dims()), last(-1);
  size_t i = 0;
  for (int z = 0; z < cells.dims().z; ++z)
    for (int y = 0; y < cells.dims().y; ++y)
      for (int x = 0; x < cells.dims().x; ++x, ++i) {
        if (distances[i] != 0) continue;
        first = glm::min(first, glm::ivec3(x, y, z));
        last = glm::max(last, glm::ivec3(x, y, z));
      }
  if (last.x < 0) return {};

  // Voxel coordinates. Beyond the outermost centres values are constant, to the ends of the volume.
  const glm::vec3 size(volume.dims()), edges = volume.geometry().voxelEdges();
  const auto edge = static_cast<float>(cells.edge());
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    const float lower = static_cast<float>(first[axis]) * edge, upper = static_cast<float>(last[axis] + 1) * edge;
    box.lower[axis] = (first[axis] > 0 ? lower + 0.5f : 0.0f) * edges[axis];
    box.upper[axis] = (upper < size[axis] - 1.0f ? upper + 0.5f : size[axis]) * edges[axis];
  }
  const glm::vec3 center = 0.5f * size * edges;
  return {box.lower - center, box.upper - center};
}

double fittingDistance(const Scene& scene, const View& view, const Box& box) {
  const Camera camera = makeCamera(scene, {view.angleDeg, view.elevationDeg, 1.0, {}}, 1, 1);
  const double halfFov = 0.5 * scene.fovYDeg * std::numbers::pi / 180.0;
  const double radius = 0.5 * glm::length(glm::dvec3(scene.geometry().bounds().extent()));
  double distance = kNearest;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 point(corner & 1 ? box.upper.x : box.lower.x, corner & 2 ? box.upper.y : box.lower.y, corner & 4 ? box.upper.z : box.lower.z);
    const double towards = -glm::dot(point, glm::dvec3(camera.forward));  // the camera
    const double aside = std::max(std::abs(glm::dot(point, glm::dvec3(camera.right))), std::abs(glm::dot(point, glm::dvec3(camera.up))));
    // Inside a half angle a seen from the distance d (in radii r, over sin a; see makeCamera): aside <= tan a * (d * r / sin a - towards), that is
    // d * r >= aside * cos a + towards * sin a. Of all half angles up to the scene's, which narrower pictures have, the one that asks for most:
    const double angle = std::clamp(std::atan2(towards, aside), 0.0, halfFov);
    distance = std::max(distance, kMargin * (aside * std::cos(angle) + towards * std::sin(angle)) / radius);
  }
  return std::min(distance, 1.0);
}

std::vector<View> fittingViews(const Scene& scene, const std::stop_token& stop) {
  std::vector<View> views = defaultViews();
  const Box box = visibleBounds(*scene.volume, scene.transferFunction, stop);
  if (box.isEmpty()) return views;
  const double factor = fittingDistance(scene, views.front(), box) / views.front().distance;
  for (View& view : views) view.distance *= factor;
  return views;
}

}  // namespace warpscope
