// How the window looks: colours, spacing and fonts, at any scale.
// A dark theme and a light one; pictures are the only saturated things on the screen.
#pragma once

#include <imgui.h>

namespace warpscope::ui {

enum class Theme { dark, light };

/// Colours that Dear ImGui's style has none for.
struct Palette {
  ImVec4 dimText, faintText, accent;
  ImVec4 errorText, errorBackground, noticeText, noticeBackground;
  ImVec4 frame;      ///< behind everything
  ImVec4 grid;       ///< of plots, on that
  ImVec4 histogram;  ///< likewise
};

/// Of the colours that were applied last, as ImGui's style is.
const Palette& palette();

// Whatever stands above pictures has a dark ground of its own, in every theme.
inline const ImVec4 kTextOnPicture{0.89f, 0.91f, 0.93f, 1.0f}, kDimTextOnPicture{0.60f, 0.63f, 0.68f, 1.0f}, kErrorTextOnPicture{1.0f, 0.62f, 0.55f, 1.0f};

/// Sizes of text at scale 1.
inline constexpr float kBodyPx = 15.0f;
inline constexpr float kSmallPx = 12.0f;

/// Fonts of the current scale; owned by ImGui's atlas.
struct Fonts {
  ImFont* body = nullptr;
  ImFont* small = nullptr;
};

/// Sets ImGui's colours and the palette.
void applyColors(Theme theme);

/// Sets ImGui's spacing and fonts. `scale` is in ImGui's units, `pixelsPerUnit` that of the framebuffer: glyphs are drawn at
/// the framebuffer's resolution. Fonts of an earlier call are gone after it.
Fonts applySizes(float scale, float pixelsPerUnit);

}  // namespace warpscope::ui
