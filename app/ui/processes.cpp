// What each process did that the server's volume is spread over, and when: a timeline a process, from when the frame reached it.
// See parts.h.
#include <algorithm>
#include <string>

#include "app/ui/parts.h"

namespace warpscope::ui {
namespace {

const ImVec4 kMarching{0.35f, 0.52f, 0.85f, 1.0f}, kWaiting{0.72f, 0.53f, 0.30f, 1.0f};
/// So many have a line of text each; of more the bars alone, and of still more the first.
constexpr size_t kMostNamed = 8, kMostDrawn = 64;

void drawKey(size_t number, const net::ProcessFields& process, const Look& look) {
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {look.px(8.0f), look.px(6.0f)});
  ImGui::BeginTooltip();
  ImGui::Text("Process %zu has cells %u, %u, %u to %u, %u, %u of the volume.", number, process.lower[0], process.lower[1], process.lower[2], process.upper[0], process.upper[1],
              process.upper[2]);
  ImGui::Text("%u tiles of a frame came to it, a GPU marched %u of them.", process.tiles, process.deviceTiles);
  ImGui::TextColored(kMarching, "Its threads marched for %s in all", durationText(process.marchMs).c_str());
  ImGui::TextColored(kWaiting, "and waited for tiles for %s.", durationText(process.waitMs).c_str());
  ImGui::Text("It sent %s to the others.", bytesText(static_cast<size_t>(process.sentBytes)).c_str());
  ImGui::EndTooltip();
  ImGui::PopStyleVar();
}

/// When the last of its threads was at it, since the frame reached it.
double endMs(const net::ProcessFields& process) {
  size_t slots = net::kProcessSlots;
  while (slots > 0 && process.marching[slots - 1] == 0 && process.waiting[slots - 1] == 0) --slots;
  return static_cast<double>(process.slotMs) * static_cast<double>(slots);
}

/// Over `lengthMs`: as high as threads marched, and above that as they waited, of `mostThreads`.
void drawTimeline(const net::ProcessFields& process, double lengthMs, double mostThreads, const ImVec2& at, const ImVec2& size) {
  ImDrawList* list = ImGui::GetWindowDrawList();
  list->AddRectFilled(at, {at.x + size.x, at.y + size.y}, ImGui::GetColorU32(ImGuiCol_FrameBg));
  if (!(lengthMs > 0.0 && mostThreads > 0.0)) return;
  const float pitch = size.x * static_cast<float>(static_cast<double>(process.slotMs) / lengthMs);
  const auto heightOf = [&](uint8_t slot) { return size.y * static_cast<float>(static_cast<double>(process.mostThreads) * slot / (255.0 * mostThreads)); };
  const float bottom = at.y + size.y;
  for (size_t i = 0; i < net::kProcessSlots; ++i) {
    const float left = at.x + pitch * static_cast<float>(i), right = std::min(left + pitch, at.x + size.x);
    if (left >= right) break;
    const float marched = bottom - heightOf(process.marching[i]), waited = std::max(at.y, marched - heightOf(process.waiting[i]));
    if (process.marching[i] > 0) list->AddRectFilled({left, marched}, {right, bottom}, ImGui::GetColorU32(kMarching));
    if (process.waiting[i] > 0) list->AddRectFilled({left, waited}, {right, marched}, ImGui::GetColorU32(kWaiting));
  }
}

}  // namespace

void drawProcesses(std::span<const net::ProcessFields> processes, const Look& look) {
  if (processes.empty()) return;
  double lengthMs = 0.0, mostThreads = 0.0;
  uint64_t sentBytes = 0;
  for (const net::ProcessFields& process : processes) {
    lengthMs = std::max(lengthMs, endMs(process));
    mostThreads = std::max(mostThreads, static_cast<double>(process.mostThreads));
    sentBytes += process.sentBytes;
  }
  ImGui::PushFont(look.fonts.small);
  ImGui::TextColored(palette().dimText, "%zu processes, %s a frame in %s", processes.size(), bytesText(static_cast<size_t>(sentBytes)).c_str(), durationText(lengthMs).c_str());
  const bool areNamed = processes.size() <= kMostNamed;
  const float line = ImGui::GetTextLineHeight(), height = areNamed ? line : look.px(4.0f), numbers = areNamed ? ImGui::CalcTextSize("00").x + look.px(4.0f) : 0.0f;
  for (size_t i = 0; i < std::min(processes.size(), kMostDrawn); ++i) {
    const net::ProcessFields& process = processes[i];
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float width = ImGui::GetContentRegionAvail().x;
    ImGui::PushID(static_cast<int>(i));
    ImGui::InvisibleButton("process", {width, height});
    ImGui::PopID();
    if (areNamed) ImGui::GetWindowDrawList()->AddText(at, ImGui::GetColorU32(palette().dimText), std::to_string(i).c_str());
    drawTimeline(process, lengthMs, mostThreads, {at.x + numbers, at.y + (areNamed ? 0.15f * line : 0.0f)}, {width - numbers, areNamed ? 0.7f * line : height - look.px(1.0f)});
    if (ImGui::IsItemHovered()) drawKey(i, process, look);
  }
  if (processes.size() > kMostDrawn) ImGui::TextColored(palette().dimText, "and %zu more", processes.size() - kMostDrawn);
  ImGui::PopFont();
}

}  // namespace warpscope::ui
