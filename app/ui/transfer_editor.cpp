// A chart over the values' range, and what the pointer does there.
// See transfer_editor.h.
#include "app/ui/transfer_editor.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "app/scene/auto_transfer_function.h"
#include "app/scene/transfer_file.h"
#include "app/scene/transfer_presets.h"
#include "app/shell/output_files.h"
#include "app/ui/ground.h"
#include "app/ui/knob_parts.h"
#include "render/base/error.h"
#include "render/base/formatted.h"
#include "render/core/color.h"

namespace warpscope::ui {
namespace {

constexpr float kChartPx = 96.0f, kBarPx = 12.0f, kMarkPx = 9.0f, kCornerPx = 4.0f, kReachPx = 11.0f, kOnCurvePx = 8.0f, kColorReachPx = 6.0f, kClickPx = 2.0f;  // at scale 1
constexpr const char* kRemoved = "the corner is gone; Ctrl+Z brings it back";
constexpr std::string_view kHandling = "Left button: drag a corner, or click for a new one; here it is then typed. Right button: a drag moves opacities and colours together, up "
                                       "and down widens and narrows them; a click on a corner removes it, as does Delete the chosen one while the pointer is here.";
constexpr const char* kRemoval = "A right click on it removes it, and so does Delete while the pointer is on the chart.";
constexpr std::string_view kSpreadHelp = "It is in Hounsfield units, which this volume's values do not look like: spread over their range instead, so that it need not show what its name says.";

/// While nothing is held or typed: what is chosen is to go.
bool isDeletePressed() {
  return !ImGui::IsAnyMouseDown() && !ImGui::GetIO().WantTextInput && ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Delete), false);
}

/// Faint opacities have room, too.
float heightOf(float alpha) { return std::sqrt(alpha); }
float alphaAt(float height) { return height * height; }

/// Of these the one at the least distance, if that is within reach.
template <class Thing, class Distance>
std::optional<size_t> nearestOf(const std::vector<Thing>& things, const Distance& distanceTo, float reach) {
  std::optional<size_t> nearest;
  for (size_t i = 0; i < things.size(); ++i) {
    const float distance = distanceTo(things[i]);
    if (distance > reach) continue;
    reach = distance;
    nearest = i;
  }
  return nearest;
}

}  // namespace

/// From values and opacities to places.
struct TransferEditor::Chart {
  ImVec2 from, to;
  double lowest, highest;

  float x(double value) const { return from.x + (to.x - from.x) * static_cast<float>((value - lowest) / (highest - lowest)); }
  float y(float alpha) const { return to.y - (to.y - from.y) * heightOf(alpha); }
  double value(float x) const { return std::clamp(lowest + (highest - lowest) * static_cast<double>((x - from.x) / (to.x - from.x)), lowest, highest); }
  /// Nearly nothing is nothing, and nearly all is all: a hand's breadth above the floor all that is empty would turn into fog.
  float alpha(float y) const {
    constexpr float kNear = 0.04f;  // of the chart's height
    const float height = (to.y - y) / (to.y - from.y);
    return height < kNear ? 0.0f : height > 1.0f - kNear ? 1.0f : alphaAt(height);
  }
};

TransferEditor::Chart TransferEditor::chartOf(const Session& session, const ImVec2& from, const ImVec2& to) const {
  const VoxelStatistics& statistics = session.scene()->volume->statistics();
  // While something is held the chart stays as it is.
  const TransferCurves& curves = grip_ == Grip::none ? curves_ : curvesAtGrip_;
  const double lowest = std::min({statistics.rangeLower, curves.colors.front().value, curves.opacities.front().value});
  double highest = std::max({statistics.rangeUpper, curves.colors.back().value, curves.opacities.back().value});
  if (!(highest > lowest)) highest = lowest + 1.0;
  return {from, to, lowest, highest};
}

void TransferEditor::followScene(const Session& session) {
  const Scene& scene = *session.scene();
  if (volume_ != scene.volume.get() || sceneName_ != scene.name) {
    error_.clear();
    grip_ = Grip::none;
  }
  volume_ = scene.volume.get();
  sceneName_ = scene.name;
  if (shown_ == scene.transferFunction && !curves_.colors.empty()) return;
  shown_ = scene.transferFunction;
  curves_ = curvesOf(shown_);
  opacity_.reset();
  color_.reset();
  typed_.reset();
}

