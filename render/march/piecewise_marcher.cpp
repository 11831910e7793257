// Tiles' rays in their places.
// See piecewise_marcher.h.
#include "render/march/piecewise_marcher.h"

#include <algorithm>
#include <chrono>

#include "render/base/error.h"
#include "render/base/stopwatch.h"
#include "render/march/compact.h"
#include "render/march/frame_normals.h"
#include "render/march/ray_relay.h"

namespace warpscope {
namespace {

/// Calls `take(i, pixel)` with each of the rays and its place in the picture.
template <class Take>
void forEachFinished(const PieceOutcome& outcome, uint32_t width, const Take& take) {
  const PixelArea& area = outcome.area;
  for (size_t i = 0; i < outcome.finished.size(); ++i) {
    const uint32_t place = outcome.finished[i];
    take(i, size_t{area.y + place / area.width} * width + area.x + place % area.width);
  }
}

}  // namespace

SampleFrame PiecewiseMarcher::march(const Camera& camera, const MarchSettings& settings, const std::stop_token& stop) {
  const std::scoped_lock lock(mutex_);
  requireMarchable(*volume(), camera, settings);
  requirePieces(settings.render);
  const SampleRule rule = sampleRuleFor(*volume(), camera, settings.sample);
  SampleFrame frame = emptyFrame(*volume(), camera, settings, rule);
  const auto marchStart = std::chrono::steady_clock::now();
  dense_.resize(size_t{camera.width} * camera.height, settings.sample, wantsNormals(*marched_, camera, settings.render, *plan(settings.render, settings.sample)));
  std::ranges::fill(dense_.samples, PackedSample{0});
  std::ranges::fill(dense_.segments.rays, RaySegmentCount{});
  marchTiles(camera, settings.render, settings.sample, stop, [&](const PieceOutcome& outcome) {
    forEachFinished(outcome, camera.width, [&](size_t i, size_t pixel) { dense_.take(pixel, outcome.found, i); });
  });
  frame.timings.marchMs = millisecondsSince(marchStart);

  const auto compactStart = std::chrono::steady_clock::now();
  compact(dense_.samples, dense_.colors, dense_.spreads, dense_.slots, frame);
  if (dense_.segments.slots > 0) compact(dense_.segments, frame.segments);
  if (settings.sample.proxy > 0) frame.proxy = proxyFor(settings.sample.proxy, stop);
  frame.timings.compactMs = millisecondsSince(compactStart);
  return frame;
}

void PiecewiseMarcher::render(const Camera& camera, const RenderSettings& settings, Image<glm::vec4>& image, const std::stop_token& stop) {
  const std::scoped_lock lock(mutex_);
  requireMarchable(*volume(), camera, settings);
  requirePieces(settings);
  image.resize(camera.width, camera.height);
  std::fill_n(image.data(), size_t{camera.width} * camera.height, glm::vec4(0.0f));
  marchTiles(camera, settings, std::nullopt, stop, [&](const PieceOutcome& outcome) {
    forEachFinished(outcome, camera.width, [&](size_t i, size_t pixel) { image.data()[pixel] = outcome.colors[i]; });
  });
}

std::optional<EffectPlan> PiecewiseMarcher::plan(const RenderSettings& settings, const std::optional<SampleSettings>& sample) const {
  return planFor(*marched_, settings, sample);
}

void PiecewiseMarcher::requirePieces(const RenderSettings& settings) const {
  if (const std::string reason = whyNotInPieces(settings); !reason.empty()) throw UsageError(reason + ", and " + std::string(whyPieces_));
}

}  // namespace warpscope
