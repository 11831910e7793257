// What one panel shows: a picture, which technique drew it from which frame, what that took, and how wrong it is.
// State alone; live_panel.h fills it.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "app/experiment/configuration.h"
#include "app/frames/frame_source.h"
#include "app/picture/shown_picture.h"
#include "app/session/error_history.h"
#include "app/session/panel_content.h"
#include "app/session/warp_worker.h"
#include "render/metrics/picture_errors.h"

namespace warpscope {

inline constexpr size_t kMaxPanels = 6;
inline constexpr std::chrono::seconds kLiveErrors(1);

/// What the user has chosen for one panel.
struct PanelSettings {
  const WarpDescriptor* technique = nullptr;
  bool isAutomatic = false;                              ///< `technique` is chosen for each picture by what was measured
  KnobValues knobs{};                                    ///< of techniques' knobs those that each panel has for itself (Knob::isOfPanel)
  PictureContent content = PictureContent::picture;      ///< that is to be seen
  PictureContent lastContent = PictureContent::flip;     ///< that was wanted last in place of the picture
  std::optional<float> contentRange{};                   ///< of its ramp, if the user said one
  bool isHidden = false;                                 ///< nothing is drawn for it: another one has its room
};

/// Whether a command's options of techniques' knobs are for this one of so many panels: the first of several is what the others are compared with.
inline bool takesOptions(size_t panel, size_t panels) { return panel > 0 || panels == 1; }

struct Panel : PanelSettings {
  uint64_t id = 0;                              ///< of all panels that a session has had, this one's alone
  ShownPicture picture;                         ///< none until the first is there; stays until the next
  const WarpDescriptor* drawn = nullptr;        ///< the technique that drew it, or whose place a shortcut took
  uint64_t requestId = 0;                       ///< of the frame that it was drawn from
  FrameLatency latency;                         ///< of that frame
  /// What its technique draws of that frame, on the wire (bytesFor), or what the frame's picture would take where that is enough (drawsPictureAlone):
  /// found as errors are, so that nothing waits for it; nothing until then.
  std::optional<size_t> bytes;
  size_t proxyBytes = 0;                        ///< of the copy of the volume, once a scene, where its technique draws that
  double buildMs = 0.0;
  double drawMs = 0.0;
  double displayMs = 0.0;                       ///< from the picture's end until the display took it
  std::optional<Configuration> configuration;   ///< that drew it; nothing if not known, without frames, and for shortcuts
  std::string shortcut;                         ///< shortcutText() where no technique drew the picture; mostly empty
  PicturePlan plan;                             ///< of what its worker did last
  WarpCounts counts;                            ///< what it did since the scene was opened
  std::string leftOut;                          ///< how that frame's march was coarser than what was asked for, because the camera moved; mostly empty
  std::string lack;                             ///< why the technique shows nothing of that frame (lackOf); mostly empty
  std::string error;                            ///< empty if the last picture succeeded

  std::optional<Configuration> choice;          ///< what was chosen; nothing if nothing fits
  std::string choiceText;                       ///< what, and why: a sentence without its full stop

  std::optional<PictureErrors> errors;  ///< the last that were found
  /// They are those of the picture that is shown or, where the ground truth follows the moving camera (LiveGroundTruth::followsCamera), of one shown
  /// less than kLiveErrors ago by the same technique, or instead of it by the same shortcut.
  bool errorsAreCurrent = false;
  std::optional<PictureErrors> movingErrors;  ///< of few pixels of a picture that was on show less than kLiveErrors ago (moving_errors.h), where `errors` are not current
  std::shared_ptr<const PanelPixels> pixels;  ///< of the picture that was judged last; null before
  PanelContent shownContent;            ///< found as `errors` are, and true as long
  ErrorHistory history;                 ///< of FLIP

  /// What was found last, for the picture of `errors`, is what is wanted.
  bool isContentFound() const { return content == PictureContent::picture || (shownContent.what == content && shownContent.range == contentRange); }
  /// Null where they are not those of the picture on show.
  const PanelPixels* currentPixels() const { return pixels && pixels->picture == picture ? pixels.get() : nullptr; }
  bool hasContentOnShow() const { return content != PictureContent::picture && errorsAreCurrent && shownContent.what == content && shownContent.picture; }
};

}  // namespace warpscope
