// The same spheres through Embree: a check of the hierarchy of lbvh.h and the baseline that it has to beat.
// Embree 3.13 API, RTC_GEOMETRY_TYPE_SPHERE_POINT.
#pragma once

#include <embree3/rtcore.h>

#include <memory>
#include <type_traits>

#include "render/warp/lbvh/sphere_tracer.h"

namespace warpscope {

/// Agrees with the other tracers but for rounding: Embree has its own formula, so that rays which graze a sphere, and
/// spheres whose distances differ by rounding only, may be judged otherwise. What Embree itself finds equally near goes
/// to the lowest id.
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
  std::unique_ptr<ErrorLog> errors_;  // outlives the device, which reports to it
  std::unique_ptr<std::remove_pointer_t<RTCDevice>, Release> device_;
  std::unique_ptr<std::remove_pointer_t<RTCScene>, Release> scene_;  // null while there are no spheres
};

}  // namespace warpscope
