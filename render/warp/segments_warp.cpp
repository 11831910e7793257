// A walk for each pixel, in tiles on all cores.
// See segments_warp.h.
#include "render/warp/segments_warp.h"

#include "render/warp/fill.h"
#include "render/warp/proxy_fill.h"
#include "render/warp/segments/packet_walk.h"
#include "render/warp/segments/pixel_packets.h"
#include "render/warp/segments/segment_field_build.h"
#include "render/warp/segments_warp_cuda.h"

namespace warpscope {
namespace {

constexpr std::array<NamedValue<Between>, 3> kBetweens{{
    {Between::nearest, "nearest", "what the nearest pixel has"},
    {Between::linear, "linear", "what the four pixels about it have, blended"},
    {Between::refined, "refined", "the same; where these disagree the copy of the volume, if that has all voxels as they are"},
}};
constexpr auto kBetweenChoices = choicesOf(kBetweens);

}  // namespace

constinit const Knob kBetweenKnob{.key = "between",
                                  .option = "--between",
                                  .label = "Interpolation",
                                  .noun = "filling between rays",
                                  .help = "What lies between the rays of a frame's pixels",
                                  .type = KnobType::choice,
                                  .isOfPanel = true,
                                  .defaultValue = static_cast<double>(Between::refined),
                                  .choices = kBetweenChoices,
                                  .axis = {"betweens", "--betweens", "What lies between pixels' rays, by name"},
                                  .phrase = ", {}",
                                  .naming = KnobNaming::unlessDefault};

bool isFilledFromCopy(const SampleFrame& frame, const KnobValues& knobs) {
  return frame.proxy && goesOnThroughProxy(kSegmentsWarp, frame.settings.render.effects.mode) && fillOf(kSegmentsWarp, knobs) == Fill::proxy;
}

Between betweenOf(const SampleFrame& frame, const Camera& camera, const KnobValues& knobs) {
  const Between wanted = knobs.choice<Between>(kBetweenKnob);
  if (wanted != Between::refined) return wanted;
  return camera != frame.camera && isFilledFromCopy(frame, knobs) && showsTheVolume(*frame.proxy, frame.settings.render) ? Between::refined : Between::linear;
}

namespace {

class SegmentsWarp final : public Warp {
 public:
  void setFrame(SampleFramePtr frame, const WarpSettings&, const std::stop_token&) override {
    frame_ = nullptr;  // in case that building fails
    if (frame) built_.build(*frame);
    frame_ = std::move(frame);
  }

  void draw(const Camera& camera, const WarpSettings& settings, WarpedImage& image, const std::stop_token& stop) override {
    requireUsable(camera);
    image.samples.resize(camera.width, camera.height, kNoSample);
    image.color.resize(camera.width, camera.height);
    if (!frame_ || frame_->segments.empty()) return;
    built_.relight(*frame_, camera);
    visitBetween(betweenOf(*frame_, camera, settings.knobs), [&](auto between) { drawRays<between()>(camera, settings, image, stop); });
  }

 private:
  template <Between kBetween>
  void drawRays(const Camera& camera, const WarpSettings& settings, WarpedImage& image, const std::stop_token& stop) {
    const SegmentField field = built_.field();
    const float stopBelow = limitsOf(frame_->settings.render).stopBelow;
    const auto walkRays = [&](const auto& fillFor) {
      forEachPixelPacket(
          *frame_, camera, stop, [&](const RayPacket& rays, auto& walked) { walkPacket<kBetween>(field, rays, stopBelow, walked, fillFor(rays)); },
          [&](uint32_t x, uint32_t y, const WalkedRay& walked) {
            image.color(x, y) = walked.seen();
            image.samples(x, y) = walked.id();
          });
    };
    if (!isFilledFromCopy(*frame_, settings.knobs)) return walkRays([](const RayPacket& /*rays*/) { return nullptr; });
    fill_.visit(frame_->proxy, frame_->settings.render, camera, [&](const auto& march, const auto& /*baked*/) {
      walkRays([&](const RayPacket& rays) {
        return [&](int lane, WalkedRay& walked, float tNear, float tFar, FillReason reason) { walked.fill(march(rays.ray(lane), tNear, tFar, walked.through), reason); };
      });
    });
  }

  SampleFramePtr frame_;
  BuiltSegmentField built_;
  ProxyFill fill_;
};

std::unique_ptr<Warp> makeSegmentsWarp(const WarpResources& resources) {
  if (resources.backend == Backend::cuda) return makeCudaSegmentsWarp();
  return std::make_unique<SegmentsWarp>();
}

constexpr const Knob* kSegmentsKnobs[] = {&kBetweenKnob};

}  // namespace

constinit const WarpDescriptor kSegmentsWarp{
    .name = "segments",
    .label = "Segments",
    .summary = "stretches of each ray instead of one point, met again by the rays of the new camera",
    .runsOnCuda = true,
    .uses = {.segments = true, .proxy = true},
    .knobs = kSegmentsKnobs,
    .make = makeSegmentsWarp,
};

}  // namespace warpscope
