// Segments of a device's march against those of the CPU's.
// Mirrors render/march/device_segments.h.
#include <gtest/gtest.h>

#include <map>
#include <utility>

#include "render/cuda/devices.h"
#include "render/warp/segments_warp.h"
#include "tests/gpu/march_pairs.h"

namespace warpscope {
namespace {

/// Segments of rays, in every mode, lit or not, cut or not.
TEST(SegmentsOnDevice, OfEveryVoxelTypeWithAndWithoutHoles) {
  WARPSCOPE_NEEDS_GPU();
  forEveryVoxelType(9, [](const Pair& pair) {
    for (const RenderMode mode : {RenderMode::composite, RenderMode::mip, RenderMode::isosurface})
      for (const bool integrates : {false, true})
        for (const int segments : {1, 4, 16})
          for (const float shading : {0.0f, 1.0f}) {
            MarchSettings settings;
            settings.sample.segments = segments;
            settings.render.effects.mode = mode;
            settings.render.effects.preIntegration = integrates;
            settings.render.effects.shading.strength = shading;
            settings.render.effects.shadows.occlusion = segments == 4 ? 1.0f : 0.0f;
            settings.render.effects.isoValues = parseIsoValues("60@0.5", "it");
            settings.render.effects.jitter = segments == 1 ? 0.7f : 0.0f;
            if (segments == 16) settings.render.effects.clip.planes = parseClipPlanes("1,0.2,0,0", "it");
            for (const glm::vec3& eye : {kOutside, kInside}) pair.expectSame(lookingFrom(eye, {0.5f, 0.0f, 0.0f}, 90, 70), settings);
          }
  });
}

TEST(SegmentsOnDevice, OfEverySceneAtManyNumbers) {
  WARPSCOPE_NEEDS_GPU();
  for (const BuiltinScene& builtin : builtinScenes()) {
    const Scene scene = smallScene(builtin.name, 96);
    const Pair pair(scene);
    const Camera camera = makeCamera(scene, scene.views.front(), 203, 157);
    for (const int segments : {1, 2, 4, 8, 16}) {
      MarchSettings settings = scene.march;
      settings.sample.segments = segments;
      pair.expectSame(camera, settings);
    }
  }
}

/// Settings that leave nothing to be seen, and such that leave rays without an end.
TEST(SegmentsOnDevice, OfNothingAndOfRaysThatDoNotEnd) {
  WARPSCOPE_NEEDS_GPU();
  Scene scene = smallScene("shells", 64);
  MarchSettings settings = scene.march;
  settings.sample.segments = 3;
  settings.render.terminateEarly = false;
  Pair(scene).expectSame(makeCamera(scene, scene.views.front(), 90, 70), settings);
  for (TransferPoint& point : scene.transferFunction.points) point.alpha = 0.0f;
  Pair(scene).expectSame(makeCamera(scene, scene.views.front(), 90, 70), settings);
}

/// Walks and light, with a coarse copy of the volume, with all of it and without, on frames of both.
TEST(SegmentsOnDevice, PicturesAreTheCpusBitForBit) {
  WARPSCOPE_NEEDS_GPU();
  int refined = 0;  // pictures that are not as blended ones
  for (const BuiltinScene& builtin : builtinScenes()) {
    const Scene scene = smallScene(builtin.name, 96);
    const Pair pair(scene);
    for (const auto& [proxy, mode] : {std::pair(0, RenderMode::composite), {32, RenderMode::composite}, {96, RenderMode::composite}, {96, RenderMode::isosurface}})
      for (const float shading : {0.0f, 1.0f}) {
        MarchSettings settings = scene.march;
        settings.render.effects.mode = mode;
        settings.render.effects.isoValues = parseIsoValues("110", "it");
        settings.sample.segments = 4;
        settings.sample.proxy = proxy;
        settings.render.effects.shading.strength = shading;
        const auto frame = std::make_shared<const SampleFrame>(pair.cpu->march(makeCamera(scene, scene.views.front(), 300, 220), settings));
        WarpResources resources;
        const std::unique_ptr<Warp> onCpu = findWarp("segments").make(resources);
        resources.backend = Backend::cuda;
        const std::unique_ptr<Warp> onDevice = findWarp("segments").make(resources);
        std::map<float, WarpedImage> blended;
        for (const Between between : {Between::nearest, Between::linear, Between::refined}) {
          WarpSettings drawn;
          drawn.knobs.set(kBetweenKnob, between);
          onCpu->setFrame(frame, drawn);
          onDevice->setFrame(frame, drawn);
          for (const View& view : scene.views) {
            SCOPED_TRACE(::testing::Message() << builtin.name << ", copy " << proxy << ", mode " << static_cast<int>(mode) << ", shading " << shading << ", between " << static_cast<int>(between) << ", " << view.angleDeg);
            const Camera camera = makeCamera(scene, view, 203, 157);
            WarpedImage expected, actual;
            onCpu->draw(camera, drawn, expected);
            onDevice->draw(camera, drawn, actual);
            EXPECT_EQ(expected.samples, actual.samples);
            EXPECT_TRUE(sameBits(expected.color, actual.color));
            if (between == Between::refined) refined += !sameBits(expected.color, blended[view.angleDeg].color);
            if (between == Between::linear) blended[view.angleDeg] = std::move(expected);
          }
        }
      }
  }
  EXPECT_GT(refined, 20);
}

}  // namespace
}  // namespace warpscope
