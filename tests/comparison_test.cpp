// Rows of a comparison against pictures drawn anew: one frame from the first view, each view's own ground truth, what is drawn how often.
// Mirrors app/experiment/comparison.h.
#include "app/experiment/comparison.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

#include "render/base/error.h"
#include "render/metrics/holes.h"
#include "render/metrics/psnr.h"
#include "tests/headless.h"

namespace warpscope {
namespace {

/// A marcher that counts what it is asked for.
class CountingMarcher final : public Marcher {
 public:
  explicit CountingMarcher(MarcherPtr marcher) : marcher_(std::move(marcher)) {}
  SampleFrame march(const Camera& camera, const MarchSettings& settings, const std::stop_token& stop) override {
    ++marches;
    return marcher_->march(camera, settings, stop);
  }
  void render(const Camera& camera, const RenderSettings& settings, Image<glm::vec4>& image, const std::stop_token& stop) override {
    ++renders;
    marcher_->render(camera, settings, image, stop);
  }
  const VolumePtr& volume() const override { return marcher_->volume(); }
  Backend backend() const override { return marcher_->backend(); }
  MarcherCapabilities capabilities() const override { return marcher_->capabilities(); }
  using Marcher::twin;
  MarcherPtr twin(TurnsPtr turns) const override { return marcher_->twin(std::move(turns)); }
  MarcherPtr withTransferFunction(TransferFunction function) const override {
    return marcher_->withTransferFunction(std::move(function));
  }

  std::atomic<int> marches = 0, renders = 0;

