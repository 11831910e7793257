// What the metrics of a picture take, each alone and all together, at 1024x1024 on all cores.
// Their values are checked first, against those of other implementations; then median and spread of several repetitions, by the clock and of both
// cores together.
#include <benchmark/benchmark.h>

#include <cmath>
#include <stdexcept>
#include <string>

#include "app/scene/scene.h"
#include "render/march/marcher_cpu.h"
#include "render/metrics/flip.h"
#include "render/metrics/picture_errors.h"
#include "render/metrics/psnr.h"
#include "render/metrics/ssim.h"
#include "tests/bench/bench_main.h"
#include "tests/metric_pictures.h"

namespace warpscope {
namespace {

constexpr uint32_t kSide = 1024;  // pixels
constexpr glm::vec3 kBackground(0.0f);

void check(const char* what, double value, double expected, double tolerance) {
  if (std::abs(value - expected) <= tolerance) return;
  throw std::runtime_error(std::string(what) + " is " + std::to_string(value) + " where " + std::to_string(expected) + " is right; nothing was timed");
}

void checkValues() {
  const WarpedImage image{somePicture(0.35, true), Image<uint32_t>(96, 64, 0)};
  const Image<glm::vec4> reference = somePicture(0.0, false);
  check("FLIP", flip(image.color, reference, kBackground).mean, kOracleFlip, 1e-4);
  check("SSIM", ssimSrgb(image.color, reference, kBackground), kOracleSsim, 1e-5);
  check("PSNR", psnrSrgb(image.color, reference, kBackground), kOraclePsnrDb, 1e-4);
  const PictureErrors errors = PictureJudge(reference, kBackground).errorsOf(image);
  check("the judge's FLIP", errors.flip, kOracleFlip, 1e-4);
  check("the judge's SSIM", errors.ssim, kOracleSsim, 1e-5);
  check("the judge's PSNR", errors.psnrDb, kOraclePsnrDb, 1e-4);
}

/// Frames of the built-in shells, from the front and turned: pictures and what was marched for them.
struct Views {
  SampleFrame frame, reference;
  Image<glm::vec4> picture, truth;
};

const Views& views() {
  static const Views kViews = [] {
    const Scene scene = openScene("shells");
    const MarcherPtr marcher = makeCpuMarcher(scene.volume, scene.transferFunction);
    const Camera before = makeCamera(scene, scene.views.at(0), kSide, kSide), now = makeCamera(scene, scene.views.at(1), kSide, kSide);
    const MarchSettings settings;
    Views made{marcher->march(before, settings), marcher->march(now, settings), {}, {}};
    marcher->render(before, settings.render, made.picture);
    marcher->render(now, settings.render, made.truth);
    return made;
  }();
  return kViews;
}

void timePsnr(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(psnrSrgb(views().picture, views().truth, kBackground));
}

void timeSsim(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(ssimSrgb(views().picture, views().truth, kBackground));
}

void timeFlip(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(flip(views().picture, views().truth, kBackground).mean);
}

void timePreparing(benchmark::State& state) {
  for (auto _ : state) {
    const PictureJudge judge(views().truth, kBackground);
    benchmark::DoNotOptimize(&judge);
  }
}

void timeJudge(benchmark::State& state) {
  const PictureJudge judge(views().truth, kBackground);
  const WarpedImage image{views().picture, Image<uint32_t>(kSide, kSide, 0)};
  const Image<Visibility> mask = visibilityOf(views().frame, views().reference);
  Image<float> map;
  for (auto _ : state) benchmark::DoNotOptimize(judge.errorsOf(image, state.range(0) ? &mask : nullptr, &map).flip);
}

void timeVisibility(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(visibilityOf(views().frame, views().reference).data());
  state.counters["samples"] = static_cast<double>(views().frame.size());
}

void add(const char* name, void (*body)(benchmark::State&), int argument = 0) {
  benchmark::RegisterBenchmark(name, body)->Arg(argument)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime()->MinTime(0.1)->Repetitions(15)
      ->ReportAggregatesOnly(true);
}

}  // namespace
}  // namespace warpscope

int main(int argc, char** argv) {
  using namespace warpscope;
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  return benchMain("metrics_bench", [] {
    checkValues();
    views();  // marched before anything is timed
    add("psnr", timePsnr);
    add("ssim", timeSsim);
    add("flip", timeFlip);
    add("judge/prepare", timePreparing);
    add("judge/errors", timeJudge, 0);
    add("judge/errorsOfMask", timeJudge, 1);
    add("visibility", timeVisibility);
    benchmark::RunSpecifiedBenchmarks();
  });
}
