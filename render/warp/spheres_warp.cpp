// Sphere clouds of frames, handed to a tracer.
// See spheres_warp.h; the hierarchy and its traversal are in lbvh/.
#include "render/warp/spheres_warp.h"

#include <cstring>

#include "render/base/error.h"
#include "render/core/parallel.h"
#include "render/warp/arithmetic_knob.h"
#include "render/warp/lbvh/embree_tracer.h"
#include "render/warp/lbvh/sample_capsules.h"
#include "render/warp/lbvh/sphere_tracer.h"
#include "render/warp/sphere_cloud_warp.h"
#include "render/warp/sphere_ways.h"
#include "render/warp/spheres_warp_cuda.h"
#include "render/warp/splats/splat_tracer.h"

namespace warpscope {
namespace {

SphereTracing tracingOf(const WarpSettings& settings) { return settings.knobs.choice<SphereTracing>(kSphereTracingKnob); }
Arithmetic arithmeticOf(const WarpSettings& settings) { return settings.knobs.choice<Arithmetic>(kArithmeticKnob); }

class SpheresWarp final : public SphereCloudWarp {
 protected:
  /// Where the way depends on the view nothing is built before there is one.
  void build(const SampleFrame& frame, std::span<const Sphere> spheres, const WarpSettings& settings) override {
    if (tracingOf(settings) == SphereTracing::clusters)
      throw UsageError("clusters are for CUDA devices: choose another way of tracing (--via), or --backend cuda");
    requireTraceable(settings);
    const SamplePlane* const spreads = spreadsOf(frame);
    const bool isOfCapsules = spreads != nullptr && settings.knobs.number(kSmearKnob) > 0.0f;
    if (isOfCapsules) requireCapsules(settings);
    tracer_ = nullptr;  // if this fails
    smear_ = settings.knobs.number(kSmearKnob);
    tracing_ = tracingOf(settings);
    arithmetic_ = arithmeticOf(settings);
    isOfCapsules_ = isOfCapsules;
    footprints_.isBuilt = hierarchy_.isBuilt = false;
    if (isOfCapsules_) {
      auto capsules = std::make_unique<LbvhTracer>();
      capsules->build(spheres, halfLinesOf(frame, *spreads));
      hierarchy_ = {std::move(capsules), {}, true};
      tracer_ = hierarchy_.tracer.get();
      return;
    }
    if (dependsOnView())
      probe_ = SphereLoadProbe(frame);
    else
      buildFor(tracing_);
  }

  void drawSpheres(const SampleFrame& frame, const Camera& camera, const WarpSettings& settings, WarpedImage& image,
                   const std::stop_token& stop) override {
    if (isOther(settings)) build(frame, spheres(), settings);
    if (dependsOnView()) buildFor(hostFavoursFootprints(probe_.loadFor(camera)) ? SphereTracing::footprints : SphereTracing::lbvh);
    tracer_->trace(camera, image.samples, nullptr, stop);
    resolveColors(frame, image.samples, image.color);
  }

 private:
  /// What finds spheres, and for what it was made; what is built of a frame stays for the next pictures of it.
  struct Tracing {
    std::unique_ptr<SphereTracer> tracer;
    std::optional<std::pair<SphereTracing, Arithmetic>> madeFor;  // where it is of spheres
    bool isBuilt = false;                                         // for this frame
  };

  /// Whether what is built is not for these settings, or building it has failed.
  bool isOther(const WarpSettings& settings) const {
    return (tracer_ == nullptr && !dependsOnView()) || tracing_ != tracingOf(settings) || arithmetic_ != arithmeticOf(settings) || smear_ != settings.knobs.number(kSmearKnob);
  }
  bool dependsOnView() const { return tracing_ == SphereTracing::automatic && arithmetic_ == Arithmetic::stable && !isOfCapsules_; }

  void buildFor(SphereTracing way) {
    Tracing& tracing = way == SphereTracing::footprints ? footprints_ : hierarchy_;
    tracer_ = nullptr;  // if this fails
    if (tracing.madeFor != std::pair(way, arithmetic_)) {
      if (way == SphereTracing::embree)
        tracing.tracer = std::make_unique<EmbreeTracer>();
      else if (way == SphereTracing::footprints)
        tracing.tracer = std::make_unique<SplatTracer>();
      else
        tracing.tracer = std::make_unique<LbvhTracer>(arithmetic_);
      tracing.madeFor = {way, arithmetic_};
      tracing.isBuilt = false;
    }
    if (!tracing.isBuilt) tracing.tracer->build(spheres());
    tracing.isBuilt = true;
    tracer_ = tracing.tracer.get();
  }

