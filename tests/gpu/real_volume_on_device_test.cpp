// The device against the CPU on real volumes, all heuristics, at the size that the program uses.
// The volumes are no part of the repository: WARPSCOPE_DATA names the folder that holds them.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "render/cuda/devices.h"
#include "render/march/marcher_cpu.h"
#include "render/march/marcher_cuda.h"
#include "tests/gpu/agreement.h"
#include "tests/headless.h"

namespace warpscope {
namespace {

class RealVolumeOnDevice : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Both, RealVolumeOnDevice, testing::Values("engine_256x256x128_uint8.raw", "spm152.nii.gz"),
                         [](const auto& info) { return std::string(info.param).substr(0, 6); });

TEST_P(RealVolumeOnDevice, EveryHeuristicAgrees) {
  WARPSCOPE_NEEDS_GPU();
  const char* folder = std::getenv("WARPSCOPE_DATA");
  if (folder == nullptr) GTEST_SKIP() << "set WARPSCOPE_DATA to the folder that holds " << GetParam();
  const std::filesystem::path path = std::filesystem::path(folder) / GetParam();
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  const Scene scene = openScene(path.string());
  const MarcherPtr onCpu = makeCpuMarcher(scene.volume, scene.transferFunction);
  const MarcherPtr onDevice = makeCudaMarcher(scene.volume, scene.transferFunction);
  const Camera camera = makeCamera(scene, scene.views.front(), 1024, 1024);
  for (const auto& heuristic : kHeuristics) {
    SCOPED_TRACE(std::string(heuristic.name));
    MarchSettings settings = scene.march;
    settings.sample.heuristic = heuristic.value;
    const SampleFrame expected = onCpu->march(camera, settings);
    EXPECT_GT(expected.size(), 100000u);
    expectSameFrames(expected, onDevice->march(camera, settings));
  }
}

}  // namespace
}  // namespace warpscope
