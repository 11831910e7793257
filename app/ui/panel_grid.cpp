// Sharing the room, and comparing in place.
// See panel_grid.h.
#include "app/ui/panel_grid.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "app/picture/pixel_report.h"
#include "app/ui/ground.h"
#include "app/ui/panel_header.h"

namespace warpscope::ui {
namespace {

constexpr float kGapPx = 8.0f, kPaddingPx = 8.0f;  // at scale 1
/// Where pictures would be lower than this, panels keep one line of measurements.
constexpr float kLowPicturePx = 220.0f;
/// Where they would be lower than this even so, panels keep none, and no bar of times.
constexpr float kLowestPicturePx = 56.0f;
/// Narrower panels have no room for what is chosen above their pictures.
constexpr float kLeastWidthPx = 210.0f;
/// How long each of two pictures is on show in turns: as blink comparators do, about two changes a second.
constexpr std::chrono::milliseconds kBlinkPeriod(450);

/// The panel that another is compared with.
size_t nextOf(const Session& session, size_t panel) { return (panel + 1) % session.panelCount(); }

const WarpDescriptor& techniqueToAdd(const Session& session) {
  const auto isOnShow = [&](const WarpDescriptor& technique) {
    for (size_t i = 0; i < session.panelCount(); ++i)
      if (session.panel(i).technique == &technique) return true;
    return false;
  };
  const auto all = warpRegistry();
  const auto unseen = std::ranges::find_if_not(all, isOnShow);
  return unseen != all.end() ? *unseen : all.front();
}

}  // namespace

size_t PanelGrid::usedLast(const Session& session) const { return session.placeOf(usedLast_).value_or(0); }

std::optional<size_t> PanelGrid::underPointer(const Session& session) const {
  return underPointer_ ? session.placeOf(*underPointer_) : std::nullopt;
}

void PanelGrid::addPanel(Session& session) {
  PanelSettings settings = session.panel(usedLast(session));  // its knobs
  settings.technique = &techniqueToAdd(session);
  settings.isAutomatic = false;
  settings.content = PictureContent::picture;
  if (session.addPanel(settings)) alone_.reset();
}

void PanelGrid::closePanel(Session& session, size_t panel) {
  session.removePanel(panel);
  forgetClosed(session);
}

void PanelGrid::toggleMaximised(const Session& session, size_t panel) {
  const uint64_t id = session.panel(panel).id;
  alone_ = alone_ == id || session.panelCount() == 1 ? std::nullopt : std::optional(id);
}

void PanelGrid::toggleWipe(const Session& session, size_t panel) {
  const uint64_t id = session.panel(panel).id;
  wiped_ = wiped_ == id || session.panelCount() == 1 ? std::nullopt : std::optional(id);
}

std::string PanelGrid::textAboutPixel(const Session& session) const {
  const std::optional<size_t> panel = underPointer(session);
  const PanelPixels* const pixels = panel ? session.panel(*panel).currentPixels() : nullptr;
  return pixels != nullptr && inspection_.place ? textOf(pixelReport(pixels->inputs(), pixels->at(*inspection_.place))) : "";
}

bool PanelGrid::goBack() {
  if (!wiped_ && std::exchange(isInspecting_, false)) return true;
  std::optional<uint64_t>& left = wiped_ ? wiped_ : alone_;
  return std::exchange(left, std::nullopt).has_value();
}

void PanelGrid::forgetClosed(const Session& session) {
  const auto isOpen = [&](uint64_t id) { return session.placeOf(id).has_value(); };
  std::erase_if(shown_, [&](const auto& entry) { return !isOpen(entry.first); });
  if (alone_ && !isOpen(*alone_)) alone_.reset();
  if (wiped_ && (!isOpen(*wiped_) || session.panelCount() == 1)) wiped_.reset();
}

void PanelGrid::followUse(const Session& session) {
  const ImGuiIO& io = ImGui::GetIO();
  const bool isUsed = io.MouseWheel != 0.0f || ImGui::IsMouseClicked(ImGuiMouseButton_Left) || ImGui::IsMouseClicked(ImGuiMouseButton_Right);
  if (underPointer_ && isUsed) usedLast_ = *underPointer_;
  for (size_t i = 0; i < session.panelCount(); ++i) {
    const Panel& panel = session.panel(i);
    Shown& shown = *shown_.at(panel.id);
    if (std::exchange(shown.technique, panel.technique) != panel.technique) usedLast_ = panel.id;  // by its list, or by a key
  }
}

float PanelGrid::pictureSide(const Session& session, const ImVec2& room, const Look& look) const {
  const Layout layout = layoutOf(alone_ ? 1 : session.panelCount(), room, look);
  return layout.space != MeasurementSpace::none ? layout.side : 0.0f;
}

PanelGrid::Layout PanelGrid::layoutOf(size_t count, const ImVec2& room, const Look& look) const {
  const float gap = look.px(kGapPx), padding = 2.0f * look.px(kPaddingPx);
  Layout best;
  for (size_t columns = 1; columns <= count; ++columns) {
    if (columns_ != 0 && columns != std::min(columns_, count)) continue;
    const size_t rows = (count + columns - 1) / columns;
    Layout layout;
    layout.columns = columns;
    layout.cell = {std::floor((room.x - gap * static_cast<float>(columns - 1)) / static_cast<float>(columns)),
                   std::floor((room.y - gap * static_cast<float>(rows - 1)) / static_cast<float>(rows))};
    const float width = layout.cell.x - padding;
    const auto pictureHeight = [&](MeasurementSpace space) { return layout.cell.y - padding - panelHeightBesidePicture(width, space, look); };
    if (pictureHeight(MeasurementSpace::all) < look.px(kLowPicturePx)) layout.space = MeasurementSpace::oneLine;
    if (pictureHeight(MeasurementSpace::oneLine) < look.px(kLowestPicturePx)) layout.space = MeasurementSpace::none;
    layout.side = std::min(width, pictureHeight(layout.space));
    const bool isTooNarrow = columns > 1 && width < look.px(kLeastWidthPx);
    // Figures are worth more than larger pictures.
    const auto worth = [](const Layout& one) { return std::pair(one.space != MeasurementSpace::none, one.side); };
    if (columns == 1 || columns_ != 0 || (worth(layout) > worth(best) && !isTooNarrow)) best = layout;
  }
  return best;
}

std::optional<OtherPicture> PanelGrid::otherOf(const Session& session, size_t panel, const HeldKeys& held, const Look& look) {
  const bool isUnderPointer = underPointer_ == session.panel(panel).id;
  if (held.reference && isUnderPointer) {
    const auto& truth = session.groundTruth(panel).image();
    return OtherPicture{{truth ? truth->picture() : nullptr, nullptr}, "Ground truth", nullptr};
  }
  if (session.panelCount() == 1) return std::nullopt;
  const Panel& next = session.panel(nextOf(session, panel));
  const ShownPicture& nextPicture = next.hasContentOnShow() ? next.shownContent.picture : next.picture;
  const std::string name(next.technique->label);
  if (held.blink && isUnderPointer) {
    isBlinking_ = true;
    const auto turns = std::chrono::duration_cast<std::chrono::milliseconds>(look.now.time_since_epoch()) / kBlinkPeriod;
    return turns % 2 == 0 ? std::nullopt : std::optional(OtherPicture{nextPicture, name, nullptr});
  }
  if (isWiped(session, panel)) return OtherPicture{nextPicture, name, &wipeAt_};
  return std::nullopt;
}

PanelEvents PanelGrid::drawCell(Session& session, size_t panel, const Layout& layout, const HeldKeys& held, const Look& look) {
  const uint64_t id = session.panel(panel).id;
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {look.px(kPaddingPx), look.px(kPaddingPx)});
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {look.px(8.0f), look.px(6.0f)});
  beginChildOnGround(gl_, ("panel " + std::to_string(id)).c_str(), layout.cell, ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse);
  const PanelEvents events = drawWarpPanel(session, panel, alone_ == id, otherOf(session, panel, held, look), isInspecting_ ? &inspection_ : nullptr,
                                           layout.space, shown_.at(id)->textures, look);
  if (ImGui::IsWindowHovered(ImGuiHoveredFlags_ChildWindows | ImGuiHoveredFlags_AllowWhenBlockedByActiveItem)) underPointerNow_ = id;
  ImGui::EndChild();
  ImGui::PopStyleVar(2);
  return events;
}

