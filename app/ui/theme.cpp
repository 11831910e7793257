// Colours, spacing, fonts.
// See theme.h.
#include "app/ui/theme.h"

#include <cmath>
#include <string_view>

#include "app/picture/text.h"

namespace warpscope::ui {
namespace {

void setColors(ImGuiStyle& style) {
  ImGui::StyleColorsDark(&style);
  ImVec4* colors = style.Colors;
  colors[ImGuiCol_Text] = {0.89f, 0.91f, 0.93f, 1.0f};
  colors[ImGuiCol_TextDisabled] = kDimText;
  colors[ImGuiCol_WindowBg] = kFrameColor;
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
  colors[ImGuiCol_TitleBg] = colors[ImGuiCol_TitleBgActive] = colors[ImGuiCol_TitleBgCollapsed] = {0.14f, 0.26f, 0.29f, 1.0f};
  colors[ImGuiCol_MenuBarBg] = {0.098f, 0.108f, 0.125f, 1.0f};
  colors[ImGuiCol_CheckMark] = kAccent;
  colors[ImGuiCol_SliderGrab] = {0.22f, 0.47f, 0.52f, 1.0f};
  colors[ImGuiCol_SliderGrabActive] = {0.26f, 0.60f, 0.66f, 1.0f};
  colors[ImGuiCol_PlotHistogram] = kAccent;
  colors[ImGuiCol_Separator] = colors[ImGuiCol_Border];
  colors[ImGuiCol_ScrollbarBg] = {0.0f, 0.0f, 0.0f, 0.0f};
  colors[ImGuiCol_TextSelectedBg] = {0.20f, 0.45f, 0.50f, 1.0f};
}

void setSpacing(ImGuiStyle& style) {
  style.WindowPadding = {10.0f, 10.0f};
  style.FramePadding = {7.0f, 4.0f};
  style.ItemSpacing = {8.0f, 5.0f};
  style.ItemInnerSpacing = {6.0f, 4.0f};
  style.ScrollbarSize = 10.0f;
  style.GrabMinSize = 10.0f;
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

Fonts applyTheme(float scale, float pixelsPerUnit) {
  ImGuiStyle style;
  setColors(style);
  setSpacing(style);
  style.ScaleAllSizes(scale);
  ImGui::GetStyle() = style;

  ImGuiIO& io = ImGui::GetIO();
  io.Fonts->Clear();
  const Fonts fonts{addFont(kBodyPx * scale * pixelsPerUnit), addFont(kSmallPx * scale * pixelsPerUnit)};
  io.FontGlobalScale = 1.0f / pixelsPerUnit;
  return fonts;
}

}  // namespace warpscope::ui
