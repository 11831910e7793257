// Which way of finding what lies along rays is fastest, over frames and views of many kinds: on a CUDA device for `spheres` and for `multihit`, or on the CPU for `spheres`? What sphere_ways.h
// estimates stands beside what was measured. A line for each view as CSV, then how what is chosen compares with the faster of the two ways. Needs no display. Arguments: cpu or cuda, and
// scenes; without these, the built-in ones.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "app/scene/scene.h"
#include "render/base/stopwatch.h"
#include "render/core/crew.h"
#include "render/cuda/devices.h"
#include "render/march/marcher_cpu.h"
#include "render/march/marcher_cuda.h"
#include "render/warp/sphere_ways.h"
#include "render/warp/multihit_warp_cuda.h"
#include "render/warp/spheres_warp_cuda.h"
#include "tests/bench/bench_main.h"

namespace warpscope {
namespace {

constexpr int kRuns = 15, kHostRuns = 5;
constexpr int kWarmRuns = 3, kHostWarmRuns = 1;
constexpr double kLongMs = 100.0;  // what takes longer is measured once
constexpr double kTurns[] = {0.0, 5.0, 10.0, 25.0, -30.0, 45.0, 90.0, 170.0}, kNearer[] = {0.35, 0.5, 0.7, 0.83, 1.0, 1.25, 2.0, 4.0}, kHostNearer[] = {0.1, 0.2, 0.35, 0.5, 0.7, 0.83, 1.0, 1.25, 2.0, 4.0};

/// Throws unless both ways show the same.
void requireSame(Warp& byFootprints, const WarpSettings& footprints, Warp& byClusters, const WarpSettings& clusters, const Camera& camera) {
  WarpedImage a, b;
  byFootprints.draw(camera, footprints, a);
  byClusters.draw(camera, clusters, b);
  if (!(a.samples == b.samples && a.color == b.color)) throw std::runtime_error("the ways' pictures differ; nothing was timed");
}

/// Median of the device's own clock; the picture is not copied.
double medianMs(Warp& warp, const Camera& camera, const WarpSettings& settings) {
  std::vector<double> times;
  for (int run = -kWarmRuns; run < kRuns; ++run) {
    const DevicePicturePtr picture = warp.drawForScreen(camera, settings, glm::vec3(0.0f), PixelMarks{}, {});
    if (run >= 0) times.push_back(warp.deviceTimings()->drawMs);
  }
  std::nth_element(times.begin(), times.begin() + kRuns / 2, times.end());
  return times[kRuns / 2];
}

/// By the host's clock.
double medianHostMs(Warp& warp, const Camera& camera, const WarpSettings& settings, WarpedImage& image) {
  std::vector<double> times;
  for (int run = -kHostWarmRuns; run < kHostRuns; ++run) {
    const double ms = milliseconds([&] { warp.draw(camera, settings, image); });
    if (run >= 0) times.push_back(ms);
    if (run >= 0 && ms > kLongMs) break;
  }
  const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
  std::ranges::nth_element(times, middle);
  return *middle;
}

WarpSettings settingsFor(SphereTracing tracing) {
  WarpSettings settings;
  settings.knobs.set(kSphereTracingKnob, tracing);
  return settings;
}

struct Regret {
  double worst = 1.0, logSum = 0.0;
  int views = 0, rightly = 0;

  void add(double footprints, double clusters, bool tookFootprints) {
    const double factor = (tookFootprints ? footprints : clusters) / std::min(footprints, clusters);
    worst = std::max(worst, factor);
    logSum += std::log(factor);
    rightly += factor == 1.0;
    ++views;
  }

