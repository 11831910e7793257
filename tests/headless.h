// A scene with a marcher and an OpenGL context, for tests that draw without a window.
// One platform at a time (render/gl/context.h): tests that need OpenGL are parameterised over both.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "app/scene/scene.h"
#include "render/gl/context.h"
#include "render/march/marcher_registry.h"
#include "render/warp/warp.h"
#include "tests/frame_samples.h"

namespace warpscope {

/// A small size of each built-in volume, for tests that need its shape and not its detail.
inline Scene smallScene(const std::string& name, uint32_t side = 48) {
  SceneOverrides overrides;
  overrides.proceduralDims = glm::uvec3(side, side - 5, side - 2);
  return openScene(name, overrides);
}

/// A scene and what draws it.
class Stage {
 public:
  explicit Stage(Scene scene, gl::Platform platform = gl::Platform::automatic, Backend backend = Backend::cpu)
      : scene_(std::move(scene)),
        resources_{makeMarcher(backend, scene_.volume, scene_.transferFunction, {}),
                   [this, platform]() -> gl::Context& {
                     if (!context_) context_ = gl::makeHeadlessContext(platform);
                     context_->makeCurrent();
                     return *context_;
                   },
                   backend,
                   {}} {}
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  const Scene& scene() const { return scene_; }
  const WarpResources& resources() const { return resources_; }
  Marcher& marcher() const { return *resources_.marcher; }

  /// The camera of the scene's first view, turned.
  Camera camera(uint32_t width, uint32_t height, double turnDeg = 0.0) const {
    View view = scene_.views.front();
    view.angleDeg += turnDeg;
    return makeCamera(scene_, view, width, height);
  }
  SampleFramePtr frame(const Camera& camera, const MarchSettings& settings) const {
    return std::make_shared<SampleFrame>(marcher().march(camera, settings));
  }

  WarpedImage draw(std::string_view technique, const SampleFramePtr& frame, const Camera& camera,
                   const WarpSettings& settings = {}) const {
    const std::unique_ptr<Warp> warp = makeWarp(findWarp(technique), resources_);
    warp->setFrame(frame, settings);
    WarpedImage image;
    warp->draw(camera, settings, image);
    return image;
  }

 private:
  Scene scene_;
  std::unique_ptr<gl::Context> context_;
  WarpResources resources_;
};

/// The sample that stands for each pixel of the frame's own image: the first one whose centre the pixel's camera sees there.
/// Independent of any technique: by Camera's documented conventions, in double.
inline Image<uint32_t> ownPixels(const SampleFrame& frame) {
  const Camera& camera = frame.camera;
  Image<uint32_t> pixels(camera.width, camera.height, kNoSample);
  const double edge = 2.0 * camera.tanHalfFovY / camera.height;
  for (size_t i = 0; i < frame.size(); ++i) {
    const glm::dvec3 offset = glm::dvec3(sphereOf(frame, i).center) - glm::dvec3(camera.eye);
    const double depth = glm::dot(offset, glm::dvec3(camera.forward));
    if (!(depth > 0.0)) continue;
    const double x = 0.5 * camera.width + glm::dot(offset, glm::dvec3(camera.right)) / (depth * edge);
    const double y = 0.5 * camera.height - glm::dot(offset, glm::dvec3(camera.up)) / (depth * edge);
    if (!(x >= 0.0 && y >= 0.0 && x < camera.width && y < camera.height)) continue;
    uint32_t& pixel = pixels(static_cast<uint32_t>(x), static_cast<uint32_t>(y));
    if (pixel == kNoSample) pixel = static_cast<uint32_t>(i);
  }
  return pixels;
}

/// Tests over both ways to OpenGL without a window.
class OnPlatform : public testing::TestWithParam<gl::Platform> {};
inline auto bothPlatforms() { return testing::Values(gl::Platform::egl, gl::Platform::osmesa); }
inline std::string platformName(const testing::TestParamInfo<gl::Platform>& info) {
  return info.param == gl::Platform::egl ? "egl" : "osmesa";
}

}  // namespace warpscope
