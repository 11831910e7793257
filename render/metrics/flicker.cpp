// Differences of planes, then FLIP.
// See flicker.h.
#include "render/metrics/flicker.h"

#include <utility>

#include "render/base/error.h"
#include "render/core/parallel.h"

namespace warpscope {
namespace {

/// 0.5 + 0.5 * (after - before) of displayed values, as linear ones.
ColorPlanes changeOf(const ColorPlanes& before, const ColorPlanes& after) {
  ColorPlanes change;
  for (size_t channel = 0; channel < 3; ++channel) {
    const Image<float>&from = before[channel], &to = after[channel];
    Image<float>& out = change[channel];
    out.reshape(from.width(), from.height());
    parallelForRanges(out.size(), 1 << 14, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) out[i] = 0.5f + 0.5f * (to[i] - from[i]);
    });
  }
  linearize(change);
  return change;
}

}  // namespace

FlickerMeter::FlickerMeter(const glm::vec3& background, float pixelsPerDegree) : background_(background), pixelsPerDegree_(pixelsPerDegree) {
  requireFlipResolution(pixelsPerDegree);
}

void FlickerMeter::add(const Image<glm::vec4>& picture, const Image<glm::vec4>& reference) {
  requireOneSize(picture, reference, "flicker");
  const bool isFirst = picture_[0].empty();
  if (!isFirst && (picture.width() != picture_[0].width() || picture.height() != picture_[0].height()))
    throw InputError("flicker needs pictures of one size along the whole path");
  ColorPlanes shown = srgbPlanes(picture, background_, "flicker"), truth = srgbPlanes(reference, background_, "flicker");
  if (!isFirst) {
    const FlipReference expected(changeOf(reference_, truth), pixelsPerDegree_);
    sum_ += expected.difference(changeOf(picture_, shown), map_);
    ++steps_;
  }
  picture_ = std::move(shown);
  reference_ = std::move(truth);
}

std::optional<double> FlickerMeter::mean() const {
  if (steps_ == 0) return std::nullopt;
  return sum_ / static_cast<double>(steps_);
}

}  // namespace warpscope