void TransferEditor::show(Session& session, const TransferFunction& function) {
  error_.clear();
  toRemove_.reset();  // by its place among corners that may be others now
  try {
    session.setTransferFunction(function);
    shown_ = function;  // curves stay as they are edited
  } catch (const UsageError& error) {
    error_ = error.what();
    curves_ = {};  // again those of what is on show
    followScene(session);
  }
}

void TransferEditor::apply(Session& session) { show(session, functionOf(curves_)); }

void TransferEditor::set(Session& session, const TransferFunction& function) {
  error_.clear();
  if (session.scene() == nullptr || function == session.scene()->transferFunction) return;
  followScene(session);
  show(session, function);
  if (!error_.empty()) return;
  curves_ = curvesOf(function);
  opacity_.reset();
  color_.reset();
}

const TransferCurves* TransferEditor::curves(const Session& session) const {
  return session.scene() != nullptr && !curves_.colors.empty() && session.whyFunctionIsFixed().empty() ? &curves_ : nullptr;
}

void TransferEditor::setCurves(Session& session, const TransferCurves& curves) {
  if (!session.whyFunctionIsFixed().empty() || curves == curves_) return;
  curves_ = curves;
  apply(session);
}

void TransferEditor::update(Session& session, Session::TimePoint now) {
  if (!session.whyFunctionIsFixed().empty()) return;
  followScene(session);
  if (grip_ != Grip::none && !ImGui::IsMouseDown(grip_ == Grip::window ? ImGuiMouseButton_Right : ImGuiMouseButton_Left)) {  // let go of, seen or not
    grip_ = Grip::none;
  }
  followFile(session, now);
  followScene(session);
}

void TransferEditor::followFile(Session& session, Session::TimePoint now) {
  if (grip_ != Grip::none) return;
  std::optional<WatchedFunction::Written> written = watched_.follow(now);
  if (!written) return;
  if (written->error.empty())
    set(session, written->function);
  else
    error_ = std::move(written->error);
}

