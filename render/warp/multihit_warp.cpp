// Sphere clouds of frames, their hierarchy, and as many hits as the settings say.
// See multihit_warp.h.
#include "render/warp/multihit_warp.h"

#include "render/warp/lbvh/lbvh_builder.h"
#include "render/warp/multihit/multihit_trace.h"
#include "render/warp/multihit_warp_cuda.h"
#include "render/warp/sphere_cloud_warp.h"

namespace warpscope {
namespace {

class MultihitWarp final : public SphereCloudWarp {
 protected:
  void build(std::span<const Sphere> spheres, const WarpSettings&) override { lbvh_.build(spheres); }

  void drawSpheres(const SampleFrame& frame, const Camera& camera, const WarpSettings& settings, WarpedImage& image,
                   const std::stop_token& stop) override {
    traceNearestHits(lbvh_.view(), frame.colors, camera, settings.hits, image.samples, image.color, stop);
  }

 private:
  Lbvh lbvh_;
};

}  // namespace

std::unique_ptr<Warp> makeMultihitWarp(const WarpResources& resources) {
  if (resources.backend == Backend::cuda) return makeCudaMultihitWarp();
  return std::make_unique<MultihitWarp>();
}

}  // namespace warpscope
