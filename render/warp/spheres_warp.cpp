// Sphere clouds of frames, handed to a tracer.
// See spheres_warp.h; the hierarchy and its traversal are in lbvh/.
#include "render/warp/spheres_warp.h"

#include <vector>

#include "render/core/error.h"
#include "render/core/parallel.h"
#include "render/warp/lbvh/embree_tracer.h"
#include "render/warp/lbvh/sphere_tracer.h"
#include "render/warp/spheres_warp_cuda.h"

namespace warpscope {
namespace {

class SpheresWarp final : public Warp {
 public:
  void setFrame(SampleFramePtr frame, const WarpSettings& settings, const std::stop_token&) override {
    frame_ = std::move(frame);
    build(settings.sphereTracing);
  }

  void draw(const Camera& camera, const WarpSettings& settings, WarpedImage& image,
            const std::stop_token& stop) override {
    requireUsable(camera);
    if (tracer_ && tracing_ != settings.sphereTracing) build(settings.sphereTracing);
    if (!frame_ || !tracer_) {
      image.samples.resize(camera.width, camera.height, kNoSample);
      image.color.resize(camera.width, camera.height);
      return;
    }
    tracer_->trace(camera, image.samples, nullptr, stop);
    resolveColors(*frame_, image.samples, image.color);
  }

 private:
  void build(SphereTracing tracing) {
    if (tracing == SphereTracing::clusters) throw UsageError("the hierarchy clusters is for CUDA devices: choose another, or --backend cuda");
    if (!tracer_ || tracing_ != tracing) {
      if (tracing == SphereTracing::embree)
        tracer_ = std::make_unique<EmbreeTracer>();
      else
        tracer_ = std::make_unique<LbvhTracer>();
      tracing_ = tracing;
    }
    spheres_.resize(frame_ ? frame_->size() : 0);
    parallelForRanges(spheres_.size(), 1 << 15, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) spheres_[i] = frame_->sphere(i);
    });
    tracer_->build(spheres_);
  }

  SampleFramePtr frame_;
  std::vector<Sphere> spheres_;
  std::unique_ptr<SphereTracer> tracer_;
  SphereTracing tracing_ = SphereTracing::automatic;
};

}  // namespace

std::unique_ptr<Warp> makeSpheresWarp(const WarpResources& resources) {
  if (resources.backend == Backend::cuda) return makeCudaSpheresWarp();
  return std::make_unique<SpheresWarp>();
}

}  // namespace warpscope
