// The small parts: status bar, error banner, tooltips.
// See parts.h.
#include "app/ui/parts.h"

#include <algorithm>
#include <vector>

#include "render/base/formatted.h"
#include "render/core/color.h"

namespace warpscope::ui {
namespace {

/// 83412 as "83 412".
std::string grouped(size_t number) {
  std::string text = std::to_string(number);
  for (size_t at = text.size(); at > 3; at -= 3) text.insert(at - 3, " ");
  return text;
}

}  // namespace

bool Hover::hasRested(const ImVec2& item, Session::TimePoint now) {
  constexpr std::chrono::milliseconds kDelay(450);
  constexpr float kReachPx = 3.0f;  // that a hand at rest moves
  const int frame = ImGui::GetFrameCount();
  // Who has just pressed looks at what came of it, and not for a word about what lies beneath the pointer now.
  const ImGuiIO& io = ImGui::GetIO();
  for (const ImVec2& pressed : io.MouseClickedPos)
    if (std::hypot(io.MousePos.x - pressed.x, io.MousePos.y - pressed.y) < kReachPx) return false;
  const bool isOther = item.x != item_.x || item.y != item_.y || frame > lastFrame_ + 1;
  if (isOther) since_ = now;
  item_ = item;
  lastFrame_ = frame;
  return now - since_ >= kDelay;
}

ImU32 screenColor(const glm::vec3& linear, float opacity) {
  const glm::vec3 shown = glm::clamp(linear, 0.0f, 1.0f);
  return ImGui::GetColorU32({srgbFromLinear(shown.r), srgbFromLinear(shown.g), srgbFromLinear(shown.b), opacity});
}

std::string durationText(double milliseconds) {
  if (milliseconds < 0.005) return "0 ms";
  if (milliseconds < 0.0995) return formatted("%.0f µs", 1e3 * milliseconds);
  if (milliseconds < 9.95) return formatted("%.2g ms", milliseconds);
  if (milliseconds < 999.5) return formatted("%.0f ms", milliseconds);
  if (milliseconds < 9950.0) return formatted("%.1f s", milliseconds / 1e3);
  return formatted("%.0f s", milliseconds / 1e3);
}

std::string bytesText(size_t bytes) {
  if (bytes < 1000) return std::to_string(bytes) + " bytes";
  if (bytes < 1000 * 1000) return formatted("%.0f kB", static_cast<double>(bytes) / 1e3);
  return formatted("%.2f MB", static_cast<double>(bytes) / 1e6);
}

void tooltip(const std::string& text, const Look& look) {
  // Who types looks at what is typed, and has left the pointer where it was.
  if (ImGui::GetIO().WantTextInput || !ImGui::IsItemHovered() || !look.hover->hasRested(ImGui::GetItemRectMin(), look.now)) return;
  const ImVec2 padding{look.px(8.0f), look.px(6.0f)};
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, padding);
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(look.px(300.0f));
  ImGui::TextUnformatted(text.c_str());
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
  ImGui::PopStyleVar();
}

void tooltip(Action action, const Look& look) {
  const ActionDescriptor& described = describe(action);
  tooltip(std::string(described.help) + ". Key " + std::string(described.keys) + ".", look);
}

