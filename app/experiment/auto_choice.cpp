// Choosing.
// See auto_choice.h.
#include "app/experiment/auto_choice.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <tuple>
#include <utility>

namespace warpscope {
namespace {

/// How far beyond what was measured counts as measured.
constexpr double kSlackDeg = 2.5;

/// 0..180.
double folded(double angleDeg) { return std::abs(std::remainder(angleDeg, 360.0)); }

std::string reasonFor(const Configuration& configuration, double flip, double frameMs, double angleDeg, const AutoChoice::Budget& budget, size_t count) {
  char text[200];
  if (frameMs <= budget.ms)
    std::snprintf(text, sizeof text, ": least error (FLIP %.4f) at %.1f degrees of what was measured within %g ms (%.3g ms, of %zu)", flip, angleDeg,
                  budget.ms, frameMs, count);
  else
    std::snprintf(text, sizeof text, ": the fastest (%.3g ms, FLIP %.4f at %.1f degrees) of %zu measured, none of which keeps to %g ms", frameMs, flip,
                  angleDeg, count, budget.ms);
  const std::string bytes = budget.bytes > 0 ? ", of frames of no more than " + std::to_string(budget.bytes / 1024) + " KiB" : "";
  return labelOf(configuration) + text + bytes;
}

}  // namespace

AutoChoice::AutoChoice(const std::vector<SweepRow>& rows) {
  std::map<std::string, size_t> places;
  for (const SweepRow& row : rows) {
    const Configuration& configuration = row.configuration;
    if (!row.link.empty() || !configuration.technique->usesFrame) continue;
    const auto [place, isNew] = places.emplace(keyOf(configuration), candidates_.size());
    if (isNew) candidates_.push_back({configuration, {}});
    candidates_[place->second].angles.push_back({folded(row.angleDeg), row.errors.flip, row.frameMs(), row.cost.bytes});
  }
  for (Candidate& candidate : candidates_)
    std::stable_sort(candidate.angles.begin(), candidate.angles.end(), [](const AtAngle& a, const AtAngle& b) { return a.angleDeg < b.angleDeg; });
}

uint32_t AutoChoice::largestSidePx() const {
  uint32_t sidePx = 0;
  for (const Candidate& candidate : candidates_) sidePx = std::max(sidePx, candidate.configuration.serverSidePx);
  return sidePx;
}

AutoChoice::AtAngle AutoChoice::Candidate::at(double angleDeg) const {
  const auto above = std::lower_bound(angles.begin(), angles.end(), angleDeg, [](const AtAngle& a, double angle) { return a.angleDeg < angle; });
  if (above == angles.end()) return angles.back();
  if (above == angles.begin() || above->angleDeg == angleDeg) return *above;
  const AtAngle& below = *std::prev(above);
  const double share = (angleDeg - below.angleDeg) / (above->angleDeg - below.angleDeg);
  return {angleDeg, std::lerp(below.flip, above->flip, share), std::lerp(below.frameMs, above->frameMs, share), std::max(below.bytes, above->bytes)};
}

bool AutoChoice::Candidate::covers(double angleDeg) const {
  return angleDeg >= angles.front().angleDeg - kSlackDeg && angleDeg <= angles.back().angleDeg + kSlackDeg;
}

std::optional<AutoChoice::Choice> AutoChoice::choose(double angleDeg, const Budget& budget, const std::function<bool(const Configuration&)>& may) const {
  angleDeg = folded(angleDeg);
  const Candidate* best = nullptr;
  AtAngle bestAt{};
  std::tuple<bool, bool, double, double> bestRank;
  size_t count = 0;
  for (const Candidate& candidate : candidates_) {
    const AtAngle here = candidate.at(angleDeg);
    if ((budget.bytes > 0 && here.bytes > budget.bytes) || !may(candidate.configuration)) continue;
    ++count;
    const bool isLate = here.frameMs > budget.ms;
    const std::tuple<bool, bool, double, double> rank(isLate, !candidate.covers(angleDeg), isLate ? here.frameMs : here.flip,
                                                      isLate ? here.flip : here.frameMs);
    if (best != nullptr && rank >= bestRank) continue;
    best = &candidate;
    bestAt = here;
    bestRank = rank;
  }
  if (best == nullptr) return std::nullopt;
  Choice choice{best->configuration, bestAt.flip, bestAt.frameMs,
                reasonFor(best->configuration, bestAt.flip, bestAt.frameMs, angleDeg, budget, count)};
  if (!best->covers(angleDeg)) choice.reason += ", though nothing was measured that far out";
  return choice;
}

double angleBetweenDeg(const Camera& a, const Camera& b) {
  const glm::dvec3 from(a.forward), to(b.forward), eyeA(a.eye), eyeB(b.eye);
  const double turned = std::atan2(glm::length(glm::cross(from, to)), glm::dot(from, to));
  const double distance = std::max(glm::length(eyeA), glm::length(eyeB));
  const double moved = distance > 0.0 ? 2.0 * std::asin(std::min(1.0, 0.5 * glm::length(eyeB - eyeA) / distance)) : 0.0;
  return std::max(turned, moved) * 180.0 / std::numbers::pi;
}

}  // namespace warpscope
