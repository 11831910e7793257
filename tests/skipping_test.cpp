// Leaving out empty space never changes a bit of a picture or of a frame; and metamorphic tests of marching.
// Mirrors the skipping of render/march/volume_source.h over render/volume/macrocells.h.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <random>

#include "marcher_cases.h"
#include "render/volume/procedural.h"
#include "test_volumes.h"

namespace warpscope {
namespace {

/// Shows `from`..`to` and nothing else.
TransferFunction band(double from, double to, float alpha) {
  return {{{from, {1.0f, 0.3f, 0.1f}, 0.0f}, {from, {1.0f, 0.3f, 0.1f}, alpha}, {to, {0.1f, 0.3f, 1.0f}, alpha}, {to, glm::vec3(1.0f), 0.0f}}};
}

std::vector<Camera> camerasAround(const Box& box) {
  const float radius = 0.5f * glm::length(box.extent());
  std::vector<Camera> cameras{lookingFrom(radius * glm::vec3(1.3f, 0.9f, 1.6f), {}, 64, 56),
                              lookingFrom(radius * glm::vec3(0.1f, 0.2f, 0.1f), {}, 64, 56, 1.2f),
                              lookingFrom({0.0f, 0.0f, 2.5f * radius}, {}, 33, 33),   // along an axis
                              lookingFrom({-2.5f * radius, 0.0f, 0.0f}, {}, 33, 33),
                              lookingFrom(box.upper, {}, 64, 56, 1.0f)};              // on a corner
  // As if turned by 90 degrees with rounding: components next to nothing.
  Camera turned = cameras[2];
  turned.eye = 2.5f * radius * glm::vec3(1.0f, 6e-17f, 6e-17f);
  turned.right = {6e-17f, 6e-17f, -1.0f};
  turned.forward = {-1.0f, -6e-17f, -6e-17f};
  turned.up = {-6e-17f, 1.0f, 6e-17f};
  cameras.push_back(turned);
  return cameras;
}

void expectSkippingChangesNothing(const VolumePtr& volume, const TransferFunction& function, const std::vector<Camera>& cameras,
                                  const std::vector<float>& steps, const std::string& label) {
  const MarcherPtr marcher = makeCpuMarcher(volume, function);
  for (const float step : steps)
    for (size_t i = 0; i < cameras.size(); ++i) {
      MarchSettings with, without;
      with.render.step = without.render.step = step;
      without.render.skipEmpty = false;
      ASSERT_TRUE(sameBits(rendered(*marcher, cameras[i], with), rendered(*marcher, cameras[i], without)))
          << label << ", camera " << i << ", step " << step;
      with.sample.heuristic = without.sample.heuristic = Heuristic::expected;
      ASSERT_TRUE(sameFrame(marcher->march(cameras[i], with), marcher->march(cameras[i], without)))
          << label << ", camera " << i << ", step " << step;
    }
}

TEST(Skipping, ProceduralVolumes) {
  for (const ProceduralVolume& procedural : kProceduralVolumes) {
    const VolumePtr volume = makeProceduralVolume(procedural.name, procedural.defaultDims / 3u);
    for (const TransferFunction& function : {band(100.0, 120.0, 0.3f), band(1.0, 255.0, 0.02f), band(254.0, 256.0, 0.9f)})
      expectSkippingChangesNothing(volume, function, camerasAround(volume->bounds()), {0.5f}, std::string(procedural.name));
  }
}

TEST(Skipping, EveryVoxelType) {
  for (const VoxelType type : kAllVoxelTypes)
    for (const glm::uvec3 dims : {glm::uvec3(30, 25, 27), glm::uvec3(1, 50, 50), glm::uvec3(90, 2, 1)}) {
      VolumeGeometry geometry;
      geometry.dims = dims;
      geometry.spacing = {1.0, 1.0, 1.7};
      const VolumePtr volume = makeTestVolume(type, geometry, blobs(dims, 47));
      for (const TransferFunction& function : {band(40.0, 60.0, 0.4f), band(99.0, 101.0, 0.2f)})
        expectSkippingChangesNothing(volume, function, camerasAround(volume->bounds()), {0.5f, 0.23f}, std::string(nameOf(type)));
    }
}

TEST(Skipping, VolumesWithHoles) {
  const glm::uvec3 dims(30, 28, 26);
  const FieldFunction field = blobs(dims, 2);
  const VolumePtr volume = makeTestVolume(VoxelType::float32, dims, [&](const glm::ivec3& p) {
    return p.x > 20 || (p.x + p.y * p.z) % 9 == 0 ? std::nan("") : field(p);
  });
  expectSkippingChangesNothing(volume, band(30.0, 70.0, 0.3f), camerasAround(volume->bounds()), {0.5f, 0.23f}, "holes");
}

TEST(Skipping, LargeBesideTheirExtent) {
  const glm::uvec3 dims(30, 28, 26);
  const FieldFunction field = blobs(dims, 2);
  for (const VoxelType type : {VoxelType::uint16, VoxelType::int16}) {
    const double offset = type == VoxelType::uint16 ? 65430.0 : -32760.0;
    const VolumePtr volume = makeTestVolume(type, dims, [&](const glm::ivec3& p) { return offset + field(p); });
    expectSkippingChangesNothing(volume, band(offset + 30.0, offset + 70.0, 0.3f), camerasAround(volume->bounds()), {0.5f},
                                 std::string(nameOf(type)));
  }
}

TEST(Skipping, FarCamerasWithNarrowViews) {
  // Far away, distances along a ray are coarse beside a step: leaving a block must not overshoot. Everything above 0 is shown, so that
  // what lies hardly beyond a block counts.
  std::mt19937 random(47);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, {48, 48, 48}, [&](auto) { return random() % 150 == 0 ? 255.0 : 0.0; });
  std::vector<Camera> cameras;
  for (const float distance : {1e3f, 1e4f, 5e4f, 2e5f})
    for (int i = 0; i < 3; ++i) {
      const glm::vec3 toEye = glm::normalize(glm::vec3(unit(random), unit(random), unit(random)));
      cameras.push_back(lookingFrom(distance * toEye, {}, 64, 64, 40.0f / distance));
    }
  expectSkippingChangesNothing(volume, band(0.05, 256.0, 0.1f), cameras, {0.5f, 0.1f}, "seed 47, far");
}

TEST(Skipping, LeavesOutMostOfAnEmptyVolume) {
  // That it is worth something: marching a volume with one visible voxel looks at few samples, which shows as time. Here: it ends at once.
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, {512, 512, 64}, [](auto p) { return p.x + p.y + p.z == 0 ? 255.0 : 0.0; });
  const MarcherPtr marcher = makeCpuMarcher(volume, band(100.0, 256.0, 0.5f));
  MarchSettings settings;
  settings.render.step = 0.05f;
  const Camera camera = lookingFrom({600.0f, 500.0f, 400.0f}, {}, 48, 48);
  const auto milliseconds = [&](bool skip) {
    settings.render.skipEmpty = skip;
    double least = marcher->march(camera, settings).timings.marchMs;
    for (int i = 0; i < 2; ++i) least = std::min(least, marcher->march(camera, settings).timings.marchMs);
    return least;
  };
  EXPECT_LT(milliseconds(true), 0.5 * milliseconds(false));
}

