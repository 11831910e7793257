// The column of knobs.
// See controls.h.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "app/frames/transport_knobs.h"
#include "app/session/picture_plan.h"
#include "app/ui/knob_parts.h"
#include "app/ui/controls.h"
#include "render/march/march_knobs.h"
#include "render/volume/volume_format.h"

namespace warpscope::ui {
namespace {

constexpr std::array<uint32_t, 8> kServerSidesPx{128, 256, 384, 512, 768, 1024, 1536, 2048};
constexpr uint32_t kMaxScreenPixels = 4;

constexpr std::string_view kFreezeHelp = "Ask the server for nothing more: its last frame stays, and can be looked at from elsewhere. Key F.";

/// The server's picture, and whether it makes any.
void drawServerSide(const Session& session, LiveSettings& knobs, const Look& look) {
  label(std::string(kServerSideKnob.label).c_str(), look, std::string(kServerSideKnob.help) + ".");
  beginHalves();
  const glm::uvec2 size = session.serverSize();
  const SampleFramePtr& newest = session.frames().newest();
  const auto sizeText = [](uint32_t side) { return std::to_string(side) + " px"; };
  const auto areaText = [](uint32_t width, uint32_t height) { return std::to_string(width) + " × " + std::to_string(height); };
  const bool isOpen = ImGui::BeginCombo("##server image", std::to_string(knobs.serverSidePx).c_str());
  if (!isOpen)
    tooltip(std::string(kServerSideKnob.help) + ". Now " + areaText(size.x, size.y) +
                (session.isFrameSmaller() ? ", and " + areaText(newest->camera.width, newest->camera.height) + " of the newest frame, which may not take more bytes." : "."),
            look);
  if (isOpen) {
    for (const uint32_t side : kServerSidesPx)
      if (ImGui::Selectable(sizeText(side).c_str(), side == knobs.serverSidePx)) knobs.serverSidePx = side;
    ImGui::EndCombo();
  }

  nextHalf();
  ImGui::Checkbox("Freeze", &knobs.isFrozen);
  tooltip(std::string(kFreezeHelp), look);
}

void drawServer(Session& session, LiveSettings& knobs, const Look& look) {
  if (!section("SERVER", look)) return;
  for (const MarchKnob& row : marchKnobs())
    if (row.knob->owner != KnobOwner::effect && row.matters(knobs.march)) knobWidget(row, knobs.march, look);
  for (const TransportKnob& row : transportKnobs())
    if (row.isOfServer) knobWidget(row, knobs.transport, look);
  drawServerSide(session, knobs, look);
  if (!knobs.isFrozen || session.playback().isOpen()) return;
  ImGui::PushFont(look.fonts.small);
  ImGui::TextColored(palette().noticeText, "Frozen: changes show in the next frame");
  ImGui::PopFont();
}

/// A checkbox and a colour, which is kept while it is not used.
void markWidget(const char* name, Rgba8& mark, std::array<float, 3>& color, const std::string& what, const Look& look) {
  bool isMarked = mark != 0;
  ImGui::PushID(name);
  ImGui::Checkbox(name, &isMarked);
  tooltip("Show " + what + " in a colour.", look);
  ImGui::SameLine(0.0f, ImGui::GetStyle().ItemInnerSpacing.x);
  ImGui::ColorEdit3("##color", color.data(), ImGuiColorEditFlags_NoInputs);
  tooltip("The colour of " + what + ".", look);
  ImGui::PopID();
  const auto code = [](float channel) { return quantizeUnorm8(channel); };
  mark = isMarked ? code(color[0]) | code(color[1]) << 8 | code(color[2]) << 16 | 0xff000000u : 0u;
}

constexpr std::string_view kPixelSizeHelp = "How many screen pixels wide a pixel of the pictures is.", kMarksHelp = "Holes, which nothing covers, and guesses, of which no frame says anything, in a colour.";

void drawPixelSize(const Session& session, LiveSettings& knobs, const Look& look) {
  label("Pixel size", look, std::string(kPixelSizeHelp));
  const auto pixelsText = [](uint32_t pixels) {
    if (pixels == 0) return std::string("automatic");
    return pixels == 1 ? std::string("1 : 1") : "1 : " + std::to_string(pixels);
  };
  const glm::uvec2 size = session.pictureSize();
  const bool isOpen = ImGui::BeginCombo("##pixels", pixelsText(knobs.screenPixels).c_str());
  if (!isOpen)
    tooltip(std::string(kPixelSizeHelp) + " Now the pictures have " + std::to_string(size.x) + " × " +
                std::to_string(size.y) + " pixels.",
            look);
  if (isOpen) {
    for (uint32_t pixels = 0; pixels <= kMaxScreenPixels; ++pixels)
      if (ImGui::Selectable(pixelsText(pixels).c_str(), pixels == knobs.screenPixels)) knobs.screenPixels = pixels;
    ImGui::EndCombo();
  }
}

void drawMarks(LiveSettings& knobs, MarkColors& markColors, const Look& look) {
  label("Mark", look, std::string(kMarksHelp), 0.4f * kLabelWidth);  // the line is full
  markWidget("Holes", knobs.marks.uncovered, markColors.uncovered, "pixels that nothing covers", look);
  ImGui::SameLine();
  markWidget("Guesses", knobs.marks.filled, markColors.filled, "pixels that show a guess, because no frame says anything about them", look);
}

void drawShortcuts(LiveSettings& knobs, const Look& look) {
  double takesShortcuts = knobs.takesShortcuts ? 1.0 : 0.0;
  if (knobWidget(kShortcutsKnob, takesShortcuts, look)) knobs.takesShortcuts = takesShortcuts != 0.0;
}

void drawDisplay(const Session& session, LiveSettings& knobs, MarkColors& markColors, const Look& look) {
  if (!section("DISPLAY", look)) return;
  for (const Knob* knob : warpKnobs()) {
    if (knob->isOfPanel) continue;
    double value = knobs.warp.knobs[*knob];
    if (knobWidget(*knob, value, look)) knobs.warp.knobs.set(*knob, value);
  }
  drawShortcuts(knobs, look);
  drawPixelSize(session, knobs, look);
  drawMarks(knobs, markColors, look);
}

constexpr double kJumpDeg = 120.0;

constexpr std::string_view kMotionHelp = "What moves the camera by itself, and how fast. Whoever moves the camera otherwise ends its motion.";

/// What moves the camera by itself, how fast, and the path that is recorded of it.
void drawMotion(Session& session, const Look& look) {
  const LiveMotion& motion = session.motion();
  label("Motion", look, std::string(kMotionHelp));
  beginHalves();
  const CameraMotionDescriptor& shown = describe(motion.motion());
  const bool isOpen = ImGui::BeginCombo("##motion", std::string(shown.label).c_str());
  if (!isOpen) tooltip(std::string(shown.help) + ". Whoever moves the camera otherwise ends its motion.", look);
  if (isOpen) {
    for (const CameraMotionDescriptor& choice : cameraMotions()) {
      if (choice.value == CameraMotion::recorded && !motion.hasPath()) continue;
      if (ImGui::Selectable(std::string(choice.label).c_str(), choice.value == motion.motion())) session.setMotion(choice.value, motion.speed());
      tooltip(std::string(choice.help) + ".", look);
    }
    ImGui::EndCombo();
  }
  nextHalf();
  auto speed = static_cast<float>(motion.speed());
  bareSlider("speed", speed, {0.1f, 5.0f, "%.1f ×", true}, "How fast, times the usual speed.", look);
  if (speed != static_cast<float>(motion.speed())) session.setMotion(motion.motion(), speed);
  bool isRecording = motion.isRecording();
  if (ImGui::Checkbox("Keep the camera's path", &isRecording)) session.setRecording(isRecording);
  tooltip("The camera's path from now on, until this is switched off: then it can be chosen as a motion.", look);
}

void drawCamera(Session& session, const Look& look) {
  if (!section("CAMERA", look)) return;
  const View& view = session.view();
  const auto rounded = [](double degrees) { return std::round(degrees) + 0.0; };  // no "-0"
  ImGui::TextColored(palette().dimText, "%.0f° around, %.0f° up, %.2f × as far", rounded(view.angleDeg), rounded(view.elevationDeg),
                     view.distance);
  beginHalves();
  const float half = ImGui::CalcItemWidth();
  if (ImGui::Button("Reset view", {half, 0.0f})) session.resetView();
  tooltip("Back to the scene's first view. Key R, or a double click.", look);
  nextHalf();
  if (ImGui::Button("Jump", {-1.0f, 0.0f})) {
    View jumped = view;
    jumped.angleDeg = std::remainder(view.angleDeg + kJumpDeg, 360.0);
    session.setView(jumped);
  }
  tooltip("The camera is all at once somewhere else, a third of a turn away: what no frame has seen.", look);
  drawMotion(session, look);
  ImGui::PushFont(look.fonts.small);
  ImGui::PushTextWrapPos(0.0f);
  ImGui::TextColored(palette().faintText, "Drag to orbit, with the right button to pan; wheel to zoom.");
  ImGui::PopTextWrapPos();
  ImGui::PopFont();
}

}  // namespace

void Controls::search() {
  ImGui::SetWindowFocus(nullptr);  // a field that has the keyboard already would not choose its text anew
  wantsSearch_ = true;
}

bool Controls::endSearch() { return std::exchange(search_[0], '\0') != '\0'; }

void Controls::drawSearch(const Look& look) {
  if (std::exchange(wantsSearch_, false)) ImGui::SetKeyboardFocusHere();
  const bool hasEnd = search_[0] != '\0';
  const float side = ImGui::GetFrameHeight();
  ImGui::SetNextItemWidth(hasEnd ? -side - ImGui::GetStyle().ItemInnerSpacing.x : -1.0f);
  ImGui::InputTextWithHint("##search", "search a knob", search_.data(), search_.size(), ImGuiInputTextFlags_AutoSelectAll);
  // It would cover what was found.
  if (!ImGui::IsItemActive() && !hasEnd) tooltip("A part of a knob's name, or of what it does. Ctrl+F.", look);
  if (!hasEnd) return;
  ImGui::SameLine(0.0f, ImGui::GetStyle().ItemInnerSpacing.x);
  if (ImGui::Button("×##end", {side, side})) endSearch();
  tooltip("All knobs again. Esc.", look);
}

void Controls::drawFound(Session& session, LiveSettings& knobs, const Look& look) {
  const std::string wanted = lowered(search_.data());
  size_t found = 0;
  const KnobFilter isWanted = [&](std::string_view text) { return lowered(std::string(text)).find(wanted) != std::string::npos; };
  const auto hasWords = [&](std::initializer_list<std::string_view> words) {
    const bool isFound = std::ranges::any_of(words, isWanted);
    found += isFound ? 1 : 0;
    return isFound;
  };
  const auto has = [&](const Knob& knob) { return !knob.label.empty() && hasWords({knob.label, knob.noun, knob.key, knob.option, knob.help}); };
  ImGui::BeginDisabled(session.playback().isOpen());
  for (const MarchKnob& row : marchKnobs())
    if (has(*row.knob)) knobWidget(row, knobs.march, look);
  for (const MarchText& text : marchTexts())
    if (hasWords({text.label, text.noun, text.key, text.option, text.help})) effects_.drawText(text, knobs.march, look);
  if (hasWords({kServerSideKnob.label, kServerSideKnob.noun, kServerSideKnob.help, "Freeze", kFreezeHelp})) drawServerSide(session, knobs, look);
  for (const TransportKnob& row : transportKnobs())
    if (has(*row.knob)) knobWidget(row, knobs.transport, look);
  found += drawLinkKnobs(knobs.transport.link, isWanted, look);
  ImGui::EndDisabled();
  for (const Knob* knob : warpKnobs()) {
    if (knob->isOfPanel || !has(*knob)) continue;
    double value = knobs.warp.knobs[*knob];
    if (knobWidget(*knob, value, look)) knobs.warp.knobs.set(*knob, value);
  }
  for (const Knob* knob : warpKnobs())
    if (knob->isOfPanel && hasWords({knob->label, knob->noun, knob->key, knob->option, knob->help})) {
      ImGui::TextColored(palette().dimText, "%s: in the titles of panels", std::string(knob->label.empty() ? knob->noun : knob->label).c_str());
      tooltip("Each panel has its own. " + std::string(knob->help) + ".", look);
    }
  if (has(kShortcutsKnob)) drawShortcuts(knobs, look);
  if (hasWords({"Pixel size", kPixelSizeHelp})) drawPixelSize(session, knobs, look);
  if (hasWords({"Mark", kMarksHelp})) drawMarks(knobs, markColors_, look);
  if (hasWords({"Motion", kMotionHelp})) drawMotion(session, look);
  found_ = found;
  if (found == 0) ImGui::TextColored(palette().dimText, "No knob has that; Esc shows all.");
}

void Controls::draw(Session& session, const SceneOpener& openScene, const FileOpener& openFile, const EditHistory& history, const Look& look) {
  // Closer than elsewhere: all knobs fit into a window of 1280 x 800.
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {look.px(7.0f), look.px(3.0f)});
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {look.px(8.0f), look.px(4.0f)});
  drawScene(session, openScene, openFile, look);
  drawSearch(look);
  if (search_[0] != '\0') {
    LiveSettings found = session.knobs();
    markColors_.take(found.marks);
    drawFound(session, found, look);
    session.setKnobs(found);
    ImGui::PopStyleVar(2);
    return;
  }
  const bool hasFunction = section("TRANSFER FUNCTION", look);
  tooltip("Opacity over the values, on top of how often they occur (logarithm), and colours below. Drag corners; click to add one, right click to remove one; drag "
          "with the right button to move the window sideways and to widen it upwards. Faint opacities are drawn higher than they are (root).",
          look);
  if (hasFunction) transferEditor_.draw(session, history, look);
  LiveSettings knobs = session.knobs();
  markColors_.take(knobs.marks);
  // Of what was recorded nothing can be changed.
  ImGui::BeginDisabled(session.playback().isOpen());
  drawServer(session, knobs, look);
  effects_.draw(knobs.march, look);
  ImGui::EndDisabled();
  plan_.draw(session, look);
  ImGui::BeginDisabled(session.playback().isOpen());
  drawNetwork(session, knobs, look);
  ImGui::EndDisabled();
  drawDisplay(session, knobs, markColors_, look);
  session.setKnobs(knobs);
  drawCamera(session, look);
  ImGui::PopStyleVar(2);
}

