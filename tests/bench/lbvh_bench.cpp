// Builds and traces a frame's cloud of spheres with the hierarchy, with Embree and by splats, side by side.
// Every picture is checked before anything is timed: a benchmark of a wrong picture says nothing.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <stdexcept>

#include "render/warp/lbvh/embree_tracer.h"
#include "render/warp/lbvh/sphere_tracer.h"
#include "render/warp/splats/splat_tracer.h"
#include "render/warp/warp.h"
#include "tests/frame_samples.h"
#include "tests/sphere_clouds.h"

namespace warpscope {
namespace {

constexpr uint32_t kSide = 1024;  // pixels
constexpr float kDistance = 350.0f;

const std::vector<Sphere>& frameCloud() {
  static const auto cloud = makeFrameCloud(orbitCamera(kDistance, 0.0f, kSide, kSide), 1);
  return cloud;
}

template <class Tracer>
SphereTracer& builtTracer() {
  static const std::unique_ptr<SphereTracer> tracer = [] {
    auto made = std::make_unique<Tracer>();
    made->build(frameCloud());
    return made;
  }();
  return *tracer;
}

/// Brute force on a few pixels, splats bit for bit and Embree on all: at most one pixel in a thousand may differ (silhouettes and ties within
/// rounding).
void checkPictures() {
  for (const float angleDeg : {0.0f, 25.0f, 60.0f}) {
    Image<uint32_t> lbvh, embree, splats, brute, few;
    const Camera camera = orbitCamera(kDistance, angleDeg, kSide, kSide);
    builtTracer<LbvhTracer>().trace(camera, lbvh, nullptr, {});
    builtTracer<EmbreeTracer>().trace(camera, embree, nullptr, {});
    builtTracer<SplatTracer>().trace(camera, splats, nullptr, {});
    if (!(splats == lbvh)) throw std::runtime_error("the splats' picture differs from the hierarchy's");
    size_t different = 0;
    for (size_t i = 0; i < lbvh.size(); ++i) different += lbvh[i] != embree[i];
    if (different * 1000 > lbvh.size()) throw std::runtime_error("the hierarchy's picture differs from Embree's");
    const Camera small = orbitCamera(kDistance, angleDeg, 24, 24);
    builtTracer<LbvhTracer>().trace(small, few, nullptr, {});
    builtTracer<BruteForceTracer>().trace(small, brute, nullptr, {});
    if (!(few == brute)) throw std::runtime_error("the hierarchy's picture differs from brute force's");
  }
}

template <class Tracer>
void buildCloud(benchmark::State& state) {
  const auto& cloud = frameCloud();
  Tracer tracer;
  tracer.build(cloud);
  for (auto _ : state) tracer.build(cloud);
  state.counters["spheres"] = static_cast<double>(cloud.size());
}

template <class Tracer>
void traceCloud(benchmark::State& state) {
  const SphereTracer& tracer = builtTracer<Tracer>();
  const Camera camera = orbitCamera(kDistance, static_cast<float>(state.range(0)), kSide, kSide);
  Image<uint32_t> ids;
  tracer.trace(camera, ids, nullptr, {});
  for (auto _ : state) tracer.trace(camera, ids, nullptr, {});
}

BENCHMARK(buildCloud<LbvhTracer>)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();
BENCHMARK(buildCloud<EmbreeTracer>)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();
/// The cloud as a frame, every sample half transparent.
SampleFramePtr cloudFrame() {
  auto frame = std::make_shared<SampleFrame>(frameOfCloud(frameCloud()));
  frame->colors.assign(frame->size(), 0x80ffc040u);
  return frame;
}

/// From the camera to colours, as the program draws; without what a technique builds once for a frame.
void drawFrame(benchmark::State& state, const char* technique) {
  const std::unique_ptr<Warp> warp = findWarp(technique).make({});
  warp->setFrame(cloudFrame(), {});
  const Camera camera = orbitCamera(kDistance, static_cast<float>(state.range(0)), kSide, kSide);
  WarpedImage image;
  warp->draw(camera, {}, image);
  for (auto _ : state) warp->draw(camera, {}, image);
}

/// Pictures in which a sphere covers ever more pixels, and each has a sphere: 25 degrees from where the cloud was seen.
template <class Tracer>
void traceLarger(benchmark::State& state) {
  const auto side = static_cast<uint32_t>(state.range(0));
  Tracer tracer;
  const auto cloud = makeFrameCloud(orbitCamera(kDistance, 0.0f, side, side), 1);
  tracer.build(cloud);
  Image<uint32_t> ids;
  for (auto _ : state) tracer.trace(orbitCamera(kDistance, 25.0f, side, side), ids, nullptr, {});
  state.counters["spheres"] = static_cast<double>(cloud.size());
}

void sides(benchmark::internal::Benchmark* bench) {
  for (const int side : {1024, 2048, 4096, 8192}) bench->Arg(side);
  bench->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime()->Iterations(1)->Repetitions(2);
}

void viewAngles(benchmark::internal::Benchmark* bench) {
  for (const int angleDeg : {0, 25, 60}) bench->Arg(angleDeg);
  bench->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();
}

BENCHMARK(traceCloud<LbvhTracer>)->Apply(viewAngles);
BENCHMARK(traceCloud<EmbreeTracer>)->Apply(viewAngles);
BENCHMARK(traceCloud<SplatTracer>)->Apply(viewAngles);
BENCHMARK(traceLarger<LbvhTracer>)->Apply(sides);
BENCHMARK(traceLarger<SplatTracer>)->Apply(sides);
BENCHMARK_CAPTURE(drawFrame, spheres, "spheres")->Apply(viewAngles);
BENCHMARK_CAPTURE(drawFrame, splats, "splats")->Apply(viewAngles);
BENCHMARK_CAPTURE(drawFrame, multihit4, "multihit")->Apply(viewAngles);

}  // namespace
}  // namespace warpscope

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  try {
    warpscope::checkPictures();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "lbvh_bench: %s\n", error.what());
    return 1;
  }
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
