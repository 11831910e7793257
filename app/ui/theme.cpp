// Colours, spacing, fonts.
// See theme.h.
#include "app/ui/theme.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string_view>

#include "app/picture/text.h"

namespace warpscope::ui {
namespace {

const Palette kDark{
    .dimText = {0.56f, 0.59f, 0.64f, 1.0f},
    .faintText = {0.40f, 0.43f, 0.47f, 1.0f},
    .accent = {0.30f, 0.72f, 0.78f, 1.0f},
    .errorText = {1.0f, 0.62f, 0.55f, 1.0f},
    .errorBackground = {0.32f, 0.13f, 0.12f, 1.0f},
    .noticeText = {1.0f, 0.82f, 0.35f, 1.0f},
    .noticeBackground = {0.30f, 0.22f, 0.05f, 1.0f},
    .frame = {0.055f, 0.062f, 0.073f, 1.0f},
    .grid = {0.17f, 0.19f, 0.215f, 1.0f},
    .histogram = {0.275f, 0.298f, 0.337f, 1.0f},
};
// Text and what is pointed at have at least the contrast of 4.5 to 1 with what they stand on that WCAG 2.1, 1.4.3 asks for; what is faint on purpose has 3.
const Palette kLight{
    .dimText = {0.33f, 0.36f, 0.40f, 1.0f},
    .faintText = {0.48f, 0.51f, 0.55f, 1.0f},
    .accent = {0.02f, 0.42f, 0.48f, 1.0f},
    .errorText = {0.60f, 0.10f, 0.06f, 1.0f},
    .errorBackground = {0.98f, 0.86f, 0.84f, 1.0f},
    .noticeText = {0.42f, 0.27f, 0.00f, 1.0f},
    .noticeBackground = {0.99f, 0.92f, 0.72f, 1.0f},
    .frame = {0.86f, 0.87f, 0.89f, 1.0f},
    .grid = {0.76f, 0.78f, 0.81f, 1.0f},
    .histogram = {0.66f, 0.69f, 0.73f, 1.0f},
};
const Palette* current = &kDark;  // as ImGui's own style: one at a time

void setDark(ImVec4* colors) {
  ImGui::StyleColorsDark();
  colors[ImGuiCol_Text] = kTextOnPicture;
  colors[ImGuiCol_ChildBg] = {0.098f, 0.108f, 0.125f, 1.0f};
  colors[ImGuiCol_PopupBg] = {0.13f, 0.145f, 0.165f, 1.0f};
  colors[ImGuiCol_Border] = {0.20f, 0.22f, 0.25f, 1.0f};
  colors[ImGuiCol_FrameBg] = {0.165f, 0.18f, 0.205f, 1.0f};
  colors[ImGuiCol_FrameBgHovered] = {0.21f, 0.23f, 0.26f, 1.0f};
  colors[ImGuiCol_FrameBgActive] = {0.24f, 0.27f, 0.30f, 1.0f};
  colors[ImGuiCol_Button] = {0.20f, 0.22f, 0.25f, 1.0f};
  colors[ImGuiCol_ButtonHovered] = {0.24f, 0.36f, 0.40f, 1.0f};
  colors[ImGuiCol_ButtonActive] = {0.24f, 0.48f, 0.53f, 1.0f};
  colors[ImGuiCol_Header] = {0.20f, 0.34f, 0.38f, 1.0f};
  colors[ImGuiCol_HeaderHovered] = {0.23f, 0.42f, 0.47f, 1.0f};
  colors[ImGuiCol_HeaderActive] = {0.25f, 0.50f, 0.56f, 1.0f};
  colors[ImGuiCol_TitleBgActive] = {0.14f, 0.26f, 0.29f, 1.0f};
  colors[ImGuiCol_SliderGrab] = {0.22f, 0.47f, 0.52f, 0.75f};  // the value stands on it
  colors[ImGuiCol_SliderGrabActive] = {0.26f, 0.60f, 0.66f, 1.0f};
  colors[ImGuiCol_TextSelectedBg] = {0.20f, 0.45f, 0.50f, 1.0f};
}

void setLight(ImVec4* colors) {
  ImGui::StyleColorsLight();
  colors[ImGuiCol_Text] = {0.10f, 0.11f, 0.13f, 1.0f};
  colors[ImGuiCol_ChildBg] = {0.945f, 0.95f, 0.957f, 1.0f};
  colors[ImGuiCol_PopupBg] = {0.98f, 0.983f, 0.987f, 1.0f};
  colors[ImGuiCol_Border] = {0.74f, 0.76f, 0.79f, 1.0f};
  colors[ImGuiCol_FrameBg] = {0.855f, 0.865f, 0.88f, 1.0f};
  colors[ImGuiCol_FrameBgHovered] = {0.82f, 0.835f, 0.85f, 1.0f};
  colors[ImGuiCol_FrameBgActive] = {0.78f, 0.80f, 0.82f, 1.0f};
  colors[ImGuiCol_Button] = {0.83f, 0.845f, 0.865f, 1.0f};
  colors[ImGuiCol_ButtonHovered] = {0.72f, 0.84f, 0.87f, 1.0f};
  colors[ImGuiCol_ButtonActive] = {0.60f, 0.79f, 0.83f, 1.0f};
  colors[ImGuiCol_Header] = {0.74f, 0.86f, 0.89f, 1.0f};
  colors[ImGuiCol_HeaderHovered] = {0.68f, 0.83f, 0.86f, 1.0f};
  colors[ImGuiCol_HeaderActive] = {0.60f, 0.79f, 0.83f, 1.0f};
  colors[ImGuiCol_TitleBgActive] = {0.74f, 0.86f, 0.89f, 1.0f};
  colors[ImGuiCol_SliderGrab] = {0.52f, 0.74f, 0.78f, 0.75f};
  colors[ImGuiCol_SliderGrabActive] = {0.42f, 0.68f, 0.73f, 1.0f};
  colors[ImGuiCol_TextSelectedBg] = {0.62f, 0.82f, 0.87f, 1.0f};
}

void setSpacing(ImGuiStyle& style) {
  style.WindowPadding = {10.0f, 10.0f};
  style.FramePadding = {7.0f, 4.0f};
  style.ItemSpacing = {8.0f, 5.0f};
  style.ItemInnerSpacing = {6.0f, 4.0f};
  style.ScrollbarSize = 10.0f;
  style.GrabMinSize = 6.0f;
  style.WindowRounding = 0.0f;
  style.ChildRounding = 5.0f;
  style.FrameRounding = 4.0f;
  style.GrabRounding = 3.0f;
  style.PopupRounding = 4.0f;
  style.ScrollbarRounding = 5.0f;
  style.WindowBorderSize = 0.0f;
  style.ChildBorderSize = 1.0f;
  style.PopupBorderSize = 1.0f;
}

ImFont* addFont(float heightPx) {
  // Latin, Greek-free; dashes, ellipsis, arrows and the multiplication sign.
  static constexpr ImWchar kRanges[] = {0x20, 0xff, 0x2010, 0x2027, 0x2190, 0x2193, 0x2212, 0x2212, 0};
  ImFontConfig config;
  config.FontDataOwnedByAtlas = false;
  config.OversampleH = 2;
  config.PixelSnapH = false;
  const std::string_view file = fontFile();
  return ImGui::GetIO().Fonts->AddFontFromMemoryTTF(const_cast<char*>(file.data()), static_cast<int>(file.size()),
                                                    std::round(heightPx), &config, kRanges);
}

}  // namespace

const Palette& palette() { return *current; }

void applyColors(Theme theme) {
  current = theme == Theme::dark ? &kDark : &kLight;
  ImVec4* const colors = ImGui::GetStyle().Colors;
  if (theme == Theme::dark)
    setDark(colors);
  else
    setLight(colors);
  colors[ImGuiCol_TextDisabled] = current->dimText;
  colors[ImGuiCol_WindowBg] = current->frame;
  colors[ImGuiCol_TitleBg] = colors[ImGuiCol_TitleBgCollapsed] = colors[ImGuiCol_TitleBgActive];
  colors[ImGuiCol_MenuBarBg] = colors[ImGuiCol_ChildBg];
  colors[ImGuiCol_CheckMark] = colors[ImGuiCol_PlotHistogram] = current->accent;
  colors[ImGuiCol_Separator] = colors[ImGuiCol_Border];
  colors[ImGuiCol_ScrollbarBg] = {0.0f, 0.0f, 0.0f, 0.0f};
}

Fonts applySizes(float scale, float pixelsPerUnit) {
  ImGuiStyle style;
  setSpacing(style);
  style.ScaleAllSizes(scale);
  std::copy(std::begin(ImGui::GetStyle().Colors), std::end(ImGui::GetStyle().Colors), std::begin(style.Colors));
  ImGui::GetStyle() = style;

  ImGuiIO& io = ImGui::GetIO();
  io.Fonts->Clear();
  const Fonts fonts{addFont(kBodyPx * scale * pixelsPerUnit), addFont(kSmallPx * scale * pixelsPerUnit)};
  io.FontGlobalScale = 1.0f / pixelsPerUnit;
  return fonts;
}

}  // namespace warpscope::ui