void TransferEditor::drawChart(Session& session, const Look& look) {
  const ImVec2 from = ImGui::GetCursorScreenPos(), to{from.x + ImGui::GetContentRegionAvail().x, from.y + look.px(kChartPx)};
  // Down to the bar, so that corners without opacity can be taken by their lower halves.
  const float gap = ImGui::GetStyle().ItemSpacing.y;
  ImGui::InvisibleButton("opacities", {to.x - from.x, to.y - from.y + gap}, ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight);
  ImGui::SetCursorScreenPos({from.x, to.y + gap});
  const bool isHovered = ImGui::IsItemHovered();
  const Chart chart = chartOf(session, from, to);
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  reading_.clear();
  const auto findNear = [&] {
    const auto distanceTo = [&](const OpacityCorner& corner) { return std::hypot(chart.x(corner.value) - mouse.x, chart.y(corner.alpha) - mouse.y); };
    return isHovered ? nearestOf(curves_.opacities, distanceTo, look.px(kReachPx)) : std::nullopt;
  };
  const std::optional<size_t> near = findNear();
  const auto take = [&](Grip grip) {
    grip_ = grip;
    curvesAtGrip_ = curves_;
    gripAt_ = mouse;
  };
  // Before another corner is chosen, or there is one more.
  if (isHovered && (ImGui::IsMouseClicked(ImGuiMouseButton_Left) || ImGui::IsMouseClicked(ImGuiMouseButton_Right))) takeTyped(session);
  if (isHovered && ImGui::IsMouseClicked(ImGuiMouseButton_Left)) {
    take(Grip::opacity);
    opacity_ = near ? *near : keepBeyond(curves_, addOpacity(curves_, chart.value(mouse.x)), chart.lowest, chart.highest);
    color_.reset();
    // On the curve it lies where that was until it is dragged; beside the curve the curve goes to it.
    const float onCurve = chart.y(curves_.opacities[*opacity_].alpha);
    if (!near && std::abs(onCurve - mouse.y) > look.px(kOnCurvePx)) moveOpacity(curves_, *opacity_, chart.value(mouse.x), chart.alpha(mouse.y));
    if (!near) apply(session);
  } else if (isHovered && ImGui::IsMouseClicked(ImGuiMouseButton_Right)) {
    take(Grip::window);
    toRemove_ = near;
  }
  // A corner goes by a click on it; a drag that begins there is one like others.
  const float way = std::hypot(mouse.x - gripAt_.x, mouse.y - gripAt_.y);
  if (way > look.px(kClickPx)) toRemove_.reset();
  if (toRemove_ && !ImGui::IsMouseDown(ImGuiMouseButton_Right)) {
    const size_t corner = *toRemove_;
    if (ImGui::IsMouseReleased(ImGuiMouseButton_Right) && removeOpacity(curves_, corner)) {
      opacity_.reset();
      apply(session);
      note_ = kRemoved;
    }
    toRemove_.reset();
  }
  if (isHovered && opacity_ && isDeletePressed() && removeOpacity(curves_, *opacity_)) {
    opacity_.reset();
    typed_.reset();
    apply(session);
    note_ = kRemoved;
  }
  const bool isMoved = ImGui::IsMousePosValid() && way > 0.0f && !toRemove_;
  if (grip_ == Grip::opacity && opacity_ && isMoved) {
    moveOpacity(curves_, *opacity_, chart.value(mouse.x), chart.alpha(mouse.y));
    apply(session);
  }
  if (grip_ == Grip::window && isMoved) {
    const double shift = (chart.highest - chart.lowest) * static_cast<double>((mouse.x - gripAt_.x) / (to.x - from.x));
    curves_ = windowed(curvesAtGrip_, shift, std::exp(static_cast<double>((gripAt_.y - mouse.y) / (to.y - from.y))));
    apply(session);
  }

  ImDrawList* list = ImGui::GetWindowDrawList();
  fillGround(*list, *look.gl, from, to, ImGuiCol_WindowBg, 0.0f);
  list->PushClipRect({from.x - look.px(5.0f), from.y - look.px(5.0f)}, {to.x + look.px(5.0f), to.y + look.px(5.0f)}, true);
  const VoxelStatistics& statistics = session.scene()->volume->statistics();
  const double most = std::log1p(static_cast<double>(*std::ranges::max_element(statistics.histogram)));
  const double binWidth = (statistics.rangeUpper - statistics.rangeLower) / static_cast<double>(statistics.histogram.size());
  for (size_t bin = 0; bin < statistics.histogram.size() && most > 0.0; ++bin) {
    const double lower = statistics.rangeLower + binWidth * static_cast<double>(bin);
    const float height = static_cast<float>(std::log1p(static_cast<double>(statistics.histogram[bin])) / most);
    list->AddRectFilled({chart.x(lower), to.y - height * (to.y - from.y)}, {std::max(chart.x(lower + binWidth), chart.x(lower) + 1.0f), to.y},
                        ImGui::GetColorU32(palette().histogram));
  }
  drawOpacities(*list, chart, look);
  std::vector<ImVec2> line{{from.x, chart.y(curves_.opacities.front().alpha)}};
  // Straight in opacity is not straight here.
  const TransferFunction& function = session.scene()->transferFunction;
  for (size_t i = 0; i < curves_.opacities.size(); ++i) {
    const OpacityCorner& corner = curves_.opacities[i];
    if (i > 0)
      for (int piece = 1; piece < 12; ++piece) {
        const float share = static_cast<float>(piece) / 12.0f;
        const OpacityCorner& before = curves_.opacities[i - 1];
        line.push_back({std::lerp(chart.x(before.value), chart.x(corner.value), share), chart.y(std::lerp(before.alpha, corner.alpha, share))});
      }
    line.push_back({chart.x(corner.value), chart.y(corner.alpha)});
  }
  line.push_back({to.x, chart.y(curves_.opacities.back().alpha)});
  list->AddPolyline(line.data(), static_cast<int>(line.size()), ImGui::GetColorU32(ImGuiCol_Text), 0, look.px(1.5f));
  for (size_t i = 0; i < curves_.opacities.size(); ++i) {
    const OpacityCorner& corner = curves_.opacities[i];
    const ImVec2 at{chart.x(corner.value), chart.y(corner.alpha)};
    list->AddCircleFilled(at, look.px(kCornerPx), screenColor(glm::vec3(function.at(corner.value))));
    list->AddCircle(at, look.px(kCornerPx), ImGui::GetColorU32(opacity_ == i ? palette().accent : ImGui::GetStyleColorVec4(ImGuiCol_Text)), 0, look.px(opacity_ == i || near == i ? 2.0f : 1.0f));
  }
  list->PopClipRect();
  if (!isHovered && grip_ == Grip::none) return;
  // Of the corner that is held or would be, as corners are by now, else of the curve.
  const std::optional<size_t> corner = grip_ == Grip::opacity ? opacity_ : grip_ == Grip::none ? findNear() : std::nullopt;
  const double value = corner ? curves_.opacities[*corner].value : chart.value(mouse.x);
  const double alpha = corner ? static_cast<double>(curves_.opacities[*corner].alpha) : static_cast<double>(function.at(value).a);
  reading_ = std::string(corner ? "corner at " : "") + formatted("%.4g", value) + formatted(": opacity %.3g", alpha);
}

