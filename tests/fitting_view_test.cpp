// What is visible lies in the first view's picture, whole and large, whatever its place, its shape and the picture's.
// Mirrors app/scene/fitting_view.h.
#include "app/scene/fitting_view.h"

#include <gtest/gtest.h>

#include <random>

#include "render/base/error.h"
#include "test_folder.h"
#include "test_volumes.h"

namespace warpscope {
namespace {

/// What lies above 50 is visible.
TransferFunction visibleAboveFifty() { return {{{50.0, glm::vec3(1.0f), 0.0f}, {100.0, glm::vec3(1.0f), 1.0f}}}; }

/// 100 from `first` to `last`, both included, 0 elsewhere.
FieldFunction cuboid(const glm::ivec3& first, const glm::ivec3& last) {
  return [=](const glm::ivec3& p) { return glm::all(glm::greaterThanEqual(p, first)) && glm::all(glm::lessThanEqual(p, last)) ? 100.0 : 0.0; };
}

Scene sceneOf(VolumePtr volume) {
  Scene scene;
  scene.volume = std::move(volume);
  scene.transferFunction = visibleAboveFifty();
  return scene;
}

glm::vec3 cornerOf(const Box& box, int corner) {
  return {corner & 1 ? box.upper.x : box.lower.x, corner & 2 ? box.upper.y : box.lower.y, corner & 4 ? box.upper.z : box.lower.z};
}

struct Shape {
  uint32_t width, height;
};
constexpr Shape kShapes[] = {{400, 400}, {800, 400}, {4000, 40}, {400, 500}, {400, 800}, {400, 2000}, {40, 4000}};

/// Whether all of the box is in the picture, from that distance.
bool isInside(const Scene& scene, View view, double distance, const Box& box, const Shape& shape) {
  view.distance = distance;
  const Camera camera = makeCamera(scene, view, shape.width, shape.height);
  for (int corner = 0; corner < 8; ++corner) {
    const Projection seen = project(camera, cornerOf(box, corner));
    if (!(seen.forwardDepth > 0.0f)) return false;
    if (seen.pixel.x < 0.0f || seen.pixel.y < 0.0f || seen.pixel.x > static_cast<float>(shape.width) || seen.pixel.y > static_cast<float>(shape.height)) return false;
  }
  return true;
}

TEST(VisibleBounds, HoldWhatIsVisibleAndACellMore) {
  std::mt19937 random(51);
  VolumeGeometry geometry;
  geometry.dims = {37, 22, 18};
  geometry.spacing = {1.0, 2.0, 1.5};
  for (int round = 0; round < 50; ++round) {
    glm::ivec3 first, last;
    for (int axis = 0; axis < 3; ++axis) {
      first[axis] = static_cast<int>(random() % geometry.dims[axis]);
      last[axis] = first[axis] + static_cast<int>(random() % (geometry.dims[axis] - static_cast<uint32_t>(first[axis])));
    }
    const VolumePtr volume = makeTestVolume(VoxelType::uint8, geometry, cuboid(first, last));
    const Box box = visibleBounds(*volume, visibleAboveFifty());
    for (int axis = 0; axis < 3; ++axis) {
      const double edge = geometry.spacing[axis], half = 0.5 * geometry.dims[axis];
      // Halfway to the next voxel's centre the value is 50: visible is what lies less than that beyond a voxel's centre, which is its border.
      EXPECT_LE(box.lower[axis], (first[axis] - half) * edge + 1e-4) << "seed 51, round " << round;
      EXPECT_GE(box.upper[axis], (last[axis] + 1 - half) * edge - 1e-4) << "seed 51, round " << round;
      EXPECT_GT(box.lower[axis], (first[axis] - half - 5.0) * edge) << "seed 51, round " << round;
      EXPECT_LT(box.upper[axis], (last[axis] + 1 - half + 5.0) * edge) << "seed 51, round " << round;
      EXPECT_GE(box.lower[axis], volume->bounds().lower[axis]);
      EXPECT_LE(box.upper[axis], volume->bounds().upper[axis]);
    }
  }
}

TEST(VisibleBounds, EmptyWhereNothingIs) {
  const VolumePtr volume = makeTestVolume(VoxelType::int16, {9, 9, 9}, [](auto) { return 49.0; });
  EXPECT_TRUE(visibleBounds(*volume, visibleAboveFifty()).isEmpty());
  std::stop_source stop;
  stop.request_stop();
  EXPECT_THROW(visibleBounds(*volume, visibleAboveFifty(), stop.get_token()), OperationCancelled);
}

TEST(FittingDistance, TheWholeBoxIsInPicturesOfEveryShapeAndNarrowerFieldOfViewAndFillsOneOfThem) {
  std::mt19937 random(52);
  const auto between = [&](double lower, double upper) { return std::uniform_real_distribution(lower, upper)(random); };
  int tight = 0;
  for (int round = 0; round < 300; ++round) {
    Scene scene = sceneOf(makeTestVolume(VoxelType::uint8, {32, 20, 12}, [](auto) { return 100.0; }));
    scene.fovYDeg = between(5.0, 120.0);
    const glm::dvec3 half = 0.5 * glm::dvec3(scene.volume->dims());
    Box box;
    for (int i = 0; i < 2; ++i) box.include(glm::vec3(half * glm::dvec3(between(-1, 1), between(-1, 1), between(-1, 1))));
    const View view{between(-180.0, 180.0), between(-90.0, 90.0), 1.0, {}};
    const double distance = fittingDistance(scene, view, box);
    ASSERT_LE(distance, 1.0);
    bool isCropped = false;
    const double fovYDeg = scene.fovYDeg;
    for (const double narrowing : {1.0, 0.8, 0.6, 0.4, 0.2, 0.05}) {
      scene.fovYDeg = narrowing * fovYDeg;
      for (const Shape& shape : kShapes) {
        ASSERT_TRUE(isInside(scene, view, distance, box, shape)) << "seed 52, round " << round << ": " << shape.width << "x" << shape.height << ", " << narrowing;
        isCropped = isCropped || !isInside(scene, view, 0.9 * distance, box, shape);
      }
    }
    if (distance <= 0.2 || distance >= 1.0) continue;
    ++tight;
    ASSERT_TRUE(isCropped) << "seed 52, round " << round << ": could be nearer";
  }
  EXPECT_GT(tight, 200);
}

TEST(FittingDistance, TheWholeVolumeNeedsNoMoreThanItsSphere) {
  const Scene scene = sceneOf(makeTestVolume(VoxelType::uint8, {20, 20, 20}, [](auto) { return 100.0; }));
  for (const double angleDeg : {0.0, 30.0, 45.0}) {
    const double distance = fittingDistance(scene, {angleDeg, 35.0, 1.0, {}}, scene.volume->bounds());
    EXPECT_LE(distance, 1.0);
    EXPECT_GT(distance, 0.72) << "from where corners of a box are cropped";
  }
}

// --- Scenes that are opened.

constexpr glm::ivec3 kSize(24, 24, 24);

std::string bytesOf(const FieldFunction& value) {
  std::string bytes;
  for (int z = 0; z < kSize.z; ++z)
    for (int y = 0; y < kSize.y; ++y)
      for (int x = 0; x < kSize.x; ++x) bytes += static_cast<char>(value({x, y, z}));
  return bytes;
}

void expectRatiosOfDefaults(const std::vector<View>& views) {
  const std::vector<View> usual = defaultViews();
  ASSERT_EQ(views.size(), usual.size());
  for (size_t i = 0; i < views.size(); ++i) {
    EXPECT_NEAR(views[i].distance / views[0].distance, usual[i].distance / usual[0].distance, 1e-12) << i;
    EXPECT_EQ(views[i].angleDeg, usual[i].angleDeg) << i;
    EXPECT_EQ(views[i].elevationDeg, usual[i].elevationDeg) << i;
  }
}

TEST(FittingViews, OfFilesFollowWhatIsVisible) {
  const TestFolder folder;
  const auto opened = [&](const glm::ivec3& first, const glm::ivec3& last) {
    return openScene(folder.write("part_24x24x24_uint8.raw", bytesOf(cuboid(first, last))));
  };
  const Scene whole = opened({0, 0, 1}, {23, 23, 23});  // one side is air, so that there is an object
  const Scene corner = opened({0, 0, 0}, {5, 5, 5});
  const Scene middle = opened({9, 9, 9}, {14, 14, 14});
  for (const Scene* scene : {&whole, &corner, &middle}) {
    expectRatiosOfDefaults(scene->views);
    const Box box = visibleBounds(*scene->volume, scene->transferFunction);
    for (const Shape& shape : kShapes) EXPECT_TRUE(isInside(*scene, scene->views.front(), scene->views.front().distance, box, shape));
  }
  EXPECT_GT(whole.views.front().distance, 0.8);
  EXPECT_LT(middle.views.front().distance, 0.6);
  EXPECT_GT(corner.views.front().distance, middle.views.front().distance);
}

TEST(FittingViews, FollowTheTransferFunctionThatIsGiven) {
  const TestFolder folder;
  // A small dense thing in the middle of a large faint one.
  const std::string file = folder.write("two_24x24x24_uint8.raw", bytesOf([](const glm::ivec3& p) {
    return cuboid({9, 9, 9}, {14, 14, 14})(p) > 0.0 ? 100.0 : 60.0;
  }));
  SceneOverrides dense, all;
  dense.transferFunction = folder.write("dense.json", R"({"points": [{"value": 90, "color": [1, 1, 1], "alpha": 0}, {"value": 100, "color": [1, 1, 1], "alpha": 1}]})");
  all.transferFunction = folder.write("all.json", R"({"points": [{"value": 10, "color": [1, 1, 1], "alpha": 0}, {"value": 100, "color": [1, 1, 1], "alpha": 1}]})");
  EXPECT_LT(openScene(file, dense).views.front().distance, 0.6);
  EXPECT_GT(openScene(file, all).views.front().distance, 0.8);
}

TEST(FittingViews, WhereNothingIsVisibleAreTheUsualOnes) {
  const TestFolder folder;
  SceneOverrides invisible;
  invisible.transferFunction = folder.write("none.json", R"({"points": [{"value": 0, "color": [1, 1, 1], "alpha": 0}]})");
  EXPECT_EQ(openScene(folder.write("part_24x24x24_uint8.raw", bytesOf(cuboid({0, 0, 0}, {5, 5, 5}))), invisible).views, defaultViews());
}

TEST(FittingViews, ScenesKeepTheirOwnAndBuiltInOnesTheUsual) {
  SceneOverrides small;
  small.proceduralDims = {16, 16, 16};
  for (const BuiltinScene& builtin : builtinScenes()) {
    if (builtin.name == "marschner-lobb") continue;  // brings its own
    EXPECT_EQ(openScene(builtin.name, small).views, defaultViews()) << builtin.name;
  }
  const TestFolder folder;
  folder.write("part_24x24x24_uint8.raw", bytesOf(cuboid({9, 9, 9}, {14, 14, 14})));
  const auto scene = [&](const std::string& name, const std::string& rest) {
    return openScene(folder.write(name, R"({"name": "part", "volume": {"file": "part_24x24x24_uint8.raw"})" + rest + "}"));
  };
  EXPECT_EQ(scene("own.json", R"(, "views": [{"distance": 0.9}])").views, std::vector<View>({{0.0, 0.0, 0.9, {}}}));
  EXPECT_LT(scene("none.json", "").views.front().distance, 0.6);
  SceneOverrides other;
  other.volume = folder.file("part_24x24x24_uint8.raw");
  const Scene replaced = openScene("block", other);  // whose transfer function shows less or more, but of the file
  expectRatiosOfDefaults(replaced.views);
  EXPECT_NE(replaced.views, defaultViews());
}

}  // namespace
}  // namespace warpscope
