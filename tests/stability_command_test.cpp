// The cases of `warpscope stability`, run: the stable form keeps to its bound on each, and the textbook's does not where it is said to fail.
// Mirrors app/experiment/stability.h, exact_picture.h and textbook_ssim.h.
#include "app/experiment/stability.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "app/experiment/exact_picture.h"
#include "app/experiment/stability_page.h"
#include "app/experiment/textbook_ssim.h"
#include "render/base/error.h"
#include "render/cuda/devices.h"
#include "tests/marcher_cases.h"
#include "tests/ssim_truth.h"
#include "tests/test_volumes.h"

namespace warpscope {
namespace {

class Stability : public testing::TestWithParam<std::tuple<size_t, Backend>> {};

TEST_P(Stability, StableKeepsToItsBoundWhereTheTextbookFails) {
  const StabilityCase& what = stabilityCases()[std::get<0>(GetParam())];
  const Backend backend = std::get<1>(GetParam());
  if (backend == Backend::cuda && !cuda::whyUnavailable().empty()) GTEST_SKIP() << cuda::whyUnavailable();
  StabilitySettings settings;
  settings.cases = {&what};
  settings.backends = {backend};
  settings.runs = 1;
  const std::vector<StabilityResult> results = runStability(settings, [](const std::string&) {}, {});
  if (what.subject == StabilitySubject::similarity && backend != Backend::cpu) {
    EXPECT_TRUE(results.empty());
    return;
  }
  ASSERT_EQ(results.size(), 1u);
  const StabilityResult& result = results.front();
  EXPECT_TRUE(result.isStable()) << result.stable.error(what.subject) << " where " << what.bound << " is allowed";
  if (!what.textbook.starts_with("none")) EXPECT_GT(result.textbook.error(what.subject), what.bound) << what.textbook;
  EXPECT_GT(result.stable.time.medianMs, 0.0);
  const std::string page = stabilityPage(results, "a machine");
  EXPECT_THAT(page, testing::HasSubstr(std::string(what.name)));
  EXPECT_EQ(page.find("data:image/png") != std::string::npos, what.subject != StabilitySubject::similarity);
}

INSTANTIATE_TEST_SUITE_P(All, Stability,
                         testing::Combine(testing::Range<size_t>(0, stabilityCases().size()),
                                          testing::Values(Backend::cpu, Backend::cuda)),
                         [](const auto& info) {
                           std::string name = std::string(stabilityCases()[std::get<0>(info.param)].name) + "_" +
                                              std::string(nameOf(std::get<1>(info.param)));
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST(ExactPicture, IsTheClosedFormOfASlab) {
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, {20, 20, 6}, [](const glm::ivec3&) { return 7.0; });
  const TransferFunction function = everywhere(0.3f);
  const Camera camera = lookingFrom({12.0f, 9.0f, 30.0f}, {}, 32, 24);
  RenderSettings settings;
  settings.step = 0.7f;
  const Image<glm::vec4> picture = exactPicture(*volume, function, camera, settings);
  for (uint32_t y = 0; y < camera.height; ++y)
    for (uint32_t x = 0; x < camera.width; ++x) {
      const double length = lengthInside(camera, x, y, volume->bounds());
      ASSERT_NEAR(picture(x, y).a, -std::expm1(length * std::log1p(-static_cast<double>(0.3f))), 2e-7);
    }
}

TEST(ExactHits, AllowsWhatIsFirstAndWhatTies) {
  const std::vector<Sphere> spheres{{{0.0f, 0.0f, 0.0f}, 1.0f}, {{0.0f, 0.0f, -3.0f}, 1.0f}, {{0.0f, 0.0f, 0.0f}, 1.0f}};
  const Camera camera = lookingFrom({0.0f, 0.0f, 10.0f}, {}, 17, 17);
  const ExactHits exact(spheres, camera);
  EXPECT_EQ(exact.ids()(8, 8), 0u);
  EXPECT_TRUE(exact.allows(8, 8, 0));
  EXPECT_TRUE(exact.allows(8, 8, 2));   // as near
  EXPECT_FALSE(exact.allows(8, 8, 1));  // behind
  EXPECT_FALSE(exact.allows(8, 8, kNoSample));
  EXPECT_TRUE(exact.allows(0, 0, kNoSample));
  EXPECT_FALSE(exact.allows(0, 0, 0));
}

TEST(TextbookSsim, IsTheSameNumberWhereNothingIsHard) {
  Image<float> a(40, 30), b(40, 30);
  for (uint32_t y = 0; y < 30; ++y)
    for (uint32_t x = 0; x < 40; ++x) {
      a(x, y) = 0.5f + 0.3f * std::sin(0.7f * static_cast<float>(x));
      b(x, y) = a(x, y) + 0.1f * std::cos(1.3f * static_cast<float>(y));
    }
  const double exact = exactSsim(a, b);
  const Levels levelsA(a.begin(), a.end()), levelsB(b.begin(), b.end());
  EXPECT_NEAR(exact, static_cast<double>(ssimTruth(levelsA, levelsB, 40)), 1e-12);
  EXPECT_LT(exact, 0.99);
  EXPECT_NEAR(textbookSsim({a, a, a}, {b, b, b}), exact, 1e-5);
  EXPECT_NEAR(exactSsim(a, a), 1.0, 1e-14);
}

}  // namespace
}  // namespace warpscope
