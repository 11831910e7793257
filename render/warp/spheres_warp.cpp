// Sphere clouds of frames, handed to a tracer.
// See spheres_warp.h; the hierarchy and its traversal are in lbvh/.
#include "render/warp/spheres_warp.h"

#include "render/base/error.h"
#include "render/warp/lbvh/embree_tracer.h"
#include "render/warp/lbvh/sphere_tracer.h"
#include "render/warp/sphere_cloud_warp.h"
#include "render/warp/spheres_warp_cuda.h"

namespace warpscope {
namespace {

class SpheresWarp final : public SphereCloudWarp {
 protected:
  void build(std::span<const Sphere> spheres, const WarpSettings& settings) override {
    if (settings.sphereTracing == SphereTracing::clusters)
      throw UsageError("the hierarchy clusters is for CUDA devices: choose another, or --backend cuda");
    if (!tracer_ || tracing_ != settings.sphereTracing) {
      if (settings.sphereTracing == SphereTracing::embree)
        tracer_ = std::make_unique<EmbreeTracer>();
      else
        tracer_ = std::make_unique<LbvhTracer>();
      tracing_ = settings.sphereTracing;
    }
    tracer_->build(spheres);
  }

  void drawSpheres(const SampleFrame& frame, const Camera& camera, const WarpSettings& settings, WarpedImage& image,
                   const std::stop_token& stop) override {
    if (tracing_ != settings.sphereTracing) build(spheres(), settings);
    tracer_->trace(camera, image.samples, nullptr, stop);
    resolveColors(frame, image.samples, image.color);
  }

 private:
  std::unique_ptr<SphereTracer> tracer_;
  SphereTracing tracing_ = SphereTracing::automatic;
};

}  // namespace

std::unique_ptr<Warp> makeSpheresWarp(const WarpResources& resources) {
  if (resources.backend == Backend::cuda) return makeCudaSpheresWarp();
  return std::make_unique<SpheresWarp>();
}

}  // namespace warpscope
