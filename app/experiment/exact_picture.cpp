// Rays, voxels, and sums in double.
// See exact_picture.h.
#include "app/experiment/exact_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "render/core/parallel.h"
#include "render/core/ray_sphere.h"
#include "render/march/ray_trace.h"

namespace warpscope {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The unit direction through a pixel's centre, of the camera as its floats say.
glm::dvec3 directionOf(const Camera& camera, uint32_t x, uint32_t y) {
  const double edge = 2.0 * static_cast<double>(camera.tanHalfFovY) / camera.height;
  const double right = (x + 0.5 - 0.5 * camera.width) * edge, up = (0.5 * camera.height - (y + 0.5)) * edge;
  return glm::normalize(glm::dvec3(camera.forward) + right * glm::dvec3(camera.right) + up * glm::dvec3(camera.up));
}

template <class Voxel>
class ExactRays {
 public:
  ExactRays(const Volume& volume, const TransferFunction& function, float step)
      : voxels_(volume.voxelsAs<Voxel>()),
        dims_(volume.dims()),
        function_(function),
        step_(static_cast<double>(step)),
        edges_(volume.geometry().spacing / volume.geometry().unit()),
        half_(0.5 * edges_ * glm::dvec3(dims_)) {}

  glm::dvec4 color(const glm::dvec3& eye, const glm::dvec3& direction) {
    double enters = 0.0, leaves = kInfinity;
    for (int axis = 0; axis < 3; ++axis) {
      if (direction[axis] == 0.0) {
        if (std::abs(eye[axis]) > half_[axis]) return glm::dvec4(0.0);
        continue;
      }
      const double a = (-half_[axis] - eye[axis]) / direction[axis], b = (half_[axis] - eye[axis]) / direction[axis];
      enters = std::max(enters, std::min(a, b));
      leaves = std::min(leaves, std::max(a, b));
    }
    const double length = leaves - enters;
    if (!(length > 0.0)) return glm::dvec4(0.0);
    const auto count = static_cast<int64_t>(std::ceil(length / step_));
    const glm::dvec3 entry = eye + enters * direction;
    glm::dvec3 gathered(0.0);
    double through = 1.0;
    for (int64_t i = 0; i < count; ++i) {
      const double begin = static_cast<double>(i) * step_;
      const double ds = std::min(step_, length - begin);
      const Look& look = lookAt(entry + (begin + 0.5 * ds) * direction, ds);
      gathered += through * look.alpha * look.color;
      through *= 1.0 - look.alpha;
    }
    return {gathered, 1.0 - through};
  }

 private:
  struct Look {
    double value = std::numeric_limits<double>::quiet_NaN(), ds = 0.0;
    glm::dvec3 color{0.0};
    double alpha = 0.0;
  };

  const Look& lookAt(const glm::dvec3& place, double ds) {
    const double value = valueAt(place);
    if (value == last_.value && ds == last_.ds) return last_;
    last_ = {};
    if (std::isnan(value)) return last_;
    const glm::dvec4 straight(function_.at(value));
    const double alpha = straight.a >= 1.0 ? 1.0 : -std::expm1(ds * std::log1p(-straight.a));
    last_ = {value, ds, glm::dvec3(straight), alpha};
    return last_;
  }

  /// Voxels that are not finite share their weight among the others; no value where that is half or more.
  double valueAt(const glm::dvec3& place) const {
    glm::dvec3 weight;
    glm::u64vec3 low, high;
    for (int axis = 0; axis < 3; ++axis) {
      const double last = dims_[axis] - 1.0;
      const double at = std::clamp((place[axis] + half_[axis]) / edges_[axis] - 0.5, 0.0, last);
      low[axis] = static_cast<uint64_t>(std::min(std::floor(at), std::max(0.0, last - 1.0)));
      high[axis] = std::min<uint64_t>(low[axis] + 1, dims_[axis] - 1);
      weight[axis] = at - static_cast<double>(low[axis]);
    }
    // Relative to one of them: what is equal stays what it is, as it does without rounding.
    double reference = std::numeric_limits<double>::quiet_NaN(), sum = 0.0, weights = 0.0;
    for (int i = 0; i < 8; ++i) {
      const glm::bvec3 isHigh(i & 1, i & 2, i & 4);
      const glm::u64vec3 at = glm::mix(low, high, isHigh);
      const auto voxel = static_cast<double>(voxels_[(at.z * dims_.y + at.y) * dims_.x + at.x]);
      const glm::dvec3 shares = glm::mix(1.0 - weight, weight, isHigh);
      const double share = shares.x * shares.y * shares.z;
      if (!std::isfinite(voxel)) continue;
      if (std::isnan(reference)) reference = voxel;
      sum += share * (voxel - reference);
      weights += share;
    }
    return weights > 0.5 ? reference + sum / weights : std::numeric_limits<double>::quiet_NaN();
  }