void Controls::drawScene(Session& session, const SceneOpener& openScene, const FileOpener& openFile, const Look& look) {
  static const std::vector<BuiltinScene> kScenes = builtinScenes(), kTorture = tortureScenes();
  ImGui::PushFont(look.fonts.small);
  ImGui::TextColored(palette().accent, "SCENE");
  ImGui::PopFont();
  ImGui::SetNextItemWidth(-1.0f);
  const Scene* shown = session.scene();
  const bool isOpen = ImGui::BeginCombo("##scene", shown != nullptr ? shown->name.c_str() : "–");
  if (!isOpen) tooltip("A built-in scene.", look);
  if (isOpen) {
    const auto offer = [&](const BuiltinScene& scene) {
      if (ImGui::Selectable(scene.name.c_str(), shown != nullptr && shown->name == scene.name)) session.load(openScene({scene.name, {}}));
      tooltip(scene.title, look);
    };
    for (const BuiltinScene& scene : kScenes) offer(scene);
    ImGui::Separator();
    for (const BuiltinScene& scene : kTorture) offer(scene);
    ImGui::EndCombo();
  }
  const float buttonWidth = look.px(56.0f);
  ImGui::SetNextItemWidth(-buttonWidth - ImGui::GetStyle().ItemSpacing.x);
  bool isEntered = ImGui::InputTextWithHint("##path", "file, or a server's URL", path_.data(), path_.size(),
                                            ImGuiInputTextFlags_EnterReturnsTrue);
  tooltip("Path of a volume, a scene, a session, a recording, a transfer function or a sweep, or what `warpscope serve` prints on another machine. Files can also be dropped onto the window.", look);
  ImGui::SameLine();
  if (session.loading().empty()) {
    isEntered |= ImGui::Button("Open", {-1.0f, 0.0f});
  } else {
    if (ImGui::Button("Cancel", {-1.0f, 0.0f})) session.cancelLoad();
    tooltip("Give up opening " + session.loading() + ".", look);
  }
  if (isEntered && path_[0] != '\0') openFile(path_.data());

  // The bar's place is kept, so that nothing moves when it comes and goes.
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float width = ImGui::GetContentRegionAvail().x, height = look.px(3.0f);
  ImGui::Dummy({width, height});
  if (session.loading().empty()) return;
  const float position = static_cast<float>(std::fmod(ImGui::GetTime() * 0.7, 1.0)) * 1.3f - 0.3f;
  ImDrawList* list = ImGui::GetWindowDrawList();
  list->AddRectFilled(at, {at.x + width, at.y + height}, ImGui::GetColorU32(ImGuiCol_FrameBg), 0.5f * height);
  list->AddRectFilled({at.x + width * std::max(0.0f, position), at.y},
                      {at.x + width * std::min(1.0f, position + 0.3f), at.y + height}, ImGui::GetColorU32(palette().accent), 0.5f * height);
}

}  // namespace warpscope::ui
