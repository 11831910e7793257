// Buttons, a track with a tick for each frame, figures.
// See playback_bar.h.
#include "app/ui/playback_bar.h"

#include <algorithm>
#include <cmath>

#include "app/ui/knob_parts.h"
#include "render/base/formatted.h"

namespace warpscope::ui {
namespace {

constexpr float kBarPx = 34.0f, kPaddingPx = 4.0f, kPaddingXPx = 7.0f, kPaddingYPx = 3.0f, kFiguresPx = 186.0f, kSpeedPx = 64.0f, kLeastTrackPx = 120.0f;  // at scale 1

enum class Icon { play, pause, back, on };

/// A button as high as the bar; true when it was pressed.
bool iconButton(Icon icon, const char* id, Action action, const Look& look) {
  const float side = ImGui::GetFrameHeight(), r = 0.24f * side;
  const ImVec2 at = ImGui::GetCursorScreenPos(), c{at.x + 0.5f * side, at.y + 0.5f * side};
  const bool isPressed = ImGui::Button(id, {side, side});
  ImDrawList* list = ImGui::GetWindowDrawList();
  const ImU32 color = ImGui::GetColorU32(ImGuiCol_Text);
  const float bar = 0.5f * r;
  switch (icon) {
    case Icon::play: list->AddTriangleFilled({c.x - 0.8f * r, c.y - r}, {c.x - 0.8f * r, c.y + r}, {c.x + r, c.y}, color); break;
    case Icon::pause:
      list->AddRectFilled({c.x - r, c.y - r}, {c.x - r + 1.4f * bar, c.y + r}, color);
      list->AddRectFilled({c.x + r - 1.4f * bar, c.y - r}, {c.x + r, c.y + r}, color);
      break;
    case Icon::back:
      list->AddTriangleFilled({c.x + r, c.y - r}, {c.x + r, c.y + r}, {c.x - 0.4f * r, c.y}, color);
      list->AddRectFilled({c.x - r, c.y - r}, {c.x - r + bar, c.y + r}, color);
      break;
    case Icon::on:
      list->AddTriangleFilled({c.x - r, c.y - r}, {c.x - r, c.y + r}, {c.x + 0.4f * r, c.y}, color);
      list->AddRectFilled({c.x + r - bar, c.y - r}, {c.x + r, c.y + r}, color);
      break;
  }
  tooltip(action, look);
  return isPressed;
}

/// Time from left to right; a drag or a click on it seeks.
void drawTrack(LivePlayback& playback, float width, const Look& look) {
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float height = ImGui::GetFrameHeight();
  ImGui::InvisibleButton("track", {width, height});
  const double first = playback.firstSeconds(), length = std::max(1e-9, playback.lastSeconds() - first);
  if (ImGui::IsItemActive()) {
    playback.setPlaying(false);
    playback.seek(first + length * static_cast<double>((ImGui::GetIO().MousePos.x - at.x) / width));
  }
  tooltip("When frames came, and what is on show of them. Drag to seek.", look);
  ImDrawList* list = ImGui::GetWindowDrawList();
  const float middle = at.y + 0.5f * height, half = look.px(3.0f);
  const auto placeOf = [&](double seconds) { return at.x + width * static_cast<float>((seconds - first) / length); };
  const float now = placeOf(playback.seconds());
  list->AddRectFilled({at.x, middle - half}, {at.x + width, middle + half}, ImGui::GetColorU32(ImGuiCol_FrameBg), half);
  list->AddRectFilled({at.x, middle - half}, {now, middle + half}, ImGui::GetColorU32(ImGuiCol_SliderGrab), half);
  // No more ticks than pixels.
  float last = -1.0f;
  for (const Recording::Frame& frame : playback.recording().frames) {
    const float x = std::round(placeOf(frame.seconds));
    if (x < last + look.px(2.0f)) continue;
    last = x;
    list->AddLine({x, middle + half}, {x, middle + half + look.px(4.0f)}, ImGui::GetColorU32(ImGuiCol_TextDisabled));
  }
  list->AddCircleFilled({now, middle}, look.px(6.0f), ImGui::GetColorU32(ImGuiCol_Text));
}

constexpr const char *kLoop = "Loop", *kCamera = "Recorded camera", *kExport = "Export";

/// What stands beside the track, or beneath it where a row has no room for both.
struct Widths {
  float figures, speed, loop, camera, exporting, buttons;
  float all() const { return figures + speed + loop + camera + exporting + buttons; }
};

Widths widthsOf(const Look& look) {
  const float spacing = ImGui::GetStyle().ItemSpacing.x, side = ImGui::GetTextLineHeight() + look.px(2.0f * kPaddingYPx);
  const auto boxWidth = [&](const char* text) { return side + ImGui::GetStyle().ItemInnerSpacing.x + ImGui::CalcTextSize(text).x + spacing; };
  const float exporting = look.px(2.0f * kPaddingXPx) + std::max(ImGui::CalcTextSize(kExport).x, ImGui::CalcTextSize("Cancel, 100 %, 59:59 left").x) + spacing;
  return {look.px(kFiguresPx) + spacing, look.px(kSpeedPx) + spacing, boxWidth(kLoop), boxWidth(kCamera), exporting, 3.0f * side + 2.0f * look.px(4.0f) + spacing};
}

bool hasTwoRows(float width, const Look& look) { return width - look.px(4.0f * kPaddingPx) - widthsOf(look).all() < look.px(kLeastTrackPx); }

void drawFigures(const LivePlayback& playback, float width, const Look& look) {
  const float left = ImGui::GetCursorPosX();
  const size_t count = playback.recording().frames.size();
  const std::string text = formatted("%.2f of ", playback.seconds()) + formatted("%.2f s", playback.lastSeconds()) +
                           (count > 0 ? ", frame " + std::to_string(playback.frame() + 1) + " of " + std::to_string(count) : std::string(", no frames"));
  ImGui::PushFont(look.fonts.small);
  ImGui::AlignTextToFramePadding();
  ImGui::TextColored(palette().dimText, "%s", text.c_str());
  ImGui::PopFont();
  ImGui::SameLine(left + width);
}

/// True when it was pressed.
bool drawExport(const ReplayExport& exporting, const Look& look) {
  std::string text(kExport);
  if (exporting.isAtWork()) {
    text = "Cancel, " + std::to_string(100 * exporting.begun() / exporting.steps()) + " %";
    if (exporting.isFilming()) text = "Cancel, making the film";
    if (const std::optional<double> left = exporting.secondsLeft(); left && *left < 3600.0) {
      const int seconds = static_cast<int>(std::ceil(*left));
      text += ", " + std::to_string(seconds / 60) + formatted(":%02.0f left", static_cast<double>(seconds % 60));
    }
  }
  ImGui::SameLine();
  const bool isPressed = ImGui::Button((text + "###export").c_str());
  tooltip(Action::exportFilm, look);
  return isPressed;
}

void drawOptions(LivePlayback& playback, const Look& look) {
  ImGui::SetNextItemWidth(look.px(kSpeedPx));
  auto times = static_cast<float>(playback.speed());
  bareSlider("speed", times, {static_cast<float>(kPlaybackSpeedRange.lowest), static_cast<float>(kPlaybackSpeedRange.highest), "%.1f ×", true}, "How fast, times the speed at which it was recorded.", look);
  playback.setSpeed(times);
  ImGui::SameLine();
  bool isLooping = playback.isLooping();
  if (ImGui::Checkbox(kLoop, &isLooping)) playback.setLooping(isLooping);
  tooltip("From the end on at the beginning.", look);
  ImGui::SameLine();
  bool follows = playback.followsCamera();
  if (ImGui::Checkbox(kCamera, &follows)) playback.setFollowsCamera(follows);
  tooltip("The camera as it was moved then. Who drags a picture has it for himself until this is switched on again: frames come as they were recorded.", look);
}

}  // namespace

float playbackHeight(const Session& session, float width, const Look& look) {
  if (!session.playback().isOpen()) return 0.0f;
  return look.px(hasTwoRows(width, look) ? 2.0f * kBarPx - kPaddingPx : kBarPx) + ImGui::GetStyle().ItemSpacing.y;
}

bool drawPlayback(Session& session, float width, const Look& look) {
  LivePlayback& playback = session.playback();
  if (!playback.isOpen()) return false;
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {look.px(2.0f * kPaddingPx), look.px(kPaddingPx)});
  ImGui::BeginChild("playback", {0.0f, playbackHeight(session, width, look) - ImGui::GetStyle().ItemSpacing.y}, true, ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse);
  ImGui::PopStyleVar();
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {look.px(kPaddingXPx), look.px(kPaddingYPx)});
  const float gap = look.px(4.0f);
  const bool isTwoRows = hasTwoRows(width, look);
  const Widths widths = widthsOf(look);
  if (iconButton(playback.isPlaying() ? Icon::pause : Icon::play, "##play", Action::play, look)) playback.setPlaying(!playback.isPlaying());
  ImGui::SameLine(0.0f, gap);
  if (iconButton(Icon::back, "##back", Action::stepBack, look)) playback.step(-1);
  ImGui::SameLine(0.0f, gap);
  if (iconButton(Icon::on, "##on", Action::stepOn, look)) playback.step(1);
  ImGui::SameLine();
  drawTrack(playback, std::max(look.px(20.0f), ImGui::GetContentRegionAvail().x - (isTwoRows ? 0.0f : widths.all() - widths.buttons)), look);
  if (!isTwoRows) ImGui::SameLine();
  drawFigures(playback, widths.figures, look);
  drawOptions(playback, look);
  const bool wantsExport = drawExport(session.exporting(), look);
  ImGui::PopStyleVar();
  ImGui::EndChild();
  return wantsExport;
}

}  // namespace warpscope::ui
