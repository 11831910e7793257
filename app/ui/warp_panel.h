// A panel: header, picture with orbit control, measurements.
#pragma once

#include <optional>
#include <string>

#include "app/session/actions.h"
#include "app/ui/parts.h"
#include "app/ui/texture.h"

namespace warpscope::ui {

/// What a panel shows besides its own picture, or in its place.
struct OtherPicture {
  ShownPicture picture;     ///< may be none yet
  std::string name;         ///< of what it is
  float* wipeAt = nullptr;  ///< where a bar stands, of the picture's width, that the user may drag: the other picture is on its right. Null: the other one is in the panel's place
};

/// What a panel draws with. Textures belong to whoever draws panels: they outlive the frame.
struct PanelTextures {
  PictureTexture own, other;
};

/// A look through the loupe: at the same place of all panels' pictures.
struct Inspection {
  std::optional<glm::dvec2> place;  ///< in shares of the picture's width and height from its upper left corner; nothing while the pointer is on no picture
};

/// What happened in a panel.
struct PanelEvents {
  std::optional<Action> asked;          ///< by one of its buttons
  std::optional<glm::dvec2> pointer;    ///< where on its picture, as in Inspection
  bool isClicked = false;               ///< there, by the left button, without a drag
};

/// Height of all that a panel has above and beneath its picture, in ImGui units, in a child window that gives it so much width.
float panelHeightBesidePicture(float width, MeasurementSpace space, const Look& look);

/// Fills the current child window. The session learns the size of the picture's area. `inspection`: null while there is no loupe.
PanelEvents drawWarpPanel(Session& session, size_t index, bool isAlone, const std::optional<OtherPicture>& other, const Inspection* inspection,
                          MeasurementSpace space, PanelTextures& textures, const Look& look);

}  // namespace warpscope::ui
