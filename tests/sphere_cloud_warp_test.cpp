// Techniques that draw a frame as spheres show the same samples, on every built-in scene.
// Mirrors render/warp/sphere_cloud_warp.h; what all techniques owe their caller is in warp_test.cpp.
#include "render/warp/sphere_cloud_warp.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/base/error.h"
#include "render/core/ray_sphere.h"
#include "render/march/own_picture.h"
#include "render/metrics/flip.h"
#include "render/warp/spheres_warp.h"
#include "tests/frame_samples.h"
#include "tests/headless.h"
#include "tests/real_data.h"

namespace warpscope {
namespace {

TEST(SphereCloudWarp, EmbreeAndLbvhSeeTheSameOnRealFrames) {
  for (const BuiltinScene& builtin : builtinScenes()) {
    const Stage stage(smallScene(builtin.name, 64));
    const SampleFramePtr frame = stage.frame(stage.camera(320, 240), stage.scene().march);
    for (const double turn : {0.0, 12.0, -40.0}) {
      const Camera camera = stage.camera(320, 240, turn);
      WarpSettings lbvh, embree;
      embree.knobs.set(kSphereTracingKnob, SphereTracing::embree);
      const WarpedImage a = stage.draw("spheres", frame, camera, lbvh);
      const WarpedImage b = stage.draw("spheres", frame, camera, embree);
      size_t different = 0;
      for (uint32_t y = 0; y < camera.height; ++y)
        for (uint32_t x = 0; x < camera.width; ++x) {
          const uint32_t ids[2] = {a.samples(x, y), b.samples(x, y)};
          if (ids[0] == ids[1]) continue;
          ++different;
          // Only where rounding decides: hits of one distance, or a silhouette that one of them just misses.
          const Ray ray = pixelRay(camera, {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f});
          double t[2], miss[2] = {1.0, 1.0};
          for (int k = 0; k < 2; ++k) {
            t[k] = std::numeric_limits<double>::infinity();
            if (ids[k] == kNoSample) continue;
            const Sphere sphere = sphereOf(*frame, ids[k]);
            const glm::dvec3 direction = glm::normalize(glm::dvec3(ray.direction));
            const glm::dvec3 toCenter = glm::dvec3(sphere.center) - glm::dvec3(ray.origin);
            const double along = glm::dot(toCenter, direction);
            const glm::dvec3 offset = toCenter - along * direction;
            const double radius = sphere.radius;
            miss[k] = std::abs(glm::length(offset) - radius) / radius;
            t[k] = along - std::sqrt(std::max(0.0, radius * radius - glm::dot(offset, offset)));
          }
          const bool isTie = std::abs(t[0] - t[1]) < 1e-4 * std::max(1.0, std::min(t[0], t[1]));
          const bool isSilhouette = std::min(miss[0], miss[1]) < 1e-3;
          EXPECT_TRUE(isTie || isSilhouette) << builtin.name << " " << turn << " degrees, pixel " << x << " " << y << ": ids "
                                             << ids[0] << " " << ids[1] << ", t " << t[0] << " " << t[1];
        }
      EXPECT_LT(different, 100u) << builtin.name << ", " << turn << " degrees";
    }
  }
}

/// Splats are the traced picture: sample for sample and bit for bit.
TEST(SphereCloudWarp, SplatsShowWhatSpheresShow) {
  for (const BuiltinScene& builtin : builtinScenes()) {
    const Stage stage(smallScene(builtin.name, 64));
    const SampleFramePtr frame = stage.frame(stage.camera(320, 240), stage.scene().march);
    for (const double turn : {0.0, 12.0, -40.0, 170.0}) {
      SCOPED_TRACE(builtin.name + ", " + std::to_string(turn) + " degrees");
      const Camera camera = stage.camera(301, 243, turn);
      const WarpedImage spheres = stage.draw("spheres", frame, camera);
      const WarpedImage splats = stage.draw("splats", frame, camera);
      EXPECT_GT(std::count_if(spheres.samples.begin(), spheres.samples.end(), [](uint32_t id) { return id != kNoSample; }), 1000);
      EXPECT_EQ(splats.samples, spheres.samples);
      EXPECT_EQ(splats.color, spheres.color);
    }
  }
}

/// 0 is the picture itself; that of spheres of voxels' radii is 0.03 to 0.2 away from it.
void expectOwnPicture(const Scene& scene, uint32_t side) {
  const Stage stage(scene);
  const SampleFramePtr frame = stage.frame(stage.camera(side, side), scene.march);
  Image<glm::vec4> own;
  resolveRayColors(*frame, ownPicture(*frame), own);
  EXPECT_LT(flip(stage.draw("multihit", frame, frame->camera).color, own, glm::vec3(0.0f)).mean, 0.01) << side;
}

TEST(SphereCloudWarp, MultihitIsTheFramesOwnPictureOnEveryScene) {
  for (const BuiltinScene& builtin : builtinScenes())
    for (const uint32_t side : {512u, 1024u}) {
      SCOPED_TRACE(builtin.name);
      expectOwnPicture(smallScene(builtin.name, 128), side);
    }
}

TEST(SphereCloudWarp, MultihitIsTheFramesOwnPictureOnRealVolumes) {
  for (const char* name : {"engine_256x256x128_uint8.raw", "spm152.nii.gz"}) {
    const RealData file(name);
    if (!file.whyMissing().empty()) GTEST_SKIP() << file.whyMissing();
    SCOPED_TRACE(name);
    for (const uint32_t side : {512u, 1024u}) expectOwnPicture(openScene(file.path().string(), {}), side);
  }
}

/// Drawn out by 0, and where frames say nothing of spreads, they are the spheres that they were; else they close gaps, by the lbvh alone.
TEST(SphereCloudWarp, SpheresAreDrawnOutWhereDepthIsUncertain) {
  for (const char* name : {"shells", "block"}) {
    const Stage stage(smallScene(name, 64));
    MarchSettings march = stage.scene().march;
    const SampleFramePtr plain = stage.frame(stage.camera(160, 120), march);
    march.sample.sendsSpread = true;
    const SampleFramePtr spread = stage.frame(stage.camera(160, 120), march);
    const Camera camera = stage.camera(160, 120, 25.0);
    const WarpedImage spheres = stage.draw("spheres", plain, camera);
    WarpSettings none, whole;
    none.knobs.set(kSmearKnob, 0.0);
    whole.knobs.set(kSmearKnob, 2.0);
    EXPECT_EQ(stage.draw("spheres", spread, camera, none).samples, spheres.samples);
    EXPECT_EQ(stage.draw("spheres", plain, camera, whole).samples, spheres.samples);
    const auto covered = [](const WarpedImage& image) { return std::ranges::count_if(image.samples, [](uint32_t id) { return id != kNoSample; }); };
    EXPECT_GT(covered(stage.draw("spheres", spread, camera, whole)), covered(spheres) + 100) << name;
    // One that is kept follows its settings.
    const std::unique_ptr<Warp> warp = makeWarp(findWarp("spheres"), stage.resources());
    warp->setFrame(spread, none);
    WarpedImage image;
    for (const WarpSettings& settings : {none, whole, none}) {
      warp->draw(camera, settings, image);
      EXPECT_EQ(image.samples, stage.draw("spheres", spread, camera, settings).samples);
    }
    whole.knobs.set(kSphereTracingKnob, SphereTracing::embree);
    EXPECT_THROW(stage.draw("spheres", spread, camera, whole), UsageError);
    none.knobs.set(kSphereTracingKnob, SphereTracing::embree);
    EXPECT_NO_THROW(stage.draw("spheres", spread, camera, none));
  }
}

/// Spheres that would hold the eye give way: the view from which a frame was marched is covered, and no technique shows another picture than the others.
TEST(SphereCloudWarp, AnEyeInsideMatterSeesWhatIsAroundIt) {
  for (const char* name : {"shells", "block"}) {
    const Stage stage(smallScene(name, 64));
    const Camera camera = makeCamera(stage.scene(), {30.0, 20.0, 0.05, {}}, 160, 120);
    const SampleFramePtr frame = stage.frame(camera, stage.scene().march);
    ASSERT_GT(frame->size(), camera.width * camera.height / 2);
    for (const double turn : {0.0, 4.0, 180.0}) {
      SCOPED_TRACE(std::string(name) + ", " + std::to_string(turn) + " degrees");
      const Camera eye = makeCamera(stage.scene(), {30.0 + turn, 20.0, 0.05, {}}, 160, 120);
      const WarpedImage spheres = stage.draw("spheres", frame, eye);
      const auto covered = static_cast<size_t>(std::count_if(spheres.samples.begin(), spheres.samples.end(), [](uint32_t id) { return id != kNoSample; }));
      if (turn == 0.0) EXPECT_GT(covered, 0.999 * static_cast<double>(frame->size()));
      EXPECT_EQ(stage.draw("splats", frame, eye).samples, spheres.samples);
      WarpSettings settings;
      if (turn == 0.0) EXPECT_EQ(stage.draw("multihit", frame, eye, settings).samples, ownPicture(*frame));
      settings.knobs.set(kSphereTracingKnob, SphereTracing::embree);
      const WarpedImage embree = stage.draw("spheres", frame, eye, settings);
      size_t different = 0;
      for (size_t i = 0; i < spheres.samples.size(); ++i) different += embree.samples[i] != spheres.samples[i];
      EXPECT_LT(different, spheres.samples.size() / 100);
    }
  }
}

/// One after another, whatever was built before.
TEST(SphereCloudWarp, EveryWayOfTracingIsTheSame) {
  const Stage stage(smallScene("block", 48));
  const SampleFramePtr frame = stage.frame(stage.camera(120, 90), stage.scene().march);
  const std::unique_ptr<Warp> warp = makeWarp(findWarp("spheres"), stage.resources());
  warp->setFrame(frame, {});
  for (const double turn : {0.0, 20.0}) {
    const Camera camera = stage.camera(133, 77, turn);
    const WarpedImage expected = stage.draw("spheres", frame, camera);
    for (const SphereTracing tracing : {SphereTracing::footprints, SphereTracing::lbvh, SphereTracing::footprints, SphereTracing::automatic}) {
      WarpSettings settings;
      settings.knobs.set(kSphereTracingKnob, tracing);
      WarpedImage image;
      warp->draw(camera, settings, image);
      EXPECT_EQ(image.samples, expected.samples) << nameOf(kSphereTracings, tracing);
      EXPECT_TRUE(image.color == expected.color);
    }
  }
}

/// What was built for one eye is not what another sees.
TEST(SphereCloudWarp, AnEyeThatPassesThroughTheCloudSeesEachTimeWhatItSawAtFirst) {
  const Stage stage(smallScene("shells", 48));
  const SampleFramePtr frame = stage.frame(stage.camera(120, 90), stage.scene().march);
  for (const char* technique : {"spheres", "multihit"}) {
    const std::unique_ptr<Warp> warp = makeWarp(findWarp(technique), stage.resources());
    warp->setFrame(frame, {});
    for (const double distance : {0.7, 0.3, 0.1, 0.05, 0.3, 0.7}) {
      const Camera camera = makeCamera(stage.scene(), {30.0, 20.0, distance, {}}, 100, 80);
      WarpedImage image;
      warp->draw(camera, {}, image);
      EXPECT_EQ(image.samples, stage.draw(technique, frame, camera).samples) << technique << " from " << distance;
    }
  }
}

}  // namespace
}  // namespace warpscope
