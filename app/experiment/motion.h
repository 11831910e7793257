// Which frame is on show at an instant, and for which moment it was asked, while the camera moves behind a link: in virtual time.
// The link is net/link_model.h's; what the server and the client take is what was measured of them.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "net/link_settings.h"

namespace warpscope {

/// What each frame takes on its way; milliseconds and bytes.
struct MotionStages {
  double serverMs = 0.0;   ///< march to encoding
  double arrivalMs = 0.0;  ///< decoding and building
  double drawMs = 0.0;     ///< camera to picture
  size_t requestBytes = 160;  ///< a camera and its settings, on the wire
  size_t frameBytes = 0;
};

/// Seconds since the motion began.
struct ShownPictureTimes {
  double shownS = 0.0;      ///< the instant
  double drawnForS = 0.0;   ///< when the camera that the picture was drawn for was the current one: `drawMs` before it was finished
  double requestedS = 0.0;  ///< when the camera of the frame was
  bool hasFrame = false;    ///< false before the first frame is there
};

/// From one picture of the display to the next.
inline constexpr double kDisplayPeriodS = 1.0 / 60.0;

struct Motion {
  std::vector<ShownPictureTimes> pictures;  ///< one for each instant
  double framesPerSecond = 0.0;             ///< that arrive, up to the last instant
  std::optional<double> firstFrameS;        ///< when the first can be drawn from; nothing if that is after the last instant's requests
};

/// One request is under way at a time, the next leaves when its frame has arrived. The client decodes and builds one frame after the other, newest
/// wins, and draws one picture after the other, none faster than the display. `instantsS` rise. A picture is drawn from the newest frame that is ready when drawing begins. Throws net::LinkSettingsError.
Motion simulateMotion(const std::vector<double>& instantsS, const MotionStages& stages, const net::DuplexLinkSettings& link);

}  // namespace warpscope
