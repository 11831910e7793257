// One panel.
// See parts.h.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "app/orbit.h"
#include "app/ui/parts.h"

namespace warpscope::ui {
namespace {

struct Measurement {
  const char* name;
  std::string value;
  bool isCurrent;
  const char* explanation;
};

std::string holesText(double fraction) {
  char text[32];
  std::snprintf(text, sizeof text, fraction < 0.0995 ? "%.2f %%" : "%.1f %%", 100.0 * fraction);
  return text;
}

std::array<Measurement, 4> measurementsOf(const Session& session, size_t index, Session::TimePoint now) {
  const Panel& panel = session.panel(index);
  const bool usesFrame = panel.drawn != nullptr && panel.drawn->usesFrame;
  const std::optional<double> age = session.ageMs(index, now);
  const std::string none = "–";
  return {{
      {"build", usesFrame ? durationText(panel.buildMs) : none, true,
       "Time to derive from a frame what drawing needs (a hierarchy, a vertex buffer), once for each frame."},
      {"draw", panel.picture ? durationText(panel.drawMs) : none, true,
       "Time from the camera to finished colours, for each picture."},
      {"age", age ? durationText(*age) : none, true,
       "For how long the camera of the frame on show has not been the current one any more; 0 while it is."},
      {"holes", usesFrame && panel.holeFraction ? holesText(*panel.holeFraction) : none, panel.holesAreCurrent,
       "Pixels that no sample covers although the reference shows something there. Counted when the camera rests; grey while it is "
       "an earlier camera's."},
  }};
}

void drawMeasurements(const Session& session, size_t index, const Look& look) {
  const float width = ImGui::GetContentRegionAvail().x;
  const auto measurements = measurementsOf(session, index, look.now);
  const ImVec2 origin = ImGui::GetCursorScreenPos();
  const float column = width / static_cast<float>(measurements.size());
  const float labelHeight = look.px(kSmallPx + 3.0f);
  for (size_t i = 0; i < measurements.size(); ++i) {
    const Measurement& measurement = measurements[i];
    ImGui::SetCursorScreenPos({origin.x + column * static_cast<float>(i), origin.y});
    ImGui::BeginGroup();
    ImGui::PushFont(look.fonts.small);
    ImGui::TextColored(kDimText, "%s", measurement.name);
    ImGui::PopFont();
    ImGui::SetCursorScreenPos({origin.x + column * static_cast<float>(i), origin.y + labelHeight});
    if (measurement.isCurrent)
      ImGui::TextUnformatted(measurement.value.c_str());
    else
      ImGui::TextColored(kFaintText, "%s", measurement.value.c_str());
    ImGui::EndGroup();
    tooltip(measurement.explanation, look);
  }
}

void drawTechniqueChoice(Session& session, size_t index, const Look& look) {
  const WarpDescriptor& technique = *session.panel(index).technique;
  ImGui::SetNextItemWidth(std::min(look.px(170.0f), ImGui::GetContentRegionAvail().x));
  const bool isOpen = ImGui::BeginCombo("##technique", std::string(technique.label).c_str());
  if (!isOpen) tooltip(std::string(technique.summary) + ".\nKeys 1 to 9 choose a technique for the panel under the pointer.", look);
  if (!isOpen) return;
  for (const WarpDescriptor& choice : warpRegistry()) {
    const std::string label = std::to_string(&choice - warpRegistry().data() + 1) + "  " + std::string(choice.label);
    if (ImGui::Selectable(label.c_str(), &choice == &technique)) session.setTechnique(index, choice);
    tooltip(std::string(choice.summary), look);
  }
  ImGui::EndCombo();
}

/// Lets the pointer move the camera. The item drawn last is the picture's area.
void steer(Session& session, const ImVec2& area) {
  const Scene* scene = session.scene();
  if (scene == nullptr) return;
  const ImGuiIO& io = ImGui::GetIO();
  View view = session.view();
  if (ImGui::IsItemActive()) {
    const glm::dvec2 drag(io.MouseDelta.x / area.y, io.MouseDelta.y / area.y);
    if (ImGui::IsMouseDown(ImGuiMouseButton_Left)) view = orbited(view, drag);
    if (ImGui::IsMouseDown(ImGuiMouseButton_Right) || ImGui::IsMouseDown(ImGuiMouseButton_Middle))
      view = panned(view, scene->fovYDeg, area.x / area.y, drag);
  }
  if (ImGui::IsItemHovered()) {
    if (io.MouseWheel != 0.0f) view = zoomed(view, io.MouseWheel);
    if (ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left)) view = scene->views.front();
  }
  session.setView(view);
}

/// Draws the picture in the middle of the area: pixel on pixels if it was made for this size, else fitted.
void drawPicture(const Session& session, const Panel& panel, PictureTexture& texture, const ImVec2& origin, const ImVec2& area,
                 const Look& look) {
  texture.show(panel.picture);
  const float pictureWidth = static_cast<float>(panel.picture.width()), pictureHeight = static_cast<float>(panel.picture.height());
  float zoom = static_cast<float>(session.screenPixels()) / look.pixelsPerUnit;
  const bool isExact = glm::uvec2(panel.picture.width(), panel.picture.height()) == session.pictureSize();
  if (!isExact) zoom = std::min(area.x / pictureWidth, area.y / pictureHeight);
  texture.setSmooth(!isExact);
  const auto snapped = [&](float value) { return std::floor(value * look.pixelsPerUnit) / look.pixelsPerUnit; };
  const ImVec2 from{snapped(origin.x + 0.5f * (area.x - zoom * pictureWidth)),
                    snapped(origin.y + 0.5f * (area.y - zoom * pictureHeight))};
  ImGui::GetWindowDrawList()->AddImage(reinterpret_cast<ImTextureID>(static_cast<uintptr_t>(texture.name())), from,
                                       {from.x + zoom * pictureWidth, from.y + zoom * pictureHeight});
}

void drawNote(const std::string& text, const ImVec4& color, const ImVec2& origin, const ImVec2& area, const Look& look) {
  const float wrap = std::max(look.px(80.0f), area.x - look.px(24.0f));
  const ImVec2 size = ImGui::CalcTextSize(text.c_str(), nullptr, false, wrap);
  const ImVec2 at{origin.x + 0.5f * (area.x - size.x), origin.y + 0.5f * (area.y - size.y)};
  ImDrawList* list = ImGui::GetWindowDrawList();
  const float margin = look.px(8.0f);
  list->AddRectFilled({at.x - margin, at.y - margin}, {at.x + size.x + margin, at.y + size.y + margin},
                      ImGui::GetColorU32({0.0f, 0.0f, 0.0f, 0.6f}), look.px(4.0f));
  list->AddText(nullptr, 0.0f, at, ImGui::GetColorU32(color), text.c_str(), nullptr, wrap);
}

}  // namespace

