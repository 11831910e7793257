// A list of what is in a folder.
// See file_dialog.h.
#include "app/ui/file_dialog.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "app/shell/log.h"
#include "render/base/printable.h"

namespace warpscope::ui {
namespace {

constexpr size_t kMostEntries = 20000;

std::string_view titleOf(FileDialog::Purpose purpose) {
  switch (purpose) {
    case FileDialog::Purpose::open: return "Open";
    case FileDialog::Purpose::saveSession: return "Save session";
    case FileDialog::Purpose::record: return "Record";
  }
  return "";
}

void copyInto(std::array<char, 1024>& field, const std::string& text) {
  const size_t size = std::min(text.size(), field.size() - 1);
  std::copy_n(text.begin(), size, field.begin());
  field[size] = '\0';
}

}  // namespace

void FileDialog::show(Purpose purpose, const std::string& name) {
  if (desktop_ && desktop_->isOpen()) return;
  purpose_ = purpose;
  copyInto(name_, name);
  std::error_code failed;
  if (folder_.empty()) folder_ = std::filesystem::current_path(failed);
  if (desktop_ && desktop_->show({std::string(titleOf(purpose)), folder_, name})) return;
  open();
}

void FileDialog::open() {
  toReplace_.clear();
  isOpen_ = true;
  enter(std::filesystem::path(folder_));
}

void FileDialog::enter(const std::filesystem::path& folder) {
  error_.clear();
  std::vector<Entry> entries;
  std::error_code failed;
  std::filesystem::directory_iterator at(folder, failed), end;
  for (; !failed && at != end && entries.size() < kMostEntries; at.increment(failed)) {
    std::error_code ignored;
    const std::string name = at->path().filename().string();
    if (name.empty() || name.front() == '.') continue;
    const bool isFolder = at->is_directory(ignored);
    entries.push_back({name, isFolder, isFolder ? 0 : at->file_size(ignored)});
  }
  if (failed) {
    error_ = folder.string() + ": " + failed.message();
    return;
  }
  std::ranges::sort(entries, [](const Entry& a, const Entry& b) { return std::pair(!a.isFolder, a.name) < std::pair(!b.isFolder, b.name); });
  folder_ = folder;
  entries_ = std::move(entries);
}

std::optional<std::filesystem::path> FileDialog::draw(const Look& look) {
  if (desktop_) {
    if (const std::optional<DesktopDialog::Answer> answer = desktop_->tryTake()) {
      if (answer->path) {
        folder_ = answer->path->parent_path();
        return answer->path;
      }
      if (answer->hasFailed) {
        logDetail(answer->error);
        open();
      }
    }
  }
  if (!isOpen_) return std::nullopt;
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.5f * display.x, 0.5f * display.y}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSize({std::min(look.px(620.0f), 0.96f * display.x), std::min(look.px(460.0f), 0.9f * display.y)});
  std::optional<std::filesystem::path> chosen;
  bool isChosen = false;
  const bool isWriting = purpose_ != Purpose::open;
  if (ImGui::Begin((std::string(titleOf(purpose_)) + "###file dialog").c_str(), &isOpen_, ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoSavedSettings)) {
    if (ImGui::Button("Up")) enter(folder_.parent_path());
    ImGui::SameLine();
    ImGui::TextColored(palette().dimText, "%s", printable(folder_.string()).c_str());
    ImGui::BeginChild("entries", {0.0f, -2.0f * ImGui::GetFrameHeightWithSpacing()}, true);
    std::optional<std::filesystem::path> entered;
    for (const Entry& entry : entries_) {
      const std::string text = printable(entry.name) + (entry.isFolder ? "/" : "") + "##" + entry.name;
      if (ImGui::Selectable(text.c_str(), entry.name == name_.data(), ImGuiSelectableFlags_AllowDoubleClick)) {
        if (entry.isFolder)
          entered = folder_ / entry.name;
        else
          copyInto(name_, entry.name);
        isChosen = !isWriting && !entry.isFolder && (look.isDoubleClicked || ImGui::IsMouseDoubleClicked(0));
      }
      if (entry.isFolder) continue;
      const std::string size = bytesText(entry.bytes);
      ImGui::SameLine(ImGui::GetWindowContentRegionMax().x - ImGui::CalcTextSize(size.c_str()).x);
      ImGui::TextColored(palette().faintText, "%s", size.c_str());
    }
    ImGui::EndChild();
    if (entered) enter(*entered);
    const float button = look.px(84.0f);
    ImGui::SetNextItemWidth(-2.0f * button - 2.0f * ImGui::GetStyle().ItemSpacing.x);
    isChosen |= ImGui::InputTextWithHint("##name", isWriting ? "name of the file" : "name or path of a file", name_.data(), name_.size(),
                                         ImGuiInputTextFlags_EnterReturnsTrue);
    ImGui::SameLine();
    isChosen |= ImGui::Button(!isWriting ? "Open" : toReplace_.empty() ? "Save" : "Replace", {button, 0.0f});
    ImGui::SameLine();
    if (ImGui::Button("Cancel", {button, 0.0f})) isOpen_ = false;
    if (!error_.empty()) ImGui::TextColored(palette().errorText, "%s", printable(error_).c_str());
  }
  ImGui::End();
  if (!isChosen || name_[0] == '\0') return std::nullopt;
  const std::filesystem::path path = folder_ / name_.data();
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    enter(path);
    name_[0] = '\0';
    return std::nullopt;
  }
  // A file that is there is not replaced without a question: the button asks.
  if (isWriting && std::filesystem::exists(path, ignored) && toReplace_ != name_.data()) {
    toReplace_ = name_.data();
    return std::nullopt;
  }
  isOpen_ = false;
  return path;
}

}  // namespace warpscope::ui
