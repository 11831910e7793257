// A share of what is expected, and a search between what fits and what does not.
// See frame_budget.h.
#include "app/frames/frame_budget.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "render/base/error.h"

namespace warpscope {
namespace {

constexpr int kMostTries = 8;
constexpr double kEnough = 0.9;       // of a budget: more is not searched for
constexpr uint32_t kClosePx = 4;      // sides between which nothing is searched for
constexpr double kUsualPixels = 0x1p18;

double pixelsOf(const Camera& camera) { return std::max(1.0, static_cast<double>(camera.width) * camera.height); }

/// Packed frames of the built-in scenes and two CT scans, of which a half to a third of the pixels show anything, took 0.5 to 2 bytes a pixel without segments, and 0.8 to 2 a segment.
double usualBytes(const Camera& camera, const MarchSettings& settings) {
  const double aPixel = 0.7 + 1.3 * settings.sample.segments;
  return aPixel * kUsualPixels * std::pow(pixelsOf(camera) / kUsualPixels, FrameSizeRule::kExponent);
}

/// The longer side of a frame with `factor` times the bytes of that of `camera`, at most `mostPx`.
uint32_t sideOf(const Camera& camera, double factor, uint32_t mostPx) {
  const double sidePx = longerSide(camera) * std::pow(factor, 0.5 / FrameSizeRule::kExponent);
  return sidePx >= mostPx ? mostPx : std::max(1u, static_cast<uint32_t>(sidePx));
}

}  // namespace

uint32_t longerSide(const Camera& camera) { return std::max(camera.width, camera.height); }

Camera ofLongerSide(const Camera& camera, uint32_t sidePx) {
  const double scale = static_cast<double>(sidePx) / std::max(1u, longerSide(camera));
  Camera scaled = camera;
  scaled.width = std::max(1u, static_cast<uint32_t>(std::lround(camera.width * scale)));
  scaled.height = std::max(1u, static_cast<uint32_t>(std::lround(camera.height * scale)));
  return scaled;
}

double FrameSizeRule::foreseen(const Camera& camera, const MarchSettings& settings) const {
  return usualBytes(camera, settings) * share_;
}

void FrameSizeRule::note(const Camera& camera, const MarchSettings& settings, double tookBytes) {
  share_ = std::max(tookBytes, 1.0) / usualBytes(camera, settings);
}

Camera FrameSizeRule::choose(const Camera& full, const MarchSettings& settings, double budgetBytes) {
  const uint32_t fullPx = longerSide(full);
  Camera chosen = full;
  if (const double share = budgetBytes / foreseen(full, settings); share < 1.0) {
    chosen = ofLongerSide(full, std::max(sideOf(full, kAim * share, fullPx), std::min(kLeastSidePx, fullPx)));
    const Camera before = ofLongerSide(full, std::min(lastPx_, fullPx));
    if (const double takes = foreseen(before, settings); takes <= budgetBytes && takes >= kLeastShare * budgetBytes) chosen = before;
  }
  lastPx_ = longerSide(chosen);
  return chosen;
}

Camera FrameSizeRule::grown(const Camera& camera, const Camera& full, double factor) {
  return ofLongerSide(full, std::max(sideOf(camera, factor, longerSide(full)), std::min(longerSide(camera) + 1, longerSide(full))));
}

FrameFetch withinBudget(FrameFetch fetch, uint64_t budgetBytes) {
  return [fetch = std::move(fetch), budgetBytes](const Camera& full, const MarchSettings& settings, const std::stop_token& stop) {
    const auto budget = static_cast<double>(budgetBytes);
    const uint32_t leastPx = std::min(FrameSizeRule::kLeastSidePx, longerSide(full));
    std::optional<ServedFrame> fits;
    uint32_t fittingPx = leastPx - 1, tooLargePx = longerSide(full) + 1;  // sides between which the largest lies that fits
    size_t proxyBytes = 0;                                                // came with the first
    uint32_t sidePx = longerSide(FrameSizeRule().choose(full, settings, budget));
    for (int tries = 0; tries < kMostTries || !fits; ++tries) {
      const Camera camera = ofLongerSide(full, sidePx);
      ServedFrame served = fetch(camera, settings, stop);
      const size_t took = served.bytes.ofFrame();
      proxyBytes = std::max(proxyBytes, served.bytes.proxy);
      if (took <= budgetBytes) {
        fits = std::move(served);
        fittingPx = sidePx;
      } else {
        if (sidePx == leastPx)
          throw InputError("a frame of " + std::to_string(camera.width) + "x" + std::to_string(camera.height) + " pixels, the smallest that is tried, takes " + std::to_string(took) +
                           " bytes, and no more than " + std::to_string(budgetBytes) + " are allowed: allow more, or ask for fewer segments or samples");
        tooLargePx = sidePx;
      }
      const bool isEnough = fits && (static_cast<double>(fits->bytes.ofFrame()) >= kEnough * budget || tooLargePx - fittingPx <= kClosePx);
      if (isEnough) break;
      const uint32_t nextPx = sideOf(camera, FrameSizeRule::kAim * budget / static_cast<double>(std::max<size_t>(took, 1)), longerSide(full));
      // Where what is foreseen leads nowhere new, the middle does.
      sidePx = nextPx > fittingPx && nextPx < tooLargePx ? nextPx : (fittingPx + tooLargePx) / 2;
    }
    fits->bytes.proxy = proxyBytes;
    return std::move(*fits);
  };
}

}  // namespace warpscope
