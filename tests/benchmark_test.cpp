// What would be timed is looked at first: techniques whose pictures are wrong, and effects that do nothing.
// Mirrors app/experiment/benchmark.h and app/experiment/effect_costs.h.
#include "app/experiment/benchmark.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/experiment/effect_costs.h"
#include "render/base/error.h"
#include "tests/complaint.h"
#include "tests/headless.h"
#include "tests/marcher_cases.h"

namespace warpscope {
namespace {

using testing::HasSubstr;

/// Draws white, whatever there is.
class WhiteWarp final : public Warp {
 public:
  void setFrame(SampleFramePtr, const WarpSettings&, const std::stop_token&) override {}
  void draw(const Camera& camera, const WarpSettings&, WarpedImage& image, const std::stop_token&) override {
    image.color = Image<glm::vec4>(camera.width, camera.height, glm::vec4(1.0f));
    image.samples = Image<uint32_t>(camera.width, camera.height, kNoSample);
  }
};

constexpr WarpDescriptor kWhiteWarp{
    .name = "white", .label = "White", .summary = "white", .make = [](const WarpResources&) -> std::unique_ptr<Warp> { return std::make_unique<WhiteWarp>(); }};

TEST(Benchmark, ATechniqueWhosePictureIsWrongIsNotTimed) {
  const Stage stage(smallScene("block", 24));
  BenchmarkSettings settings;
  settings.march = stage.scene().march;
  settings.width = settings.height = 48;
  settings.runs = 1;
  settings.backends = {Backend::cpu};
  const auto run = [&](const WarpDescriptor& technique) {
    settings.techniques = {&technique};
    return runBenchmark(stage.scene(), settings, [&](Backend) { return stage.resources(); }, [](const std::string&) {}, {});
  };
  const std::vector<BackendBenchmark> right = run(findWarp("hold"));
  ASSERT_EQ(right.size(), 1u);
  EXPECT_EQ(right.front().techniques.size(), 1u);
  EXPECT_THAT(complaintOf([&] { run(kWhiteWarp); }), AllOf(HasSubstr("white on cpu: its picture is wrong"), HasSubstr("nothing was timed")));
}

TEST(EffectCosts, AnEffectThatDoesNotChangeThePictureIsNotTimed) {
  const Scene scene = smallScene("block", 24);
  const Camera camera = makeCamera(scene, scene.views.front(), 40, 40);
  int rounds = 0;
  const auto measure = [&](const MarcherPtr& marcher) { measureEffects(*marcher, camera, scene.march, 1, [&] { ++rounds; }, {}); };
  measure(makeCpuMarcher(scene.volume, scene.transferFunction));
  EXPECT_EQ(rounds, 2);
  EXPECT_THAT(complaintOf([&] { measure(makeCpuMarcher(scene.volume, everywhere(0.0f))); }), HasSubstr("does not change this picture; nothing was timed"));
  EXPECT_EQ(rounds, 2) << "of an empty picture there was none";
}

}  // namespace
}  // namespace warpscope