void drawStatusBar(const Session& session, double displayFramesPerSecond, const Look& look) {
  std::vector<std::string> items;
  if (const Scene* scene = session.scene()) {
    const glm::uvec3 dims = scene->geometry().dims;
    items.push_back(scene->name);
    items.push_back(std::to_string(dims.x) + " × " + std::to_string(dims.y) + " × " + std::to_string(dims.z) + " voxels");
  } else {
    items.push_back("no scene yet");
  }
  if (const SampleFramePtr& frame = session.frames().newest()) {
    items.push_back(grouped(frame->size()) + " samples");
    const Camera& camera = frame->camera;
    items.push_back(bytesText(session.frames().bytesOfNewest().ofFrame()) + " a frame" + (session.isFrameSmaller() ? " of " + std::to_string(camera.width) + " × " + std::to_string(camera.height) : ""));
    const double rate = session.frames().perSecond(look.now);
    const std::optional<SourceStatus> status = session.sourceStatus();
    items.push_back("server " + durationText(frame->timings.marchMs + frame->timings.compactMs) +
                    (status && !status->isConnected ? std::string(", not connected")
                     : rate > 0.0                   ? ", " + formatted("%.1f frames/s", rate)
                     : session.frames().isUnderWay()     ? std::string(", at work")
                                                    : std::string(", idle")));
  }
  if (const std::optional<SourceStatus> status = session.sourceStatus(); status && status->busyWith)
    items.insert(items.begin() + 1, busySentence(*status->busyWith));
  if (session.exporting().isAtWork())
    items.insert(items.begin() + 1, session.exporting().isFilming() ? std::string("making the film")
                                              : "exporting " + std::to_string(session.exporting().begun()) + " of " + std::to_string(session.exporting().pictures()));
  const std::string display =
      displayFramesPerSecond > 0.0 ? formatted("display %.0f frames/s", displayFramesPerSecond) : std::string("display idle");

  const float right = ImGui::GetWindowContentRegionMax().x;
  const float displayWidth = ImGui::CalcTextSize(display.c_str()).x;
  const float gap = look.px(22.0f);
  ImGui::AlignTextToFramePadding();
  for (size_t i = 0; i < items.size(); ++i) {
    if (i > 0) ImGui::SameLine(0.0f, gap);
    // What does not fit is left out; the first says most.
    if (ImGui::GetCursorPosX() + ImGui::CalcTextSize(items[i].c_str()).x + gap > right - displayWidth) break;
    ImGui::TextColored(i == 0 ? ImGui::GetStyle().Colors[ImGuiCol_Text] : palette().dimText, "%s", items[i].c_str());
  }
  ImGui::SameLine(right - displayWidth);
  ImGui::TextColored(palette().dimText, "%s", display.c_str());
}

void drawErrorBanner(Session& session, const Look& look) {
  const std::string failure = session.error();
  const std::string error = failure.empty() ? connectionTrouble(session, look) : failure;
  if (error.empty()) return;
  const float buttonWidth = look.px(72.0f), padding = look.px(8.0f);
  const float wrap = ImGui::GetContentRegionAvail().x - buttonWidth - 3.0f * padding;
  const float height = std::max(ImGui::CalcTextSize(error.c_str(), nullptr, false, wrap).y, ImGui::GetFrameHeight()) + 2.0f * padding;
  ImGui::SetCursorPosY(std::max(ImGui::GetWindowHeight() - height, 0.0f));
  ImGui::PushStyleColor(ImGuiCol_ChildBg, palette().errorBackground);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {padding, padding});
  ImGui::BeginChild("error", {0.0f, height}, true, ImGuiWindowFlags_NoScrollbar);
  // By itself: Dear ImGui draws a child's ground into its parent's list, beneath other children, where it does not overlap the one before it.
  const ImVec2 from = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
  ImGui::GetWindowDrawList()->AddRectFilled(from, {from.x + size.x, from.y + size.y}, ImGui::GetColorU32(palette().errorBackground), ImGui::GetStyle().ChildRounding);
  ImGui::PushTextWrapPos(padding + wrap);
  ImGui::AlignTextToFramePadding();
  ImGui::TextColored(palette().errorText, "%s", error.c_str());
  ImGui::PopTextWrapPos();
  if (!failure.empty()) {  // the connection's trouble goes by itself
    ImGui::SameLine(ImGui::GetWindowWidth() - buttonWidth - padding);
    ImGui::SetCursorPosY(padding);
    if (ImGui::Button("Dismiss", {buttonWidth, 0.0f})) session.dismissErrors();
  }
  ImGui::EndChild();
  ImGui::PopStyleVar();
  ImGui::PopStyleColor();
}

}  // namespace warpscope::ui
