// Times of the server's march and of compaction. Run by hand; `--benchmark_filter` chooses.
// The volume is the real engine where WARPSCOPE_DATA names a folder that holds it, else the built-in block at the same size.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <string>

#include "app/scene/scene.h"
#include "render/march/compact.h"
#include "render/march/marcher_cpu.h"

namespace warpscope {
namespace {

Scene openBenchScene() {
  if (const char* folder = std::getenv("WARPSCOPE_DATA")) {
    const std::filesystem::path engine = std::filesystem::path(folder) / "engine_256x256x128_uint8.raw";
    if (std::filesystem::exists(engine)) return openScene(engine.string());
  }
  SceneOverrides overrides;
  overrides.proceduralDims = {256, 256, 128};
  return openScene("block", overrides);
}

const Scene& benchScene() {
  static const Scene scene = openBenchScene();
  return scene;
}

void march(benchmark::State& state) {
  const Scene& scene = benchScene();
  const MarcherPtr marcher = makeCpuMarcher(scene.volume, scene.transferFunction);
  const Camera camera = makeCamera(scene, scene.views.front(), 1024, 1024);
  MarchSettings settings;
  settings.sample.heuristic = static_cast<Heuristic>(state.range(0));
  settings.sample.samplesPerRay = static_cast<int>(state.range(1));
  state.SetLabel(scene.name + ", " + std::string(nameOf(settings.sample.heuristic)) + ", " +
                 std::to_string(settings.sample.samplesPerRay) + " a ray");
  size_t samples = marcher->march(camera, settings).size();  // warms up, and shows that there is a picture
  if (samples < 10000) state.SkipWithError("the picture is nearly empty");
  for (auto _ : state) samples = marcher->march(camera, settings).size();
  state.counters["samples"] = static_cast<double>(samples);
}
BENCHMARK(march)
    ->Args({static_cast<int>(Heuristic::gradient), 1})
    ->Args({static_cast<int>(Heuristic::gradient), 4})
    ->Args({static_cast<int>(Heuristic::relThreshold), 1})
    ->Args({static_cast<int>(Heuristic::expected), 1})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

/// Of the scene's first view, as its file says but without light; `segments` a ray, 0 for none.
void marchScene(benchmark::State& state, const std::string& name, int segments) {
  const Scene scene = name == "engine" ? openBenchScene() : openScene(name);
  const MarcherPtr marcher = makeCpuMarcher(scene.volume, scene.transferFunction);
  const Camera camera = makeCamera(scene, scene.views.front(), 1024, 1024);
  MarchSettings settings;
  settings.render.step = scene.march.render.step;
  settings.sample.segments = segments;
  const SampleFrame first = marcher->march(camera, settings);  // warms up, and shows that there is a picture
  if (first.size() < 10000) state.SkipWithError("the picture is nearly empty");
  if (first.segments.empty() != (segments == 0)) state.SkipWithError("segments are not as they were asked for");
  double ms = std::numeric_limits<double>::infinity();
  for (auto _ : state) ms = std::min(ms, marcher->march(camera, settings).timings.marchMs);
  state.counters["least_ms"] = ms;
}
const bool areScenesRegistered = [] {
  for (const char* scene : {"engine", "shells", "vessels", "block", "marschner-lobb"})
    for (const int segments : {0, 4})
      benchmark::RegisterBenchmark(("marchScene/" + std::string(scene) + "/segments" + std::to_string(segments)).c_str(), marchScene, scene, segments)
          ->Unit(benchmark::kMillisecond)
          ->MeasureProcessCPUTime()
          ->UseRealTime();
  return true;
}();

void compaction(benchmark::State& state) {
  constexpr size_t kPixels = 1 << 20;
  std::vector<PackedSample> samples(kPixels);
  std::vector<Rgba8> colors(kPixels, 0xff808080u);
  const SampleQuantization quantization;
  size_t expected = 0;
  for (size_t i = 0; i < kPixels; ++i) {
    if (i % 5 >= 3) continue;
    samples[i] = packSample(0, 0, 0.5f, 0.5f, quantization);
    ++expected;
  }
  SampleFrame frame;
  for (auto _ : state) {
    compact(samples, colors, 1, frame);
    benchmark::DoNotOptimize(frame.samples.data());
  }
  if (frame.size() != expected) state.SkipWithError("wrong count");
}
BENCHMARK(compaction)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace warpscope

BENCHMARK_MAIN();