std::optional<PanelGrid::Asked> PanelGrid::draw(Session& session, const ImVec2& room, const HeldKeys& held, const Look& look) {
  forgetClosed(session);
  for (size_t i = 0; i < session.panelCount(); ++i) {
    std::unique_ptr<Shown>& shown = shown_[session.panel(i).id];
    if (!shown) shown = std::make_unique<Shown>(gl_);
  }
  followUse(session);
  isBlinking_ = false;
  underPointerNow_.reset();
  std::vector<size_t> drawn;
  for (size_t i = 0; i < session.panelCount(); ++i) {
    // A panel alone may be compared with the next, which is drawn for that.
    const bool isDrawn = !alone_ || alone_ == session.panel(i).id;
    if (isDrawn) drawn.push_back(i);
    const size_t before = (i + session.panelCount() - 1) % session.panelCount();
    const bool isCompared = isWiped(session, before) || (held.blink && underPointer_ == session.panel(before).id);
    session.setHidden(i, !isDrawn && !isCompared);
  }
  const Layout layout = layoutOf(drawn.size(), room, look);
  std::optional<Asked> asked;
  std::optional<std::pair<size_t, size_t>> moved;
  Inspection next;
  for (size_t n = 0; n < drawn.size(); ++n) {
    if (n % layout.columns != 0) ImGui::SameLine(0.0f, look.px(kGapPx));
    const PanelEvents events = drawCell(session, drawn[n], layout, held, look);
    if (events.asked) asked = Asked{session.panel(drawn[n]).id, *events.asked};
    if (events.pointer) next.place = events.pointer;
    if (isInspecting_ && events.isClicked && events.pointer) session.lookAt(LookedAt{session.panel(drawn[n]).id, *events.pointer});
    if (!ImGui::BeginDragDropTarget()) continue;
    if (const ImGuiPayload* payload = ImGui::AcceptDragDropPayload(kPanelPayload)) {
      // It may have been closed while it was dragged.
      if (const auto dragged = session.placeOf(*static_cast<const uint64_t*>(payload->Data))) moved = {*dragged, drawn[n]};
    }
    ImGui::EndDragDropTarget();
  }
  underPointer_ = underPointerNow_;
  inspection_ = next;
  if (moved) session.movePanel(moved->first, moved->second);
  return asked;
}

}  // namespace warpscope::ui
