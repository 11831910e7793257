// Tables in windows of ImGui's own.
// See help_pages.h.
#include "app/ui/help_pages.h"

#include <algorithm>
#include <thread>

#include "app/session/actions.h"
#include "render/core/instruction_set.h"

namespace warpscope::ui {
namespace {

constexpr ImGuiWindowFlags kFlags = ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoSavedSettings;

/// In the middle of the window, as wide as that if there is room; `draw` fills a table of two columns, the first so wide.
template <class Draw>
void drawPage(const char* title, bool& isOpen, float widthPx, float firstPx, const Look& look, const Draw& draw) {
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.5f * display.x, 0.5f * display.y}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSize({std::min(look.px(widthPx), 0.96f * display.x), 0.0f});
  ImGui::SetNextWindowSizeConstraints({0.0f, 0.0f}, {display.x, 0.9f * display.y});
  ImGui::PushStyleColor(ImGuiCol_WindowBg, ImGui::GetStyleColorVec4(ImGuiCol_PopupBg));
  if (ImGui::Begin(title, &isOpen, kFlags) && ImGui::BeginTable("page", 2)) {
    ImGui::TableSetupColumn("first", ImGuiTableColumnFlags_WidthFixed, look.px(firstPx));
    ImGui::TableSetupColumn("second", ImGuiTableColumnFlags_WidthStretch);
    draw();
    ImGui::EndTable();
  }
  ImGui::End();
  ImGui::PopStyleColor();
}

void row(std::string_view first, std::string_view second) {
  ImGui::TableNextColumn();
  ImGui::TextColored(palette().accent, "%s", std::string(first).c_str());
  ImGui::TableNextColumn();
  ImGui::TextWrapped("%s", std::string(second).c_str());
}

}  // namespace

void drawKeysPage(bool& isOpen, const Look& look) {
  drawPage("Keys", isOpen, 620.0f, 150.0f, look, [] {
    row("drag", "Orbit; with the right button pan, with the wheel zoom; a double click brings the first view back");
    for (const ActionDescriptor& action : windowActions())
      row(!action.keys.empty() ? std::string(action.keys) : "menu", std::string(action.label.substr(0, action.label.find("..."))) + ". " + std::string(action.help));
  });
}

void drawAboutPage(bool& isOpen, const Session& session, const std::string& renderer, const Look& look) {
  drawPage("About", isOpen, 520.0f, 110.0f, look, [&] {
    row("warpscope", WARPSCOPE_VERSION ", under the MIT licence. Ways of warping volume renderings, side by side.");
    if (const std::optional<SourceStatus> status = session.sourceStatus()) row("Frames from", status->where);
    row("CPU", std::to_string(std::thread::hardware_concurrency()) + " threads, " + std::string(instructionSet()));
    row("Window", renderer + "; Dear ImGui " IMGUI_VERSION);
    row("More", "`warpscope info` lists CUDA devices, techniques, heuristics, scenes and formats.");
  });
}

}  // namespace warpscope::ui
