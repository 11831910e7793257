// Popups in the middle of the window; a click beside them, and Esc, mean no.
// See questions.h.
#include "app/ui/questions.h"

#include <array>
#include <utility>

namespace warpscope::ui {
namespace {

constexpr const char *kExport = "Export film", *kQuit = "Quit?";
constexpr float kSizePx = 150.0f;
constexpr uint32_t kMostAcross = 16384;  // H.264 by libx264

struct FilmSize {
  const char* name;
  glm::uvec2 px;  ///< of each technique's picture; 0: as on show
};
constexpr std::array<FilmSize, 6> kSizes{{{"as on show", {0, 0}}, {"512 × 512", {512, 512}}, {"1024 × 1024", {1024, 1024}}, {"1280 × 720", {1280, 720}}, {"1920 × 1080", {1920, 1080}},
                                          {"3840 × 2160", {3840, 2160}}}};

/// True where it is open: ImGui::EndPopup() ends it.
bool beginQuestion(const char* name, bool& isAsked) {
  if (std::exchange(isAsked, false)) ImGui::OpenPopup(name);
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.5f * display.x, 0.5f * display.y}, ImGuiCond_Always, {0.5f, 0.5f});
  if (!ImGui::BeginPopup(name)) return false;
  ImGui::TextUnformatted(name);
  ImGui::Separator();
  return true;
}

/// What was pressed closes the popup. `width` 0: the text's.
bool answer(const char* text, float width = 0.0f) {
  const bool isPressed = ImGui::Button(text, {width, 0.0f});
  if (isPressed) ImGui::CloseCurrentPopup();
  return isPressed;
}

}  // namespace

std::optional<ExportLook> ExportQuestion::draw(const Session& session, const Look& look) {
  if (!beginQuestion(kExport, isAsked_)) return std::nullopt;
  std::optional<ExportLook> chosen;
  const glm::uvec2 shown = session.pictureSize(), size = size_ == 0 ? shown : kSizes[size_].px;
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted("Each picture");
  ImGui::SameLine();
  ImGui::SetNextItemWidth(look.px(kSizePx));
  if (ImGui::BeginCombo("##size", kSizes[size_].name)) {
    for (size_t i = 0; i < kSizes.size(); ++i)
      if (ImGui::Selectable(kSizes[i].name, i == size_)) size_ = i;
    ImGui::EndCombo();
  }
  ImGui::Checkbox("Names and ages below", &hasLabels_);
  tooltip("The technique's name and how old its frame is, below each picture; below all the time, and what was simulated of the link.", look);
  const std::string whyNoTruth = session.whyNoTruth();
  ImGui::BeginDisabled(!whyNoTruth.empty());
  ImGui::Checkbox("Errors below", &hasErrors_);
  ImGui::EndDisabled();
  tooltip(whyNoTruth.empty() ? "PSNR, FLIP and holes of each picture against the ground truth, which is marched for it: that takes longer." : "There is no ground truth: " + whyNoTruth, look);
  const size_t count = session.playback().isOpen() ? pictureCount(session.playback().recording(), kExportRate) : 0;
  size_t panels = 0;
  for (size_t i = 0; i < session.panelCount(); ++i) panels += !session.panel(i).isHidden;
  const std::string many = panels == 1 ? std::string() : std::to_string(panels) + " beside each other, ";
  ImGui::TextColored(palette().dimText, "%zu pictures, %.1f s: %seach %u × %u", count, static_cast<double>(count) / kExportRate, many.c_str(), size.x, size.y);
  ImGui::Spacing();
  const bool isTooWide = panels * size.x > kMostAcross;
  if (isTooWide) ImGui::TextColored(palette().errorText, "More than %u pixels across: films cannot be so wide.", kMostAcross);
  ImGui::BeginDisabled(isTooWide);
  const bool isChosen = answer("Choose a file...");
  ImGui::EndDisabled();
  if (isChosen) chosen = ExportLook{size_ == 0 ? glm::uvec2(0) : size, hasLabels_, hasErrors_ && whyNoTruth.empty()};
  ImGui::SameLine();
  answer("Cancel");
  ImGui::EndPopup();
  return chosen;
}

bool QuitQuestion::draw(const Session& session) {
  isOpen_ = beginQuestion(kQuit, isAsked_);
  if (!isOpen_) return false;
  // It may end by itself meanwhile: then nothing would be lost.
  const bool isAtWork = session.exporting().isAtWork();
  constexpr const char* kAtWork = "A film is being written. Who quits now gives it up: nothing is left of it.";
  ImGui::TextUnformatted(isAtWork ? kAtWork : "The film has been written.");
  ImGui::SameLine(ImGui::GetStyle().WindowPadding.x + ImGui::CalcTextSize(kAtWork).x);
  ImGui::NewLine();  // as wide as it was
  ImGui::Spacing();
  // Nothing moves beneath a pointer that is on its way.
  constexpr const char* kGiveUp = "Give it up and quit";
  const bool isYes = answer(isAtWork ? kGiveUp : "Quit", ImGui::CalcTextSize(kGiveUp).x + 2.0f * ImGui::GetStyle().FramePadding.x);
  ImGui::SameLine();
  answer("Go on");
  ImGui::EndPopup();
  return isYes;
}

}  // namespace warpscope::ui