 private:
  MarcherPtr marcher_;
};

Scene sceneOfTwoViews() {
  Scene scene = smallScene("block");
  scene.views.resize(1);
  scene.views.push_back(scene.views.front());
  scene.views.back().angleDeg += 25.0;
  scene.views.back().distance *= 0.8;
  scene.background = {0.2f, 0.4f, 0.1f};
  return scene;
}

ComparisonSettings settingsFor(const Scene& scene, MarcherPtr marcher) {
  ComparisonSettings settings;
  settings.codec.color = ColorCoding::lossless;
  settings.fetch = fetchHere(std::move(marcher), settings.codec);
  settings.march = scene.march;
  settings.techniques = comparedTechniques(settings.march);
  settings.warp.reference = scene.march.render;
  settings.width = 120;
  settings.height = 90;
  return settings;
}

TEST(Comparison, RowsSayWhatPicturesDrawnAnewSay) {
  const Stage stage(sceneOfTwoViews());
  const Scene& scene = stage.scene();
  const auto marcher = std::make_shared<CountingMarcher>(stage.resources().marcher);
  const ComparisonSettings settings = settingsFor(scene, marcher);
  WarpResources resources = stage.resources();
  resources.marcher = marcher;
  size_t steps = 0;
  std::vector<std::pair<const WarpDescriptor*, size_t>> pictures;
  const Comparison comparison = compareTechniques(
      scene, resources, settings,
      [&](const WarpDescriptor& technique, size_t view, const WarpedImage& image) {
        pictures.emplace_back(&technique, view);
        EXPECT_EQ(image.color.width(), settings.width);
        EXPECT_EQ(image.color.height(), settings.height);
      },
      [&](const std::string&) { ++steps; }, {});

  // One frame; one ground truth a view.
  EXPECT_EQ(marcher->marches, 1);
  EXPECT_EQ(marcher->renders, static_cast<int>(scene.views.size()));
  const size_t techniques = warpRegistry().size();
  ASSERT_EQ(comparison.rows.size(), techniques * scene.views.size());
  EXPECT_EQ(pictures.size(), comparison.rows.size());
  EXPECT_EQ(steps, comparison.rows.size() + 1);
  for (size_t i = 0; i < comparison.rows.size(); ++i) {
    const ComparisonRow& row = comparison.rows[i];
    EXPECT_EQ(row.technique, &warpRegistry()[i % techniques]) << i;
    EXPECT_EQ(row.view, i / techniques) << i;
    EXPECT_EQ(pictures[i], std::pair(row.technique, row.view)) << i;
    EXPECT_EQ(row.draws, row.technique->usesFrame ? settings.draws : 1) << i;
    EXPECT_GT(row.draw.medianMs, 0.0) << i;
    EXPECT_EQ(row.draw.spreadMs > 0.0, row.technique->usesFrame) << i;  // one draw has none
    EXPECT_EQ(row.build.upload, Measured{}) << i;                       // nothing leaves the host
    EXPECT_EQ(row.bytes > 0, row.technique->usesFrame && row.technique->name != "proxy") << i;
    EXPECT_EQ(row.proxyBytes > 0, row.technique->uses.proxy) << i;
    if (row.technique->usesFrame) continue;
    EXPECT_TRUE(std::isinf(row.psnrDb)) << i;
    EXPECT_EQ(row.holeFraction, 0.0) << i;
  }

  ASSERT_EQ(comparison.cameras.size(), scene.views.size());
  const SampleFramePtr frame = stage.frame(stage.camera(settings.width, settings.height), scene.march);
  EXPECT_EQ(comparison.frame->samples, frame->samples);
  EXPECT_EQ(comparison.frame->colors, frame->colors);
  EXPECT_LT(comparison.served.bytes.ofFrame(), frame->sizeBytes());
  for (const std::string_view technique : {"hold", "spheres"}) {
    double holesBefore = -1.0;
    for (size_t view = 0; view < scene.views.size(); ++view) {
      SCOPED_TRACE(std::string(technique) + ", view " + std::to_string(view));
      const Camera camera = makeCamera(scene, scene.views[view], settings.width, settings.height);
      EXPECT_EQ(comparison.cameras[view], camera);
      Image<glm::vec4> reference;
      stage.marcher().render(camera, scene.march.render, reference);
      const WarpedImage image = stage.draw(technique, frame, camera);
      size_t shown = 0, holes = 0;
      for (size_t i = 0; i < reference.size(); ++i) {
        if (!(reference[i].a >= 1.0f / 255.0f)) continue;
        ++shown;
        holes += image.samples[i] == kNoSample;
      }
      const auto row = std::find_if(comparison.rows.begin(), comparison.rows.end(), [&](const ComparisonRow& candidate) {
        return candidate.technique->name == technique && candidate.view == view;
      });
      ASSERT_NE(row, comparison.rows.end());
      EXPECT_DOUBLE_EQ(row->holeFraction, static_cast<double>(holes) / static_cast<double>(shown));
      EXPECT_DOUBLE_EQ(row->psnrDb, psnrSrgb(image.color, reference, scene.background));
      EXPECT_GT(row->holeFraction, holesBefore);
      holesBefore = row->holeFraction;
    }
  }
}

TEST(Comparison, StopsWhenToldTo) {
  const Stage stage(sceneOfTwoViews());
  std::stop_source source;
  size_t pictures = 0;
  EXPECT_THROW(compareTechniques(
                   stage.scene(), stage.resources(), settingsFor(stage.scene(), stage.resources().marcher),
                   [&](const WarpDescriptor&, size_t, const WarpedImage&) {
                     ++pictures;
                     source.request_stop();
                   },
                   [](const std::string&) {}, source.get_token()),
               OperationCancelled);
  EXPECT_LE(pictures, 2u);  // `hold` draws in one go and looks at no token
}

TEST(Comparison, CaptionsAreRelativeToTheFirstView) {
  const View first{30.0, 20.0, 0.8};
  EXPECT_EQ(viewCaption(first, first), "0°");
  EXPECT_EQ(viewCaption({55.0, 20.0, 0.6}, first), "25°, nearer (0.75×)");
  EXPECT_EQ(viewCaption({0.0, 30.0, 0.8}, first), "-30°, +10° up");
  const std::pair<double, std::string> factors[] = {{1.25, "1.25"}, {0.5 / 0.6, "0.83"}, {2.0, "2"},         {1.5, "1.5"},  {100.0, "100"},
                                                    {12.5, "12.5"}, {0.1, "0.1"},        {0.00417, "0.0042"}, {1e6, "1000000"}};
  for (const auto& [factor, text] : factors) EXPECT_EQ(viewCaption({30.0, 20.0, 0.8 * factor}, first), std::string("0°, ") + (factor < 1.0 ? "nearer (" : "farther (") + text + "×)");
}

TEST(Gains, ArePositiveWhereTheFirstIsBetter) {
  Comparison comparison;
  comparison.cameras.resize(2);
  const auto add = [&](std::string_view technique, size_t view, double psnrDb, double flip, double holes) {
    ComparisonRow& row = comparison.rows.emplace_back();
    row.technique = &findWarp(technique);
    row.view = view;
    row.psnrDb = psnrDb;
    row.flip = flip;
    row.holeFraction = holes;
  };
  add("points", 0, 40.0, 0.01, 0.0);
  add("spheres", 0, 35.0, 0.02, 0.0);
  add("points", 1, 20.0, 0.2, 0.25);
  add("spheres", 1, 23.5, 0.125, 0.0625);
  const std::vector<Gain> gains = gainsOf(comparison, "spheres", "points");
  ASSERT_EQ(gains.size(), 2u);
  EXPECT_EQ(gains[0].psnrDb, -5.0);
  EXPECT_EQ(gains[0].flip, -0.01);
  EXPECT_EQ(gains[1].psnrDb, 3.5);
  EXPECT_EQ(gains[1].flip, 0.2 - 0.125);
  EXPECT_EQ(gains[1].holes, 0.1875);
  EXPECT_TRUE(gainsOf(comparison, "splats", "points").empty()) << "it was not compared";
  EXPECT_THROW(gainsOf(comparison, "spheres", "dots"), UsageError);
}

}  // namespace
}  // namespace warpscope
