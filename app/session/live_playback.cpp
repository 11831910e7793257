// Time that passes.
// See live_playback.h.
#include "app/session/live_playback.h"

#include <algorithm>
#include <utility>

namespace warpscope {
namespace {

/// More than panels show at a time, and than wait to be drawn.
constexpr size_t kRemembered = 64;

}  // namespace

void LivePlayback::begin(std::shared_ptr<RecordedFrameSource> recorded) {
  *this = {};
  recorded_ = std::move(recorded);
  if (!recorded_) return;
  isPlaying_ = true;
  seconds_ = firstSeconds();
}

double LivePlayback::firstSeconds() const { return recording().frames.empty() ? 0.0 : recording().frames.front().seconds; }
double LivePlayback::lastSeconds() const { return std::max(recording().seconds, firstSeconds()); }

void LivePlayback::setPlaying(bool isPlaying) {
  if (!isOpen()) return;
  if (isPlaying && !isPlaying_ && seconds_ >= lastSeconds()) seconds_ = firstSeconds();
  isPlaying_ = isPlaying;
  updatedAt_.reset();
}

void LivePlayback::seek(double seconds) {
  if (isOpen()) seconds_ = std::clamp(seconds, firstSeconds(), lastSeconds());
}

void LivePlayback::step(int frames) {
  if (!isOpen() || recording().frames.empty()) return;
  setPlaying(false);
  const auto last = static_cast<int64_t>(recording().frames.size()) - 1;
  seek(recording().frames[static_cast<size_t>(std::clamp<int64_t>(static_cast<int64_t>(frame()) + frames, 0, last))].seconds);
}

void LivePlayback::setSpeed(double speed) { speed_ = std::clamp(speed, kPlaybackSpeedRange.lowest, kPlaybackSpeedRange.highest); }

View LivePlayback::update(const View& view, TimePoint now) {
  if (!isOpen()) return view;
  if (isPlaying_ && updatedAt_) {
    seconds_ += speed_ * std::chrono::duration<double>(now - *updatedAt_).count();
    if (seconds_ >= lastSeconds() && isLooping_) seconds_ = firstSeconds();
    if (seconds_ >= lastSeconds()) {
      seconds_ = lastSeconds();
      isPlaying_ = false;
    }
  }
  updatedAt_ = now;
  recorded_->seek(seconds_);
  if (made_ && view != *made_) followsCamera_ = false;
  made_ = followsCamera_ ? recording().path.at(seconds_) : view;
  return *made_;
}

std::optional<LivePlayback::Shown> LivePlayback::take() {
  std::optional<RecordedFrameSource::Taken> taken = recorded_->take();
  if (!taken) return std::nullopt;
  const size_t asked = taken->view;
  Shown shown{std::move(taken->served), {}};
  if (!shown.served.frame) return shown;
  const SampleFrame& frame = *shown.served.frame;
  std::erase_if(left_, [&](const Left& one) { return one.requestId == frame.requestId; });
  if (left_.size() >= kRemembered) left_.erase(left_.begin());
  left_.push_back({frame.requestId, leftAt(recording(), asked)});
  shown.asked.camera = frame.camera;
  shown.asked.view = recording().path.views()[asked].view;
  shown.asked.march = frame.settings;
  shown.asked.serverSidePx = longerSide(frame.camera);
  return shown;
}

std::optional<double> LivePlayback::ageMs(uint64_t requestId) const {
  const auto left = std::ranges::find(left_, requestId, &Left::requestId);
  if (left == left_.end()) return std::nullopt;
  return std::max(0.0, 1e3 * (seconds_ - left->seconds));
}

}  // namespace warpscope
