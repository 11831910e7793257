// How the window looks: colours, spacing and fonts, at any scale.
// One dark theme; pictures are the only saturated things on the screen.
#pragma once

#include <imgui.h>

namespace warpscope::ui {

inline const ImVec4 kDimText{0.56f, 0.59f, 0.64f, 1.0f};
inline const ImVec4 kFaintText{0.40f, 0.43f, 0.47f, 1.0f};
inline const ImVec4 kAccent{0.30f, 0.72f, 0.78f, 1.0f};
inline const ImVec4 kErrorText{1.0f, 0.62f, 0.55f, 1.0f};
inline const ImVec4 kErrorBackground{0.32f, 0.13f, 0.12f, 1.0f};
inline const ImVec4 kFrameColor{0.055f, 0.062f, 0.073f, 1.0f};  ///< behind everything

/// Sizes of text at scale 1.
inline constexpr float kBodyPx = 15.0f;
inline constexpr float kSmallPx = 12.0f;

/// Fonts of the current scale; owned by ImGui's atlas.
struct Fonts {
  ImFont* body = nullptr;
  ImFont* small = nullptr;
};

/// Sets ImGui's colours, spacing and fonts. `scale` is in ImGui's units, `pixelsPerUnit` that of the framebuffer: glyphs are drawn at
/// the framebuffer's resolution. Fonts of an earlier call are gone after it.
Fonts applyTheme(float scale, float pixelsPerUnit);

}  // namespace warpscope::ui
