// Bounds of what warps can do: dots that no choice of depths beats, and pictures that are right wherever the frame saw the place.
// Mirrors app/experiment/oracle.h.
#include <gtest/gtest.h>

#include "app/experiment/oracle.h"
#include "headless.h"
#include "marcher_cases.h"
#include "render/metrics/psnr.h"
#include "render/warp/points_warp.h"
#include "test_volumes.h"

namespace warpscope {
namespace {

Scene ballScene() {
  Scene scene = smallScene("block", 16);
  const glm::uvec3 dims(40, 40, 40);
  // A ball with a pattern, thick enough that its edge's colour does not hide it.
  scene.volume = makeTestVolume(VoxelType::uint8, dims, [](const glm::ivec3& p) {
    const glm::dvec3 offset = glm::dvec3(p) - glm::dvec3(19.5);
    return glm::length(offset) < 15.0 ? 165.0 + 50.0 * std::sin(0.5 * offset.x) * std::sin(0.5 * offset.y + 1.0) * std::sin(0.5 * offset.z + 2.0) : 0.0;
  });
  scene.transferFunction = {{{100.0, {1.0f, 0.1f, 0.1f}, 0.0f}, {105.0, {1.0f, 0.1f, 0.1f}, 0.5f}, {165.0, {0.1f, 1.0f, 0.1f}, 0.5f}, {220.0, {0.1f, 0.1f, 1.0f}, 0.5f}}};
  return scene;
}

class OracleTest : public testing::Test {
 protected:
  OracleTest() : stage_(ballScene()) {
    march_ = stage_.scene().march;
    march_.render.effects.shading.strength = 0.0f;
    march_.sample.segments = 8;
    march_.sample.proxy = 0;
  }

  Stage stage_;
  MarchSettings march_;
};

TEST_F(OracleTest, NoHeuristicBeatsTheBestDots) {
  for (const double turnDeg : {0.0, 15.0, 60.0, 180.0}) {
    const Camera camera = stage_.camera(128, 128, turnDeg);
    Image<glm::vec4> reference;
    stage_.marcher().render(camera, march_.render, reference);
    const auto psnrOf = [&](const WarpedImage& image) { return psnrSrgb(image.color, reference, glm::vec3(0.0f)); };
    const SampleFramePtr frame = stage_.frame(stage_.camera(128, 128), march_);
    const WarpedImage best = Oracle(frame, nullptr, glm::vec3(0.0f)).bestDots(camera, reference, {});
    for (const auto& heuristic : kHeuristics) {
      MarchSettings march = march_;
      march.sample.heuristic = heuristic.value;
      march.sample.radiusPolicy = RadiusPolicy::pixel;
      const SampleFramePtr other = stage_.frame(stage_.camera(128, 128), march);
      for (const char* technique : {"points", "spheres"}) {
        WarpSettings settings;
        settings.knobs.set(kPointSizeKnob, 1);
        // Half a decibel: dots that are met beside the middle of their pixels lie beyond what lines pass.
        EXPECT_GT(psnrOf(best), psnrOf(stage_.draw(technique, other, camera, settings)) - 0.5) << turnDeg << ", " << technique << ", " << heuristic.name;
      }
    }
    if (turnDeg == 0.0) EXPECT_GT(psnrOf(best), 45.0);
    for (size_t i = 0; i < best.samples.size(); ++i) ASSERT_TRUE(best.samples[i] == kNoSample || best.samples[i] < frame->size());
  }
}

TEST_F(OracleTest, ItsCopyHasAllVoxelsWhateverTheirShape) {
  for (const glm::dvec3& spacing : {glm::dvec3(1.0, 1.0, 10.0), glm::dvec3(3.0, 1.0, 1.0), glm::dvec3(0.7)}) {
    VolumeGeometry geometry = stage_.scene().volume->geometry();
    geometry.dims = {20, 12, 9};
    geometry.spacing = spacing;
    const auto voxels = std::make_shared<std::vector<uint8_t>>(20 * 12 * 9, uint8_t{7});
    const Volume volume("it", VoxelType::uint8, geometry, voxels, voxels->data());
    EXPECT_EQ(wholeCopyOf(volume, stage_.scene().transferFunction, {})->volume->dims(), geometry.dims);
  }
}

TEST_F(OracleTest, StoppedOrWithoutSegmentsItKnowsNothing) {
  SampleFrame frame = *stage_.frame(stage_.camera(64, 64), march_);
  const Image<glm::vec4> truth(64, 64, glm::vec4(0.5f));
  std::stop_source stop;
  stop.request_stop();
  const auto known = [](const SampleFrame& of) { return Oracle(std::make_shared<SampleFrame>(of), nullptr, glm::vec3(0.0f)); };
  EXPECT_THROW(known(frame).bestDots(stage_.camera(64, 64), truth, stop.get_token()), OperationCancelled);
  for (RaySegmentCount& ray : frame.segments.rays) ray = {0, true};
  frame.segments.depths.clear();
  frame.segments.colors.clear();
  frame.segments.normals.clear();
  for (const uint32_t id : known(frame).bestDots(stage_.camera(64, 64), truth, {}).samples) ASSERT_EQ(id, kNoSample);
}

TEST_F(OracleTest, APerfectWarpIsTheVolumeWhereTheFrameKnowsIt) {
  const SampleFramePtr frame = stage_.frame(stage_.camera(128, 128), march_);
  const auto whole = std::make_shared<const Proxy>(makeProxy(*stage_.scene().volume, stage_.scene().transferFunction, 40, CopyFilter::leastSquares));
  double before = 0.0;
  for (const double turnDeg : {0.0, 30.0, 180.0}) {
    const Camera camera = stage_.camera(128, 128, turnDeg);
    Image<glm::vec4> reference;
    stage_.marcher().render(camera, march_.render, reference);
    const WarpedImage image = Oracle(frame, whole, glm::vec3(0.0f)).perfectlyWarped(camera, {});
    const double psnr = psnrSrgb(image.color, reference, glm::vec3(0.0f));
    EXPECT_GT(psnr, turnDeg == 0.0 ? 100.0 : turnDeg == 30.0 ? 20.0 : 5.0) << turnDeg;
    if (turnDeg > 0.0) EXPECT_LT(psnr, before);
    before = psnr;
    for (size_t i = 0; i < image.samples.size(); ++i) ASSERT_EQ(image.samples[i] == kNoSample, image.color[i].a == 0.0f);
  }
  // Of a volume that hides nothing all is known.
  Scene thin = ballScene();
  for (TransferPoint& point : thin.transferFunction.points) point.alpha *= 0.02f;
  const Stage stage(thin);
  const SampleFramePtr seenThrough = stage.frame(stage.camera(128, 128), march_);
  const auto all = std::make_shared<const Proxy>(makeProxy(*thin.volume, thin.transferFunction, 40, CopyFilter::leastSquares));
  Image<glm::vec4> reference;
  stage.marcher().render(stage.camera(128, 128, 60.0), march_.render, reference);
  EXPECT_GT(psnrSrgb(Oracle(seenThrough, all, glm::vec3(0.0f)).perfectlyWarped(stage.camera(128, 128, 60.0), {}).color, reference, glm::vec3(0.0f)), 40.0);
}

}  // namespace
}  // namespace warpscope
