// What the picture is, is the same for everybody: with every render knob turned, the technique `reference`, the live ground truth, a sweep's and a
// comparison's take all of RenderSettings, also what somebody adds to it.
// Mirrors RenderSettings of render/march/march_settings.h.
#include <mutex>

#include "app/commands/options.h"
#include "app/experiment/comparison.h"
#include "app/experiment/sweep.h"
#include "app/picture/picture.h"
#include "tests/headless.h"
#include "tests/session_fixture.h"

namespace warpscope {
namespace {

/// The settings of every picture that was marched, by whichever twin.
struct Log {
  std::mutex mutex;
  std::vector<RenderSettings> settings;

  void add(const RenderSettings& one) {
    const std::scoped_lock lock(mutex);
    settings.push_back(one);
  }
  std::vector<RenderSettings> take() {
    const std::scoped_lock lock(mutex);
    return std::exchange(settings, {});
  }
};

class LoggingMarcher final : public Marcher {
 public:
  LoggingMarcher(MarcherPtr marcher, std::shared_ptr<Log> log) : marcher_(std::move(marcher)), log_(std::move(log)) {}
  SampleFrame march(const Camera& camera, const MarchSettings& settings, const std::stop_token& stop) override {
    log_->add(settings.render);
    return marcher_->march(camera, settings, stop);
  }
  void render(const Camera& camera, const RenderSettings& settings, Image<glm::vec4>& image, const std::stop_token& stop) override {
    log_->add(settings);
    marcher_->render(camera, settings, image, stop);
  }
  const VolumePtr& volume() const override { return marcher_->volume(); }
  Backend backend() const override { return marcher_->backend(); }
  MarcherCapabilities capabilities() const override { return marcher_->capabilities(); }
  using Marcher::twin;
  MarcherPtr twin(TurnsPtr turns) const override { return std::make_shared<LoggingMarcher>(marcher_->twin(std::move(turns)), log_); }
  MarcherPtr withTransferFunction(TransferFunction function) const override {
    return std::make_shared<LoggingMarcher>(marcher_->withTransferFunction(std::move(function)), log_);
  }

 private:
  const MarcherPtr marcher_;
  const std::shared_ptr<Log> log_;
};

/// Another value than the default that the knob can have, and a march can be done with.
double otherValue(const Knob& knob) {
  if (knob.type == KnobType::flag) return 1.0 - knob.defaultValue;
  if (knob.type == KnobType::choice) return knob.defaultValue == 0.0 ? 1.0 : 0.0;
  return knob.defaultValue == 0.0 ? knob.range.highest : std::min(knob.range.highest, 3.0 * knob.defaultValue);
}

/// But for the mode: in others some of them do not matter, and are nobody's to keep.
bool isOfPicture(const MarchKnob& row) { return (row.knob->owner == KnobOwner::rendering || row.knob->owner == KnobOwner::effect) && row.knob->key != "mode"; }

/// Every render knob turned.
MarchSettings turned() {
  MarchSettings settings;
  for (const MarchKnob& row : marchKnobs())
    if (isOfPicture(row)) row.set(settings, otherValue(*row.knob));
  settings.render.effects.lights = parseLights("camera:1,2,3@0.5 world:1,0,0", "it");
  settings.render.effects.clip.slab = {.thickness = 20.0f, .depth = 1.0f};
  settings.render.effects.clip.planes = parseClipPlanes("1,1,0,-3", "it");
  settings.render.effects.clip.box = parseClipBox("0,0,0.1,1,0.95,1", "it");
  return settings;
}

class RenderSettingsTest : public SessionTest {
 protected:
  RenderSettingsTest() : scene_(smallScene("shells", 24)) {
    scene_.march = turned();
    marcher_ = std::make_shared<LoggingMarcher>(makeMarcher(Backend::cpu, scene_.volume, scene_.transferFunction), log_);
    resources_.marcher = marcher_;
  }

  Image<glm::vec4> truth(const Camera& camera, const RenderSettings& settings) const {
    Image<glm::vec4> image;
    makeMarcher(Backend::cpu, scene_.volume, scene_.transferFunction)->render(camera, settings, image);
    return image;
  }
  Camera camera(uint32_t width, uint32_t height) const { return makeCamera(scene_, scene_.views.front(), width, height); }