void TransferEditor::drawOpacities(ImDrawList& list, const Chart& chart, const Look& look) {
  ImGui::PushFont(look.fonts.small);
  const ImU32 lineColor = ImGui::GetColorU32(ImGuiCol_Separator, 0.6f), textColor = ImGui::GetColorU32(palette().faintText);
  for (const float alpha : {0.1f, 0.5f}) {
    const float y = chart.y(alpha);
    list.AddLine({chart.from.x, y}, {chart.to.x, y}, lineColor);
    list.AddText({chart.from.x + look.px(2.0f), y}, textColor, formatted("%g", static_cast<double>(alpha)).c_str());
  }
  ImGui::PopFont();
}

void TransferEditor::drawAxis(const Session& session, const Look& look) const {
  const ImVec2 from = ImGui::GetCursorScreenPos(), to{from.x + ImGui::GetContentRegionAvail().x, from.y};
  const Chart chart = chartOf(session, from, to);
  ImGui::PushFont(look.fonts.small);
  const float line = ImGui::GetTextLineHeight();
  ImGui::Dummy({to.x - from.x, line});
  tooltip("Values, in the volume's own units. Above: how often they occur (logarithm), and their opacity, 0 to 1 over the length of a voxel's edge (root).", look);
  ImDrawList* list = ImGui::GetWindowDrawList();
  const ImU32 color = ImGui::GetColorU32(palette().dimText);
  // What is pointed at is read here, where it hides nothing.
  const std::string lowest = formatted("%.5g", chart.lowest), middle = !reading_.empty() ? reading_ : formatted("%.5g", std::midpoint(chart.lowest, chart.highest)), highest = formatted("%.5g", chart.highest);
  list->AddText(from, color, lowest.c_str());
  list->AddText({0.5f * (from.x + to.x - ImGui::CalcTextSize(middle.c_str()).x), from.y}, reading_.empty() ? color : ImGui::GetColorU32(ImGuiCol_Text), middle.c_str());
  list->AddText({to.x - ImGui::CalcTextSize(highest.c_str()).x, from.y}, color, highest.c_str());
  ImGui::PopFont();
}

void TransferEditor::drawColorBar(Session& session, const Look& look) {
  const ImVec2 from = ImGui::GetCursorScreenPos(), to{from.x + ImGui::GetContentRegionAvail().x, from.y + look.px(kBarPx + kMarkPx)};
  ImGui::InvisibleButton("colors", {to.x - from.x, to.y - from.y}, ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight);
  const Chart chart = chartOf(session, from, to);
  const bool isHovered = ImGui::IsItemHovered();
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  const auto distanceTo = [&](const ColorCorner& corner) { return std::abs(chart.x(corner.value) - mouse.x); };
  const std::optional<size_t> near = isHovered ? nearestOf(curves_.colors, distanceTo, look.px(kColorReachPx)) : std::nullopt;
  if (isHovered && (ImGui::IsMouseClicked(ImGuiMouseButton_Left) || ImGui::IsMouseClicked(ImGuiMouseButton_Right))) takeTyped(session);
  if (isHovered && ImGui::IsMouseClicked(ImGuiMouseButton_Left)) {
    grip_ = Grip::color;
    curvesAtGrip_ = curves_;
    gripAt_ = mouse;
    color_ = near ? *near : addColor(curves_, chart.value(mouse.x));
    opacity_.reset();
  } else if (isHovered && near && ImGui::IsMouseClicked(ImGuiMouseButton_Right)) {
    if (removeColor(curves_, *near)) {
      color_.reset();
      apply(session);
      note_ = kRemoved;
    }
  }
  if (isHovered && color_ && isDeletePressed() && removeColor(curves_, *color_)) {
    color_.reset();
    typed_.reset();
    apply(session);
    note_ = kRemoved;
  }
  if (grip_ == Grip::color && color_ && ImGui::IsMousePosValid() && mouse.x != gripAt_.x) {
    moveColor(curves_, *color_, chart.value(mouse.x));
    apply(session);
  }
  ImDrawList* list = ImGui::GetWindowDrawList();
  const float bottom = from.y + look.px(kBarPx);
  const TransferFunction& function = session.scene()->transferFunction;
  const float piece = std::max(1.0f, look.px(2.0f));
  for (float x = from.x; x < to.x; x += piece)
    list->AddRectFilled({x, from.y}, {std::min(x + piece, to.x), bottom}, screenColor(glm::vec3(function.at(chart.value(x + 0.5f * piece)))));
  for (size_t i = 0; i < curves_.colors.size(); ++i) {
    const float x = chart.x(curves_.colors[i].value), half = look.px(4.5f);
    const ImVec2 top{x, bottom - look.px(2.0f)}, left{x - half, to.y}, right{x + half, to.y};
    list->AddTriangleFilled(top, left, right, screenColor(curves_.colors[i].color));
    list->AddTriangle(top, left, right, ImGui::GetColorU32(color_ == i ? palette().accent : ImGui::GetStyleColorVec4(ImGuiCol_Text)), look.px(color_ == i || near == i ? 2.0f : 1.0f));
  }
}

