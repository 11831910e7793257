// Demonstrations, ready to be shown: a link, a motion of the camera and techniques beside each other.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "app/scene/camera_motion.h"
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

/// Sets panels, link and motion up; the scene and all other knobs stay as they are.
void startDemo(const Demo& demo, Session& session);

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
BeforeDemo beforeDemo(const Session& session);
/// All of that again, and a camera that stands still.
void endDemo(const BeforeDemo& before, Session& session);

/// A demonstration on show. Its panels come first, without a link, and link and motion when there is a frame that has what they draw: by the link's own time the
/// first pictures would be black until then.
class RunningDemo {
 public:
  /// After another one that goes on what was before stays what was before the first.
  void start(const Demo& demo, Session& session);
  /// Once for each frame, after the history: `edits` as EditHistory::edits().
  void follow(Session& session, uint64_t edits, Session::TimePoint now);
  bool isOn() const { return before_.has_value(); }
  /// Whether the last thing that was done is that it began.
  bool isLast(uint64_t edits) const { return isOn() && (pending_ != nullptr || edits_ == edits); }
  /// Back to what was; only where isOn().
  void end(Session& session);
  /// What it changed stays.
  void forget() { *this = {}; }

 private:
  static constexpr std::chrono::seconds kPatience{3};  // for a frame

  std::optional<BeforeDemo> before_;
  const Demo* pending_ = nullptr;  // whose frame has not come yet
  std::optional<Session::TimePoint> pendingSince_;
  std::optional<uint64_t> edits_;  // when it had begun
};

}  // namespace warpscope
