// Requests and frames on a line of time.
// See motion.h.
#include "app/experiment/motion.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "net/link_model.h"

namespace warpscope {
namespace {

using TimePoint = net::LinkModel::TimePoint;

double secondsOf(TimePoint time) { return std::chrono::duration<double>(time.time_since_epoch()).count(); }

TimePoint later(TimePoint time, double milliseconds) {
  return time + std::chrono::duration_cast<net::LinkModel::Duration>(std::chrono::duration<double, std::milli>(milliseconds));
}

struct Frame {
  double requestedS, readyS;  // ready: first at the client, then to be drawn from
};

}  // namespace

Motion simulateMotion(const std::vector<double>& instantsS, const MotionStages& stages, const net::DuplexLinkSettings& link) {
  net::LinkModel up(link.up, TimePoint{}, 0), down(link.down, TimePoint{}, 1);
  const double endS = instantsS.empty() ? 0.0 : instantsS.back();
  // A server and a link that take nothing would be asked without end; no display shows more than this.
  constexpr double kShortestMs = 1.0;

  std::vector<Frame> frames;
  size_t arrived = 0;
  for (TimePoint sentAt{}; secondsOf(sentAt) < endS;) {
    const TimePoint served = later(up.arrivalOf(stages.requestBytes, sentAt), stages.serverMs);
    const TimePoint arrivedAt = down.arrivalOf(stages.frameBytes, served);
    frames.push_back({secondsOf(sentAt), secondsOf(arrivedAt)});
    if (secondsOf(arrivedAt) <= endS) ++arrived;
    sentAt = std::max(arrivedAt, later(sentAt, kShortestMs));
  }

  // The client decodes and builds one frame at a time, the newest that is there; the others are passed over.
  std::vector<Frame> ready;
  double freeS = 0.0;
  for (size_t i = 0; i < frames.size(); ++i) {
    const double beginS = std::max(frames[i].readyS, freeS);
    const bool isOutrun = i + 1 < frames.size() && frames[i + 1].readyS <= beginS;
    if (isOutrun) continue;
    freeS = beginS + 1e-3 * stages.arrivalMs;
    ready.push_back({frames[i].requestedS, freeS});
  }

  Motion motion;
  if (endS > 0.0) motion.framesPerSecond = static_cast<double>(arrived) / endS;
  if (!ready.empty()) motion.firstFrameS = ready.front().readyS;
  // Pictures follow each other as fast as they are drawn, but no faster than the display; the last that is finished is on show.
  const double periodS = std::max(kDisplayPeriodS, 1e-3 * stages.drawMs);
  size_t next = 0;
  for (const double instantS : instantsS) {
    ShownPictureTimes picture;
    picture.shownS = instantS;
    picture.drawnForS = std::floor(instantS / periodS) * periodS - 1e-3 * stages.drawMs;
    while (next < ready.size() && ready[next].readyS <= picture.drawnForS) ++next;
    picture.hasFrame = next > 0;
    if (picture.hasFrame) picture.requestedS = ready[next - 1].requestedS;
    motion.pictures.push_back(picture);
  }
  return motion;
}

}  // namespace warpscope