void TransferEditor::drawNumber(Session& session, Field field, size_t corner, double value, const char* pattern) {
  ImGui::PushID(static_cast<int>(corner));  // another corner's is another field
  double edited = typed_ && typed_->field == field && typed_->corner == corner ? typed_->value : value;
  const char* const id = field == Field::value ? "##value" : field == Field::alpha ? "##alpha" : "##value of a colour";
  if (ImGui::InputDouble(id, &edited, 0.0, 0.0, pattern)) typed_ = {field, corner, edited};
  // Left in whatever way, what was typed holds. Only Esc takes it back: it puts there what stood there, which is not all of the number.
  if (ImGui::IsItemDeactivated() && ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape))) typed_.reset();
  if (ImGui::IsItemDeactivatedAfterEdit()) takeTyped(session);
  ImGui::PopID();
}

void TransferEditor::takeTyped(Session& session) {
  const std::optional<Typed> typed = std::exchange(typed_, std::nullopt);
  if (!typed || !std::isfinite(typed->value)) return;
  const TransferCurves before = curves_;
  const size_t i = typed->corner;
  if (typed->field == Field::colorValue) {
    if (i < curves_.colors.size()) moveColor(curves_, i, typed->value);
  } else if (i < curves_.opacities.size()) {
    const OpacityCorner corner = curves_.opacities[i];
    if (typed->field == Field::value)
      moveOpacity(curves_, i, typed->value, corner.alpha);
    else
      moveOpacity(curves_, i, corner.value, static_cast<float>(typed->value));
  }
  if (!(curves_ == before)) apply(session);
}

void TransferEditor::drawFields(Session& session, const Look& look) {
  if (opacity_ && *opacity_ < curves_.opacities.size()) {
    const OpacityCorner corner = curves_.opacities[*opacity_];
    label("Corner", look, kRemoval);
    beginHalves();
    drawNumber(session, Field::value, *opacity_, corner.value, "%.5g");
    tooltip("Its value, in the volume's own units.", look);
    nextHalf();
    drawNumber(session, Field::alpha, *opacity_, static_cast<double>(corner.alpha), "%.4g");
    tooltip("Its opacity over the length of a voxel's edge, 0 to 1.", look);
  } else if (color_ && *color_ < curves_.colors.size()) {
    const ColorCorner corner = curves_.colors[*color_];
    label("Colour", look, kRemoval);
    beginHalves();
    drawNumber(session, Field::colorValue, *color_, corner.value, "%.5g");
    nextHalf();
    std::array<float, 3> srgb{srgbFromLinear(corner.color.r), srgbFromLinear(corner.color.g), srgbFromLinear(corner.color.b)};
    if (ImGui::ColorEdit3("##color", srgb.data(), ImGuiColorEditFlags_NoInputs | ImGuiColorEditFlags_PickerHueWheel)) {
      curves_.colors[*color_].color = {linearFromSrgb(srgb[0]), linearFromSrgb(srgb[1]), linearFromSrgb(srgb[2])};
      apply(session);
    }
    tooltip("Its colour.", look);
  } else {  // so that nothing moves when one is chosen
    ImGui::AlignTextToFramePadding();
    const bool isSpreadPreset = !spread_.preset.empty() && spread_.function == session.scene()->transferFunction;
    ImGui::TextColored(isSpreadPreset ? palette().noticeText : palette().faintText, "%s", isSpreadPreset ? (spread_.preset + ", spread over all values").c_str() : "right: drag all, click removes");
    tooltip(std::string(isSpreadPreset ? kSpreadHelp : kHandling), look);
  }
}