  std::vector<glm::vec3> halfLinesOf(const SampleFrame& frame, const SamplePlane& spreads) const {
    std::vector<glm::vec3> lines(frame.size());
    const SampleGrid grid = frame.grid();
    parallelForRanges(lines.size(), 1 << 15, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        float spread;
        std::memcpy(&spread, spreads.values.data() + i * sizeof spread, sizeof spread);
        lines[i] = halfLineOf(grid, frame.samples[i], spread, smear_);
      }
    });
    return lines;
  }

  Tracing footprints_, hierarchy_;  // both, so that views between which the way changes do not build again and again
  SphereTracer* tracer_ = nullptr;  // of the two the one that is in use
  SphereLoadProbe probe_;           // of this frame, where the way depends on the view
  SphereTracing tracing_ = SphereTracing::automatic;  // as the settings of what was built said
  Arithmetic arithmetic_ = Arithmetic::stable;
  float smear_ = 0.0f;
  bool isOfCapsules_ = false;
};

std::unique_ptr<Warp> makeSpheresWarp(const WarpResources& resources) {
  if (resources.backend == Backend::cuda) return makeCudaSpheresWarp();
  return std::make_unique<SpheresWarp>();
}

constexpr auto kTracingChoices = choicesOf(kSphereTracings);
constexpr const Knob* kSpheresKnobs[] = {&kSphereTracingKnob, &kSmearKnob, &kArithmeticKnob};

}  // namespace

void requireTraceable(const WarpSettings& settings) {
  const SphereTracing tracing = tracingOf(settings);
  if (arithmeticOf(settings) == Arithmetic::textbook && tracing != SphereTracing::automatic && tracing != SphereTracing::lbvh)
    throw UsageError("textbook arithmetic is for tracing via lbvh, not " + std::string(nameOf(kSphereTracings, tracing)));
}

const SamplePlane* spreadsOf(const SampleFrame& frame) {
  const SamplePlane* const plane = frame.plane(kSpreadPlane);
  return plane != nullptr && plane->element == PlaneElement::float32 && plane->values.size() == frame.size() * sizeof(float) ? plane : nullptr;
}

void requireCapsules(const WarpSettings& settings) {
  const SphereTracing tracing = tracingOf(settings);
  const bool isKnown = tracing == SphereTracing::automatic || tracing == SphereTracing::lbvh;
  if (!isKnown || arithmeticOf(settings) == Arithmetic::textbook)
    throw UsageError("spheres that are drawn out by the spread of their depths are traced via lbvh and by stable arithmetic: choose these, or --smear 0");
}

constinit const Knob kSphereTracingKnob{
    .key = "sphereTracing",
    .option = "--via",
    .label = "Traced via",
    .noun = "way of tracing",
    .help = "How the first sphere along each ray is found; all ways find the same, Embree up to rounding",
    .type = KnobType::choice,
    .stale = KnobStage::build,
    .defaultValue = static_cast<double>(SphereTracing::automatic),
    .choices = kTracingChoices,
};

constinit const Knob kSmearKnob{
    .key = "smear",
    .option = "--smear",
    .label = "Smear",
    .noun = "smear",
    .help = "How far samples are drawn out along the rays that found them, in spreads of their depth to both sides, where frames have these (--spread true; Zellmann 2020)",
    .unit = " ×",
    .stale = KnobStage::build,
    .range = {0.0, 4.0},
    .track = {0.0, 4.0},
    .defaultValue = 0.5,  // of 0.5, 1 and 2 what measures best in the mean of turned views (tests/bench/README.md)
    .axis = {"smears", "--smears", "Spreads of depth that samples are drawn out by"},
    .phrase = ", smeared by {}",
    .naming = KnobNaming::unlessDefault,
};

constinit const WarpDescriptor kSpheresWarp{
    .name = "spheres",
    .label = "Spheres",
    .summary = "first hit of rays with spheres over an LBVH (2020)",
    .runsOnCuda = true,
    .uses = {.depth = true, .radius = true, .spread = true},
    .knobs = kSpheresKnobs,
    .make = makeSpheresWarp,
};

}  // namespace warpscope