bool drawWarpPanel(Session& session, size_t index, PictureTexture& texture, const Look& look) {
  drawTechniqueChoice(session, index, look);

  const float strip = look.px(kSmallPx + 3.0f + kBodyPx + 6.0f + kTimelinePx) + ImGui::GetStyle().ItemSpacing.y;
  ImVec2 area = ImGui::GetContentRegionAvail();
  area.x = std::max(area.x, look.px(16.0f));
  area.y = std::max(area.y - strip - ImGui::GetStyle().ItemSpacing.y, look.px(16.0f));
  session.setPanelSize(glm::uvec2(area.x * look.pixelsPerUnit, area.y * look.pixelsPerUnit));
  const ImVec2 origin = ImGui::GetCursorScreenPos();
  const ImVec2 end{origin.x + area.x, origin.y + area.y};
  ImGui::InvisibleButton("picture", area,
                         ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight | ImGuiButtonFlags_MouseButtonMiddle);
  steer(session, area);

  const Panel& panel = session.panel(index);
  ImDrawList* list = ImGui::GetWindowDrawList();
  list->PushClipRect(origin, end, true);
  list->AddRectFilled(origin, end, IM_COL32(0, 0, 0, 255));
  if (panel.picture) drawPicture(session, panel, texture, origin, area, look);
  if (!panel.error.empty())
    drawNote(panel.error, kErrorText, origin, area, look);
  else if (!panel.picture && session.scene() != nullptr)
    drawNote(panel.technique->usesFrame && !session.frame() ? "waiting for the first frame" : "drawing", kDimText, origin, area, look);
  else if (!panel.picture && !session.loading().empty())
    drawNote("opening " + session.loading(), kDimText, origin, area, look);
  list->PopClipRect();

  drawTimeline(panel, look);
  drawMeasurements(session, index, look);
  return ImGui::IsWindowHovered(ImGuiHoveredFlags_ChildWindows | ImGuiHoveredFlags_AllowWhenBlockedByActiveItem);
}

}  // namespace warpscope::ui
