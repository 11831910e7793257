// A list of what is in a folder.
// See file_dialog.h.
#include "app/ui/file_dialog.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "app/experiment/replay_files.h"
#include "app/shell/log.h"
#include "app/shell/output_files.h"
#include "render/base/printable.h"
#include "render/volume/volume_format.h"

namespace warpscope::ui {
namespace {

constexpr size_t kMostEntries = 20000;

std::string_view titleOf(FileDialog::Purpose purpose) {
  switch (purpose) {
    case FileDialog::Purpose::open: return "Open";
    case FileDialog::Purpose::openFunction: return "Load transfer function";
    case FileDialog::Purpose::saveSession: return "Save session";
    case FileDialog::Purpose::record: return "Record";
    case FileDialog::Purpose::exportFilm: return "Export film (.mp4, .gif) or pictures (.png)";
    case FileDialog::Purpose::saveFunction: return "Save transfer function";
    case FileDialog::Purpose::saveColorMap: return "Save for ParaView";
  }
  return "";
}

/// Whether a file is to be read; else one is to be written.
bool isOpening(FileDialog::Purpose purpose) { return purpose == FileDialog::Purpose::open || purpose == FileDialog::Purpose::openFunction; }

/// What the names of such files end with, in lower case.
std::vector<std::string_view> endingsOf(FileDialog::Purpose purpose) {
  if (purpose == FileDialog::Purpose::record) return {".warpscope"};
  if (purpose == FileDialog::Purpose::exportFilm) return canFilm() ? std::vector<std::string_view>{".mp4", ".gif", ".png"} : std::vector<std::string_view>{".png", ".mp4", ".gif"};
  if (purpose != FileDialog::Purpose::open) return {".json"};
  std::vector<std::string_view> endings{".json", ".warpscope"};
  for (const VolumeEnding& volume : kVolumeEndings) endings.push_back(volume.ending);
  return endings;
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
  if (current().empty()) current() = std::filesystem::current_path(failed);
  if (desktop_ && desktop_->show({std::string(titleOf(purpose)), current(), name, endingsOf(purpose)})) return;
  open();
}

std::filesystem::path& FileDialog::current() {
  const bool isOfFunction = purpose_ == Purpose::openFunction || purpose_ == Purpose::saveFunction || purpose_ == Purpose::saveColorMap;
  return folders_[isOfFunction ? 2 : isOpening(purpose_) ? 0 : 1];
}

void FileDialog::open() {
  toReplace_.clear();
  isOpen_ = true;
  wantsFocus_ = true;
  enter(std::filesystem::path(current()));
}

void FileDialog::askAgain(const std::string& why) {
  open();
  error_ = why;
}

void FileDialog::enter(const std::filesystem::path& folder) {
  error_.clear();
  std::vector<Entry> entries;
  const std::vector<std::string_view> endings = endingsOf(purpose_);
  const auto isOffered = [&](const std::string& name) {
    return showsAll_ || std::ranges::any_of(endings, [lower = lowered(name)](std::string_view ending) { return lower.ends_with(ending); });
  };
  std::error_code failed;
  std::filesystem::directory_iterator at(folder, failed), end;
  for (; !failed && at != end && entries.size() < kMostEntries; at.increment(failed)) {
    std::error_code ignored;
    const std::string name = at->path().filename().string();
    if (name.empty() || name.front() == '.') continue;
    const bool isFolder = at->is_directory(ignored);
    if (!isFolder && !isOffered(name)) continue;
    const uintmax_t bytes = isFolder ? 0 : at->file_size(ignored);
    entries.push_back({name, isFolder, isFolder || ignored ? std::nullopt : std::optional(bytes)});
  }
  if (failed) {
    error_ = folder.string() + ": " + failed.message();
    return;
  }
  std::ranges::sort(entries, [](const Entry& a, const Entry& b) { return std::pair(!a.isFolder, a.name) < std::pair(!b.isFolder, b.name); });
  current() = folder;
  entries_ = std::move(entries);
  toReplace_.clear();
}

std::optional<std::filesystem::path> FileDialog::draw(const Look& look) {
  if (desktop_) {
    if (const std::optional<DesktopDialog::Answer> answer = desktop_->tryTake()) {
      if (answer->path) {
        current() = answer->path->parent_path();
        copyInto(name_, answer->path->filename().string());
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
  bool isChosen = false;
  const bool isWriting = !isOpening(purpose_);
  if (wantsFocus_) ImGui::SetNextWindowFocus();
  ImGui::PushStyleColor(ImGuiCol_WindowBg, ImGui::GetStyleColorVec4(ImGuiCol_PopupBg));
  if (ImGui::Begin((std::string(titleOf(purpose_)) + "###file dialog").c_str(), &isOpen_, ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoSavedSettings)) {
    if (ImGui::Button("Up")) enter(current().parent_path());
    ImGui::SameLine();
    if (ImGui::Checkbox("All files", &showsAll_)) enter(std::filesystem::path(current()));
    tooltip(isWriting ? "Not only those of the kind that is written." : "Not only those whose names end as scenes, volumes, sessions and recordings do.", look);
    ImGui::SameLine();
    ImGui::TextColored(palette().dimText, "%s", printable(current().string()).c_str());
    const float below = ImGui::GetFrameHeightWithSpacing() + ImGui::GetTextLineHeightWithSpacing();
    ImGui::BeginChild("entries", {0.0f, -below}, true);
    isChosen = drawEntries(look);
    ImGui::EndChild();
    const float button = look.px(84.0f);
    isChosen |= drawName(-2.0f * button - 2.0f * ImGui::GetStyle().ItemSpacing.x);
    ImGui::SameLine();
    isChosen |= ImGui::Button(!isWriting ? "Open" : toReplace_.empty() ? "Save" : "Replace", {button, 0.0f});
    ImGui::SameLine();
    if (ImGui::Button("Cancel", {button, 0.0f})) isOpen_ = false;
    if (!error_.empty())
      ImGui::TextColored(palette().errorText, "%s", printable(error_).c_str());
    else if (!toReplace_.empty())
      ImGui::TextColored(palette().dimText, "%s is there already.", printable(toReplace_.filename().string()).c_str());
  }
  ImGui::End();
  ImGui::PopStyleColor();
  return isChosen && name_[0] != '\0' ? take() : std::nullopt;
}

bool FileDialog::drawEntries(const Look& look) {
  bool isChosen = false;
  std::optional<std::filesystem::path> entered;
  if (toScrollTo_) ImGui::SetScrollFromPosY(ImGui::GetCursorStartPos().y - ImGui::GetScrollY() + ImGui::GetTextLineHeightWithSpacing() * static_cast<float>(*toScrollTo_));
  toScrollTo_.reset();
  ImGuiListClipper clipper;
  clipper.Begin(static_cast<int>(entries_.size()), ImGui::GetTextLineHeightWithSpacing());
  while (clipper.Step()) {
    for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) {
      const Entry& entry = entries_[static_cast<size_t>(i)];
      const std::string text = printable(entry.name) + (entry.isFolder ? "/" : "") + "##" + entry.name;
      if (ImGui::Selectable(text.c_str(), entry.name == name_.data(), ImGuiSelectableFlags_AllowDoubleClick)) {
        if (entry.isFolder)
          entered = current() / entry.name;
        else
          copyInto(name_, entry.name);
        wantsFocus_ = true;
        const bool isSame = std::exchange(clicked_, current() / entry.name) == current() / entry.name;  // not a folder's, in whose place this one is now
        isChosen = isOpening(purpose_) && !entry.isFolder && isSame && (look.isDoubleClicked || ImGui::IsMouseDoubleClicked(0));
      }
      if (!entry.bytes) continue;
      const std::string size = bytesText(*entry.bytes);
      ImGui::SameLine(ImGui::GetWindowContentRegionMax().x - ImGui::CalcTextSize(size.c_str()).x);
      ImGui::TextColored(palette().faintText, "%s", size.c_str());
    }
  }
  if (entries_.empty()) ImGui::TextColored(palette().dimText, showsAll_                      ? "Nothing is here."
                                                                   : isOpening(purpose_) ? "No files that can be opened are here; \"All files\" shows others."
                                                                                               : "No files of this kind are here; \"All files\" shows others.");
  if (entered) enter(*entered);
  return isChosen;
}

bool FileDialog::drawName(float width) {
  const auto onArrow = [](ImGuiInputTextCallbackData* data) {
    FileDialog& dialog = *static_cast<FileDialog*>(data->UserData);
    const Entry* const entry = dialog.neighbour({data->Buf, static_cast<size_t>(data->BufTextLen)}, data->EventKey == ImGuiKey_UpArrow ? -1 : 1);
    if (entry == nullptr) return 0;
    data->DeleteChars(0, data->BufTextLen);
    data->InsertChars(0, entry->name.c_str());
    data->SelectAll();
    return 0;
  };
  ImGui::SetNextItemWidth(width);
  if (std::exchange(wantsFocus_, false)) ImGui::SetKeyboardFocusHere();
  constexpr ImGuiInputTextFlags kFlags = ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_AutoSelectAll | ImGuiInputTextFlags_CallbackHistory;
  return ImGui::InputTextWithHint("##name", !isOpening(purpose_) ? "name of the file" : "name or path of a file", name_.data(), name_.size(), kFlags, onArrow, this);
}

const FileDialog::Entry* FileDialog::neighbour(std::string_view name, int step) {
  if (entries_.empty()) return nullptr;
  const auto at = std::ranges::find(entries_, name, [](const Entry& entry) { return std::string_view(entry.name); });
  size_t next = step > 0 ? 0 : entries_.size() - 1;
  if (at != entries_.end()) {
    const auto index = static_cast<size_t>(at - entries_.begin());
    next = step > 0 ? std::min(index + 1, entries_.size() - 1) : index - std::min<size_t>(index, 1);
  }
  toScrollTo_ = next;
  return &entries_[next];
}

std::optional<std::filesystem::path> FileDialog::take() {
  std::filesystem::path path = current() / name_.data();
  std::error_code ignored;
  wantsFocus_ = true;
  if (std::filesystem::is_directory(path, ignored)) {
    enter(path.lexically_normal());
    name_[0] = '\0';
    return std::nullopt;
  }
  if (const std::vector<std::string_view> endings = endingsOf(purpose_); !isOpening(purpose_)) {
    // Under another ending it would not be offered when it is to be opened; films have a choice of them, and others are refused.
    if (!path.has_extension() || (endings.size() == 1 && !lowered(path.filename().string()).ends_with(endings.front()))) {
      path += endings.front();
      copyInto(name_, name_.data() + std::string(endings.front()));
    }
  }
  const std::filesystem::path needed = isOpening(purpose_) ? path : path.parent_path();
  if (!std::filesystem::exists(needed, ignored)) {
    error_ = needed.string() + " is not there";
    return std::nullopt;
  }
  if (!isOpening(purpose_) && isSpecial(path)) {
    error_ = path.filename().string() + " is no regular file";
    return std::nullopt;
  }
  // A file that is there is not replaced without a question: the button asks.
  if (!isOpening(purpose_) && std::filesystem::exists(path, ignored) && toReplace_ != path) {
    toReplace_ = path;
    return std::nullopt;
  }
  isOpen_ = false;
  current() = path.parent_path().lexically_normal();
  return path;
}

}  // namespace warpscope::ui
