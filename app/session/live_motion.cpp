// From times to views.
// See live_motion.h.
#include "app/session/live_motion.h"

#include <utility>

namespace warpscope {

void LiveMotion::start(CameraMotion motion, double speed) {
  motion_ = motion;
  speed_ = speed;
  since_.reset();
  if (motion == CameraMotion::recorded) setRecording(false);  // it would record itself
}

void LiveMotion::setRecording(bool isRecording) {
  startsRecording_ = isRecording;
  recordingSince_.reset();
  if (isRecording) path_ = {};
}

View LiveMotion::update(const View& view, TimePoint now) {
  View shown = view;
  if (motion_ != CameraMotion::none) {
    if (!since_) {
      since_ = now;
      home_ = made_ = view;
    }
    if (view != made_) {
      stop();
    } else {
      shown = made_ = movedView(motion_, home_, std::chrono::duration<double>(now - *since_).count(), speed_, path_);
    }
  }
  if (std::exchange(startsRecording_, false)) recordingSince_ = now;
  if (recordingSince_) path_.add(std::chrono::duration<double>(now - *recordingSince_).count(), shown);
  return shown;
}

}  // namespace warpscope
