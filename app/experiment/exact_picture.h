// What pictures would be without rounding: the same definitions as render/march/march.h and render/core/ray_sphere.h, in double, ray by ray.
// Written for itself, without any formula of theirs, so that it can be compared with; slow.
#pragma once

#include <span>
#include <stop_token>

#include "render/core/camera.h"
#include "render/core/image.h"
#include "render/core/sample.h"
#include "render/core/transfer_function.h"
#include "render/march/march_settings.h"
#include "render/volume/volume.h"

namespace warpscope {

/// What Marcher::render approximates, without early ends of rays: linear, premultiplied. Throws OperationCancelled if
/// `stop` is set.
Image<glm::vec4> exactPicture(const Volume& volume, const TransferFunction& function, const Camera& camera,
                              const RenderSettings& settings, const std::stop_token& stop = {});

/// The first sphere along each pixel's ray, and which others rounding may take for it.
class ExactHits {
 public:
  /// `spheres` stay where they are. Throws OperationCancelled if `stop` is set.
  ExactHits(std::span<const Sphere> spheres, const Camera& camera, const std::stop_token& stop = {});

  const Image<uint32_t>& ids() const { return ids_; }  ///< kNoSample where there is none
  /// Whether `id`, or kNoSample, may be what a pixel shows: hits are undecided within what intersectSphere() is declared to be off by.
  bool allows(uint32_t x, uint32_t y, uint32_t id) const;

 private:
  double distance(uint32_t x, uint32_t y, uint32_t id, double growth) const;

  std::span<const Sphere> spheres_;
  Camera camera_;
  Image<uint32_t> ids_;
  Image<double> farthest_;  // that what is shown may be: the first hit with spheres a little smaller
};

}  // namespace warpscope
