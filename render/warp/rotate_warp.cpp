// The own picture, kept, and turned for each camera.
// See rotate_warp.h.
#include "render/warp/rotate_warp.h"

#include "render/warp/rotated_picture.h"

namespace warpscope {
namespace {

constexpr std::array<NamedValue<PicturePlane>, 2> kPlanes{{
    {PicturePlane::middle, "middle", "through the middle of the volume: it stays where it is"},
    {PicturePlane::infinity, "infinity", "as far away as can be: right where the camera is only turned"},
}};
constexpr auto kPlaneChoices = choicesOf(kPlanes);
constexpr double kSwept[] = {static_cast<double>(PicturePlane::middle)};

class RotateWarp final : public Warp {
 public:
  void setFrame(SampleFramePtr frame, const WarpSettings&, const std::stop_token&) override {
    frame_ = nullptr;
    if (frame) own_ = ownImageOf(*frame);
    frame_ = std::move(frame);
  }

  void draw(const Camera& camera, const WarpSettings& settings, WarpedImage& image, const std::stop_token& stop) override {
    requireUsable(camera);
    if (!frame_) {
      image.samples.resize(camera.width, camera.height, kNoSample);
      image.color.resize(camera.width, camera.height);
      return;
    }
    drawRotated(own_, frame_->camera, camera, image, stop, nearnessFor(settings));
  }

 private:
  /// Of a plane behind the eye there is no picture.
  double nearnessFor(const WarpSettings& settings) const {
    if (settings.knobs.choice<PicturePlane>(kPicturePlaneKnob) == PicturePlane::infinity) return 0.0;
    const Camera& camera = frame_->camera;
    const double depth = glm::dot(glm::dvec3(frame_->quantization.bounds.center()) - glm::dvec3(camera.eye), glm::dvec3(camera.forward));
    return depth > 0.0 ? 1.0 / depth : 0.0;
  }

  SampleFramePtr frame_;
  WarpedImage own_;
};

std::unique_ptr<Warp> makeRotateWarp(const WarpResources&) { return std::make_unique<RotateWarp>(); }

constexpr const Knob* kRotateKnobs[] = {&kPicturePlaneKnob};

}  // namespace

constinit const Knob kPicturePlaneKnob{
    .key = "picturePlane",
    .option = "--picture-plane",
    .label = "Plane",
    .noun = "plane of the picture",
    .help = "On which plane a picture without depths is taken to lie",
    .type = KnobType::choice,
    .defaultValue = static_cast<double>(PicturePlane::middle),
    .choices = kPlaneChoices,
    .axis = {"picturePlanes", "--picture-planes", "Planes of pictures, by name", kSwept},
    .phrase = ", plane at {}",
    .naming = KnobNaming::unlessDefault,
};

constinit const WarpDescriptor kRotateWarp{
    .name = "rotate",
    .label = "Rotate",
    .summary = "the last image on a plane, seen from where the camera is now: time warp, without depth",
    .knobs = kRotateKnobs,
    .make = makeRotateWarp,
};

}  // namespace warpscope
