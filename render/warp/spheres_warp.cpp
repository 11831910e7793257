// Sphere clouds of frames, handed to a tracer.
// See spheres_warp.h; the hierarchy and its traversal are in lbvh/.
#include "render/warp/spheres_warp.h"

#include "render/base/error.h"
#include "render/warp/arithmetic_knob.h"
#include "render/warp/lbvh/embree_tracer.h"
#include "render/warp/lbvh/sphere_tracer.h"
#include "render/warp/sphere_cloud_warp.h"
#include "render/warp/spheres_warp_cuda.h"

namespace warpscope {
namespace {

SphereTracing tracingOf(const WarpSettings& settings) { return settings.knobs.choice<SphereTracing>(kSphereTracingKnob); }
Arithmetic arithmeticOf(const WarpSettings& settings) { return settings.knobs.choice<Arithmetic>(kArithmeticKnob); }

class SpheresWarp final : public SphereCloudWarp {
 protected:
  void build(const SampleFrame&, std::span<const Sphere> spheres, const WarpSettings& settings) override {
    if (tracingOf(settings) == SphereTracing::clusters)
      throw UsageError("the hierarchy clusters is for CUDA devices: choose another, or --backend cuda");
    requireTraceable(settings);
    if (!tracer_ || isOther(settings)) {
      if (tracingOf(settings) == SphereTracing::embree)
        tracer_ = std::make_unique<EmbreeTracer>();
      else
        tracer_ = std::make_unique<LbvhTracer>(arithmeticOf(settings));
      tracing_ = tracingOf(settings);
      arithmetic_ = arithmeticOf(settings);
    }
    tracer_->build(spheres);
  }

  void drawSpheres(const SampleFrame& frame, const Camera& camera, const WarpSettings& settings, WarpedImage& image,
                   const std::stop_token& stop) override {
    if (isOther(settings)) build(frame, spheres(), settings);
    tracer_->trace(camera, image.samples, nullptr, stop);
    resolveColors(frame, image.samples, image.color);
  }

 private:
  bool isOther(const WarpSettings& settings) const {
    return tracing_ != tracingOf(settings) || arithmetic_ != arithmeticOf(settings);
  }

  std::unique_ptr<SphereTracer> tracer_;
  SphereTracing tracing_ = SphereTracing::automatic;
  Arithmetic arithmetic_ = Arithmetic::stable;
};

std::unique_ptr<Warp> makeSpheresWarp(const WarpResources& resources) {
  if (resources.backend == Backend::cuda) return makeCudaSpheresWarp();
  return std::make_unique<SpheresWarp>();
}

constexpr auto kTracingChoices = choicesOf(kSphereTracings);
constexpr const Knob* kKnobs[] = {&kSphereTracingKnob, &kArithmeticKnob};

}  // namespace

void requireTraceable(const WarpSettings& settings) {
  const SphereTracing tracing = tracingOf(settings);
  if (arithmeticOf(settings) == Arithmetic::textbook && tracing != SphereTracing::automatic && tracing != SphereTracing::lbvh)
    throw UsageError("textbook arithmetic is for the hierarchy lbvh, not " + std::string(nameOf(kSphereTracings, tracing)));
}

constinit const Knob kSphereTracingKnob{
    .key = "sphereTracing",
    .option = "--bvh",
    .label = "Spheres",
    .noun = "hierarchy",
    .help = "The hierarchy that spheres are traced with",
    .type = KnobType::choice,
    .stale = KnobStage::build,
    .defaultValue = static_cast<double>(SphereTracing::automatic),
    .choices = kTracingChoices,
};

constinit const WarpDescriptor kSpheresWarp{
    .name = "spheres",
    .label = "Spheres",
    .summary = "first hit of rays with spheres over an LBVH (2020)",
    .runsOnCuda = true,
    .uses = {.depth = true, .radius = true},
    .knobs = kKnobs,
    .make = makeSpheresWarp,
};

}  // namespace warpscope
