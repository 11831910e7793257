// The panels of the window: how they share its room, which of them has all of it, and which picture is compared with another's in one place.
// Remembers panels by their ids, which stay as panels move.
#pragma once

#include <map>
#include <memory>
#include <optional>

#include "app/ui/warp_panel.h"

namespace warpscope::ui {

/// Keys that do something as long as they are down.
struct HeldKeys {
  bool reference = false, blink = false;
};

class PanelGrid {
 public:
  explicit PanelGrid(const WindowGl& gl) : gl_(gl) {}

  /// What a panel's button asks for.
  struct Asked {
    uint64_t panel = 0;  ///< its id
    Action action = Action::closePanel;
  };
  /// Whether one panel has all the room.
  bool isAlone() const { return alone_.has_value(); }
  /// The shorter side that a picture's area would have in that room, ImGui units, with figures beneath it; 0 or less where there is no room for that.
  float pictureSide(const Session& session, const ImVec2& room, const Look& look) const;
  /// The same with or without figures beneath.
  float barePictureSide(const Session& session, const ImVec2& room, const Look& look) const { return layoutOf(alone_ ? 1 : session.panelCount(), room, look).side; }
  /// Draws all panels into the current window's room, as much of it as `room`.
  std::optional<Asked> draw(Session& session, const ImVec2& room, const HeldKeys& held, const Look& look);

  /// The panel under the pointer in the last draw(); nothing if it has gone since.
  std::optional<size_t> underPointer(const Session& session) const;
  /// The one whose technique changed last, or that was clicked into or turned the wheel over since.
  size_t usedLast(const Session& session) const;

  /// What actions of panels do; `panel` is an index.
  void addPanel(Session& session);
  void closePanel(Session& session, size_t panel);
  void toggleMaximised(const Session& session, size_t panel);
  void toggleWipe(const Session& session, size_t panel);
  bool isMaximised(const Session& session, size_t panel) const { return alone_ == session.panel(panel).id; }
  bool isWiped(const Session& session, size_t panel) const { return wiped_ == session.panel(panel).id; }
  bool isInspecting() const { return isInspecting_; }
  void setInspecting(bool isInspecting) { isInspecting_ = isInspecting; }
  /// What is known of the pixel under the pointer, as text; empty where it is on no picture, or where nothing is known yet.
  std::string textAboutPixel(const Session& session) const;
  /// Ends a wipe, an inspection, or else lets all panels be seen again. False if there was none of these.
  bool goBack();

  /// All panels again, and none of them wiped.
  void showAll() {
    alone_.reset();
    wiped_.reset();
  }

  /// Panels side by side; 0: as many as leave the pictures most room.
  size_t columns() const { return columns_; }
  void setColumns(size_t columns) { columns_ = columns; }

  /// Whether something moves although nothing happens.
  bool isAnimating() const { return isBlinking_; }

 private:
  struct Layout {
    size_t columns = 1;
    ImVec2 cell;
    MeasurementSpace space = MeasurementSpace::all;
    float side = 0.0f;  ///< the shorter one of a picture's area
  };
  Layout layoutOf(size_t count, const ImVec2& room, const Look& look) const;
  void forgetClosed(const Session& session);
  void followUse(const Session& session);
  std::optional<OtherPicture> otherOf(const Session& session, size_t panel, const HeldKeys& held, const Look& look);
  /// One cell.
  PanelEvents drawCell(Session& session, size_t panel, const Layout& layout, const HeldKeys& held, const Look& look);

  struct Shown {
    explicit Shown(const WindowGl& gl) : textures{PictureTexture(gl), PictureTexture(gl)} {}
    PanelTextures textures;
    const WarpDescriptor* technique = nullptr;  // in the last draw()
  };
  const WindowGl& gl_;
  std::map<uint64_t, std::unique_ptr<Shown>> shown_;
  std::optional<uint64_t> alone_, wiped_;
  float wipeAt_ = 0.5f;
  size_t columns_ = 0;
  uint64_t usedLast_ = 0;
  std::optional<uint64_t> underPointer_, underPointerNow_;
  bool isBlinking_ = false;
  bool isInspecting_ = false;
  Inspection inspection_;  // in the last draw()
};

}  // namespace warpscope::ui