void TransferEditor::drawFilePopup() {
  if (!ImGui::BeginPopup("transfer file")) return;
  if (ImGui::MenuItem("Load...")) fileWish_ = FileWish::load;
  if (ImGui::MenuItem("Save...")) fileWish_ = FileWish::save;
  if (ImGui::MenuItem("Save for ParaView...")) fileWish_ = FileWish::saveForParaview;
  ImGui::EndPopup();
}

void TransferEditor::save(const Session& session, const std::filesystem::path& path, bool isForParaview) const {
  const TransferFunction& function = session.scene()->transferFunction;
  writeFileWhole(path, isForParaview ? paraviewText(function, session.scene()->name) : transferText(function));
}

void TransferEditor::drawButtons(Session& session, const EditHistory& history, const Look& look) {
  const VoxelStatistics& statistics = session.scene()->volume->statistics();
  ImGui::SetNextItemWidth(look.px(84.0f));
  const bool isOpen = ImGui::BeginCombo("##preset", "Preset");
  if (!isOpen) tooltip("Transfer functions to begin with.", look);
  if (isOpen) {
    if (ImGui::Selectable("Automatic")) set(session, autoTransferFunction(statistics));
    tooltip("From the histogram, as for a volume without a scene.", look);
    for (const TransferPreset& preset : transferPresets()) {
      const bool isSpreadHere = isSpread(preset.name, statistics);
      if (ImGui::Selectable(std::string(preset.name).c_str())) {
        set(session, presetFunction(preset.name, statistics));
        if (isSpreadHere) spread_ = {std::string(preset.name), session.scene()->transferFunction};
      }
      tooltip(std::string(preset.summary) + "." + (isSpreadHere ? " " + std::string(kSpreadHelp) : std::string()), look);
    }
    ImGui::EndCombo();
  }
  const auto smallButton = [&](const char* text, bool isPossible, const char* help) {
    ImGui::SameLine(0.0f, ImGui::GetStyle().ItemInnerSpacing.x);
    if (!isPossible) ImGui::BeginDisabled();
    const bool isPressed = ImGui::Button(text);
    if (!isPossible) ImGui::EndDisabled();
    tooltip(help, look);
    return isPressed && isPossible;
  };
  const std::string undoes = history.undoes(), redoes = history.redoes();
  if (smallButton("Undo", !undoes.empty(), ("Take the last change back, here or of knobs and panels: " + undoes + ". Ctrl+Z.").c_str())) action_ = Action::undo;
  if (smallButton("Redo", !redoes.empty(), ("Make again what was taken back: " + redoes + ". Ctrl+Shift+Z.").c_str())) action_ = Action::redo;
  if (smallButton("File", true, "Load and save, also as a colour map that ParaView imports. Files of either kind are loaded, by dropping them onto the window as well.")) ImGui::OpenPopup("transfer file");
  drawFilePopup();
}

void TransferEditor::draw(Session& session, const EditHistory& history, const Look& look) {
  if (const std::string why = session.whyFunctionIsFixed(); !why.empty()) {
    ImGui::PushTextWrapPos(0.0f);
    ImGui::TextColored(palette().dimText, "%s", (why + ".").c_str());
    ImGui::PopTextWrapPos();
    return;
  }
  followScene(session);
  ImGui::PushID("transfer");
  drawChart(session, look);
  drawColorBar(session, look);
  drawAxis(session, look);
  drawFields(session, look);
  drawButtons(session, history, look);
  ImGui::PopID();
  if (error_.empty()) return;
  ImGui::PushTextWrapPos(0.0f);
  ImGui::TextColored(palette().errorText, "%s", error_.c_str());
  ImGui::PopTextWrapPos();
}

}  // namespace warpscope::ui
