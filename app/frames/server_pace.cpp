// A mean of logarithms, and when it is heeded.
// See server_pace.h.
#include "app/frames/server_pace.h"

#include <algorithm>
#include <cmath>

#include "app/frames/coarsening.h"

namespace warpscope {
namespace {

constexpr double kShareOfNewest = 0.5;
constexpr double kLeastMs = 1e-3;  // below what clocks tell apart

double pixelsOf(const Camera& camera) { return static_cast<double>(camera.width) * camera.height; }

}  // namespace

void CoarseningRule::note(double pixels, double step, double tookMs) {
  const double logCost = std::log(std::max(tookMs, kLeastMs) * step / std::max(pixels, 1.0));
  logCost_ = logCost_ ? *logCost_ + kShareOfNewest * (logCost - *logCost_) : logCost;
}

double CoarseningRule::factorFor(double pixels, double step, double targetMs) {
  if (!logCost_) return 1.0;
  const double factor = std::clamp(std::exp(*logCost_) * pixels / (targetMs * step), 1.0, kMostCoarsening);
  const bool isEnd = factor == 1.0 || factor == kMostCoarsening;
  const bool isClose = factor < last_ * kTolerance && factor * kTolerance > last_;
  if (isEnd || !isClose) last_ = factor;
  return last_;
}

MarchSettings ServerPace::settingsFor(const Camera& camera, const MarchSettings& asked, double targetMs, Clock::TimePoint arrivedAt) {
  const bool isMoving = last_ && *last_ != camera && arrivedAt - answeredAt_ <= kMovingFor;
  return isMoving ? coarsened(asked, rule_.factorFor(pixelsOf(camera), asked.render.step, targetMs)) : asked;
}

void ServerPace::note(const Camera& camera, const MarchSettings& marched, double tookMs, Clock::TimePoint answeredAt) {
  rule_.note(pixelsOf(camera), marched.render.step, tookMs);
  last_ = camera;
  answeredAt_ = answeredAt;
}

}  // namespace warpscope
