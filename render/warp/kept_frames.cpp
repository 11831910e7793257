// Which frames stay, and what they add.
// See kept_frames.h.
#include "render/warp/kept_frames.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "render/base/error.h"
#include "render/core/parallel.h"

namespace warpscope {

constinit const Knob kKeepKnob{
    .key = "keep",
    .option = "--keep",
    .label = "Keep",
    .noun = "number of frames kept",
    .help = "How many of the last frames are drawn from, the newest first, each from another side than those before",
    .unit = " frames",
    .type = KnobType::whole,
    .stale = KnobStage::build,
    .isOfPanel = true,
    .range = {1.0, kMostKept},
    .track = {1.0, kMostKept},
    .defaultValue = 1.0,
    .axis = {"keeps", "--keeps", "How many of the last frames are drawn from; the camera came turning from smaller angles"},
    .phrase = ", {} frames kept",
    .naming = KnobNaming::unlessDefault,
};

double apartDeg(const Camera& a, const Camera& b, const Box& bounds) {
  const glm::dvec3 center = bounds.center();
  const glm::dvec3 toA = glm::dvec3(a.eye) - center, toB = glm::dvec3(b.eye) - center;
  const double farA = glm::length(toA), farB = glm::length(toB);
  constexpr double kDegrees = 57.29577951308232;
  if (!(farA > 0.0) || !(farB > 0.0)) return farA == farB ? 0.0 : 180.0;
  const double angle = std::atan2(glm::length(glm::cross(toA, toB)), glm::dot(toA, toB));
  return kDegrees * std::max(angle, std::abs(std::log(farA / farB)));
}

bool KeptFrames::fit(const SampleFrame& frame, const SampleFrame& newest) {
  return frame.settings == newest.settings && frame.functionVersion == newest.functionVersion && frame.quantization.bounds == newest.quantization.bounds && frame.proxy == newest.proxy;
}

std::unique_ptr<Warp> KeptFrames::take(SampleFramePtr frame, std::unique_ptr<Warp> warp, const SampleFrame& newest, size_t most) {
  std::erase_if(kept_, [&](const Kept& one) { return !fit(*one.frame, newest); });
  if (!fit(*frame, newest) || most == 0) {
    limitTo(most);
    return warp;
  }
  const bool isFar = kept_.empty() || apartDeg(kept_.front().frame->camera, frame->camera, newest.quantization.bounds) >= kKeptApartDeg;
  if (!isFar) {
    limitTo(most);
    return warp;
  }
  kept_.push_front({std::move(frame), std::move(warp)});
  if (kept_.size() <= most) return nullptr;
  std::unique_ptr<Warp> free = std::move(kept_.back().warp);
  limitTo(most);
  return free;
}

void KeptFrames::limitTo(size_t most) {
  while (kept_.size() > most) kept_.pop_back();
}

void KeptFrames::rebuild(const WarpSettings& settings, const std::stop_token& stop) {
  for (Kept& one : kept_) one.warp->setFrame(one.frame, settings, stop);
}

void KeptFrames::complete(const Camera& camera, const WarpSettings& settings, WarpedImage& image, const std::stop_token& stop) {
  const auto isOpen = [&](size_t i) { return image.samples[i] == kNoSample || image.samples[i] == kFilled; };
  uint32_t id = kOfEarlierFrame;
  for (Kept& one : kept_) {
    bool hasOpen = false;
    for (size_t i = 0; i < image.samples.size() && !hasOpen; ++i) hasOpen = isOpen(i);
    if (!hasOpen) return;
    one.warp->draw(camera, settings, image_, stop);
    parallelForRanges(image.samples.size(), 1 << 15, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        if (!isOpen(i) || image_.samples[i] == kNoSample || image_.samples[i] == kFilled) continue;
        image.color[i] = image_.color[i];
        image.samples[i] = id;
      }
    });
    ++id;
  }
}

}  // namespace warpscope
