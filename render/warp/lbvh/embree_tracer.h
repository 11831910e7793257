// The same spheres through Embree: a check of the hierarchy of lbvh.h and the baseline that it has to beat.
// Embree 3.13 API, RTC_GEOMETRY_TYPE_SPHERE_POINT.
#pragma once

#include <embree3/rtcore.h>

#include <memory>
#include <mutex>
#include <type_traits>
#include <vector>

#include "render/warp/lbvh/sphere_tracer.h"

namespace warpscope {

/// Agrees with the other tracers but for rounding: Embree has its own formula, so that rays which graze a sphere, and
/// spheres whose distances differ by rounding only, may be judged otherwise. What Embree itself finds equally near goes
/// to the lowest id. Views from so near to a sphere that it is not seen as large as it is (seenRadius) go through an LBVH, which is
/// built when the first of them comes: Embree's spheres have one radius for all.
class EmbreeTracer final : public SphereTracer {
 public:
  /// Throws InputError if Embree finds no device to run on.
  EmbreeTracer();
  ~EmbreeTracer() override;

  /// Embree's failures, such as exhausted memory, are thrown as std::runtime_error.
  void build(std::span<const Sphere> spheres) override;
  void trace(const Camera& camera, Image<uint32_t>& ids, Image<float>* depth,
             const std::stop_token& stop) const override;

 private:
  struct Release {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  };
  class ErrorLog;

  /// Whether the eye is that near to any sphere.
  bool isNear(const glm::vec3& eye) const;

  std::unique_ptr<ErrorLog> errors_;  // outlives the device, which reports to it
  std::unique_ptr<std::remove_pointer_t<RTCDevice>, Release> device_;
  std::unique_ptr<std::remove_pointer_t<RTCScene>, Release> scene_;  // null while there are no spheres
  std::vector<Sphere> spheres_;
  mutable std::mutex mutex_;  // of the next
  mutable std::unique_ptr<LbvhTracer> nearTracer_;  // of the same spheres; null until it is wanted
};

}  // namespace warpscope
