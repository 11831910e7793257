// Which sphere does each pixel of a camera see first: one interface, and the hierarchy of lbvh.h behind it.
// Zellmann 2020, section "ray tracing" (closest hit, no shading); a plain search over all spheres serves as the tests'
// truth.
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "render/core/camera.h"
#include "render/core/image.h"
#include "render/warp/lbvh/lbvh_builder.h"

namespace warpscope {

class SphereTracer {
 public:
  virtual ~SphereTracer() = default;

  /// Replaces the cloud; `spheres` may go afterwards. Throws as validateSpheres does; the tracer then holds
  /// no spheres.
  virtual void build(std::span<const Sphere> spheres) = 0;

  /// For every pixel of `camera` (see isUsable) the id, that is the place in the cloud, of the first sphere along its
  /// ray: of equally near ones the lowest, kNoSample where there is none. Spheres near the eye are taken as large
  /// as they are seen (see seenRadius). `depth`, unless null, takes the distance along the ray, kNoHit where there is none. Both images
  /// are resized to the camera's size. Throws OperationCancelled if `stop` is set; the images are then incomplete. Not
  /// to be called while building.
  virtual void trace(const Camera& camera, Image<uint32_t>& ids, Image<float>* depth,
                     const std::stop_token& stop) const = 0;
};

/// Packets of rays through an LBVH.
class LbvhTracer final : public SphereTracer {
 public:
  explicit LbvhTracer(Arithmetic arithmetic = Arithmetic::stable) : arithmetic_(arithmetic) {}
  void build(std::span<const Sphere> spheres) override;
  /// Capsules, see Lbvh::build; met by stable arithmetic, whatever the tracer's is.
  void build(std::span<const Sphere> spheres, std::span<const glm::vec3> halfLines);
  void trace(const Camera& camera, Image<uint32_t>& ids, Image<float>* depth,
             const std::stop_token& stop) const override;

  GroupedLbvhView view() const { return lbvh_.view(); }

 private:
  const Arithmetic arithmetic_;
  Lbvh lbvh_;
};

/// Every ray with every sphere.
class BruteForceTracer final : public SphereTracer {
 public:
  void build(std::span<const Sphere> spheres) override;
  void trace(const Camera& camera, Image<uint32_t>& ids, Image<float>* depth,
             const std::stop_token& stop) const override;

 private:
  std::vector<Sphere> spheres_;
};

}  // namespace warpscope
