// A mean of logarithms, and when it is heeded.
// See server_pace.h.
#include "app/frames/server_pace.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace warpscope {
namespace {

constexpr double kShareOfNewest = 0.5;
constexpr double kLeastMs = 1e-3;  // below what clocks tell apart
constexpr double kShareAfterRest = 0.85;  // of what marches took that were not tried since: some rests later they are again

double pixelsOf(const Camera& camera) { return static_cast<double>(camera.width) * camera.height; }

}  // namespace

void CoarseningRule::note(double pixels, double step, double tookMs) {
  const double logCost = std::log(std::max(tookMs, kLeastMs) * step / std::max(pixels, 1.0));
  logCost_ = logCost_ ? *logCost_ + kShareOfNewest * (logCost - *logCost_) : logCost;
}

void CoarseningRule::scale(double factor) {
  if (logCost_) *logCost_ += std::log(factor);
}

std::optional<double> CoarseningRule::needFor(double pixels, double step, double targetMs) const {
  if (!logCost_) return std::nullopt;
  return std::exp(*logCost_) * pixels / (targetMs * step);
}

double CoarseningRule::factorFor(double pixels, double step, double targetMs) {
  const double factor = std::clamp(needFor(pixels, step, targetMs).value_or(1.0), 1.0, kMostCoarsening);
  if (!logCost_) return factor;
  const bool isEnd = factor == 1.0 || factor == kMostCoarsening;
  const bool isClose = factor < last_ * kTolerance && factor * kTolerance > last_;
  if (isEnd || !isClose) last_ = factor;
  return last_;
}

void LeavingOutRule::follow(MarchSettings asked) {
  asked.sample.proxy = 0;  // made once: a connection's first request asks for it, and those behind it do not
  if (!groups_.empty() && asked == asked_) return;
  asked_ = asked;
  groups_.assign(static_cast<size_t>(mostLeftOut(asked)) + 1, {});
  fullMs_.reset();
  leftOut_ = 0;
}

Coarsening LeavingOutRule::choose(double pixels, const MarchSettings& asked, double targetMs) {
  follow(asked);
  const double step = asked.render.step;
  const auto groups = [&]() -> OfGroups& { return groups_[static_cast<size_t>(leftOut_)]; };
  const auto isTooMuch = [&] { return groups().rule.needFor(pixels, step, targetMs).value_or(0.0) > kMostCoarsening * CoarseningRule::kTolerance; };
  while (static_cast<size_t>(leftOut_) + 1 < groups_.size() && groups().isKnownMoving && isTooMuch()) ++leftOut_;
  // Of what nobody knows yet: as coarse as what takes longer.
  const bool isGuess = leftOut_ > 0 && !groups().isKnownMoving;
  return {isGuess ? kMostCoarsening : groups().rule.factorFor(pixels, step, targetMs), leftOut_};
}

void LeavingOutRule::noteMoving(double pixels, const MarchSettings& asked, const Coarsening& coarsening, double tookMs) {
  follow(asked);
  OfGroups& groups = groups_.at(static_cast<size_t>(coarsening.leftOut));
  groups.rule.note(pixels, double{asked.render.step} * coarsening.factor, tookMs);
  groups.isKnownMoving = groups.isFresh = true;
}

void LeavingOutRule::noteAtRest(double pixels, const MarchSettings& asked, double tookMs) {
  follow(asked);
  leftOut_ = 0;
  if (!groups_.front().isKnownMoving) groups_.front().rule.note(pixels, asked.render.step, tookMs);
  const double fullMs = std::max(tookMs, kLeastMs) / std::max(pixels, 1.0);
  for (OfGroups& groups : groups_) {
    if (!groups.isKnownMoving) continue;
    if (fullMs_) groups.rule.scale(fullMs / *fullMs_);
    if (!std::exchange(groups.isFresh, false)) groups.rule.scale(kShareAfterRest);
  }
  fullMs_ = fullMs;
}

MarchSettings ServerPace::settingsFor(const Camera& camera, const MarchSettings& asked, double targetMs, Clock::TimePoint arrivedAt) {
  isMoving_ = last_ && *last_ != camera && arrivedAt - answeredAt_ <= kMovingFor;
  return isMoving_ ? coarsened(asked, rule_.choose(pixelsOf(camera), asked, targetMs)) : asked;
}

void ServerPace::note(const Camera& camera, const MarchSettings& asked, const MarchSettings& marched, double tookMs, Clock::TimePoint answeredAt) {
  if (isMoving_)
    rule_.noteMoving(pixelsOf(camera), asked, coarseningOf(asked, marched).value_or(Coarsening{}), tookMs);
  else
    rule_.noteAtRest(pixelsOf(camera), asked, tookMs);
  last_ = camera;
  answeredAt_ = answeredAt;
}

}  // namespace warpscope
