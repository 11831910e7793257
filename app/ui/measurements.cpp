// What is measured of a panel: figures in columns, and its error over the last seconds as a line.
// See parts.h.
#include <algorithm>
#include <array>
#include <cmath>

#include "app/ui/parts.h"
#include "render/base/formatted.h"

namespace warpscope::ui {
namespace {

constexpr float kColumnPx = 58.0f, kHistoryPx = 22.0f;  // at scale 1
constexpr float kFigurePx = kSmallPx + 3.0f + kBodyPx + 6.0f;

struct Measurement {
  const char* name;
  std::string value;
  bool isCurrent;
  const char* explanation;
};
using Measurements = std::array<Measurement, 8>;
/// Those that say most, where there is room for few: places in measurementsOf().
constexpr std::array<size_t, 8> kMostFirst{5, 6, 7, 1, 3, 0, 2, 4}, kMostBehindLinks{5, 6, 2, 7, 1, 3, 0, 4};

Measurements measurementsOf(const Session& session, size_t index, Session::TimePoint now) {
  const Panel& panel = session.panel(index);
  const bool usesFrame = panel.drawn != nullptr && panel.drawn->usesFrame;
  const std::optional<double> age = session.ageMs(index, now);
  const std::string none = "–";
  std::string flip = none, psnr = none, holes = none;
  // While it moves what is found of some pixels, as "about".
  const bool isMoving = !panel.errorsAreCurrent && panel.movingErrors;
  const std::optional<PictureErrors>& errors = isMoving ? panel.movingErrors : panel.errors;
  if (errors) {
    const std::string about = isMoving ? "~" : "";
    flip = about + formatted(isMoving ? "%.3f" : "%.4f", errors->flip);
    psnr = std::isfinite(errors->psnrDb) ? about + formatted(isMoving ? "%.0f dB" : "%.1f dB", errors->psnrDb) : "equal";
    const bool hasFilled = errors->filledFraction > 0.0;  // then there is less room
    holes = about + formatted(isMoving ? "%.0f" : errors->holeFraction < 0.0995 && !hasFilled ? "%.2f" : "%.1f", 100.0 * errors->holeFraction);
    if (hasFilled) holes += formatted("+%.0f", 100.0 * errors->filledFraction);
    holes += hasFilled ? "%" : " %";
  }
  const bool isCurrent = panel.errorsAreCurrent || isMoving;
  return {{
      {"build", usesFrame ? durationText(panel.buildMs) : none, true,
       "Time to derive from a frame what drawing needs (a hierarchy, a vertex buffer), once for each frame."},
      {"draw", panel.picture ? durationText(panel.drawMs) : none, true,
       "Time from the camera to finished colours, for each picture."},
      {"age", age ? durationText(*age) : none, true,
       "For how long the camera of the frame on show has not been the current one any more; 0 while it is."},
      {"bytes", usesFrame && panel.bytes ? bytesText(*panel.bytes) : none, true,
       "What the technique draws of the frame on show, on the wire: its samples or its segments, or where a picture would do, that. "
       "The frame in whole: at the bottom of the window."},
      {"copy", panel.proxyBytes > 0 ? bytesText(panel.proxyBytes) : none, true, "Bytes of the coarse copy of the volume that the technique draws, sent once."},
      {"FLIP", flip, isCurrent,
       "Mean difference from the ground truth as an eye sees it, 0 to 1; 0 is none. Found when the camera rests (where a CUDA device marches: "
       "all the time). While it moves ~: of every n-th pixel of what was on show, a few times a second. Grey while it is an earlier camera's."},
      {"PSNR", psnr, isCurrent, "Peak signal to noise ratio against the ground truth, of values as they are displayed. More is better."},
      {"holes", holes, isCurrent, "Pixels that no sample covers although the ground truth shows something there; behind the plus those that show a guess there."},
  }};
}

size_t columnsIn(float width, const Look& look) {
  return std::clamp(static_cast<size_t>(std::max(0.0f, width) / look.px(kColumnPx)), size_t{2}, std::tuple_size_v<Measurements>);
}

float figuresHeight(float width, MeasurementSpace space, const Look& look) {
  if (space == MeasurementSpace::oneLine) return look.px(kFigurePx);
  const size_t columns = columnsIn(width, look), rows = (std::tuple_size_v<Measurements> + columns - 1) / columns;
  return look.px(kFigurePx) * static_cast<float>(rows);
}

/// The least of a few round numbers that is not below.
double roundAbove(double value) {
  for (const double top : {0.02, 0.05, 0.1, 0.2, 0.5})
    if (value <= top) return top;
  return 1.0;
}

void drawHistory(const Panel& panel, const ImVec2& at, float width, const Look& look) {
  const std::vector<ErrorHistory::Step> steps = panel.history.steps(look.now);
  double highest = 0.0;
  for (const ErrorHistory::Step& step : steps) highest = std::max(highest, step.value);
  const double top = roundAbove(highest);
  const std::string name = "FLIP, 10 s", topText = formatted("%g", top);
  ImDrawList* list = ImGui::GetWindowDrawList();
  ImGui::PushFont(look.fonts.small);
  const float height = look.px(kHistoryPx), gap = look.px(6.0f), line = ImGui::GetTextLineHeight();
  const float left = at.x + ImGui::CalcTextSize(name.c_str()).x + gap, right = at.x + width - ImGui::CalcTextSize("0.05").x - gap;
  list->AddText({at.x, at.y + 0.5f * (height - line)}, ImGui::GetColorU32(palette().dimText), name.c_str());
  const bool isThere = right > left + look.px(20.0f);
  if (isThere) list->AddText({right + gap, at.y}, ImGui::GetColorU32(palette().dimText), topText.c_str());
  ImGui::PopFont();
  if (!isThere) return;
  list->AddRectFilled({left, at.y}, {right, at.y + height}, ImGui::GetColorU32(ImGuiCol_FrameBg), look.px(2.0f));
  const double span = std::chrono::duration<double>(ErrorHistory::kSpan).count();
  const float margin = look.px(2.0f), thickness = look.px(1.5f);
  const auto place = [&](double secondsAgo, double value) {
    return ImVec2(right - (right - left) * static_cast<float>(secondsAgo / span),
                  at.y + height - margin - (height - 2.0f * margin) * static_cast<float>(value / top));
  };
  const ImU32 color = ImGui::GetColorU32(palette().accent);
  for (size_t i = 0; i < steps.size(); ++i) {
    const ErrorHistory::Step& step = steps[i];
    const ImVec2 begin = place(step.beginS, step.value), end = place(step.endS, step.value);
    list->AddLine(begin, {std::max(end.x, begin.x + thickness), end.y}, step.isSparse ? ImGui::GetColorU32(palette().faintText) : color, thickness);
    if (i > 0 && steps[i - 1].endS == step.beginS) list->AddLine(place(step.beginS, steps[i - 1].value), begin, color, thickness);
  }
}

}  // namespace

float measurementsHeight(float width, MeasurementSpace space, const Look& look) {
  if (space == MeasurementSpace::none) return 0.0f;
  const float figures = figuresHeight(width, space, look);
  return space == MeasurementSpace::oneLine ? figures : figures + ImGui::GetStyle().ItemSpacing.y + look.px(kHistoryPx);
}

void drawMeasurements(const Session& session, size_t index, MeasurementSpace space, const Look& look) {
  if (space == MeasurementSpace::none) return;
  const float width = ImGui::GetContentRegionAvail().x;
  const Measurements measurements = measurementsOf(session, index, look.now);
  const ImVec2 origin = ImGui::GetCursorScreenPos();
  const size_t columns = columnsIn(width, look), count = space == MeasurementSpace::all ? measurements.size() : columns;
  const float column = width / static_cast<float>(columns);
  const float labelHeight = look.px(kSmallPx + 3.0f);
  const auto& first = session.linkSign(look.now).full.empty() ? kMostFirst : kMostBehindLinks;
  for (size_t i = 0; i < count; ++i) {
    const Measurement& measurement = measurements[space == MeasurementSpace::all ? i : first[i]];
    const ImVec2 at{origin.x + column * static_cast<float>(i % columns), origin.y + look.px(kFigurePx) * static_cast<float>(i / columns)};
    ImGui::SetCursorScreenPos(at);
    ImGui::BeginGroup();
    ImGui::PushFont(look.fonts.small);
    ImGui::TextColored(palette().dimText, "%s", measurement.name);
    ImGui::PopFont();
    ImGui::SetCursorScreenPos({at.x, at.y + labelHeight});
    if (measurement.isCurrent)
      ImGui::TextUnformatted(measurement.value.c_str());
    else
      ImGui::TextColored(palette().faintText, "%s", measurement.value.c_str());
    ImGui::EndGroup();
    tooltip(measurement.explanation, look);
  }
  if (space == MeasurementSpace::oneLine) return;
  ImGui::SetCursorScreenPos({origin.x, origin.y + figuresHeight(width, space, look) + ImGui::GetStyle().ItemSpacing.y});
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImGui::InvisibleButton("history", {width, look.px(kHistoryPx)});
  tooltip("FLIP over the last ten seconds, now at the right; gaps are times in which it was not known. Grey: while the camera moved, of some pixels.", look);
  drawHistory(session.panel(index), at, width, look);
}

}  // namespace warpscope::ui
