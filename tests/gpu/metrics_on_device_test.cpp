// Metrics on the device say what they say on the CPU: noise, waves and warped pictures of any size, from host memory and as the device shows them.
// Mirrors render/metrics/picture_judge_cuda.h.
#include "render/metrics/picture_judge_cuda.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "app/scene/scene.h"
#include "app/session/judge_worker.h"
#include "render/base/error.h"
#include "render/cuda/devices.h"
#include "render/march/marcher_cpu.h"
#include "render/metrics/picture_errors.h"
#include "render/warp/spheres_warp_cuda.h"
#include "tests/gpu/agreement.h"
#include "tests/headless.h"
#include "tests/metric_pictures.h"

namespace warpscope {
namespace {

constexpr glm::vec3 kBackground(0.02f, 0.1f, 0.3f);

/// A little of `other` mixed in, less where pixels are even.
Image<glm::vec4> mixed(const Image<glm::vec4>& image, const Image<glm::vec4>& other) {
  Image<glm::vec4> result = image;
  for (size_t i = 0; i < result.size(); ++i) result[i] += (i % 2 == 0 ? 0.001f : 0.05f) * (other[i] - image[i]);
  return result;
}

/// What `errors` and `map` of the device are on the CPU.
void expectAgreement(const DeviceErrors& errors, const Image<float>& map, const Image<glm::vec4>& picture, const Image<glm::vec4>& reference,
                     const glm::vec3& background, float pixelsPerDegree = kFlipPixelsPerDegree) {
  const WarpedImage image{picture, Image<uint32_t>(picture.width(), picture.height(), 0)};
  Image<float> expectedMap;
  const PictureErrors expected = PictureJudge(reference, background, pixelsPerDegree).errorsOf(image, nullptr, &expectedMap);
  const auto expectNear = [](double value, double truth) {
    if (std::isinf(truth))
      EXPECT_EQ(value, truth);
    else
      EXPECT_NEAR(value, truth, 1e-5);
  };
  expectNear(errors.psnrDb, expected.psnrDb);
  expectNear(errors.psnrLinearDb, expected.psnrLinearDb);
  expectNear(errors.ssim, expected.ssim);
  expectNear(errors.flip, expected.flip);
  ASSERT_EQ(map.width(), expectedMap.width());
  ASSERT_EQ(map.height(), expectedMap.height());
  double sum = 0.0;
  for (size_t i = 0; i < map.size(); ++i) {
    const double difference = std::abs(static_cast<double>(map[i]) - static_cast<double>(expectedMap[i]));
    ASSERT_LE(difference, 2e-3) << i;  // powers are steep at 0
    sum += difference;
  }
  EXPECT_LE(sum / static_cast<double>(map.size()), 1e-5);
}

TEST(MetricsOnDevice, AgreeOnNoiseOfAnySize) {
  WARPSCOPE_NEEDS_GPU();
  const auto judge = makeCudaPictureJudge(kBackground);
  for (const auto& [width, height] : {std::pair(1u, 1u), std::pair(7u, 3u), std::pair(11u, 64u), std::pair(1024u, 1024u), std::pair(2000u, 1501u),
                                      std::pair(33u, 10u)}) {
    SCOPED_TRACE(std::to_string(width) + "x" + std::to_string(height));
    const Image<glm::vec4> reference = noise(width, height, 1), other = noise(width, height, 2);
    judge->setReference(reference);
    Image<float> map;
    for (const Image<glm::vec4>& picture : {other, mixed(reference, other), reference}) {
      const DeviceErrors errors = judge->errorsOf(picture, &map);
      expectAgreement(errors, map, picture, reference, kBackground);
    }
  }
}

TEST(MetricsOnDevice, AgreeWithOtherImplementations) {
  WARPSCOPE_NEEDS_GPU();
  const auto judge = makeCudaPictureJudge(glm::vec3(0.0f));
  judge->setReference(somePicture(0.0, false));
  const DeviceErrors errors = judge->errorsOf(somePicture(0.35, true));
  EXPECT_NEAR(errors.flip, kOracleFlip, 1e-4);
  EXPECT_NEAR(errors.ssim, kOracleSsim, 1e-5);
  EXPECT_NEAR(errors.psnrDb, kOraclePsnrDb, 1e-4);
}

TEST(MetricsOnDevice, AgreeAtAnyViewingDistance) {
  WARPSCOPE_NEEDS_GPU();
  const Image<glm::vec4> reference = somePicture(0.0, false), picture = somePicture(0.2, true);
  for (const float pixelsPerDegree : {1.0f, 20.0f, 150.0f, 1000.0f}) {
    SCOPED_TRACE(pixelsPerDegree);
    const auto judge = makeCudaPictureJudge(kBackground, pixelsPerDegree);
    judge->setReference(reference);
    Image<float> map;
    const DeviceErrors errors = judge->errorsOf(picture, &map);
    expectAgreement(errors, map, picture, reference, kBackground, pixelsPerDegree);
  }
}

TEST(MetricsOnDevice, AgreeOnWarpedPictures) {
  WARPSCOPE_NEEDS_GPU();
  const Scene scene = openScene("shells");
  const MarcherPtr marcher = makeCpuMarcher(scene.volume, scene.transferFunction);
  const MarchSettings settings;
  const Camera before = makeCamera(scene, scene.views.at(0), 600, 401), now = makeCamera(scene, scene.views.at(1), 600, 401);
  Image<glm::vec4> reference, held;
  marcher->render(now, settings.render, reference);
  marcher->render(before, settings.render, held);
  const auto judge = makeCudaPictureJudge(scene.background);
  judge->setReference(reference);
  Image<float> map;
  DeviceErrors errors = judge->errorsOf(held, &map);
  expectAgreement(errors, map, held, reference, scene.background);

  const auto warp = makeCudaSpheresWarp();
  warp->setFrame(std::make_shared<SampleFrame>(marcher->march(before, settings)), {});
  WarpedImage drawn;
  warp->draw(now, {}, drawn);
  errors = judge->errorsOf(drawn.color, &map);
  expectAgreement(errors, map, drawn.color, reference, scene.background);

  // As the screen shows it: eight bits, which the CPU gets decoded.
  const DevicePicturePtr shown = warp->drawForScreen(now, {}, scene.background, {});
  ASSERT_TRUE(shown);
  std::vector<Rgba8> codes(size_t{shown->width()} * shown->height());
  shown->download(codes);
  Image<glm::vec4> decoded(shown->width(), shown->height());
  for (size_t i = 0; i < codes.size(); ++i) decoded[i] = decodeRgba8(codes[i]);
  errors = judge->errorsOf(*shown, &map);
  expectAgreement(errors, map, decoded, reference, scene.background);
  judge->setReference(*shown);
  errors = judge->errorsOf(reference, &map);
  expectAgreement(errors, map, reference, decoded, scene.background);
}

TEST(MetricsOnDevice, WhatCannotBeComparedIsRefusedAndDoesNotStick) {
  WARPSCOPE_NEEDS_GPU();
  EXPECT_THROW(makeCudaPictureJudge(kBackground, 0.5f), InputError);
  const auto judge = makeCudaPictureJudge(kBackground);
  const Image<glm::vec4> good = noise(50, 40, 1);
  EXPECT_THROW(judge->errorsOf(good), InputError);  // nothing to compare with
  EXPECT_THROW(judge->setReference(Image<glm::vec4>()), InputError);
  Image<glm::vec4> broken = good;
  broken(49, 39).a = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(judge->setReference(broken), InputError);
  EXPECT_THROW(judge->errorsOf(good), InputError);
  judge->setReference(good);
  EXPECT_THROW(judge->errorsOf(noise(40, 50, 1)), InputError);
  EXPECT_THROW(judge->errorsOf(broken), InputError);
  const DeviceErrors errors = judge->errorsOf(good);
  EXPECT_EQ(errors.flip, 0.0);
  EXPECT_EQ(errors.psnrDb, std::numeric_limits<double>::infinity());
  EXPECT_NEAR(errors.ssim, 1.0, 1e-6);
}

/// What a panel of the window does where a device marches.
TEST(JudgeOnDevice, FindsWhatTheCpuFinds) {
  WARPSCOPE_NEEDS_GPU();
  const Stage stage(smallScene("block"), gl::Platform::automatic, Backend::cuda);
  const Camera camera = stage.camera(180, 140, 20.0);
  const SampleFramePtr frame = stage.frame(stage.camera(180, 140), stage.scene().march);
  const JudgeFunction judge = makeJudge();
  for (const float grey : {0.0f, 0.25f}) {  // another background is another ground truth
    const ReferenceJob job{stage.resources().marcher, camera, stage.scene().march.render, glm::vec3(grey)};
    Image<glm::vec4> color;
    stage.marcher().render(camera, job.settings, color);
    const auto reference = std::make_shared<const ReferenceImage>(job, std::move(color));
    for (const char* technique : {"points", "splats", "multihit"}) {
      const WarpedImage image = stage.draw(technique, frame, camera);
      Image<float> map, expectedMap;
      const PictureErrors found = judge(reference, image, map), expected = reference->judge().errorsOf(image, nullptr, &expectedMap);
      EXPECT_NEAR(found.flip, expected.flip, 1e-5) << technique;
      EXPECT_NEAR(found.ssim, expected.ssim, 1e-5);
      EXPECT_NEAR(found.psnrDb, expected.psnrDb, 1e-4);
      EXPECT_NEAR(found.psnrLinearDb, expected.psnrLinearDb, 1e-4);
      EXPECT_EQ(found.holeFraction, expected.holeFraction);
      EXPECT_GT(found.flip, 0.0);
      ASSERT_EQ(map.size(), expectedMap.size());
      for (size_t i = 0; i < map.size(); ++i) ASSERT_NEAR(map[i], expectedMap[i], 2e-3f) << technique << " " << i;
    }
  }
}

}  // namespace
}  // namespace warpscope
