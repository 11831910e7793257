// What the metrics of a picture take on a CUDA device, at 1024x1024; needs no display.
// The values are checked against the CPU's first, then medians of 100 runs after a warm-up and the spread between the quartiles are printed.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <vector>

#include "app/scene/scene.h"
#include "render/base/stopwatch.h"
#include "render/cuda/devices.h"
#include "render/march/marcher_cpu.h"
#include "render/metrics/picture_errors.h"
#include "render/metrics/picture_judge_cuda.h"
#include "render/warp/spheres_warp_cuda.h"
#include "tests/bench/bench_main.h"

namespace warpscope {
namespace {

constexpr uint32_t kSide = 1024;  // pixels
constexpr int kRuns = 100;

void print(const char* name, std::vector<double> times) {
  std::sort(times.begin(), times.end());
  std::printf("%-44s %8.4f ms, quartiles %.4f to %.4f\n", name, times[times.size() / 2], times[times.size() / 4], times[3 * times.size() / 4]);
}

template <class Picture>
void measure(const char* what, DevicePictureJudge& judge, const Picture& picture) {
  std::vector<double> planes, ssim, flip, all;
  for (int run = -10; run < kRuns; ++run) {
    DeviceErrors errors;
    const double hostMs = milliseconds([&] { errors = judge.errorsOf(picture); });
    if (run < 0) continue;
    planes.push_back(errors.planesAndPsnrMs);
    ssim.push_back(errors.ssimMs);
    flip.push_back(errors.flipMs);
    all.push_back(hostMs);
  }
  std::printf("%s, %ux%u:\n", what, kSide, kSide);
  print("  planes and PSNR", planes);
  print("  SSIM", ssim);
  print("  FLIP", flip);
  print("  picture to errors, by the host's clock", all);
}

void requireNear(const char* what, double value, double expected) {
  if (!(std::abs(value - expected) <= 1e-5))
    throw std::runtime_error(std::string(what) + " is " + std::to_string(value) + ", on the CPU " + std::to_string(expected) + "; nothing was timed");
}

void run() {
  const cuda::DeviceReport report = cuda::listDevices();
  if (report.devices.empty()) throw std::runtime_error("no GPU: " + report.reason);
  std::printf("%s\n", report.devices.front().name.c_str());
  const Scene scene = openScene("shells");
  const MarcherPtr marcher = makeCpuMarcher(scene.volume, scene.transferFunction);
  const Camera before = makeCamera(scene, scene.views.at(0), kSide, kSide), now = makeCamera(scene, scene.views.at(1), kSide, kSide);
  Image<glm::vec4> reference;
  marcher->render(now, {}, reference);
  const auto warp = makeCudaSpheresWarp();
  warp->setFrame(std::make_shared<SampleFrame>(marcher->march(before, {})), {});
  WarpedImage drawn;
  warp->draw(now, {}, drawn);
  const DevicePicturePtr shown = warp->drawForScreen(now, {}, scene.background, {});

  const auto judge = makeCudaPictureJudge(scene.background);
  judge->setReference(reference);
  const DeviceErrors errors = judge->errorsOf(drawn.color);
  const PictureErrors expected = PictureJudge(reference, scene.background).errorsOf(drawn);
  requireNear("FLIP", errors.flip, expected.flip);
  requireNear("SSIM", errors.ssim, expected.ssim);
  requireNear("PSNR", errors.psnrDb, expected.psnrDb);
  requireNear("PSNR of linear light", errors.psnrLinearDb, expected.psnrLinearDb);

  measure("a picture on the device", *judge, *shown);
  measure("a picture in host memory", *judge, drawn.color);
  std::vector<double> references;
  for (int i = -10; i < kRuns; ++i) {
    const double ms = milliseconds([&] { judge->setReference(*shown); });
    if (i >= 0) references.push_back(ms);
  }
  print("a reference on the device, host's clock", references);
}

}  // namespace
}  // namespace warpscope

int main() { return warpscope::benchMain("metrics_on_device_bench", warpscope::run); }
