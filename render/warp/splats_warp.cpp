// Sphere clouds of frames, handed to the splatter.
// See splats_warp.h.
#include "render/warp/splats_warp.h"

#include "render/warp/sphere_cloud_warp.h"
#include "render/warp/splats/splat_tracer.h"
#include "render/warp/splats_warp_cuda.h"

namespace warpscope {
namespace {

class SplatsWarp final : public SphereCloudWarp {
 protected:
  void build(const SampleFrame&, std::span<const Sphere> spheres, const WarpSettings&) override { tracer_.build(spheres); }

  void drawSpheres(const SampleFrame& frame, const Camera& camera, const WarpSettings&, WarpedImage& image,
                   const std::stop_token& stop) override {
    tracer_.trace(camera, image.samples, nullptr, stop);
    resolveColors(frame, image.samples, image.color);
  }

 private:
  SplatTracer tracer_;
};

std::unique_ptr<Warp> makeSplatsWarp(const WarpResources& resources) {
  if (resources.backend == Backend::cuda) return makeCudaSplatsWarp();
  return std::make_unique<SplatsWarp>();
}

}  // namespace

constinit const WarpDescriptor kSplatsWarp{
    .name = "splats",
    .label = "Splats",
    .summary = "the picture of spheres without a hierarchy: each is intersected with the pixels that it may cover",
    .runsOnCuda = true,
    .uses = {.depth = true, .radius = true},
    .make = makeSplatsWarp,
};

}  // namespace warpscope
