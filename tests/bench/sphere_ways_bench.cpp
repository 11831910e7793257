// Which way of finding what lies along rays is fastest on a CUDA device, over frames and views of many kinds, for `spheres` and for `multihit`? What sphere_ways.h estimates stands beside
// what was measured. A line for each view as CSV, then how what is chosen compares with the faster of the two ways. Needs no display. Arguments: scenes; without any, the built-in ones.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

#include "app/scene/scene.h"
#include "render/cuda/devices.h"
#include "render/march/marcher_cuda.h"
#include "render/warp/device/sphere_ways.h"
#include "render/warp/multihit_warp_cuda.h"
#include "render/warp/spheres_warp_cuda.h"
#include "tests/bench/bench_main.h"

namespace warpscope {
namespace {

constexpr int kRuns = 15;
constexpr int kWarmRuns = 3;

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

void measure(const std::string& name, const SceneOverrides& overrides, uint32_t side, Regret& regret, Regret& surfaceRegret) {
  Scene scene = openScene(name, overrides);
  const MarcherPtr marcher = makeCudaMarcher(scene.volume, scene.transferFunction);
  const auto settingsFor = [](SphereTracing tracing) {
    WarpSettings settings;
    settings.knobs.set(kSphereTracingKnob, tracing);
    return settings;
  };
  const WarpSettings byFootprints = settingsFor(SphereTracing::footprints), byClusters = settingsFor(SphereTracing::clusters);
  View view = scene.views.front();
  const double firstAngle = view.angleDeg, firstDistance = view.distance;
  const auto frame = std::make_shared<SampleFrame>(marcher->march(makeCamera(scene, view, side, side), scene.march));
  const SphereLoadProbe probe(*frame);
  const std::unique_ptr<Warp> warps[2] = {makeCudaSpheresWarp(), makeCudaSpheresWarp()};
  const std::unique_ptr<Warp> surfaceWarps[2] = {makeCudaMultihitWarp(SphereTracing::footprints), makeCudaMultihitWarp(SphereTracing::clusters)};
  warps[0]->setFrame(frame, byFootprints);
  warps[1]->setFrame(frame, byClusters);
  for (const auto& warp : surfaceWarps) warp->setFrame(frame, {});
  for (const double turn : {0.0, 5.0, 10.0, 25.0, -30.0, 45.0, 90.0, 170.0})
    for (const double nearer : {0.35, 0.5, 0.7, 0.83, 1.0, 1.25, 2.0, 4.0}) {
      view.angleDeg = firstAngle + turn;
      view.distance = firstDistance * nearer;
      const Camera camera = makeCamera(scene, view, side, side);
      const SphereLoad load = probe.loadFor(camera);
      requireSame(*warps[0], byFootprints, *warps[1], byClusters, camera);
      requireSame(*surfaceWarps[0], {}, *surfaceWarps[1], {}, camera);
      const double footprints = medianMs(*warps[0], camera, byFootprints), clusters = medianMs(*warps[1], camera, byClusters);
      const double surfaceFootprints = medianMs(*surfaceWarps[0], camera, {}), surfaceClusters = medianMs(*surfaceWarps[1], camera, {});
      const bool takesFootprints = sphereCosts(load).fastest() == SphereTracing::footprints, splatsSurfaces = surfaceCosts(load, 4).fastest() == SphereTracing::footprints;
      std::printf("%s,%u,%g,%g,%.0f,%.0f,%.0f,%.0f,%.0f,%.4f,%.4f,%d,%.4f,%.4f,%d\n", scene.name.c_str(), side, turn, nearer, load.pixels, load.spheres, load.fragments, load.tiles, load.longestWalk,
                  footprints, clusters, takesFootprints, surfaceFootprints, surfaceClusters, splatsSurfaces);
      regret.add(footprints, clusters, takesFootprints);
      surfaceRegret.add(surfaceFootprints, surfaceClusters, splatsSurfaces);
    }
}

void run(const std::vector<std::string>& scenes) {
  const cuda::DeviceReport report = cuda::listDevices();
  if (report.devices.empty()) throw std::runtime_error("no GPU: " + report.reason);
  std::printf("# %s\nscene,side,turn,nearer,pixels,spheres,fragments,tiles,longestWalk,footprintsMs,clustersMs,tookFootprints,surfaceFootprintsMs,surfaceClustersMs,splatsSurfaces\n", report.devices.front().name.c_str());
  Regret regret, surfaceRegret;
  for (const uint32_t side : {512u, 1024u, 2048u}) {
    for (const std::string& scene : scenes) measure(scene, {}, side, regret, surfaceRegret);
    if (side != 1024) continue;
    SceneOverrides fine;
    fine.proceduralDims = {256, 256, 256};
    measure("shells", fine, side, regret, surfaceRegret);
  }
  regret.print("spheres");
  surfaceRegret.print("multihit");
}

}  // namespace
}  // namespace warpscope

int main(int argc, char** argv) {
  using namespace warpscope;
  return benchMain("sphere_ways_bench", [&] {
    std::vector<std::string> scenes(argv + 1, argv + argc);
    if (scenes.empty())
      for (const BuiltinScene& builtin : builtinScenes()) scenes.push_back(builtin.name);
    run(scenes);
  });
}
