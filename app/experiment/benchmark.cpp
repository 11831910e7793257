// Timing what has been checked.
// See benchmark.h.
#include "app/experiment/benchmark.h"

#include <algorithm>
#include <cmath>

#include "app/frames/backend.h"
#include "app/frames/process_ranks.h"
#include "render/base/error.h"
#include "render/metrics/psnr.h"
#include "render/warp/spheres_warp.h"

namespace warpscope {
namespace {

/// Pixels of the pictures that a device's are compared in with a CPU's, at most: of larger ones every so many a side, else a CPU would draw for minutes.
constexpr double kMostComparedPixels = 1 << 20;

Camera comparedCamera(Camera camera) {
  const double pixels = static_cast<double>(camera.width) * camera.height, share = std::sqrt(std::min(1.0, kMostComparedPixels / pixels));
  for (uint32_t* side : {&camera.width, &camera.height}) *side = std::max(1u, static_cast<uint32_t>(*side * share));
  return camera;
}

/// Least PSNR of a right picture in the server's own view: techniques reach 20 dB and more, a picture of something else does not.
constexpr double kLeastPsnrDb = 12.0;

class TechniqueRun {
 public:
  TechniqueRun(const Scene& scene, const BenchmarkSettings& settings, const std::vector<Camera>& cameras, const std::stop_token& stop)
      : scene_(scene), settings_(settings), cameras_(cameras), stop_(stop), measuring_(settings.runs, stop) {}

  /// The reference in the server's own view.
  void setReference(Marcher& marcher) { marcher.render(cameras_.front(), settings_.march.render, reference_, stop_); }

  TechniqueBenchmark measure(const WarpDescriptor& technique, const WarpResources& resources, FrameCodec& codec, const SampleFramePtr& frame) {
    const std::unique_ptr<Warp> warp = makeWarp(technique, resources);
    warp->setFrame(frame, settings_.warp, stop_);
    check(technique, resources, *warp, frame);

    TechniqueBenchmark result;
    result.technique = &technique;
    const Drawing drawing{*warp, settings_.warp, scene_.background};
    result.first = measureFirstPicture(measuring_, drawing, frame, cameras_.front(), image_);
    for (const Camera& camera : cameras_) result.views.push_back({measureDraw(measuring_, drawing, camera, image_).draw});
    result.arrival = measureArrival(measuring_, drawing, codec, settings_.coding, frame, cameras_.front(), image_);
    return result;
  }

 private:
  void check(const WarpDescriptor& technique, const WarpResources& resources, Warp& warp, const SampleFramePtr& frame) {
    const std::string name = std::string(technique.name) + " on " + std::string(nameOf(resources.backend));
    warp.draw(cameras_.front(), settings_.warp, image_, stop_);
    const double psnrDb = psnrSrgb(image_.color, reference_, scene_.background);
    if (psnrDb < kLeastPsnrDb)
      throw InputError(name + ": its picture is wrong (" + std::to_string(psnrDb) + " dB in the server's own view); nothing was timed");
    if (resources.backend != Backend::cuda) return;
    WarpResources onCpu = resources;
    onCpu.backend = Backend::cpu;
    WarpSettings cpuSettings = settings_.warp;
    cpuSettings.knobs.set(kSphereTracingKnob, SphereTracing::lbvh);
    const std::unique_ptr<Warp> truth = makeWarp(technique, onCpu);
    truth->setFrame(frame, cpuSettings, stop_);
    WarpedImage expected;
    for (size_t view = 0; view < cameras_.size(); ++view) {
      const Camera camera = comparedCamera(cameras_[view]);
      truth->draw(camera, cpuSettings, expected, stop_);
      warp.draw(camera, settings_.warp, image_, stop_);
      size_t different = 0;
      for (size_t i = 0; i < image_.samples.size(); ++i) different += image_.samples[i] != expected.samples[i] || image_.color[i] != expected.color[i];
      if (different > 0)
        throw InputError(name + ": its picture of view " + std::to_string(view) + " differs from the CPU's in " + std::to_string(different) +
                         " pixels; nothing was timed");
    }
  }

  const Scene& scene_;
  const BenchmarkSettings& settings_;
  const std::vector<Camera>& cameras_;
  const std::stop_token& stop_;
  const Measuring measuring_;
  Image<glm::vec4> reference_;
  WarpedImage image_;
};

}  // namespace

size_t benchmarkSteps(const BenchmarkSettings& settings) {
  return settings.backends.size() * (1 + settings.techniques.size());
}

std::vector<BackendBenchmark> runBenchmark(const Scene& scene, const BenchmarkSettings& settings,
                                           const std::function<WarpResources(Backend)>& resourcesOf,
                                           const std::function<void(const std::string&)>& onStep, const std::stop_token& stop) {
  std::vector<Camera> cameras;
  for (const View& view : scene.views) cameras.push_back(makeCamera(scene, view, settings.width, settings.height));
  const Measuring measuring(settings.runs, stop);
  TechniqueRun run(scene, settings, cameras, stop);
  std::vector<BackendBenchmark> results;
  for (const Backend backend : settings.backends) {
    const WarpResources resources = resourcesOf(backend);
    onStep(std::string(nameOf(backend)) + ", the server's frame");
    BackendBenchmark& result = results.emplace_back();
    FrameCodec codec(makeTiledCoder(resources.marcher->backend()));
    const auto measureFrame = [&](const MarchSettings& march) {
      FrameBenchmark frame{measureMarch(measuring, *resources.marcher, cameras.front(), march), {}, {}};
      frame.coding = measureCoding(measuring, codec, frame.march.frame, settings.coding);
      frame.service = measureService(measuring, *resources.marcher, codec, cameras.front(), march, settings.coding);
      if (const BrickLeaderPtr leader = leaderOf(scene.volume)) frame.ranks = lastWork(leader);
      return frame;
    };
    result.frame = measureFrame(neededBy({}, settings.march));
    result.backend = resources.marcher->backend();
    const SampleFramePtr& frame = result.frame.march.frame;
    result.rawBytes = frame->sizeBytes();
    run.setReference(*resources.marcher);
    for (const WarpDescriptor* technique : settings.techniques) {
      onStep(std::string(nameOf(backend)) + ", " + std::string(technique->name));
      if (backend == Backend::cuda && !technique->runsOnCuda) continue;
      const MarchSettings needed = neededBy(std::array{TechniqueInUse{technique, settings.warp.knobs}}, settings.march);
      std::optional<FrameBenchmark> own;
      if (!(needed == frame->settings)) own = measureFrame(needed);
      result.techniques.push_back(run.measure(*technique, resources, codec, own ? own->march.frame : frame));
      result.techniques.back().frame = std::move(own);
    }
  }
  return results;
}

}  // namespace warpscope