  /// At least one picture was marched, and each with all of the scene's settings.
  void expectWhole(const char* who) {
    const std::vector<RenderSettings> seen = log_->take();
    EXPECT_FALSE(seen.empty()) << who;
    for (const RenderSettings& settings : seen) EXPECT_EQ(settings, scene_.march.render) << who;
  }

  const std::shared_ptr<Log> log_ = std::make_shared<Log>();
  Scene scene_;
  MarcherPtr marcher_;
  WarpResources resources_;
};

TEST_F(RenderSettingsTest, EveryKnobIsTurnedAndThePictureIsAnother) {
  for (const MarchKnob& row : marchKnobs())
    if (isOfPicture(row)) EXPECT_NE(row.get(scene_.march), row.knob->defaultValue) << row.knob->key;
  EXPECT_NE(truth(camera(48, 40), scene_.march.render), truth(camera(48, 40), {}));
}

TEST_F(RenderSettingsTest, OfTheTechniqueReference) {
  WarpSettings settings;
  settings.reference = scene_.march.render;
  const std::unique_ptr<Warp> reference = makeWarp(findWarp("reference"), resources_);
  WarpedImage image;
  reference->draw(camera(48, 40), settings, image);
  EXPECT_EQ(image.color, truth(camera(48, 40), scene_.march.render));
  expectWhole("reference");
}

TEST_F(RenderSettingsTest, OfAComparison) {
  scene_.views.resize(1);
  ComparisonSettings settings;
  settings.codec.color = ColorCoding::lossless;
  settings.fetch = fetchHere(marcher_, settings.codec);
  settings.march = scene_.march;
  settings.techniques = {&findWarp("reference")};
  settings.warp.reference = scene_.march.render;
  settings.width = 48;
  settings.height = 40;
  settings.draws = 1;
  HeadlessResources headless(marcher_, gl::Platform::automatic, Backend::cpu);
  Image<glm::vec4> shown;
  compareTechniques(
      scene_, headless.resources(), settings,
      [&](const WarpDescriptor& technique, size_t, const WarpedImage& image) {
        if (technique.name == "reference") shown = image.color;
      },
      [](const std::string&) {}, {});
  EXPECT_EQ(shown, truth(camera(48, 40), scene_.march.render));
  expectWhole("compare");
}

TEST_F(RenderSettingsTest, OfASweep) {
  SweepSettings settings;
  settings.plan = quickPlan(scene_.march, 48, 40, 0.0);
  settings.plan.techniques = {&findWarp("reference"), &findWarp("hold")};
  settings.width = 48;
  settings.height = 40;
  settings.warp.reference = scene_.march.render;
  Sweep sweep(scene_, resources_, settings, {});
  for (const Configuration& configuration : configurationsOf(settings.plan)) {
    if (configuration.technique->usesFrame) continue;
    const std::vector<SweepPicture> pictures = sweep.pictures(configuration);
    ASSERT_EQ(pictures.size(), 1u);
    EXPECT_EQ(pictures[0].image.color, truth(camera(48, 40), scene_.march.render));
    EXPECT_EQ(pictures[0].flip, 0.0);  // against the sweep's ground truth
  }
  expectWhole("a sweep");
}

TEST_F(RenderSettingsTest, OfTheLiveGroundTruth) {
  session_.load({"shells", [this](const std::function<void()>& onNews, const std::stop_token& stop) {
                   return hostScene(io_, scene_, marcher_, {}, onNews, stop);
                 }});
  session_.setTechnique(0, findWarp("reference"));
  ASSERT_TRUE(settle());
  const glm::uvec2 size = session_.pictureSize();
  const WarpedImage expected{truth(makeCamera(scene_, session_.view(), size.x, size.y), scene_.march.render),
                             Image<uint32_t>(size.x, size.y, kNotASample)};
  ASSERT_NE(session_.panel(0).picture.host, nullptr);
  EXPECT_EQ(*session_.panel(0).picture.host, toScreen(expected, scene_.background));
  EXPECT_EQ(session_.panel(0).errors->flip, 0.0);  // against the live ground truth
  expectWhole("the window");
}

}  // namespace
}  // namespace warpscope
