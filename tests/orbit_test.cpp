// What dragging and scrolling do: the picture follows the pointer.
// Mirrors app/scene/orbit.h.
#include "app/scene/orbit.h"

#include <gmock/gmock.h>

#include <cmath>
#include <utility>

namespace warpscope {
namespace {

Scene sceneToOrbit() {
  SceneOverrides overrides;
  overrides.proceduralDims = {8, 12, 10};
  return openScene("block", overrides);
}

glm::vec2 centerOnScreen(const Scene& scene, const View& view, uint32_t width, uint32_t height) {
  return project(makeCamera(scene, view, width, height), glm::vec3(0.0f)).pixel;
}

TEST(Orbit, PanningMovesTheVolumeByTheDrag) {
  const Scene scene = sceneToOrbit();
  for (const auto& [width, height] : {std::pair<uint32_t, uint32_t>{400, 300}, {300, 400}, {1000, 200}}) {
    const View before{25.0, -40.0, 0.7, {0.1, -0.2}};
    const glm::dvec2 dragPx(37.0, -21.0);
    const double shape = static_cast<double>(width) / height;
    const View after = panned(before, scene.fovYDeg, shape, dragPx / static_cast<double>(height));
    const glm::vec2 moved = centerOnScreen(scene, after, width, height) - centerOnScreen(scene, before, width, height);
    EXPECT_NEAR(moved.x, dragPx.x, 0.05);
    EXPECT_NEAR(moved.y, dragPx.y, 0.05);
  }
}

TEST(Orbit, WhatIsInFrontFollowsADrag) {
  const Scene scene = sceneToOrbit();
  const View before{10.0, 20.0, 1.0, {}};
  const Camera camera = makeCamera(scene, before, 300, 300);
  const glm::vec3 front = 3.0f * glm::normalize(camera.eye);  // towards the camera
  const View after = orbited(before, {0.02, 0.015});
  const glm::vec2 moved = project(makeCamera(scene, after, 300, 300), front).pixel -
                          project(camera, front).pixel;
  EXPECT_GT(moved.x, 0.0f);
  EXPECT_GT(moved.y, 0.0f);
}

TEST(Orbit, ElevationEndsAtThePoles) {
  EXPECT_EQ(orbited({0.0, 80.0, 1.0, {}}, {0.0, 10.0}).elevationDeg, 90.0);
  EXPECT_EQ(orbited({0.0, 80.0, 1.0, {}}, {0.0, -10.0}).elevationDeg, -90.0);
}

TEST(Orbit, AnglesStaySmallHoweverOftenOneTurns) {
  View view;
  for (int i = 0; i < 1000; ++i) view = orbited(view, {0.7, 0.0});
  EXPECT_LE(std::abs(view.angleDeg), 180.0);
}

TEST(Orbit, ZoomingInAndOutComesBack) {
  const View view = zoomed(zoomed({}, 3.0), -3.0);
  EXPECT_NEAR(view.distance, 1.0, 1e-12);
  EXPECT_LT(zoomed({}, 1.0).distance, 1.0);
  EXPECT_GT(zoomed({}, 1e6).distance, 0.0);
  EXPECT_LT(zoomed({}, -1e6).distance, 1e3);
}

}  // namespace
}  // namespace warpscope
