// One panel.
// See parts.h.
#include <algorithm>
#include <cmath>

#include "app/picture/content.h"
#include "app/scene/orbit.h"
#include "app/ui/knob_parts.h"
#include "app/ui/parts.h"
#include "render/base/formatted.h"

namespace warpscope::ui {
namespace {

constexpr float kContentPx = 96.0f;  // at scale 1

void drawTechniqueChoice(Session& session, size_t index, const Look& look) {
  const WarpDescriptor& technique = *session.panel(index).technique;
  const float buttonRoom = look.px(kContentPx) + ImGui::GetStyle().ItemSpacing.x;
  ImGui::SetNextItemWidth(std::min(look.px(170.0f), std::max(look.px(40.0f), ImGui::GetContentRegionAvail().x - buttonRoom)));
  const Panel& panel = session.panel(index);
  const std::string shown = (panel.isAutomatic ? "Auto: " : "") + std::string(technique.label);
  const bool isOpen = ImGui::BeginCombo("##technique", shown.c_str());
  if (!isOpen) {
    const std::string explanation = panel.isAutomatic && !panel.choiceText.empty() ? panel.choiceText : std::string(technique.summary);
    tooltip(explanation + ".\nKeys 1 to " + std::to_string(warpRegistry().size()) + " choose a technique for the panel under the pointer, 0 lets it choose by itself.", look);
  }
  if (!isOpen) return;
  if (ImGui::Selectable("0  Auto", panel.isAutomatic)) session.setAutomatic(index);
  tooltip("What has the least error at this angle within the budget: of a sweep (view --front, or dropped onto the window), or of what was on show so far", look);
  for (const WarpDescriptor& choice : warpRegistry()) {
    const std::string label = std::to_string(&choice - warpRegistry().data() + 1) + "  " + std::string(choice.label);
    if (ImGui::Selectable(label.c_str(), !panel.isAutomatic && &choice == &technique)) session.setTechnique(index, choice);
    tooltip(std::string(choice.summary), look);
  }
  ImGui::EndCombo();
}

/// What the panel shows: its picture, or what is wrong with it, or what its pixels are made of.
void drawContentChoice(Session& session, size_t index, const Look& look) {
  const Panel& panel = session.panel(index);
  const ContentDescriptor& shown = describe(panel.content);
  ImGui::SameLine();
  ImGui::SetNextItemWidth(look.px(kContentPx));
  const bool isOpen = ImGui::BeginCombo("##content", std::string(shown.label).c_str());
  if (!isOpen) {
    tooltip(std::string(shown.help) + ".\nKey H goes back and forth between the picture and what was shown in its place last.", look);
    return;
  }
  for (const ContentDescriptor& choice : pictureContents()) {
    if (ImGui::Selectable(std::string(choice.label).c_str(), choice.value == panel.content)) session.setContent(index, choice.value);
    tooltip(std::string(choice.help), look);
  }
  if (!shown.unit.empty()) {
    ImGui::Separator();
    float range = panel.contentRange.value_or(panel.hasContentOnShow() ? panel.shownContent.high : shown.usualRange.value_or(1.0f));
    const float before = range, most = shown.unit == "1" ? 1.0f : std::max(1000.0f, 2.0f * range);
    bareSlider("range", range, {1e-3f, most, "up to %.3g", true}, "What the brightest colour stands for. Choosing the content again takes the usual range.", look);
    if (range != before) session.setContent(index, panel.content, range);
  }
  ImGui::EndCombo();
}

/// What the technique has for each panel by itself.
void drawPanelKnobs(Session& session, size_t index, const Look& look) {
  LiveSettings knobs = session.knobs();
  bool isChanged = false;
  const std::span<const Knob* const> all = session.panel(index).technique->knobs;
  auto left = static_cast<float>(std::ranges::count_if(all, &Knob::isOfPanel));  // that share the room
  for (const Knob* knob : all) {
    if (!knob->isOfPanel) continue;
    ImGui::SameLine();
    const float room = (ImGui::GetContentRegionAvail().x - (left - 1.0f) * ImGui::GetStyle().ItemSpacing.x) / left;
    ImGui::SetNextItemWidth(std::clamp(room, look.px(30.0f), look.px(96.0f)));
    left -= 1.0f;
    double value = knobs.panelKnobs[index][*knob];
    if (!bareKnobWidget(*knob, value, look)) continue;
    knobs.panelKnobs[index].set(*knob, value);
    isChanged = true;
  }
  if (isChanged) session.setKnobs(knobs);
}

/// For a panel that chooses by itself: how long a picture may take.
void drawBudget(Session& session, const Look& look) {
  ImGui::SameLine();
  ImGui::SetNextItemWidth(std::min(look.px(110.0f), std::max(look.px(30.0f), ImGui::GetContentRegionAvail().x)));
  LiveSettings knobs = session.knobs();
  float budgetMs = static_cast<float>(knobs.budgetMs);
  bareSlider("budget", budgetMs, {1.0f, 1000.0f, "%.0f ms", true}, "Budget: milliseconds that a new frame's picture may take (decoding, building, drawing).", look);
  if (budgetMs == static_cast<float>(knobs.budgetMs)) return;
  knobs.budgetMs = budgetMs;
  session.setKnobs(knobs);
}

/// The content's ramp and what its ends stand for, in the lower left corner of the picture; or, while there is none, when there will be one, or why not.
void drawContentLegend(const Panel& panel, const ImVec2& origin, const ImVec2& area, const Look& look) {
  const ContentDescriptor& content = describe(panel.content);
  const PanelContent& shown = panel.shownContent;
  const bool isOnShow = panel.hasContentOnShow(), hasRamp = isOnShow && shown.hasRamp;
  const bool isRefused = panel.errorsAreCurrent && shown.what == panel.content && !shown.refusal.empty();
  const std::string unit = content.unit == "1" ? "" : " " + std::string(content.unit);
  const std::string low = isRefused  ? shown.refusal
                          : !isOnShow ? std::string(content.label) + " when the view rests"
                          : hasRamp   ? std::string(content.label) + formatted(" %.3g", static_cast<double>(shown.low))
                                      : std::string(content.label);
  const std::string high = hasRamp ? formatted("%.3g", static_cast<double>(shown.high)) + unit : "";
  ImDrawList* list = ImGui::GetWindowDrawList();
  ImGui::PushFont(look.fonts.small);
  const float line = ImGui::GetTextLineHeight(), margin = look.px(6.0f), gap = look.px(5.0f);
  const float lowWidth = ImGui::CalcTextSize(low.c_str()).x, barWidth = look.px(90.0f);
  const float width = lowWidth + (hasRamp ? barWidth + 2.0f * gap + ImGui::CalcTextSize(high.c_str()).x : 0.0f);
  ImVec2 at{origin.x + 2.0f * margin, origin.y + area.y - line - 2.0f * margin};
  list->AddRectFilled({at.x - margin, at.y - 0.5f * margin}, {at.x + width + margin, at.y + line + 0.5f * margin},
                      ImGui::GetColorU32({0.0f, 0.0f, 0.0f, 0.7f}), look.px(3.0f));
  list->AddText(at, ImGui::GetColorU32(isOnShow ? ImGui::GetStyleColorVec4(ImGuiCol_Text) : kDimText), low.c_str());
  if (hasRamp) {
    constexpr int kPieces = 45;
    at.x += lowWidth + gap;
    const float top = at.y + 0.5f * line - look.px(4.0f), bottom = top + look.px(8.0f), piece = barWidth / kPieces;
    for (int i = 0; i < kPieces; ++i)
      list->AddRectFilled({at.x + piece * static_cast<float>(i), top}, {at.x + piece * static_cast<float>(i + 1), bottom},
                          rampColor(panel.content, (static_cast<float>(i) + 0.5f) / kPieces));
    list->AddRect({at.x, top}, {at.x + barWidth, bottom}, ImGui::GetColorU32(kFaintText));
    list->AddText({at.x + barWidth + gap, at.y}, ImGui::GetColorU32(ImGuiCol_Text), high.c_str());
  }
  ImGui::PopFont();
}

/// Lets the pointer move the camera. The item drawn last is the picture's area.
void steer(Session& session, const ImVec2& area, const Look& look) {
  const Scene* scene = session.scene();
  if (scene == nullptr) return;
  const ImGuiIO& io = ImGui::GetIO();
  View view = session.view();
  // Where frames of the display are far apart, the one in which the button goes down also holds the pointer's way to the picture.
  if (ImGui::IsItemActive() && !ImGui::IsItemActivated()) {
    const glm::dvec2 drag(io.MouseDelta.x / area.y, io.MouseDelta.y / area.y);
    if (ImGui::IsMouseDown(ImGuiMouseButton_Left)) view = orbited(view, drag);
    if (ImGui::IsMouseDown(ImGuiMouseButton_Right) || ImGui::IsMouseDown(ImGuiMouseButton_Middle))
      view = panned(view, scene->fovYDeg, area.x / area.y, drag);
  }
  if (ImGui::IsItemHovered()) {
    if (io.MouseWheel != 0.0f) view = zoomed(view, io.MouseWheel);
    if (look.isDoubleClicked) view = scene->views.front();
  }
  session.setView(view);
}

/// Draws the picture in the middle of the area: pixel on pixels if it was made for this size, else fitted.
void drawPicture(const Session& session, const Panel& panel, PictureTexture& texture, const ImVec2& origin, const ImVec2& area,
                 const Look& look) {
  const ShownPicture& picture = panel.hasContentOnShow() ? panel.shownContent.picture : panel.picture;
  texture.show(picture);
  const float pictureWidth = static_cast<float>(picture.width()), pictureHeight = static_cast<float>(picture.height());
  float zoom = static_cast<float>(session.screenPixels()) / look.pixelsPerUnit;
  const bool isExact = glm::uvec2(picture.width(), picture.height()) == session.pictureSize();
  if (!isExact) zoom = std::min(area.x / pictureWidth, area.y / pictureHeight);
  texture.setSmooth(!isExact);
  const auto snapped = [&](float value) { return std::floor(value * look.pixelsPerUnit) / look.pixelsPerUnit; };
  const ImVec2 from{snapped(origin.x + 0.5f * (area.x - zoom * pictureWidth)),
                    snapped(origin.y + 0.5f * (area.y - zoom * pictureHeight))};
  ImGui::GetWindowDrawList()->AddImage(reinterpret_cast<ImTextureID>(static_cast<uintptr_t>(texture.name())), from,
                                       {from.x + zoom * pictureWidth, from.y + zoom * pictureHeight});
}

/// What the picture is if it is not the technique's, and what its frame was marched without; empty for most.
std::string reservations(const Panel& panel) {
  std::string text = panel.shortcut;
  if (!panel.lack.empty()) text += (text.empty() ? "" : "; ") + panel.lack;
  if (!panel.leftOut.empty()) text += (text.empty() ? "moving: " : "; moving: ") + panel.leftOut;
  return text;
}

/// In the upper left corner of the picture.
void drawReservations(const std::string& text, const ImVec2& origin, const Look& look) {
  ImDrawList* list = ImGui::GetWindowDrawList();
  ImGui::PushFont(look.fonts.small);
  const float margin = look.px(6.0f);
  const ImVec2 size = ImGui::CalcTextSize(text.c_str()), at{origin.x + 2.0f * margin, origin.y + 1.5f * margin};
  list->AddRectFilled({at.x - margin, at.y - 0.5f * margin}, {at.x + size.x + margin, at.y + size.y + 0.5f * margin},
                      ImGui::GetColorU32({0.0f, 0.0f, 0.0f, 0.7f}), look.px(3.0f));
  list->AddText(at, ImGui::GetColorU32(kDimText), text.c_str());
  ImGui::PopFont();
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
  drawContentChoice(session, index, look);
  drawPanelKnobs(session, index, look);
  if (session.panel(index).isAutomatic) drawBudget(session, look);

  ImVec2 area = ImGui::GetContentRegionAvail();
  const float strip = measurementsHeight(area.x, look) + look.px(kTimelinePx) + ImGui::GetStyle().ItemSpacing.y;
  area.x = std::max(area.x, look.px(16.0f));
  area.y = std::max(area.y - strip - ImGui::GetStyle().ItemSpacing.y, look.px(16.0f));
  session.setPanelSize(glm::uvec2(area.x * look.pixelsPerUnit, area.y * look.pixelsPerUnit));
  const ImVec2 origin = ImGui::GetCursorScreenPos();
  const ImVec2 end{origin.x + area.x, origin.y + area.y};
  ImGui::InvisibleButton("picture", area,
                         ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight | ImGuiButtonFlags_MouseButtonMiddle);
  steer(session, area, look);

  const Panel& panel = session.panel(index);
  ImDrawList* list = ImGui::GetWindowDrawList();
  list->PushClipRect(origin, end, true);
  list->AddRectFilled(origin, end, IM_COL32(0, 0, 0, 255));
  if (panel.picture) drawPicture(session, panel, texture, origin, area, look);
  if (!panel.error.empty())
    drawNote(panel.error, kErrorText, origin, area, look);
  else if (!panel.picture && session.scene() != nullptr)
    drawNote(panel.technique->usesFrame && !session.frames().newest() ? "waiting for the first frame" : "drawing", kDimText, origin, area, look);
  else if (!panel.picture && !session.loading().empty())
    drawNote("opening " + session.loading(), kDimText, origin, area, look);
  const std::string reserved = reservations(panel);
  if (panel.picture && !reserved.empty()) drawReservations(reserved, origin, look);
  if (panel.picture && panel.content != PictureContent::picture) drawContentLegend(panel, origin, area, look);
  list->PopClipRect();

  drawTimeline(panel, look);
  drawMeasurements(session, index, look);
  return ImGui::IsWindowHovered(ImGuiHoveredFlags_ChildWindows | ImGuiHoveredFlags_AllowWhenBlockedByActiveItem);
}

}  // namespace warpscope::ui
