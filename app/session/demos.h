// Demonstrations, ready to be shown: a link, a motion of the camera and techniques beside each other.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "app/scene/camera_motion.h"
#include "app/session/edit_history.h"
#include "app/session/session.h"

namespace warpscope {

struct Demo {
  std::string_view name;     ///< "Satellite"
  std::string_view summary;  ///< what one sees: one sentence without its full stop
  std::string_view link;     ///< a preset's name
  CameraMotion motion = CameraMotion::none;
  std::vector<std::string_view> techniques;
  int frameKib = 0;          ///< what a frame may take (TransportSettings)
};

/// The first is what a first start shows.
std::span<const Demo> demos();

/// What a demonstration changes.
struct BeforeDemo {
  std::vector<PanelSettings> panels;
  std::vector<std::optional<View>> ownViews;  ///< of panels with a camera of their own
  View view;
  uint64_t scene = 0;  ///< Session::sceneCount(): views are that scene's
  net::DuplexLinkSettings link;
  int frameKib = 0;
  bool isFrozen = false;
};

/// A demonstration on show: panels, link and motion; the scene and all other knobs stay as they are. Its panels come first, without a link, and link and motion when there is a frame that has what they draw: by the link's own time the
/// first pictures would be black until then. Who changes something meanwhile has what he wanted, and they do not come.
class RunningDemo {
 public:
  /// After another one that goes on what was before stays what was before the first.
  void start(const Demo& demo, Session& session, const EditHistory& history);
  /// Once for each frame, after the history has followed. `isHeld`: as it was told.
  void follow(Session& session, const EditHistory& history, bool isHeld, Session::TimePoint now);
  bool isOn() const { return before_.has_value(); }
  /// Whether the last thing that was done is that it began, so that it can be taken back as a whole.
  bool isLast(const Session& session, const EditHistory& history) const;
  /// Back to what was, with a camera that stands still; only where isOn(). Taken back as a whole it leaves no step.
  void end(Session& session, EditHistory& history);
  /// What it changed stays.
  void forget() { *this = {}; }

 private:
  static constexpr std::chrono::seconds kPatience{3};  // for a frame

  std::optional<BeforeDemo> before_;
  uint64_t scene_ = 0;                   // Session::sceneCount() when the last one began
  uint64_t depthBefore_ = 0;             // of the history
  std::optional<uint64_t> depthBegun_;   // when what it changes was a step; nothing: it is not yet
  const Demo* pending_ = nullptr;        // whose frame has not come yet
  View pendingView_;                     // since it began
  std::optional<Session::TimePoint> pendingSince_;
};

}  // namespace warpscope