  const Voxel* voxels_;
  glm::uvec3 dims_;
  const TransferFunction& function_;
  double step_;
  glm::dvec3 edges_, half_;
  Look last_;
};

/// Of a sphere whose radius is `growth` more, taken as large as it is seen: at most half its distance (ray_sphere.h).
double distanceTo(const Sphere& sphere, const glm::dvec3& eye, const glm::dvec3& direction, double growth) {
  const glm::dvec3 toCenter = glm::dvec3(sphere.center) - eye;
  const double away = glm::length(toCenter);
  const double radius = std::min(static_cast<double>(sphere.radius), 0.5 * away) + growth * (away + static_cast<double>(sphere.radius));
  const double along = glm::dot(toCenter, direction);
  const double beside = glm::length(toCenter - along * direction);
  if (!(along > 0.0) || !(beside <= radius)) return kInfinity;
  return along - std::sqrt((radius - beside) * (radius + beside));
}

/// By how much a sphere's radius may seem to differ, relative to its distance.
constexpr double kUndecided = kSphereSurfaceError;

}  // namespace

Image<glm::vec4> exactPicture(const Volume& volume, const TransferFunction& function, const Camera& camera,
                              const RenderSettings& settings, const std::stop_token& stop) {
  requireWholeRays(volume);
  Image<glm::vec4> picture(camera.width, camera.height);
  const glm::dvec3 eye(camera.eye);
  visitVoxelType(volume.type(), [&](auto voxel) {
    parallelForTiles(camera.width, camera.height, 8, stop, [&](uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) {
      ExactRays<decltype(voxel)> rays(volume, function, settings.step);
      for (uint32_t y = y0; y < y1; ++y)
        for (uint32_t x = x0; x < x1; ++x) picture(x, y) = glm::vec4(rays.color(eye, directionOf(camera, x, y)));
    });
  });
  return picture;
}

ExactHits::ExactHits(std::span<const Sphere> spheres, const Camera& camera, const std::stop_token& stop)
    : spheres_(spheres),
      camera_(camera),
      ids_(camera.width, camera.height, kNoSample),
      farthest_(camera.width, camera.height, kInfinity) {
  const glm::dvec3 eye(camera.eye);
  parallelForTiles(camera.width, camera.height, 8, stop, [&](uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) {
    for (uint32_t y = y0; y < y1; ++y)
      for (uint32_t x = x0; x < x1; ++x) {
        const glm::dvec3 direction = directionOf(camera, x, y);
        double nearest = kInfinity;
        for (uint32_t id = 0; id < spheres.size(); ++id) {
          // What passes far away needs no root.
          const glm::dvec3 offset = glm::cross(glm::dvec3(spheres[id].center) - eye, direction);
          const double reach = 1.001 * static_cast<double>(spheres[id].radius);
          if (glm::dot(offset, offset) > reach * reach) continue;
          const double t = distanceTo(spheres[id], eye, direction, 0.0);
          if (t < nearest) {
            nearest = t;
            ids_(x, y) = id;
          }
          farthest_(x, y) = std::min(farthest_(x, y), distanceTo(spheres[id], eye, direction, -kUndecided));
        }
      }
  });
}

double ExactHits::distance(uint32_t x, uint32_t y, uint32_t id, double growth) const {
  return distanceTo(spheres_[id], glm::dvec3(camera_.eye), directionOf(camera_, x, y), growth);
}

bool ExactHits::allows(uint32_t x, uint32_t y, uint32_t id) const {
  const double farthest = farthest_(x, y);
  if (id >= spheres_.size()) return farthest == kInfinity;
  const double nearest = distance(x, y, id, kUndecided);
  return nearest < kInfinity && nearest <= farthest;
}

}  // namespace warpscope