// --- Metamorphic: the same picture of a volume that is mirrored or turned together with the camera.

RC_GTEST_PROP(March, MirroredAndPermutedAxesGiveTheSamePicture, ()) {
  const auto axes = *rc::gen::elementOf(std::vector<glm::ivec3>{{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {1, 0, 2}, {2, 1, 0}, {0, 2, 1}});
  glm::ivec3 sign;
  for (int axis = 0; axis < 3; ++axis) sign[axis] = *rc::gen::element(-1, 1);
  const glm::ivec3 n(22, 18, 14);
  const FieldFunction field = blobs(glm::uvec3(n), 9);
  const TransferFunction function{{{0.0, {1.0f, 0.2f, 0.1f}, 0.0f}, {100.0, {0.1f, 0.5f, 1.0f}, 0.2f}}};
  const Camera camera = lookingFrom({25.0f, 18.0f, 30.0f}, {}, 40, 32);

  // Component a of the other volume is component axes[a] of this one, perhaps with the other sign.
  glm::uvec3 otherDims;
  for (int a = 0; a < 3; ++a) otherDims[a] = static_cast<uint32_t>(n[axes[a]]);
  const auto moved = [&](const glm::vec3& v) {
    return glm::vec3(v[axes[0]], v[axes[1]], v[axes[2]]) * glm::vec3(sign);
  };
  const auto otherField = [&](const glm::ivec3& p) {
    glm::ivec3 q;
    for (int a = 0; a < 3; ++a) q[axes[a]] = sign[a] > 0 ? p[a] : n[axes[a]] - 1 - p[a];
    return field(q);
  };
  Camera other = camera;
  other.eye = moved(camera.eye);
  other.right = moved(camera.right);
  other.up = moved(camera.up);
  other.forward = moved(camera.forward);
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, glm::uvec3(n), field);
  const Image<glm::vec4> a = rendered(*makeCpuMarcher(volume, function), camera);
  const Image<glm::vec4> b = rendered(*makeCpuMarcher(makeTestVolume(VoxelType::uint8, otherDims, otherField), function), other);
  RC_ASSERT(largestAlpha(a) > 0.3f);
  // Sums in another order, and entries of the table next to each other: the function is smooth, so that is little.
  for (size_t i = 0; i < a.size(); ++i)
    for (int c = 0; c < 4; ++c) RC_ASSERT(std::abs(a[i][c] - b[i][c]) < 1e-3f);
}

}  // namespace
}  // namespace warpscope
