// The scene's cameras for volumes of any place and handedness in the world. Poles, impossible views: stability/camera_test.cpp.
// Mirrors makeCamera of app/scene/scene.h; the world's geometry is worked out anew, in double.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "app/scene/scene.h"
#include "marcher_cases.h"
#include "render/base/error.h"
#include "test_volumes.h"

namespace warpscope {
namespace {

constexpr double kPi = std::numbers::pi;

Scene sceneOf(VolumePtr volume) {
  Scene scene;
  scene.volume = std::move(volume);
  scene.transferFunction = {{{0.0, {1.0f, 0.3f, 0.1f}, 0.0f}, {100.0, {0.1f, 0.6f, 1.0f}, 0.4f}}};
  return scene;
}

VolumeGeometry geometryOf(const glm::uvec3& dims, const glm::dvec3& spacing, const glm::dvec3& origin = glm::dvec3(0.0)) {
  VolumeGeometry geometry;
  geometry.dims = dims;
  geometry.spacing = spacing;
  geometry.origin = origin;
  return geometry;
}

const glm::uvec3 kDims(24, 20, 6);

Scene blobScene(const VolumeGeometry& geometry) { return sceneOf(makeTestVolume(VoxelType::uint8, geometry, blobs(kDims, 46))); }

// --- The world seen by the scene's camera, worked out in the world.

struct WorldView {
  glm::dvec3 eye, right, up, forward;
};

/// What scene.h says of a view: on a sphere about the volume's centre, at `angleDeg` to the right and `elevationDeg` up from the front.
WorldView worldViewOf(const Scene& scene, const View& view, double widthOverHeight) {
  const VolumeGeometry& g = scene.volume->geometry();
  const glm::dvec3 halfExtent = 0.5 * glm::dvec3(g.dims) * g.spacing;
  const glm::dvec3 center = g.origin + g.direction * (0.5 * (glm::dvec3(g.dims) - 1.0) * g.spacing);
  const double radius = glm::length(halfExtent);
  const double tanHalf = std::tan(scene.fovYDeg * kPi / 360.0);
  const double distance = view.distance * radius / std::sin(std::atan(tanHalf * std::min(1.0, widthOverHeight)));
  const glm::dvec3 up = glm::normalize(scene.up);
  const glm::dvec3 front = glm::normalize(scene.front - glm::dot(scene.front, up) * up);
  const glm::dvec3 toTheRight = glm::cross(up, front);  // of a camera in front that looks at the volume
  const double a = view.angleDeg * kPi / 180.0, e = view.elevationDeg * kPi / 180.0;
  const glm::dvec3 outward = std::cos(e) * (std::cos(a) * front + std::sin(a) * toTheRight) + std::sin(e) * up;
  WorldView world;
  world.forward = -outward;
  world.right = glm::normalize(glm::cross(up, std::cos(a) * front + std::sin(a) * toTheRight));
  world.up = glm::cross(world.right, world.forward);
  world.eye = center + distance * outward + radius * (view.pan.x * world.right + view.pan.y * world.up);
  return world;
}

glm::dvec2 worldPixel(const WorldView& world, double fovYDeg, uint32_t width, uint32_t height, const glm::dvec3& point) {
  const glm::dvec3 offset = point - world.eye;
  const double scale = 0.5 * height / (std::tan(fovYDeg * kPi / 360.0) * glm::dot(offset, world.forward));
  return {0.5 * width + glm::dot(offset, world.right) * scale, 0.5 * height - glm::dot(offset, world.up) * scale};
}

/// Where a picture has its weight.
glm::dvec2 centroid(const Image<glm::vec4>& image) {
  glm::dvec2 sum(0.0);
  double weight = 0.0;
  for (uint32_t y = 0; y < image.height(); ++y)
    for (uint32_t x = 0; x < image.width(); ++x) {
      sum += static_cast<double>(image(x, y).a) * (glm::dvec2(x, y) + 0.5);
      weight += image(x, y).a;
    }
  return sum / weight;
}

std::vector<glm::dmat3> orientations() {
  const double c = std::cos(0.4), s = std::sin(0.4);
  const glm::dmat3 turned{{c, s, 0.0}, {-s, c, 0.0}, {0.0, 0.0, 1.0}};
  const glm::dmat3 tilted{{1.0, 0.0, 0.0}, {0.0, c, s}, {0.0, -s, c}};
  std::vector<glm::dmat3> all;
  for (const glm::dmat3& rotation : {glm::dmat3(1.0), turned * tilted})
    for (const glm::dvec3 sign : {glm::dvec3(1, 1, 1), glm::dvec3(-1, 1, 1), glm::dvec3(1, 1, -1), glm::dvec3(-1, -1, -1), glm::dvec3(-1, -1, 1)})
      all.push_back(rotation * glm::dmat3{{sign.x, 0, 0}, {0, sign.y, 0}, {0, 0, sign.z}});
  return all;
}

TEST(SceneCamera, MarkedCornersAppearWhereTheWorldSays) {
  constexpr uint32_t kWidth = 160, kHeight = 120;
  for (const glm::dmat3& direction : orientations())
    for (int corner = 0; corner < 8; ++corner) {
      VolumeGeometry geometry = geometryOf({16, 14, 12}, {2.0, 2.5, 3.0}, {100.0, -50.0, 30.0});
      geometry.direction = direction;
      const glm::ivec3 marked(corner & 1 ? 14 : 1, corner & 2 ? 12 : 1, corner & 4 ? 10 : 1);
      Scene scene = sceneOf(makeTestVolume(VoxelType::uint8, geometry, [&](const glm::ivec3& p) { return p == marked ? 100.0 : 0.0; }));
      scene.up = {0.0, 0.0, 1.0};
      scene.front = {0.2, -1.0, 0.1};
      const glm::dvec3 point = geometry.origin + direction * (glm::dvec3(marked) * geometry.spacing);
      const MarcherPtr marcher = makeCpuMarcher(scene.volume, scene.transferFunction);
      for (const View& view : {View{25.0, 15.0, 1.2, {}}, View{-140.0, -60.0, 1.5, {0.1, -0.15}}}) {
        const glm::dvec2 truth = worldPixel(worldViewOf(scene, view, 4.0 / 3.0), scene.fovYDeg, kWidth, kHeight, point);
        const Image<glm::vec4> image = rendered(*marcher, makeCamera(scene, view, kWidth, kHeight));
        ASSERT_GT(largestAlpha(image), 0.05f);
        const glm::dvec2 seen = centroid(image);
        ASSERT_NEAR(seen.x, truth.x, 0.4) << "corner " << corner << ", determinant " << glm::determinant(direction);
        ASSERT_NEAR(seen.y, truth.y, 0.4) << "corner " << corner << ", determinant " << glm::determinant(direction);
      }
    }
}

TEST(SceneCamera, TheBoundingSphereJustFillsTheImageAtDistanceOne) {
  const Scene scene = blobScene(geometryOf(kDims, {1.0, 1.0, 4.0}));
  const double radius = 0.5 * glm::length(glm::dvec3(scene.volume->bounds().extent()));
  for (const auto& [width, height] : {std::pair<uint32_t, uint32_t>{300, 300}, {400, 300}, {300, 400}, {1000, 100}}) {
    const Camera camera = makeCamera(scene, {10.0, 20.0, 1.0, {}}, width, height);
    const double distance = glm::length(glm::dvec3(camera.eye));
    const double tangent = radius / std::sqrt(distance * distance - radius * radius);  // of the cone about the sphere
    EXPECT_NEAR(tangent / camera.tanHalfFovY, std::min(1.0, static_cast<double>(width) / height), 1e-5);
  }
}

TEST(SceneCamera, WhoCannotStandSoFarAwayIsToldHowLargeTheVolumeIs) {
  const Scene scene = blobScene(geometryOf(kDims, {1.0, 1e-6, 1.0}));
  try {
    makeCamera(scene, {10.0, 20.0, 1.0, {}}, 32, 32);
    ADD_FAILURE() << "no voxel could be told from the next";
  } catch (const UsageError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("2.47e+07 of its shortest voxel edge")) << "24 and 6 voxels of a million each";
  }
}

}  // namespace
}  // namespace warpscope