  void print(const char* technique) const {
    std::printf("# %s: the faster way in %d of %d views; %.3f of its time in the geometric mean, %.2f at worst\n", technique, rightly, views, std::exp(logSum / views), worst);
  }
};

/// Calls f(camera, load) for every view of the scene that is looked from, and prints the head of its line first.
template <class F>
void forEveryView(const Scene& scene, const SampleFrame& frame, uint32_t side, std::span<const double> distances, const F& f) {
  const SphereLoadProbe probe(frame);
  for (const double turn : kTurns)
    for (const double nearer : distances) {
      View view = scene.views.front();
      view.angleDeg += turn;
      view.distance *= nearer;
      const Camera camera = makeCamera(scene, view, side, side);
      const SphereLoad load = probe.loadFor(camera);
      std::printf("%s,%u,%g,%g,%.0f,%.0f,%.0f,%.0f,%.0f", scene.name.c_str(), side, turn, nearer, load.pixels, load.spheres, load.fragments, load.tiles, load.longestWalk);
      f(camera, load);
    }
}

void measure(const std::string& name, const SceneOverrides& overrides, uint32_t side, Regret& regret, Regret& surfaceRegret) {
  const Scene scene = openScene(name, overrides);
  const MarcherPtr marcher = makeCudaMarcher(scene.volume, scene.transferFunction);
  const WarpSettings byFootprints = settingsFor(SphereTracing::footprints), byClusters = settingsFor(SphereTracing::clusters);
  const auto frame = std::make_shared<SampleFrame>(marcher->march(makeCamera(scene, scene.views.front(), side, side), scene.march));
  const std::unique_ptr<Warp> warps[2] = {makeCudaSpheresWarp(), makeCudaSpheresWarp()};
  const std::unique_ptr<Warp> surfaceWarps[2] = {makeCudaMultihitWarp(SphereTracing::footprints), makeCudaMultihitWarp(SphereTracing::clusters)};
  warps[0]->setFrame(frame, byFootprints);
  warps[1]->setFrame(frame, byClusters);
  for (const auto& warp : surfaceWarps) warp->setFrame(frame, {});
  forEveryView(scene, *frame, side, kNearer, [&](const Camera& camera, const SphereLoad& load) {
    requireSame(*warps[0], byFootprints, *warps[1], byClusters, camera);
    requireSame(*surfaceWarps[0], {}, *surfaceWarps[1], {}, camera);
    const double footprints = medianMs(*warps[0], camera, byFootprints), clusters = medianMs(*warps[1], camera, byClusters);
    const double surfaceFootprints = medianMs(*surfaceWarps[0], camera, {}), surfaceClusters = medianMs(*surfaceWarps[1], camera, {});
    const bool takesFootprints = sphereCosts(load).favourFootprints(), splatsSurfaces = surfaceCosts(load, 4).favourFootprints();
    std::printf(",%.4f,%.4f,%d,%.4f,%.4f,%d\n", footprints, clusters, takesFootprints, surfaceFootprints, surfaceClusters, splatsSurfaces);
    regret.add(footprints, clusters, takesFootprints);
    surfaceRegret.add(surfaceFootprints, surfaceClusters, splatsSurfaces);
  });
}

void measureOnHost(const std::string& name, const SceneOverrides& overrides, uint32_t side, Regret& regret) {
  const Scene scene = openScene(name, overrides);
  const MarcherPtr marcher = makeCpuMarcher(scene.volume, scene.transferFunction);
  const WarpSettings byFootprints = settingsFor(SphereTracing::footprints), byLbvh = settingsFor(SphereTracing::lbvh);
  const auto frame = std::make_shared<SampleFrame>(marcher->march(makeCamera(scene, scene.views.front(), side, side), scene.march));
  WarpResources resources;
  resources.backend = Backend::cpu;
  const std::unique_ptr<Warp> warps[2] = {makeWarp(kSpheresWarp, resources), makeWarp(kSpheresWarp, resources)};
  warps[0]->setFrame(frame, byFootprints);
  warps[1]->setFrame(frame, byLbvh);
  WarpedImage image;
  forEveryView(scene, *frame, side, kHostNearer, [&](const Camera& camera, const SphereLoad& load) {
    requireSame(*warps[0], byFootprints, *warps[1], byLbvh, camera);
    const double footprints = medianHostMs(*warps[0], camera, byFootprints, image), lbvh = medianHostMs(*warps[1], camera, byLbvh, image);
    const bool takesFootprints = hostFavoursFootprints(load);
    std::printf(",%.4f,%.4f,%d\n", footprints, lbvh, takesFootprints);
    std::fflush(stdout);
    regret.add(footprints, lbvh, takesFootprints);
  });
}

SceneOverrides fine() {
  SceneOverrides overrides;
  overrides.proceduralDims = {256, 256, 256};
  return overrides;
}

void runOnHost(const std::vector<std::string>& scenes) {
  std::printf("# %d threads\nscene,side,turn,nearer,pixels,spheres,fragments,tiles,longestWalk,footprintsMs,lbvhMs,tookFootprints\n", static_cast<int>(Crew::usualSize()));
  Regret regret;
  for (const uint32_t side : {256u, 512u, 1024u, 2048u})
    for (const std::string& scene : scenes) measureOnHost(scene, {}, side, regret);
  measureOnHost("shells", fine(), 512, regret);
  measureOnHost("shells", {}, 4096, regret);
  regret.print("spheres");
}

void runOnDevice(const std::vector<std::string>& scenes) {
  const cuda::DeviceReport report = cuda::listDevices();
  if (report.devices.empty()) throw std::runtime_error("no GPU: " + report.reason);
  std::printf("# %s\nscene,side,turn,nearer,pixels,spheres,fragments,tiles,longestWalk,footprintsMs,clustersMs,tookFootprints,surfaceFootprintsMs,surfaceClustersMs,splatsSurfaces\n", report.devices.front().name.c_str());
  Regret regret, surfaceRegret;
  for (const uint32_t side : {512u, 1024u, 2048u}) {
    for (const std::string& scene : scenes) measure(scene, {}, side, regret, surfaceRegret);
    if (side != 1024) continue;
    measure("shells", fine(), side, regret, surfaceRegret);
  }
  regret.print("spheres");
  surfaceRegret.print("multihit");
}

}  // namespace
}  // namespace warpscope

int main(int argc, char** argv) {
  using namespace warpscope;
  return benchMain("sphere_ways_bench", [&] {
    const std::string backend = argc > 1 ? argv[1] : "";
    if (backend != "cpu" && backend != "cuda") throw std::runtime_error("say where: cpu or cuda, and then scenes");
    std::vector<std::string> scenes(argv + 2, argv + argc);
    if (scenes.empty())
      for (const BuiltinScene& builtin : builtinScenes()) scenes.push_back(builtin.name);
    backend == "cpu" ? runOnHost(scenes) : runOnDevice(scenes);
  });
}
