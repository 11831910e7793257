// The device's march against the CPU's: every heuristic, radius policy, voxel type and built-in scene; colours; twins; cancelling; errors.
// Mirrors render/march/marcher_cuda.h.
#include "render/march/marcher_cuda.h"

#include <gtest/gtest.h>

#include "render/base/error.h"
#include "render/cuda/devices.h"
#include "render/march/marcher_cpu.h"
#include "tests/gpu/march_pairs.h"
#include "tests/headless.h"
#include "tests/marcher_cases.h"
#include "tests/test_volumes.h"

namespace warpscope {
namespace {

TEST(MarchOnDevice, EveryHeuristicAndRadiusInEveryScene) {
  WARPSCOPE_NEEDS_GPU();
  for (const BuiltinScene& builtin : builtinScenes()) {
    const Scene scene = smallScene(builtin.name, 96);
    const Pair pair(scene);
    for (const View& view : {scene.views.front(), scene.views.back()}) {
      const Camera camera = makeCamera(scene, view, 301, 257);
      for (const auto& heuristic : kHeuristics)
        for (const auto& radius : kRadiusPolicies) {
          if (radius.value != RadiusPolicy::voxel && heuristic.value != Heuristic::gradient && heuristic.value != Heuristic::median) continue;
          SCOPED_TRACE(builtin.name + ", " + std::string(heuristic.name) + ", " + std::string(radius.name));
          MarchSettings settings = scene.march;
          settings.sample.heuristic = heuristic.value;
          settings.sample.radiusPolicy = radius.value;
          pair.expectSame(camera, settings);
        }
    }
  }
}

TEST(MarchOnDevice, SeveralSamplesARayByEveryHeuristic) {
  WARPSCOPE_NEEDS_GPU();
  for (const BuiltinScene& builtin : builtinScenes()) {
    const Scene scene = smallScene(builtin.name, 96);
    const Pair pair(scene);
    const Camera camera = makeCamera(scene, scene.views.front(), 203, 157);
    for (const auto& heuristic : kHeuristics)
      for (const int samplesPerRay : {1, 2, 4, 8}) {
        SCOPED_TRACE(builtin.name + ", " + std::string(heuristic.name) + ", " + std::to_string(samplesPerRay));
        MarchSettings settings = scene.march;
        settings.sample.heuristic = heuristic.value;
        settings.sample.radiusPolicy = samplesPerRay == 2 ? RadiusPolicy::uncertainty : RadiusPolicy::opacity;
        settings.sample.samplesPerRay = samplesPerRay;
        pair.expectSame(camera, settings);
      }
  }
}

TEST(MarchOnDevice, RadiiOfUncertaintyInEveryMode) {
  WARPSCOPE_NEEDS_GPU();
  const Scene scene = smallScene("shells", 96);
  const Pair pair(scene);
  const Camera camera = makeCamera(scene, scene.views.front(), 203, 157);
  for (const RenderMode mode : {RenderMode::composite, RenderMode::isosurface, RenderMode::mip})
    for (const bool integrates : {false, true})
      for (const bool sends : {false, true})
        for (const int samplesPerRay : {1, 3}) {
          SCOPED_TRACE(::testing::Message() << nameOf(mode) << ", " << integrates << ", " << sends << ", " << samplesPerRay);
          MarchSettings settings = scene.march;
          settings.render.effects.mode = mode;
          settings.render.effects.preIntegration = integrates && mode == RenderMode::composite;
          settings.render.effects.isoValues = parseIsoValues("100@0.25 160@1", "it");
          settings.sample.radiusPolicy = RadiusPolicy::uncertainty;
          settings.sample.sendsSpread = sends;
          settings.sample.samplesPerRay = samplesPerRay;
          pair.expectSame(camera, settings);
        }
}

TEST(MarchOnDevice, FramesAfterOneOfSeveralSamplesARayAreAsBefore) {
  WARPSCOPE_NEEDS_GPU();
  const Scene scene = smallScene("shells", 64);
  const Pair pair(scene);
  const Camera camera = makeCamera(scene, scene.views.front(), 200, 200);
  MarchSettings several = scene.march;
  several.sample.samplesPerRay = 8;
  const SampleFrame before = pair.cuda->march(camera, scene.march);
  EXPECT_GT(pair.cuda->march(camera, several).size(), before.size());
  expectSameFrames(before, pair.cuda->march(camera, scene.march));
}

TEST(MarchOnDevice, SkippingAndEarlyEndsChangeNothing) {
  WARPSCOPE_NEEDS_GPU();
  const Scene scene = smallScene("shells", 64);
  const Pair pair(scene);
  const Camera camera = makeCamera(scene, scene.views.front(), 200, 200);
  for (const bool skips : {false, true})
    for (const bool ends : {false, true})
      for (const float step : {0.5f, 0.3f, 2.0f}) {
        MarchSettings settings = scene.march;
        settings.render.skipEmpty = skips;
        settings.render.terminateEarly = ends;
        settings.render.step = step;
        pair.expectSame(camera, settings);
      }
}

TEST(MarchOnDevice, LitByEveryHeuristicAndLight) {
  WARPSCOPE_NEEDS_GPU();
  for (const BuiltinScene& builtin : builtinScenes()) {
    const Scene scene = smallScene(builtin.name, 64);
    const Pair pair(scene);
    const Camera camera = makeCamera(scene, scene.views.front(), 203, 157);
    const auto expectSame = [&](const MarchSettings& settings) {
      pair.expectSame(camera, settings);
      EXPECT_TRUE(sameBits(rendered(*pair.cpu, camera, settings), rendered(*pair.cuda, camera, settings)));
    };
    MarchSettings lit = scene.march;
    lit.render.effects.shading.strength = 1.0f;
    for (const auto& heuristic : kHeuristics)
      for (const int samplesPerRay : {1, 4}) {
        SCOPED_TRACE(builtin.name + ", " + std::string(heuristic.name) + ", " + std::to_string(samplesPerRay));
        MarchSettings settings = lit;
        settings.sample.heuristic = heuristic.value;
        settings.sample.samplesPerRay = samplesPerRay;
        expectSame(settings);
      }
    for (const char* lights : {"none", "camera:-1,2,1@1.5", "world:1,0.3,-2 headlight@0.2", "point:3,70,20 point:31.5,31.5,31.5 camera:0,0,-1"})
      for (const float specular : {0.0f, 0.7f}) {
        SCOPED_TRACE(builtin.name + ", " + lights);
        MarchSettings settings = lit;
        settings.render.effects.lights = parseLights(lights, "it");
        settings.render.effects.shading.specular = specular;
        settings.render.effects.shading.strength = 0.75f;
        expectSame(settings);
      }
  }
}

TEST(MarchOnDevice, PreIntegratedByEveryHeuristicAndLight) {
  WARPSCOPE_NEEDS_GPU();
  for (const BuiltinScene& builtin : builtinScenes()) {
    const Scene scene = smallScene(builtin.name, 64);
    const Pair pair(scene);
    const Camera camera = makeCamera(scene, scene.views.front(), 203, 157);
    MarchSettings settings = scene.march;
    settings.render.effects.preIntegration = true;
    for (const float step : {0.5f, 1.0f, 3.0f})
      for (const bool skips : {false, true})
        for (const float shading : {0.0f, 1.0f})
          for (const int samplesPerRay : {1, 4})
            for (const Heuristic heuristic : {Heuristic::gradient, Heuristic::median}) {
              SCOPED_TRACE(::testing::Message() << builtin.name << ", step " << step << ", " << skips << ", shading " << shading);
              settings.render.step = step;
              settings.render.skipEmpty = skips;
              settings.render.effects.shading.strength = shading;
              settings.render.effects.shadows = {.strength = step > 2.0f ? 0.8f : 0.0f};
              settings.render.effects.lights = parseLights("world:1,0.3,-2 headlight@0.2", "it");
              settings.sample.heuristic = heuristic;
              settings.sample.samplesPerRay = samplesPerRay;
              pair.expectSame(camera, settings);
              EXPECT_TRUE(sameBits(rendered(*pair.cpu, camera, settings), rendered(*pair.cuda, camera, settings)));
            }
  }
}

TEST(MarchOnDevice, ShadowsAndOcclusion) {
  WARPSCOPE_NEEDS_GPU();
  for (const BuiltinScene& builtin : builtinScenes()) {
    const Scene scene = smallScene(builtin.name, 64);
    const Pair pair(scene);
    const Camera camera = makeCamera(scene, scene.views.front(), 203, 157);
    const auto expectSame = [&](const MarchSettings& settings) {
      pair.expectSame(camera, settings);
      EXPECT_TRUE(sameBits(rendered(*pair.cpu, camera, settings), rendered(*pair.cuda, camera, settings)));
    };
    MarchSettings shadowed = scene.march;
    shadowed.render.effects.shading.strength = 1.0f;
    shadowed.render.effects.shadows = {.strength = 0.8f, .occlusion = 0.7f, .occlusionRadius = 5.0f};
    shadowed.render.effects.lights = parseLights("world:1,0.3,-2 headlight@0.2", "it");
    for (const auto& heuristic : kHeuristics)
      for (const int samplesPerRay : {1, 4}) {
        SCOPED_TRACE(builtin.name + ", " + std::string(heuristic.name) + ", " + std::to_string(samplesPerRay));
        MarchSettings settings = shadowed;
        settings.sample.heuristic = heuristic.value;
        settings.sample.samplesPerRay = samplesPerRay;
        expectSame(settings);
      }
    for (const char* lights : {"none", "camera:-1,2,1@1.5", "point:3,70,20 point:31.5,31.5,31.5 camera:0,0,-1 world:0,1,0"})
      for (const float edge : {1.0f, 2.5f}) {
        SCOPED_TRACE(builtin.name + ", " + lights);
        MarchSettings settings = shadowed;
        settings.render.effects.lights = parseLights(lights, "it");
        settings.render.effects.shadows.gridEdge = edge;
        expectSame(settings);
        settings.render.skipEmpty = false;
        expectSame(settings);
        settings.render.effects.clip.planes = parseClipPlanes("1,0.5,0,-3", "it");
        expectSame(settings);
      }
  }
}

TEST(MarchOnDevice, CutByPlanesBoxesAndSlabs) {
  WARPSCOPE_NEEDS_GPU();
  const Scene scene = smallScene("vessels", 64);
  const Pair pair(scene);
  for (const View& view : {scene.views.front(), scene.views.back()}) {
    const Camera camera = makeCamera(scene, view, 203, 157);
    for (const char* planes : {"none", "1,0.3,-0.2,3", "1,0,0,-20 -1,0,0,-20 0,1,0,-20 0,-1,0,-20 0,0,1,-20 0.1,0,-1,-20"})
      for (const char* box : {"none", "0.2,0,0.1,0.9,0.7,0.6"})
        for (const float thickness : {0.0f, 11.0f}) {
          SCOPED_TRACE(::testing::Message() << planes << " and " << box << " and " << thickness);
          MarchSettings settings = scene.march;
          settings.render.effects.clip = {parseClipPlanes(planes, "it"), parseClipBox(box, "it"), {.thickness = thickness, .depth = -3.0f}};
          pair.expectSame(camera, settings);
          EXPECT_TRUE(sameBits(rendered(*pair.cpu, camera, settings), rendered(*pair.cuda, camera, settings)));
        }
  }
}

TEST(MarchOnDevice, WithSamplesMovedByNoise) {
  WARPSCOPE_NEEDS_GPU();
  const Scene scene = smallScene("shells", 64);
  const Pair pair(scene);
  const Camera camera = makeCamera(scene, scene.views.front(), 203, 157);
  for (const float jitter : {0.0f, 0.3f, 1.0f, 0.0f})
    for (const float shading : {0.0f, 1.0f}) {
      SCOPED_TRACE(::testing::Message() << jitter << " and shading " << shading);
      MarchSettings settings = scene.march;
      settings.render.effects.jitter = jitter;
      settings.render.effects.shading.strength = shading;
      pair.expectSame(camera, settings);
      EXPECT_TRUE(sameBits(rendered(*pair.cpu, camera, settings), rendered(*pair.cuda, camera, settings)));
    }
}

/// Greatest values and surfaces, by every heuristic and with everything that they may meet.
TEST(MarchOnDevice, OtherModesInEveryScene) {
  WARPSCOPE_NEEDS_GPU();
  for (const BuiltinScene& builtin : builtinScenes()) {
    const Scene scene = smallScene(builtin.name, 64);
    const Pair pair(scene);
    const VoxelStatistics& statistics = scene.volume->statistics();
    const auto at = [&](double share) { return numberText(statistics.lowest + share * (statistics.highest - statistics.lowest)); };
    const std::string several = at(0.3) + "@0.25 " + at(0.6) + "@0.5 " + at(0.9);
    for (const View& view : {scene.views.front(), scene.views.back()}) {
      const Camera camera = makeCamera(scene, view, 203, 157);
      for (const auto& [mode, values] :
           {std::pair(RenderMode::mip, std::string("none")), std::pair(RenderMode::isosurface, at(0.5)), std::pair(RenderMode::isosurface, several)})
        for (const auto& heuristic : kHeuristics)
          for (const int samplesPerRay : {1, 4})
            for (const bool skips : {true, false})
              for (const float shading : {0.0f, 0.75f}) {
                SCOPED_TRACE(builtin.name + ", " + std::string(nameOf(mode)) + " " + values + ", " + std::string(heuristic.name) + ", " +
                             std::to_string(samplesPerRay));
                MarchSettings settings = scene.march;
                settings.render.effects.mode = mode;
                settings.render.effects.isoValues = parseIsoValues(values, "it");
                settings.render.effects.shading.strength = shading;
                settings.render.skipEmpty = skips;
                settings.sample.heuristic = heuristic.value;
                settings.sample.samplesPerRay = samplesPerRay;
                pair.expectSame(camera, settings);
                if (heuristic.value != Heuristic::gradient || samplesPerRay != 1) continue;
                for (const char* planes : {"none", "1,0.3,-0.2,3"}) {
                  settings.render.effects.clip.planes = parseClipPlanes(planes, "it");
                  EXPECT_TRUE(sameBits(rendered(*pair.cpu, camera, settings), rendered(*pair.cuda, camera, settings)));
                }
              }
      // A marcher goes from mode to mode, and back.
      const SampleFrame before = pair.cuda->march(camera, scene.march);
      expectSameFrames(pair.cpu->march(camera, scene.march), before);
    }
  }
}

TEST(MarchOnDevice, OtherModesOfEveryVoxelTypeWithAndWithoutHoles) {
  WARPSCOPE_NEEDS_GPU();
  forEveryVoxelType(5, [](const Pair& pair) {
    for (const RenderMode mode : {RenderMode::mip, RenderMode::isosurface})
      for (const float step : {0.5f, 6.0f})
        for (const glm::vec3& eye : {kOutside, kInside}) {
          MarchSettings settings;
          settings.render.step = step;
          settings.render.effects.mode = mode;
          settings.render.effects.shading.strength = 0.5f;
          settings.render.effects.isoValues = parseIsoValues("60@0.5", "it");
          pair.expectSame(lookingFrom(eye, {0.5f, 0.0f, 0.0f}, 90, 70), settings);
        }
  });
}

TEST(MarchOnDevice, PreIntegratedOfEveryVoxelTypeWithAndWithoutHoles) {
  WARPSCOPE_NEEDS_GPU();
  forEveryVoxelType(7, [](const Pair& pair) {
    for (const float step : {0.5f, 2.0f})
      for (const glm::vec3& eye : {kOutside, kInside}) {
        MarchSettings settings;
        settings.render.step = step;
        settings.render.effects.preIntegration = true;
        settings.render.effects.shading.strength = 0.5f;
        pair.expectSame(lookingFrom(eye, {0.5f, 0.0f, 0.0f}, 90, 70), settings);
      }
  });
}

/// How far depths are spread: one sample a ray and several, in every mode, lit or not.
TEST(MarchOnDevice, SpreadsOfDepthOfEveryVoxelTypeWithAndWithoutHoles) {
  WARPSCOPE_NEEDS_GPU();
  forEveryVoxelType(3, [](const Pair& pair) {
    for (const RenderMode mode : {RenderMode::composite, RenderMode::mip, RenderMode::isosurface})
      for (const bool integrates : {false, true})
        for (const int samplesPerRay : {1, 3})
          for (const Heuristic heuristic : {Heuristic::gradient, Heuristic::expected, Heuristic::median}) {
            MarchSettings settings;
            settings.sample.sendsSpread = true;
            settings.sample.samplesPerRay = samplesPerRay;
            settings.sample.heuristic = heuristic;
            settings.render.effects.mode = mode;
            settings.render.effects.preIntegration = integrates;
            settings.render.effects.shading.strength = heuristic == Heuristic::median ? 1.0f : 0.0f;
            settings.render.effects.isoValues = parseIsoValues("60@0.5", "it");
            pair.expectSame(lookingFrom(kOutside, {0.5f, 0.0f, 0.0f}, 90, 70), settings);
          }
  });
}

TEST(MarchOnDevice, EveryVoxelTypeWithAndWithoutHoles) {
  WARPSCOPE_NEEDS_GPU();
  forEveryVoxelType(0, [](const Pair& pair) {
    MarchSettings settings;
    for (const Heuristic heuristic : {Heuristic::gradient, Heuristic::expected, Heuristic::median}) {
      settings.sample.heuristic = heuristic;
      for (const float shading : {0.0f, 1.0f})
        for (const glm::vec3& eye : {kOutside, kInside}) {
          settings.render.effects.shading.strength = shading;
          settings.render.effects.shadows.occlusion = eye == kInside ? 1.0f : 0.0f;
          pair.expectSame(lookingFrom(eye, {0.5f, 0.0f, 0.0f}, 90, 70), settings);
        }
    }
  });
}

/// Bins of the transfer function's table that are told apart further, by a few pieces and by many.
TEST(MarchOnDevice, StepsNeedlesAndOutliers) {
  WARPSCOPE_NEEDS_GPU();
  const glm::uvec3 dims(40, 36, 30);
  const FieldFunction field = blobs(dims, 21);
  const TransferFunction step{{{40.0, {1.0f, 0.2f, 0.1f}, 0.0f}, {40.0, {1.0f, 0.2f, 0.1f}, 0.4f}, {70.0, {0.1f, 0.9f, 0.3f}, 0.4f}, {70.0, {0.1f, 0.9f, 0.3f}, 0.02f}}};
  const TransferFunction needle{{{0.0, {0.2f, 0.3f, 1.0f}, 0.0f},
                                 {49.9, {0.2f, 0.3f, 1.0f}, 0.0f},
                                 {50.0, {1.0f, 0.9f, 0.3f}, 0.9f},
                                 {50.2, {0.1f, 0.2f, 0.3f}, 0.0f},
                                 {1e6, {0.1f, 0.9f, 0.3f}, 0.1f}}};
  for (const VoxelType type : kAllVoxelTypes)
    for (const TransferFunction& function : {step, needle})
      for (const bool hasOutlier : {false, true}) {
        const bool isWide = sizeBytes(type) >= 4;
        if (hasOutlier && !isWide) continue;
        const VolumePtr volume = makeTestVolume(type, dims, [&](const glm::ivec3& p) { return hasOutlier && p == glm::ivec3(3) ? 2e9 : field(p); });
        Scene scene;
        scene.volume = volume;
        scene.transferFunction = function;
        const Pair pair(scene);
        for (const float stepLength : {0.5f, 3.7f}) {
          SCOPED_TRACE(std::string(nameOf(type)) + (hasOutlier ? ", an outlier" : "") + ", step " + std::to_string(stepLength));
          MarchSettings settings;
          settings.render.step = stepLength;
          pair.expectSame(lookingFrom({50.0f, 30.0f, 45.0f}, {}, 150, 130), settings);
        }
      }
}

TEST(MarchOnDevice, ColoursAreTheCpus) {
  WARPSCOPE_NEEDS_GPU();
  for (const BuiltinScene& builtin : builtinScenes()) {
    SCOPED_TRACE(builtin.name);
    const Scene scene = smallScene(builtin.name, 96);
    const Pair pair(scene);
    const Camera camera = makeCamera(scene, scene.views.back(), 255, 301);
    Image<glm::vec4> expected, actual;
    pair.cpu->render(camera, scene.march.render, expected);
    pair.cuda->render(camera, scene.march.render, actual);
    ASSERT_EQ(expected.size(), actual.size());
    size_t different = 0;
    for (size_t i = 0; i < expected.size(); ++i) different += expected[i] != actual[i];
    EXPECT_EQ(different, 0u) << "of " << expected.size();
  }
}

TEST(MarchOnDevice, TwinsAgreeAndOutliveTheFirst) {
  WARPSCOPE_NEEDS_GPU();
  const Scene scene = smallScene("block", 48);
  MarcherPtr first = makeCudaMarcher(scene.volume, scene.transferFunction);
  const Camera camera = makeCamera(scene, scene.views.front(), 128, 128);
  const SampleFrame frame = first->march(camera, scene.march);
  ASSERT_GT(frame.size(), 1000u);
  const MarcherPtr twin = first->twin();
  first.reset();
  const SampleFrame again = twin->march(camera, scene.march);
  EXPECT_TRUE(frame.samples == again.samples && frame.colors == again.colors);
}

TEST(MarchOnDevice, FollowsAnotherTransferFunction) {
  WARPSCOPE_NEEDS_GPU();
  const glm::uvec3 dims(60, 44, 52);
  for (const VoxelType type : kAllVoxelTypes) {
    SCOPED_TRACE(nameOf(type));
    const VolumePtr volume = makeTestVolume(type, dims, blobs(dims, 5));
    const Camera camera = lookingFrom({90.0f, 40.0f, 60.0f}, {}, 160, 120);
    MarcherPtr marcher = makeCudaMarcher(volume, band(30.0, 50.0, 0.4f));
    EXPECT_EQ(marcher->capabilities().functionChange, FunctionChange::followed);
    const MarcherPtr first = marcher;
    const SampleFrame before = first->march(camera, {});
    for (const double from : {10.0, 55.0, 40.0}) {
      const TransferFunction function = band(from, from + 25.0, 0.2f);
      marcher = marcher->withTransferFunction(function);
      const MarcherPtr cpu = makeCpuMarcher(volume, function);
      expectSameFrames(cpu->march(camera, {}), marcher->march(camera, {}));
      EXPECT_TRUE(sameBits(rendered(*marcher, camera), rendered(*cpu, camera)));
    }
    expectSameFrames(before, first->march(camera, {}));
    EXPECT_GT(before.size(), 500u);
  }
}

TEST(MarchOnDevice, InTurnsItIsTheSameAndEndsAtItsLimit) {
  WARPSCOPE_NEEDS_GPU();
  const Scene scene = smallScene("shells", 64);
  const MarcherPtr whole = makeCudaMarcher(scene.volume, scene.transferFunction);
  const MarcherPtr inTurns = whole->twin(std::make_shared<Turns>());
  const Camera camera = makeCamera(scene, scene.views.front(), 500, 400);
  MarchSettings settings = scene.march;
  for (const float step : {0.5f, 0.01f}) {  // launches are smaller where there are many steps
    settings.render.step = step;
    const SampleFrame a = whole->march(camera, settings), b = inTurns->march(camera, settings);
    EXPECT_TRUE(a.samples == b.samples && a.colors == b.colors) << step;
  }
  settings.render.skipEmpty = settings.render.terminateEarly = false;
  settings.render.step = 0.001f;
  const MarcherPtr limited = whole->twin(std::make_shared<Turns>(TurnSettings{.limit = std::chrono::milliseconds(2)}));
  EXPECT_THROW(limited->march(makeCamera(scene, scene.views.front(), 2048, 2048), settings), WorkLimitExceeded);
  EXPECT_GT(limited->march(camera, scene.march).size(), 1000u);
}

TEST(MarchOnDevice, RefusesAndCancels) {
  WARPSCOPE_NEEDS_GPU();
  const Scene scene = smallScene("block", 48);
  const MarcherPtr marcher = makeCudaMarcher(scene.volume, scene.transferFunction);
  Camera camera = makeCamera(scene, scene.views.front(), 64, 64);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_THROW(marcher->march(camera, scene.march, stop.get_token()), OperationCancelled);
  camera.eye.x = std::nanf("");
  EXPECT_THROW(marcher->march(camera, scene.march), InputError);
  camera = makeCamera(scene, scene.views.front(), 64, 64);
  MarchSettings settings = scene.march;
  settings.render.step = 0.0f;
  EXPECT_THROW(marcher->march(camera, settings), UsageError);
  EXPECT_GT(marcher->march(camera, scene.march).size(), 100u);  // and goes on
}

TEST(MarchOnDevice, NothingToSeeGivesNoSamples) {
  WARPSCOPE_NEEDS_GPU();
  const Scene scene = smallScene("block", 48);
  const MarcherPtr marcher = makeCudaMarcher(scene.volume, scene.transferFunction);
  Camera camera = makeCamera(scene, scene.views.front(), 64, 64);
  camera.forward = -camera.forward;
  EXPECT_EQ(marcher->march(camera, scene.march).size(), 0u);
}

TEST(MarchOnDevice, WhereEverythingIsHiddenNothingIsMarched) {
  WARPSCOPE_NEEDS_GPU();
  Scene scene = smallScene("block", 48);
  const Camera camera = makeCamera(scene, scene.views.front(), 64, 48);
  EXPECT_GT(makeCudaMarcher(scene.volume, scene.transferFunction)->march(camera, scene.march).size(), 0u);
  for (TransferPoint& point : scene.transferFunction.points) point.alpha = 0.0f;
  const MarcherPtr marcher = makeCudaMarcher(scene.volume, scene.transferFunction);
  EXPECT_FALSE(marcher->plan(scene.march.render, scene.march.sample)->has(PlanStage::march));
  EXPECT_EQ(marcher->march(camera, scene.march).size(), 0u);
  EXPECT_EQ(largestAlpha(rendered(*marcher, camera, scene.march)), 0.0f);
}

}  // namespace
}  // namespace warpscope
