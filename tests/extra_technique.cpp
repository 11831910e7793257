// Another technique's file, as it would lie in render/warp/.
// See extra_technique.h.
#include "tests/extra_technique.h"

#include "render/core/parallel.h"

namespace warpscope {
namespace {

enum class Tint { none, red };

constexpr std::array<NamedValue<Tint>, 2> kTints{{
    {Tint::none, "none", "colours as they are"},
    {Tint::red, "red", "red alone"},
}};
constexpr auto kTintChoices = choicesOf(kTints);
constexpr double kSweptDensities[] = {0.25, 0.5};

constexpr Knob kDensityKnob{
    .key = "fogDensity",
    .option = "--fog-density",
    .label = "Fog",
    .noun = "fog density",
    .help = "Share of the light that the fog swallows (Beer 1852)",
    .range = {0.0, 1.0},
    .track = {0.0, 1.0},
    .defaultValue = 0.25,
    .axis = {"fogDensities", "--fog-densities", "Shares of the light that the fog swallows", kSweptDensities},
    .phrase = " of density {}",
};

constexpr Knob kTintKnob{
    .key = "fogTint",
    .option = "--fog-tint",
    .label = "Fog's tint",
    .noun = "fog tint",
    .help = "What colours are left",
    .type = KnobType::choice,
    .choices = kTintChoices,
    .axis = {"fogTints", "--fog-tints", "Tints of the fog, by name"},
    .phrase = ", {}",
    .naming = KnobNaming::unlessDefault,
};

class FogWarp final : public Warp {
 public:
  explicit FogWarp(const WarpResources& resources) : held_(makeWarp(findWarp("hold"), resources)) {}

  void setFrame(SampleFramePtr frame, const WarpSettings& settings, const std::stop_token& stop) override {
    held_->setFrame(std::move(frame), settings, stop);
  }

  void draw(const Camera& camera, const WarpSettings& settings, WarpedImage& image, const std::stop_token& stop) override {
    held_->draw(camera, settings, image, stop);
    const float left = 1.0f - settings.knobs.number(kDensityKnob);
    const bool isRed = settings.knobs.choice<Tint>(kTintKnob) == Tint::red;
    for (size_t i = 0; i < image.color.size(); ++i)
      image.color[i] = isRed ? glm::vec4(left * image.color[i].r, 0.0f, 0.0f, image.color[i].a)
                             : glm::vec4(left * glm::vec3(image.color[i]), image.color[i].a);
  }

 private:
  const std::unique_ptr<Warp> held_;
};

std::unique_ptr<Warp> makeFogWarp(const WarpResources& resources) { return std::make_unique<FogWarp>(resources); }

constexpr const Knob* kKnobs[] = {&kDensityKnob, &kTintKnob};

constexpr WarpDescriptor kFogWarp{
    .name = "fog",
    .label = "Fog",
    .summary = "the last image in fog: a technique of a test's",
    .knobs = kKnobs,
    .make = makeFogWarp,
};

}  // namespace

const WarpDescriptor& extraTechnique() { return kFogWarp; }

}  // namespace warpscope
