// Frames as surfaces, and as many of them along a ray as the settings say.
// See multihit_warp.h.
#include "render/warp/multihit_warp.h"

#include "render/warp/multihit/multihit_trace.h"
#include "render/warp/multihit_warp_cuda.h"
#include "render/warp/sphere_cloud_warp.h"

namespace warpscope {
namespace {

class MultihitWarp final : public SphereCloudWarp {
 protected:
  void build(const SampleFrame& frame, std::span<const Sphere> spheres, const WarpSettings&) override { tracer_.build(frame, spheres); }

  void drawSpheres(const SampleFrame&, const Camera& camera, const WarpSettings& settings, WarpedImage& image,
                   const std::stop_token& stop) override {
    tracer_.trace(camera, settings.knobs.whole(kHitsKnob), image.samples, image.color, stop);
  }

 private:
  SurfaceTracer tracer_;
};

std::unique_ptr<Warp> makeMultihitWarp(const WarpResources& resources) {
  if (resources.backend == Backend::cuda) return makeCudaMultihitWarp();
  return std::make_unique<MultihitWarp>();
}

constexpr double kSweptHits[] = {2.0};
constexpr const Knob* kMultihitKnobs[] = {&kHitsKnob};

}  // namespace

constinit const Knob kHitsKnob{
    .key = "hits",
    .option = "--hits",
    .label = "Hits",
    .noun = "number of hits",
    .help = "How many surfaces along each ray are blended, the nearest in front (Gribble, Naveros, Kerzner 2014)",
    .type = KnobType::whole,
    .stale = KnobStage::draw,
    .range = {1.0, kMaxHits},
    .track = {1.0, kMaxHits},
    .defaultValue = 4.0,
    .axis = {"hits", "--hit-counts", "Surfaces blended along a ray", kSweptHits},
    .phrase = " of {}",
};

constinit const WarpDescriptor kMultihitWarp{
    .name = "multihit",
    .label = "Multihit",
    .summary = "the nearest few surfaces along each ray, blended",
    .runsOnCuda = true,
    .uses = {.depth = true, .radius = true},
    .knobs = kMultihitKnobs,
    .make = makeMultihitWarp,
};

}  // namespace warpscope
