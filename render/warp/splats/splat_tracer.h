// First hits of all of a camera's rays without a hierarchy: each sphere is intersected with the rays of the pixels that it may cover.
// Exact splats: the rays of a bounding box on the screen, as Sigg, Weyrich, Botsch, Gross 2006 ("GPU-Based Ray-Casting of Quadratic
// Surfaces"); tiles of the screen as Laine, Karras 2011 ("High-Performance Software Rasterization on GPUs"), ours in a pyramid.
#pragma once

#include <span>
#include <vector>

#include "render/warp/lbvh/sphere_tracer.h"

namespace warpscope {

/// Each has up to four places in lists whose length is counted in 32 bits.
inline constexpr uint32_t kMaxSplats = 0x3fffffffu;

/// Equals the other tracers bit for bit. Nothing is built but a copy of the cloud.
class SplatTracer final : public SphereTracer {
 public:
  /// Throws InputError beyond kMaxSplats, too.
  void build(std::span<const Sphere> spheres) override;
  void trace(const Camera& camera, Image<uint32_t>& ids, Image<float>* depth, const std::stop_token& stop) const override;

 private:
  std::vector<Sphere> spheres_;
};

}  // namespace warpscope
