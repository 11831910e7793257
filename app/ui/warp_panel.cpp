// One panel.
// See warp_panel.h.
#include "app/ui/warp_panel.h"

#include <algorithm>
#include <cmath>

#include "app/picture/content.h"
#include "app/picture/pixel_report.h"
#include "app/scene/orbit.h"
#include "app/ui/panel_header.h"
#include "render/base/formatted.h"

namespace warpscope::ui {
namespace {

enum class Corner { upperLeft, upperRight, lowerLeft };

/// A rectangle of the window: the picture's area.
struct Area {
  ImVec2 from, size;
  ImVec2 to() const { return {from.x + size.x, from.y + size.y}; }
};

/// Text, and room beside it, on a dark ground in a corner of the picture; where the text begins.
ImVec2 drawInCorner(Corner corner, const Area& area, const std::string& text, const ImVec4& color, float moreWidth, const Look& look) {
  const float margin = look.px(6.0f);
  ImVec2 size = ImGui::CalcTextSize(text.c_str());
  ImVec2 at{area.from.x + 2.0f * margin, area.from.y + 1.5f * margin};
  if (corner == Corner::upperRight) at.x = area.to().x - 2.0f * margin - size.x - moreWidth;
  if (corner == Corner::lowerLeft) at.y = area.to().y - 2.0f * margin - size.y;
  ImDrawList* list = ImGui::GetWindowDrawList();
  list->AddRectFilled({at.x - margin, at.y - 0.5f * margin}, {at.x + size.x + moreWidth + margin, at.y + size.y + 0.5f * margin},
                      ImGui::GetColorU32({0.0f, 0.0f, 0.0f, 0.7f}), look.px(3.0f));
  list->AddText(at, ImGui::GetColorU32(color), text.c_str());
  return at;
}

/// The content's ramp and what its ends stand for, in the lower left corner of the picture; or, while there is none, when there will be one, or why not.
void drawContentLegend(const Panel& panel, const PixelMarks& marks, const Area& area, const Look& look) {
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
  ImGui::PushFont(look.fonts.small);
  const float line = ImGui::GetTextLineHeight(), gap = look.px(5.0f), barWidth = look.px(90.0f);
  // Colours that stand for something, in a content without a ramp.
  struct Swatch {
    Rgba8 color;
    const char* text;
  };
  std::vector<Swatch> swatches;
  if (isOnShow && panel.content == PictureContent::holes) {
    const PixelMarks shownBy = marksOfHoles(marks);
    swatches = {{shownBy.uncovered, "a hole"}, {shownBy.filled, "a guess"}};
  }
  float swatchesWidth = 0.0f;
  for (const Swatch& swatch : swatches) swatchesWidth += line + 2.0f * gap + ImGui::CalcTextSize(swatch.text).x;
  const float moreWidth = !swatches.empty() ? swatchesWidth : hasRamp ? barWidth + 2.0f * gap + ImGui::CalcTextSize(high.c_str()).x : 0.0f;
  ImVec2 at = drawInCorner(Corner::lowerLeft, area, low, isOnShow ? kTextOnPicture : kDimTextOnPicture, moreWidth, look);
  ImDrawList* list = ImGui::GetWindowDrawList();
  at.x += !swatches.empty() ? ImGui::CalcTextSize(low.c_str()).x : 0.0f;
  for (const Swatch& swatch : swatches) {
    at.x += gap;
    list->AddRectFilled({at.x, at.y + 0.15f * line}, {at.x + line, at.y + 0.85f * line}, swatch.color);
    at.x += line + gap;
    list->AddText(at, ImGui::GetColorU32(kTextOnPicture), swatch.text);
    at.x += ImGui::CalcTextSize(swatch.text).x;
  }
  if (hasRamp) {
    constexpr int kPieces = 45;
    at.x += ImGui::CalcTextSize(low.c_str()).x + gap;
    const float top = at.y + 0.5f * line - look.px(4.0f), bottom = top + look.px(8.0f), piece = barWidth / kPieces;
    for (int i = 0; i < kPieces; ++i)
      list->AddRectFilled({at.x + piece * static_cast<float>(i), top}, {at.x + piece * static_cast<float>(i + 1), bottom},
                          rampColor(panel.content, (static_cast<float>(i) + 0.5f) / kPieces));
    list->AddRect({at.x, top}, {at.x + barWidth, bottom}, ImGui::GetColorU32(kDimTextOnPicture));
    list->AddText({at.x + barWidth + gap, at.y}, ImGui::GetColorU32(kTextOnPicture), high.c_str());
  }
  ImGui::PopFont();
}

/// Lets the pointer move the camera. The item drawn last is the picture's area.
void steer(Session& session, size_t index, const ImVec2& area, const Look& look) {
  const Scene* scene = session.scene();
  if (scene == nullptr) return;
  const ImGuiIO& io = ImGui::GetIO();
  View view = session.view(index);
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
  session.setView(index, view);
}

/// What lies around `inner`, filled: where the CPU draws the window, what a picture covers is not drawn twice.
void fillAround(const Area& area, const Area& inner, ImU32 color) {
  ImDrawList* list = ImGui::GetWindowDrawList();
  const auto fill = [&](const ImVec2& from, const ImVec2& to) {
    if (from.x < to.x && from.y < to.y) list->AddRectFilled(from, to, color);
  };
  const ImVec2 from{std::max(area.from.x, inner.from.x), std::max(area.from.y, inner.from.y)}, to{std::min(area.to().x, inner.to().x), std::min(area.to().y, inner.to().y)};
  fill(area.from, {area.to().x, from.y});
  fill({area.from.x, to.y}, area.to());
  fill({area.from.x, from.y}, {from.x, to.y});
  fill({to.x, from.y}, {area.to().x, to.y});
}

/// Where a picture lies: in the middle of the area, pixel on pixels if it was made for this size, else fitted.
Area placeOf(const Session& session, const ShownPicture& picture, const Area& area, const Look& look) {
  const float pictureWidth = static_cast<float>(picture.width()), pictureHeight = static_cast<float>(picture.height());
  float zoom = static_cast<float>(session.screenPixels()) / look.pixelsPerUnit;
  const bool isExact = glm::uvec2(picture.width(), picture.height()) == session.pictureSize();
  if (!isExact) zoom = std::min(area.size.x / pictureWidth, area.size.y / pictureHeight);
  const auto snapped = [&](float value) { return std::floor(value * look.pixelsPerUnit) / look.pixelsPerUnit; };
  return {{snapped(area.from.x + 0.5f * (area.size.x - zoom * pictureWidth)), snapped(area.from.y + 0.5f * (area.size.y - zoom * pictureHeight))},
          {zoom * pictureWidth, zoom * pictureHeight}};
}

/// Draws a picture there. Where it lies.
Area drawPicture(const Session& session, const ShownPicture& picture, PictureTexture& texture, const Area& area, const Look& look) {
  texture.show(picture);
  // Blending takes the CPU several times as long: what is drawn by it shows squares until there is a picture of the right size.
  texture.setSmooth(!look.gl->isDrawnByCpu && glm::uvec2(picture.width(), picture.height()) != session.pictureSize());
  const Area at = placeOf(session, picture, area, look);
  texture.draw(*ImGui::GetWindowDrawList(), at.from, at.to());
  return at;
}

/// What the picture is if it is not the technique's, and what its frame was marched without; empty for most.
std::string reservations(const Session& session, const Panel& panel) {
  std::string text = panel.shortcut;
  if (!panel.lack.empty()) {
    const bool isOnItsWay = lackOf(*panel.technique, session.knobs().march).empty();
    text += (text.empty() ? "" : "; ") + (isOnItsWay ? "the frame on show has nothing for it; one that has comes next" : panel.lack);
  }
  if (!panel.leftOut.empty()) text += (text.empty() ? "moving: " : "; moving: ") + panel.leftOut;
  return text;
}

void drawNote(const std::string& text, const ImVec4& color, const Area& area, const Look& look) {
  const float wrap = std::max(look.px(80.0f), area.size.x - look.px(24.0f));
  const ImVec2 size = ImGui::CalcTextSize(text.c_str(), nullptr, false, wrap);
  const ImVec2 at{area.from.x + 0.5f * (area.size.x - size.x), area.from.y + 0.5f * (area.size.y - size.y)};
  ImDrawList* list = ImGui::GetWindowDrawList();
  const float margin = look.px(8.0f);
  list->AddRectFilled({at.x - margin, at.y - margin}, {at.x + size.x + margin, at.y + size.y + margin},
                      ImGui::GetColorU32({0.0f, 0.0f, 0.0f, 0.6f}), look.px(4.0f));
  list->AddText(nullptr, 0.0f, at, ImGui::GetColorU32(color), text.c_str(), nullptr, wrap);
}

/// What is drawn where a picture would be; empty where there is one.
std::string whyNoPicture(const Session& session, const Panel& panel) {
  if (panel.picture) return "";
  if (session.playback().isOpen() && session.playback().recording().frames.empty() && panel.technique->usesFrame) return "the recording has no frames";
  if (session.scene() != nullptr) return panel.technique->usesFrame && !session.frames().newest() ? "waiting for the first frame" : "drawing";
  return session.loading().empty() ? "" : "opening " + session.loading();
}

/// The panel's picture, or what is chosen in its place.
const ShownPicture& ownPicture(const Panel& panel) { return panel.hasContentOnShow() ? panel.shownContent.picture : panel.picture; }

/// The same, with what is to be said about it. Where the picture lies.
std::optional<Area> drawOwn(const Session& session, const Panel& panel, PictureTexture& texture, const Area& area, const Look& look) {
  std::optional<Area> at;
  if (const ShownPicture& picture = ownPicture(panel)) at = drawPicture(session, picture, texture, area, look);
  if (!panel.error.empty())
    drawNote(panel.error, kErrorTextOnPicture, area, look);
  else if (const std::string why = whyNoPicture(session, panel); !why.empty())
    drawNote(why, kDimTextOnPicture, area, look);
  if (!at) return at;
  ImGui::PushFont(look.fonts.small);
  if (const std::string reserved = reservations(session, panel); !reserved.empty()) drawInCorner(Corner::upperLeft, area, reserved, kDimTextOnPicture, 0.0f, look);
  ImGui::PopFont();
  if (panel.content != PictureContent::picture) drawContentLegend(panel, session.knobs().marks, area, look);
  return at;
}

/// The other picture and its name; the name alone where there is none yet. Where the picture lies.
std::optional<Area> drawOther(const Session& session, const OtherPicture& other, PictureTexture& texture, const Area& area, const Look& look) {
  std::optional<Area> at;
  if (other.picture) at = drawPicture(session, other.picture, texture, area, look);
  ImGui::PushFont(look.fonts.small);
  drawInCorner(Corner::upperRight, area, other.picture ? other.name : other.name + " when the view rests", kTextOnPicture, 0.0f, look);
  ImGui::PopFont();
  return at;
}

/// The bar between two pictures, which is dragged.
void drawWipeBar(float& at, const Area& area, const Look& look) {
  const float reach = look.px(6.0f);
  const float x = area.from.x + at * area.size.x;
  const ImVec2 after = ImGui::GetCursorScreenPos();
  ImGui::SetCursorScreenPos({x - reach, area.from.y});
  ImGui::InvisibleButton("wipe", {2.0f * reach, area.size.y});
  if (ImGui::IsItemActive()) at = std::clamp((ImGui::GetIO().MousePos.x - area.from.x) / area.size.x, 0.02f, 0.98f);
  const bool isUsed = ImGui::IsItemActive() || ImGui::IsItemHovered();
  if (isUsed) ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
  ImDrawList* list = ImGui::GetWindowDrawList();
  const ImU32 color = ImGui::GetColorU32(isUsed ? palette().accent : kTextOnPicture);
  list->AddLine({x, area.from.y}, {x, area.to().y}, color, look.px(1.5f));
  list->AddCircleFilled({x, area.from.y + 0.5f * area.size.y}, look.px(5.0f), color);
  ImGui::SetCursorScreenPos(after);
}

/// A picture that is on show, for the loupe.
struct OnShow {
  Area area;
  const PictureTexture* texture = nullptr;
  glm::uvec2 size{0};
};

/// What the area holds; `other` on the right of the bar, or everywhere. The picture that lies under most of it; nothing where there is none.
std::optional<OnShow> drawPictures(const Session& session, const Panel& panel, const std::optional<OtherPicture>& other, PanelTextures& textures,
                                   const Area& area, const Look& look) {
  ImDrawList* list = ImGui::GetWindowDrawList();
  list->PushClipRect(area.from, area.to(), true);
  const ShownPicture& whole = other ? other->picture : ownPicture(panel);
  if (whole && !(other && other->wipeAt != nullptr))
    fillAround(area, placeOf(session, whole, area, look), IM_COL32_BLACK);
  else
    list->AddRectFilled(area.from, area.to(), IM_COL32_BLACK);
  std::optional<Area> own, others;
  if (!other) {
    own = drawOwn(session, panel, textures.own, area, look);
  } else if (other->wipeAt == nullptr) {
    others = drawOther(session, *other, textures.other, area, look);
  } else {
    const float x = area.from.x + *other->wipeAt * area.size.x;
    list->PushClipRect(area.from, {x, area.to().y}, true);
    own = drawOwn(session, panel, textures.own, area, look);
    ImGui::PushFont(look.fonts.small);
    if (reservations(session, panel).empty()) drawInCorner(Corner::upperLeft, area, std::string(panel.technique->label), kTextOnPicture, 0.0f, look);
    ImGui::PopFont();
    list->PopClipRect();
    list->PushClipRect({x, area.from.y}, area.to(), true);
    drawOther(session, *other, textures.other, area, look);
    list->PopClipRect();
  }
  list->PopClipRect();
  if (own) return OnShow{*own, &textures.own, {panel.picture.width(), panel.picture.height()}};
  if (others) return OnShow{*others, &textures.other, {other->picture.width(), other->picture.height()}};
  return std::nullopt;
}

constexpr int kLoupePixels = 11;                         // of the picture along each edge
constexpr float kLoupePx = 132.0f, kLoupeTextPx = 156.0f;  // at scale 1
constexpr float kLargestShare = 0.3f;                      // of the picture, that the loupe with its text covers
constexpr size_t kFewestLines = 4;                         // of text that are worth their room

/// The pixels about a place, enlarged, with a grid, in a corner that does not cover it; what is known of the pixel in its middle beside them.
void drawLoupe(const OnShow& shown, const glm::dvec2& place, std::vector<std::pair<std::string, std::string>> lines, const Area& area, const Look& look) {
  const glm::ivec2 size(shown.size);
  const glm::ivec2 pixel = glm::clamp(glm::ivec2(place * glm::dvec2(size)), glm::ivec2(0), size - 1);
  const glm::ivec2 count = glm::min(glm::ivec2(kLoupePixels), size);
  const glm::ivec2 first = glm::clamp(pixel - count / 2, glm::ivec2(0), size - count);
  const float room = std::min(area.size.x, area.size.y);
  const float besideText = std::max(look.px(0.5f * kLoupePx), area.size.x - look.px(kLoupeTextPx + 14.0f));
  const float edge = std::floor(std::min({look.px(kLoupePx), 0.4f * room, besideText}) / kLoupePixels);
  const ImVec2 loupe{edge * static_cast<float>(count.x), edge * static_cast<float>(count.y)};
  const float margin = look.px(6.0f), widthWithText = loupe.x + look.px(kLoupeTextPx);
  ImGui::PushFont(look.fonts.small);
  const float lineHeight = ImGui::GetTextLineHeight() + look.px(1.0f);
  // The picture is what is looked at: text takes little of it, or there is none.
  const float textRoom = std::min(area.size.y - 2.0f * margin, kLargestShare * area.size.x * area.size.y / widthWithText);
  const auto mostLines = static_cast<size_t>(std::max(0.0f, textRoom / lineHeight));
  const bool hasText = !lines.empty() && area.size.x >= widthWithText && mostLines >= std::min(lines.size(), kFewestLines);
  const float width = hasText ? widthWithText : loupe.x;
  if (hasText) shorten(lines, mostLines);
  const float textHeight = hasText ? lineHeight * static_cast<float>(lines.size()) : 0.0f;
  const float height = std::max(loupe.y, textHeight);  // where pictures are small, the text is higher than the loupe
  // Aside from the place; where that is too narrow, above it instead of below.
  const float left = place.x < 0.5 ? area.to().x - width - margin : area.from.x + margin;
  const glm::vec2 eyed = glm::vec2(shown.area.from.x, shown.area.from.y) + glm::vec2(place) * glm::vec2(shown.area.size.x, shown.area.size.y);
  const bool isBeneath = eyed.x > left - margin && eyed.x < left + width + margin && eyed.y > area.to().y - height - 2.0f * margin;
  const float top = isBeneath ? area.from.y + margin : area.to().y - height - margin;
  const ImVec2 to{left + loupe.x, top + height}, at{left, to.y - loupe.y};
  ImDrawList* list = ImGui::GetWindowDrawList();
  list->PushClipRect(area.from, area.to(), true);
  list->AddRectFilled({at.x - 2.0f, top - 2.0f}, {at.x + width + 2.0f, to.y + 2.0f}, ImGui::GetColorU32({0.03f, 0.03f, 0.04f, 0.9f}));
  const auto share = [&](const glm::ivec2& corner) {
    return ImVec2(static_cast<float>(corner.x) / static_cast<float>(size.x), static_cast<float>(corner.y) / static_cast<float>(size.y));
  };
  list->AddImage(shown.texture->id(), at, to, share(first), share(first + count));
  const ImU32 line = IM_COL32(128, 128, 128, 90);
  for (int i = 1; i < count.x; ++i) list->AddLine({at.x + edge * static_cast<float>(i), at.y}, {at.x + edge * static_cast<float>(i), to.y}, line);
  for (int i = 1; i < count.y; ++i) list->AddLine({at.x, at.y + edge * static_cast<float>(i)}, {to.x, at.y + edge * static_cast<float>(i)}, line);
  const glm::vec2 corner = glm::vec2(at.x, at.y) + edge * glm::vec2(pixel - first);
  list->AddRect({corner.x - 1.0f, corner.y - 1.0f}, {corner.x + edge + 1.0f, corner.y + edge + 1.0f}, IM_COL32(0, 0, 0, 255));
  list->AddRect({corner.x, corner.y}, {corner.x + edge, corner.y + edge}, IM_COL32(255, 255, 255, 255));
  if (hasText) {
    float y = top, nameWidth = 0.0f;
    for (const auto& [name, figure] : lines) nameWidth = std::max(nameWidth, ImGui::CalcTextSize(name.c_str()).x);
    for (const auto& [name, figure] : lines) {
      list->AddText({to.x + margin, y}, ImGui::GetColorU32(kDimTextOnPicture), name.c_str());
      list->AddText({to.x + 2.0f * margin + nameWidth, y}, ImGui::GetColorU32(kTextOnPicture), figure.c_str());
      y += lineHeight;
    }
  }
  ImGui::PopFont();
  list->PopClipRect();
}

/// Of the pixel of the panel's picture at that place.
std::vector<std::pair<std::string, std::string>> linesAbout(const Panel& panel, const glm::dvec2& place) {
  const PanelPixels* const pixels = panel.currentPixels();
  if (pixels == nullptr) return {{"pixels", "when it rests"}};
  return linesOf(pixelReport(pixels->inputs(), pixels->at(place)));
}

/// Of what stands beneath a picture, with the gap between them.
float stripHeight(float width, MeasurementSpace space, const Look& look) {
  if (space == MeasurementSpace::none) return 0.0f;
  return measurementsHeight(width, space, look) + look.px(kTimelinePx) + 2.0f * ImGui::GetStyle().ItemSpacing.y;
}

}  // namespace

float panelHeightBesidePicture(float width, MeasurementSpace space, const Look& look) {
  return panelHeaderHeight(look) + stripHeight(width, space, look);
}

PanelEvents drawWarpPanel(Session& session, size_t index, bool isAlone, const std::optional<OtherPicture>& other, const Inspection* inspection,
                          MeasurementSpace space, PanelTextures& textures, const Look& look) {
  PanelEvents events;
  events.asked = drawPanelHeader(session, index, isAlone, look);
  ImVec2 room = ImGui::GetContentRegionAvail();
  const float strip = stripHeight(room.x, space, look);
  room.x = std::max(room.x, look.px(16.0f));
  room.y = std::max(room.y - strip, look.px(16.0f));
  session.setPanelSize(glm::uvec2(room.x * look.pixelsPerUnit, room.y * look.pixelsPerUnit));
  const Area area{ImGui::GetCursorScreenPos(), room};
  ImGui::InvisibleButton("picture", room, ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight | ImGuiButtonFlags_MouseButtonMiddle);
  ImGui::SetItemAllowOverlap();
  const bool isHovered = ImGui::IsItemHovered();
  const ImGuiIO& io = ImGui::GetIO();
  events.isClicked = ImGui::IsItemDeactivated() && ImGui::IsMouseReleased(ImGuiMouseButton_Left) && io.MouseDragMaxDistanceSqr[0] < look.px(3.0f) * look.px(3.0f);
  steer(session, index, room, look);
  const Panel& panel = session.panel(index);
  const std::optional<OnShow> shown = drawPictures(session, panel, other, textures, area, look);
  if (shown && isHovered) {
    const glm::dvec2 place((io.MousePos.x - shown->area.from.x) / shown->area.size.x, (io.MousePos.y - shown->area.from.y) / shown->area.size.y);
    if (place.x >= 0.0 && place.y >= 0.0 && place.x < 1.0 && place.y < 1.0) events.pointer = place;
  }
  if (shown && inspection != nullptr && inspection->place)
    drawLoupe(*shown, *inspection->place, linesAbout(panel, *inspection->place), area, look);
  if (other && other->wipeAt != nullptr) drawWipeBar(*other->wipeAt, area, look);
  if (space != MeasurementSpace::none) drawTimeline(panel, look);
  drawMeasurements(session, index, space, look);
  return events;
}

}  // namespace warpscope::ui
