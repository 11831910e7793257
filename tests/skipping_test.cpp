// Metamorphic tests of marching through empty space. That leaving it out changes no bit: stability/volumes_test.cpp; that it is worth something: counted_test.cpp.
// Mirrors the skipping of render/march/volume_source.h over render/volume/macrocells.h.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <random>

#include "marcher_cases.h"
#include "test_volumes.h"

namespace warpscope {
namespace {

/// The same picture of a volume that is mirrored or turned together with the camera.
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
