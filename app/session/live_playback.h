// A recording that is shown again in a session: its frames and its camera, at a time that passes, stands still, or is sought.
// Its clock is its own: what is on show depends on seconds() alone.
#pragma once

#include <memory>
#include <optional>

#include "app/frames/recorded_frame_source.h"
#include "app/session/frame_requests.h"

namespace warpscope {

inline constexpr Range kPlaybackSpeedRange{0.1, 4.0};

class LivePlayback {
 public:
  using TimePoint = Clock::TimePoint;

  /// Plays from the first frame on. `recorded` null: there is no recording.
  void begin(std::shared_ptr<RecordedFrameSource> recorded);

  bool isOpen() const { return recorded_ != nullptr; }
  bool isPlaying() const { return isPlaying_; }
  /// Playing goes on from the beginning where the end was reached.
  void setPlaying(bool isPlaying);
  void seek(double seconds);
  /// So many frames on, or back, and stays there.
  void step(int frames);
  double speed() const { return speed_; }
  void setSpeed(double speed);
  bool isLooping() const { return isLooping_; }
  void setLooping(bool isLooping) { isLooping_ = isLooping; }
  /// Whether the camera is the recorded one. Whoever moves it otherwise has it for himself until this is set again.
  bool followsCamera() const { return followsCamera_; }
  void setFollowsCamera(bool follows) { followsCamera_ = follows; }

  /// Seconds of the recording: of what is on show, of the first frame, of the end.
  double seconds() const { return seconds_; }
  double firstSeconds() const;
  double lastSeconds() const;
  /// Of the frame that belongs to seconds(), from 0 on.
  size_t frame() const { return frameAt(recording(), seconds_).value_or(0); }
  const Recording& recording() const { return recorded_->recording(); }
  const std::shared_ptr<const Recording>& sharedRecording() const { return recorded_->sharedRecording(); }

  /// Lets time pass, and seeks the frame that belongs to it. The view to be shown now; `view` is the current one.
  View update(const View& view, TimePoint now);
  /// The frame that was sought, once it is there, and what it was asked for with as far as that is known.
  struct Shown {
    ServedFrame served;
    WantedFrame asked;
  };
  std::optional<Shown> take();
  bool isAtRest() const { return !isPlaying_ && !recorded_->isSeeking(); }
  /// For how long, in the recording's time, the camera of that frame has not been the recorded one any more: 0 while it is. Nothing for frames that are unknown.
  std::optional<double> ageMs(uint64_t requestId) const;

 private:
  std::shared_ptr<RecordedFrameSource> recorded_;
  bool isPlaying_ = false, isLooping_ = false, followsCamera_ = true;
  double seconds_ = 0.0, speed_ = 1.0;
  std::optional<TimePoint> updatedAt_;
  std::optional<View> made_;  // that update() gave last
  /// When a frame's view was left, for those that may be on show.
  struct Left {
    uint64_t requestId = 0;
    double seconds = 0.0;
  };
  std::vector<Left> left_;  // the newest last; bounded
};

}  // namespace warpscope
