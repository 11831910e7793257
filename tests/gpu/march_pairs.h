// A CPU's marcher and a device's of the same scene, and scenes of every voxel type for them.
// Samples, colours, planes and segments are to be the same bits.
#pragma once

#include <cmath>

#include "render/march/marcher_cpu.h"
#include "render/march/marcher_cuda.h"
#include "tests/gpu/agreement.h"
#include "tests/headless.h"
#include "tests/marcher_cases.h"
#include "tests/test_volumes.h"

namespace warpscope {

struct Pair {
  explicit Pair(const Scene& scene)
      : cpu(makeCpuMarcher(scene.volume, scene.transferFunction)), cuda(makeCudaMarcher(scene.volume, scene.transferFunction)) {}
  MarcherPtr cpu, cuda;

  void expectSame(const Camera& camera, const MarchSettings& settings) const {
    const SampleFrame expected = cpu->march(camera, settings);
    expectSameFrames(expected, cuda->march(camera, settings));
  }
};

/// Calls `check` with a pair of marchers for volumes of every voxel type, wide, flat, thin and of one voxel, with and without holes: voxels whose
/// number modulo 11 is `hole`.
template <class Check>
void forEveryVoxelType(int hole, const Check& check) {
  const TransferFunction function{{{10.0, {1.0f, 0.2f, 0.1f}, 0.0f}, {40.0, {0.1f, 0.9f, 0.3f}, 0.1f}, {100.0, {0.2f, 0.3f, 1.0f}, 0.5f}}};
  for (const VoxelType type : kAllVoxelTypes)
    for (const glm::uvec3 dims : {glm::uvec3(40, 33, 29), glm::uvec3(1, 20, 20), glm::uvec3(20, 1, 1), glm::uvec3(1)})
      for (const bool hasHoles : {false, true}) {
        if (hasHoles && type != VoxelType::float32 && type != VoxelType::float64) continue;
        SCOPED_TRACE(::testing::Message() << nameOf(type) << ", " << dims.x << "x" << dims.y << "x" << dims.z << ", holes " << hasHoles);
        const FieldFunction field = blobs(dims, 4);
        Scene scene;
        scene.volume = makeTestVolume(type, dims, [&](const glm::ivec3& p) {
          if (hasHoles && (p.x * 7 + p.y * 5 + p.z * 3) % 11 == hole) return std::nan("");
          return dims.x * dims.y * dims.z < 1000 ? static_cast<double>((p.x * 31 + p.y * 17 + p.z * 13 + 60) % 101) : field(p);
        });
        scene.transferFunction = function;
        check(Pair(scene));
      }
}

inline constexpr glm::vec3 kOutside(60.0f, 45.0f, 53.0f), kInside(0.1f, 0.2f, 0.3f);

}  // namespace warpscope
