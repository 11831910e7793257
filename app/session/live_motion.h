// The camera's own motion in a session, and the path that is recorded of it: whoever else moves the camera ends the motion.
#pragma once

#include <optional>

#include "app/scene/camera_motion.h"
#include "render/base/clock.h"

namespace warpscope {

class LiveMotion {
 public:
  using TimePoint = Clock::TimePoint;

  /// Begins at the first update().
  void start(CameraMotion motion, double speed);
  void stop() { start(CameraMotion::none, speed_); }
  CameraMotion motion() const { return motion_; }
  double speed() const { return speed_; }
  bool hasPath() const { return !path_.empty(); }

  /// Records the current view at each update() from now on, in place of what was recorded before; or ends that.
  void setRecording(bool isRecording);
  bool isRecording() const { return recordingSince_.has_value() || startsRecording_; }
  const CameraPath& path() const { return path_; }
  void setPath(CameraPath path) { path_ = std::move(path); }

  /// The view to be shown now. `view` is the current one: where it is not what this made of it, somebody else has moved the camera, and the motion ends.
  View update(const View& view, TimePoint now);

 private:
  CameraMotion motion_ = CameraMotion::none;
  double speed_ = 1.0;
  CameraPath path_;
  std::optional<TimePoint> since_;
  View home_, made_;
  bool startsRecording_ = false;
  std::optional<TimePoint> recordingSince_;
};

}  // namespace warpscope
