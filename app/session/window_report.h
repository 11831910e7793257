// What a window was like to use, in figures: how often it drew, how old the frames on show were, where their time went.
// For tests and measurements; README explains what is written.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/session/session.h"

namespace warpscope {

class WindowReport {
 public:
  /// Once for each frame of the display. `isMoving`: it draws at the display's rate because something moves or has just done so.
  void add(const Session& session, Clock::TimePoint now, bool isMoving);
  /// What the window's own thread took for one frame of the display, in ms, without waiting for the next.
  struct ThreadTime {
    double session = 0.0;  ///< answers of workers and servers taken, requests sent
    double widgets = 0.0;  ///< with textures of new pictures
    double openGl = 0.0;   ///< drawing, until the picture is swapped
    double endedS = 0.0;   ///< by the monotonic clock, s: what else happened then can be found
    double total() const { return session + widgets + openGl; }
  };
  void add(const ThreadTime& time) { frames_.push_back(time); }

  /// A JSON document about all that was added, and about the session as it is now.
  std::string text(const Session& session, Clock::TimePoint now) const;

 private:
  std::vector<double> gapsMs_;  // between frames of the display while something moved
  std::vector<ThreadTime> frames_;
  std::vector<double> agesMs_;  // of the frames on show, one for each frame of the display in which it was not of the current camera
  std::vector<double> marchesMs_;  // of the frames that came while something moved
  uint64_t newestId_ = 0;          // of these
  struct Seen {
    size_t pictures = 0;  // that the panel showed anew meanwhile
    ShownPicture last;
  };
  std::map<uint64_t, Seen> panels_;  // by their ids
  std::optional<Clock::TimePoint> last_;  // nothing after a pause
};

}  // namespace warpscope
