// Demonstrations, ready to be shown: a link, a motion of the camera and techniques beside each other.
#pragma once

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

}  // namespace warpscope
