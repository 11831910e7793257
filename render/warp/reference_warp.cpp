// Marching instead of warping.
// See reference_warp.h.
#include "render/warp/reference_warp.h"

#include "render/warp/arithmetic_knob.h"

namespace warpscope {
namespace {

class ReferenceWarp final : public Warp {
 public:
  explicit ReferenceWarp(MarcherPtr marcher) : marcher_(std::move(marcher)) {}

  void setFrame(SampleFramePtr, const WarpSettings&, const std::stop_token&) override {}

  void draw(const Camera& camera, const WarpSettings& settings, WarpedImage& image,
            const std::stop_token& stop) override {
    RenderSettings wanted = settings.reference;
    wanted.arithmetic = settings.knobs.choice<Arithmetic>(kArithmeticKnob);
    marcher_->render(camera, wanted, image.color, stop);
    image.samples.resize(camera.width, camera.height, kNotASample);
  }

 private:
  MarcherPtr marcher_;
};

std::unique_ptr<Warp> makeReferenceWarp(const WarpResources& resources) {
  return std::make_unique<ReferenceWarp>(resources.marcher);
}

constexpr const Knob* kReferenceKnobs[] = {&kArithmeticKnob};

}  // namespace

constinit const WarpDescriptor kReferenceWarp{
    .name = "reference",
    .label = "Ground truth",
    .summary = "the volume marched at the current camera: the ground truth",
    .usesFrame = false,
    .knobs = kReferenceKnobs,
    .make = makeReferenceWarp,
};

}  // namespace warpscope
