// Cameras that move by themselves: the same view at the same time, whoever asks and however often. For demonstrations and recordings.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "app/scene/scene.h"

namespace warpscope {

enum class CameraMotion { none, orbit, shake, dolly, flyThrough, recorded };

struct CameraMotionDescriptor {
  std::string_view name;   ///< in files and on the command line
  CameraMotion value;
  std::string_view label;  ///< in the window
  std::string_view help;   ///< one sentence without its full stop
};

/// In the order of their values.
std::span<const CameraMotionDescriptor> cameraMotions();
const CameraMotionDescriptor& describe(CameraMotion motion);

/// A view that was the current one, and when: seconds since the first.
struct TimedView {
  double seconds = 0.0;
  View view;

  bool operator==(const TimedView&) const = default;
};

/// A path that somebody has flown: times rise. Bounded: beyond kMost it takes no more.
class CameraPath {
 public:
  static constexpr size_t kMost = 216000;  ///< an hour at 60 pictures a second

  /// What is no later than the last view replaces it.
  void add(double seconds, const View& view);
  bool empty() const { return views_.empty(); }
  double seconds() const { return views_.empty() ? 0.0 : views_.back().seconds; }
  /// Between two views in straight lines, angles the short way around. Before the first and behind the last, those. There must be one.
  View at(double seconds) const;
  const std::vector<TimedView>& views() const { return views_; }

  bool operator==(const CameraPath&) const = default;

 private:
  std::vector<TimedView> views_;
};

/// Where the camera is `seconds` after it stood at `home`, at so many times the motion's usual speed. `path` is what `recorded` repeats, back and forth.
View movedView(CameraMotion motion, const View& home, double seconds, double speed, const CameraPath& path);

}  // namespace warpscope
