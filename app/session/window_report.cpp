// Gathering gaps and ages, and their medians.
// See window_report.h.
#include "app/session/window_report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <span>
#include <utility>

#include "app/experiment/plan_json.h"
#include "app/frames/process_json.h"
#include "app/scene/json_document.h"

namespace warpscope {
namespace {

using Json = nlohmann::json;

/// Null if there are none.
Json medianAndLongest(std::vector<double> values) {
  if (values.empty()) return nullptr;
  std::sort(values.begin(), values.end());
  return {{"median", values[values.size() / 2]}, {"longest", values.back()}};
}

Json toJson(const Panel& panel) {
  if (!panel.picture || !panel.drawn->usesFrame) return nullptr;
  const auto current = [&](double PictureErrors::*error) {
    return panel.errorsAreCurrent && std::isfinite((*panel.errors).*error) ? Json((*panel.errors).*error) : Json(nullptr);
  };
  const FrameLatency& latency = panel.latency;
  return {{"leftOut", panel.leftOut},
          {"shortcut", panel.shortcut},
          {"bytes", panel.bytes ? Json(*panel.bytes) : Json(nullptr)},
          {"proxyBytes", panel.proxyBytes},   {"waitMs", latency.waitMs},       {"wireMs", latency.wireMs},
          {"queueMs", latency.queueMs},       {"marchMs", latency.marchMs},     {"compactMs", latency.compactMs},
          {"copyMs", latency.copyMs},         {"encodeMs", latency.encodeMs},   {"decodeMs", latency.decodeMs},
          {"buildMs", panel.buildMs},         {"drawMs", panel.drawMs},         {"displayMs", panel.displayMs},
          {"flip", current(&PictureErrors::flip)},
          {"psnrDb", current(&PictureErrors::psnrDb)},
          {"holeFraction", current(&PictureErrors::holeFraction)},
          {"filledFraction", current(&PictureErrors::filledFraction)}};
}

/// What a panel's worker did since the scene was opened, and which stages of its plan were in last.
Json workOf(const Panel& panel) {
  Json stages = Json::array();
  if (panel.picture)
    for (const PictureStageDescriptor& stage : kPictureStages)
      stages.push_back({{"stage", stage.name},
                        {"summary", stage.summary},
                        {"in", panel.plan.has(stage.stage)},
                        {"reason", panel.plan[stage.stage].reason}});
  const WarpCounts& counts = panel.counts;
  return {{"made", counts.made},
          {"builds", counts.builds},
          {"draws", counts.draws},
          {"drawsToJudge", counts.drawsToJudge},
          {"shortcutsTaken", counts.shortcuts},
          {"stages", stages}};
}

/// How many there are, and those that a hand would feel: which they are, and where their time went.
Json threadFrames(std::span<const WindowReport::ThreadTime> frames) {
  constexpr double kHitchMs = 33.0;
  Json hitches = Json::array();
  for (size_t i = 0; i < frames.size(); ++i)
    if (const auto& [sessionMs, widgetsMs, openGlMs, endedS] = frames[i]; frames[i].total() > kHitchMs)
      hitches.push_back({{"frame", i}, {"sessionMs", sessionMs}, {"widgetsMs", widgetsMs}, {"openGlMs", openGlMs}, {"endedS", endedS}});
  return {{"all", frames.size()}, {"over33Ms", hitches.size()}, {"hitches", hitches}};
}

Json toJson(const SourceStatus& status) {
  Json processes = Json::array();
  for (const net::ProcessFields& process : status.processes) processes.push_back(warpscope::toJson(process));
  return {{"where", status.where},
          {"isConnected", status.isConnected},
          {"sentence", status.sentence},
          {"roundTripMs", status.roundTripMs},
          {"processes", processes},
          {"busyWith", status.busyWith ? Json(*status.busyWith) : Json(nullptr)}};
}

/// Null where the plan is not known.
Json toJson(const LivePlan& plan) {
  if (!plan.plan()) return nullptr;
  const bool isMeasured = plan.areCurrent();
  return {{"marchMs", isMeasured ? Json(plan.costs()->march.medianMs) : Json(nullptr)},
          {"stages", toJson(*plan.plan(), isMeasured ? &*plan.costs() : nullptr)}};
}

}  // namespace

void WindowReport::add(const Session& session, Clock::TimePoint now, bool isMoving) {
  if (isMoving && last_) gapsMs_.push_back(millisecondsBetween(*last_, now));
  last_.reset();
  if (isMoving) last_ = now;
  for (size_t i = 0; i < session.panelCount(); ++i) {
    const ShownPicture& picture = session.panel(i).picture;
    Seen& seen = panels_[session.panel(i).id];
    if (!(seen.last == picture) && isMoving) ++seen.pictures;
    seen.last = picture;
  }
  if (const SampleFramePtr& frame = session.frames().newest(); frame && std::exchange(newestId_, frame->requestId) != frame->requestId && isMoving)
    marchesMs_.push_back(frame->timings.marchMs);
  // All panels show the same frames; the age is the most recent one's, as far as one of them has any.
  std::optional<double> ageMs;
  for (size_t i = 0; i < session.panelCount(); ++i)
    if (const std::optional<double> age = session.ageMs(i, now)) ageMs = std::min(*age, ageMs.value_or(*age));
  if (ageMs && *ageMs > 0.0) agesMs_.push_back(*ageMs);
}

std::string WindowReport::text(const Session& session, Clock::TimePoint now) const {
  const double movingMs = std::accumulate(gapsMs_.begin(), gapsMs_.end(), 0.0);
  const auto perSecond = [&](size_t count) { return movingMs > 0.0 ? Json(1e3 * static_cast<double>(count) / movingMs) : Json(nullptr); };
  Json panels = Json::array(), work = Json::array(), pictures = Json::array();
  for (size_t i = 0; i < session.panelCount(); ++i) {
    const Panel& panel = session.panel(i);
    panels.push_back(toJson(panel));
    work.push_back(workOf(panel));
    const auto seen = panels_.find(panel.id);
    pictures.push_back(perSecond(seen != panels_.end() ? seen->second.pictures : 0));
  }
  std::vector<double> threadMs;
  for (const ThreadTime& frame : frames_) threadMs.push_back(frame.total());
  const std::optional<SourceStatus> status = session.sourceStatus();
  const std::optional<double> frameAge = session.frames().ageOfNewestMs(now);
  return textOf({{"framesPerSecond", perSecond(gapsMs_.size())},
                 {"picturesPerSecond", pictures},
                 {"gapMs", medianAndLongest(gapsMs_)},
                 {"threadMs", medianAndLongest(threadMs)},
                 {"threadFrames", threadFrames(frames_)},
                 {"ageMs", medianAndLongest(agesMs_)},
                 {"movingMarchMs", medianAndLongest(marchesMs_)},
                 {"framesReceived", session.frames().received()},
                 {"lastFrameAgeMs", frameAge ? Json(*frameAge) : Json(nullptr)},
                 {"panels", panels},
                 {"work", work},
                 {"plan", toJson(session.plan())},
                 {"server", status ? toJson(*status) : Json(nullptr)}});
}

}  // namespace warpscope
