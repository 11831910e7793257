// From a new transfer function to what a march by it needs: its table, and which cells it leaves empty. Run by hand.
// Volumes of 256^3 voxels of three types, each with a function that shows some of it; what comes of changes is checked
// against a marcher that is made anew.
#include <benchmark/benchmark.h>

#include "app/scene/scene.h"
#include "render/march/march_setup.h"
#include "render/march/marcher_registry.h"

namespace warpscope {
namespace {

/// The built-in shells in another type: values 0 to 255 as they are, or spread over 16 bits, or from 0 to 1.
VolumePtr volumeOf(VoxelType type) {
  SceneOverrides overrides;
  overrides.proceduralDims = {256, 256, 256};
  static const VolumePtr shells = openScene("shells", overrides).volume;
  if (type == shells->type()) return shells;
  return visitVoxelType(shells->type(), [&](auto from) {
    return visitVoxelType(type, [&](auto to) -> VolumePtr {
      using To = decltype(to);
      const auto* source = shells->voxelsAs<decltype(from)>();
      const double lower = shells->statistics().rangeLower, upper = shells->statistics().rangeUpper;
      const double factor = (std::is_floating_point_v<To> ? 1.0 : 65535.0) / (upper - lower);
      auto voxels = std::make_shared<std::vector<To>>(shells->voxelCount());
      for (size_t i = 0; i < voxels->size(); ++i)
        (*voxels)[i] = static_cast<To>((static_cast<double>(source[i]) - lower) * factor);
      return std::make_shared<Volume>("shells", type, shells->geometry(), voxels, voxels->data());
    });
  });
}

/// Opacities from 0 to 0.9 over the range, in the shape of three hats.
TransferFunction functionFor(const Volume& volume, double shift) {
  const double lower = volume.statistics().rangeLower, extent = volume.statistics().rangeUpper - lower;
  TransferFunction function;
  for (const double at : {0.3, 0.55, 0.8}) {
    const auto add = [&](double x, float alpha) {
      function.points.push_back({lower + extent * (x + shift), glm::vec3(float(x), 1.0f - float(x), 0.5f), alpha});
    };
    add(at - 0.1, 0.0f);
    add(at, 0.1f + float(at));
    add(at + 0.1, 0.0f);
  }
  return function;
}

struct Case {
  explicit Case(VoxelType type) : volume(volumeOf(type)), marched(volume, functionFor(*volume, 0.0)) {}
  VolumePtr volume;
  MarchedVolume marched;
};

Case& caseOf(int64_t type) {
  static Case cases[] = {Case(VoxelType::uint8), Case(VoxelType::uint16), Case(VoxelType::float32)};
  return cases[type];
}

void table(benchmark::State& state) {
  const Case& c = caseOf(state.range(0));
  state.SetLabel(std::string(nameOf(c.volume->type())));
  for (auto _ : state)
    benchmark::DoNotOptimize(bakeTransferTable(c.marched.transferFunction, *c.volume, c.marched.scale, 0.5f));
}
BENCHMARK(table)->DenseRange(0, 2)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();

void cells(benchmark::State& state) {
  const Case& c = caseOf(state.range(0));
  const TransferTable baked = bakeTransferTable(c.marched.transferFunction, *c.volume, c.marched.scale, 0.5f);
  state.SetLabel(std::string(nameOf(c.volume->type())));
  for (auto _ : state) benchmark::DoNotOptimize(c.marched.macrocells.emptyDistances(baked));
}
BENCHMARK(cells)->DenseRange(0, 2)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();

/// From another function to a picture of one ray, as an editor has it when a point is dragged.
void newFunction(benchmark::State& state, const MarcherDescriptor& descriptor) {
  const Case& c = caseOf(state.range(0));
  state.SetLabel(std::string(nameOf(c.volume->type())));
  MarcherPtr marcher = descriptor.make(c.volume, c.marched.transferFunction);
  Camera camera;
  camera.eye.z = 300.0f;
  camera.width = camera.height = 1;
  Image<glm::vec4> image, expected;
  int change = 0;
  for (auto _ : state) {
    marcher = marcher->withTransferFunction(functionFor(*c.volume, 1e-3 * (++change % 50)));
    marcher->render(camera, {}, image);
  }
  descriptor.make(c.volume, functionFor(*c.volume, 1e-3 * (change % 50)))->render(camera, {}, expected);
  if (!(image == expected) || !(image(0, 0).a > 0.0f))
    state.SkipWithError("not the picture of a marcher that was made with the function");
}

}  // namespace
}  // namespace warpscope

int main(int argc, char** argv) {
  for (const warpscope::MarcherDescriptor& descriptor : warpscope::marcherRegistry())
    if (descriptor.whyUnavailable().empty())
      benchmark::RegisterBenchmark(("newFunction/" + std::string(descriptor.name)).c_str(),
                                   [&](benchmark::State& state) { warpscope::newFunction(state, descriptor); })
          ->DenseRange(0, 2)
          ->Unit(benchmark::kMillisecond)
          ->MeasureProcessCPUTime()
          ->UseRealTime();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
