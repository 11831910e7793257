// What stages cost, by a marcher that says how long it took: pairs from the same camera, another camera for each pair.
// Mirrors app/experiment/stage_costs.h.
#include "app/experiment/stage_costs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "marcher_cases.h"
#include "render/base/error.h"
#include "test_volumes.h"

namespace warpscope {
namespace {

/// Milliseconds of a march: 5, 2 more with light, and 10 for shadows, but 100 where the camera is another than in the last march with shadows.
class TimedMarcher final : public Marcher {
 public:
  explicit TimedMarcher(MarcherPtr inner) : inner_(std::move(inner)) {}

  SampleFrame march(const Camera& camera, const MarchSettings& settings, const std::stop_token&) override {
    const Effects& effects = settings.render.effects;
    SampleFrame frame;
    frame.timings.marchMs = 5.0 + (effects.shading.strength > 0.0f ? 2.0 : 0.0);
    if (effects.shadows.strength > 0.0f) {
      frame.timings.marchMs += shadowed_ == camera ? 10.0 : 100.0;
      shadowed_ = camera;
    }
    cameras.push_back(camera);
    return frame;
  }
  void render(const Camera&, const RenderSettings&, Image<glm::vec4>&, const std::stop_token&) override {}
  const VolumePtr& volume() const override { return inner_->volume(); }
  Backend backend() const override { return inner_->backend(); }
  MarcherCapabilities capabilities() const override { return inner_->capabilities(); }
  std::optional<EffectPlan> plan(const RenderSettings& settings, const std::optional<SampleSettings>& sample) const override {
    return inner_->plan(settings, sample);
  }
  MarcherPtr twin(TurnsPtr) const override { return nullptr; }
  MarcherPtr withTransferFunction(TransferFunction) const override { return nullptr; }

  std::vector<Camera> cameras;

 private:
  const MarcherPtr inner_;
  std::optional<Camera> shadowed_;
};

class StageCostsTest : public testing::Test {
 protected:
  StageCostsTest() {
    settings_.render.effects.shading.strength = 1.0f;
    settings_.render.effects.lights = parseLights("camera:1,1,1", "it");
    settings_.render.effects.shadows.strength = 1.0f;
  }
  StageCosts measured(int runs, const std::stop_token& stop = {}) {
    return measureStages(marcher_, camera_, settings_, *marcher_.plan(settings_.render, settings_.sample), runs, [](std::string_view) {}, stop);
  }

  const glm::uvec3 dims_{20, 20, 20};
  TimedMarcher marcher_{makeCpuMarcher(makeTestVolume(VoxelType::uint8, dims_, blobs(dims_, 2)), everywhere(0.3f))};
  const Camera camera_ = lookingFrom({30.0f, 20.0f, 40.0f}, glm::vec3(0.0f), 20, 20);
  MarchSettings settings_;
};

TEST_F(StageCostsTest, WhatGoesWithTheCameraIsMadeAnewForEachPair) {
  const StageCosts costs = measured(5);
  EXPECT_EQ(costs.of(PlanStage::shadows)->medianMs, 100.0);
  EXPECT_EQ(costs.march.medianMs, 107.0);
  EXPECT_EQ(costs.of(PlanStage::jitter), nullptr) << "it is out";
  EXPECT_EQ(costs.of(PlanStage::lightVolume), nullptr) << "it cannot be left out by itself";
}

TEST_F(StageCostsTest, PairsAreOfOneCameraHardlyTurned) {
  measured(4);
  ASSERT_EQ(marcher_.cameras.front(), camera_) << "to warm up";
  size_t pairs = 0;
  for (const Camera& camera : marcher_.cameras) {
    EXPECT_EQ(camera.eye, camera_.eye);
    EXPECT_GT(glm::dot(camera.forward, camera_.forward), 0.99999f);
    EXPECT_NEAR(glm::dot(camera.forward, camera.right), 0.0f, 1e-6f);
    EXPECT_NEAR(glm::length(camera.forward), 1.0f, 1e-6f);
  }
  for (size_t i = 1; i < marcher_.cameras.size(); ++i) pairs += marcher_.cameras[i] == marcher_.cameras[i - 1] ? 1 : 0;
  EXPECT_GE(pairs, 4u * 2u);
}

TEST_F(StageCostsTest, EndsWhenItIsToldTo) {
  std::stop_source stop;
  stop.request_stop();
  EXPECT_THROW(measured(3, stop.get_token()), OperationCancelled);
}

}  // namespace
}  // namespace warpscope
