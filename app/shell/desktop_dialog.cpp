// Command lines and exit codes.
// See desktop_dialog.h.
#include "app/shell/desktop_dialog.h"

#include <cstdlib>
#include <utility>

#include "app/shell/child_process.h"

namespace warpscope {
namespace {

bool isSet(const char* name) {
  const char* const value = std::getenv(name);
  return value != nullptr && value[0] != '\0';
}

bool isKde() {
  const char* const desktop = std::getenv("XDG_CURRENT_DESKTOP");
  return desktop != nullptr && std::string_view(desktop).find("KDE") != std::string_view::npos;
}

}  // namespace

std::vector<std::string> desktopDialogCommand(const DialogWish& wish) {
  if (!isSet("DISPLAY") && !isSet("WAYLAND_DISPLAY")) return {};
  const bool isWriting = !wish.name.empty();
  const std::string place = (wish.folder / wish.name).string();
  const bool hasZenity = hasProgram("zenity"), hasKdialog = hasProgram("kdialog");
  std::string patterns;
  for (const std::string_view ending : wish.endings) patterns += (patterns.empty() ? "*" : " *") + std::string(ending);
  if (hasKdialog && (isKde() || !hasZenity)) {
    std::vector<std::string> command{"kdialog", "--title", wish.title, isWriting ? "--getsavefilename" : "--getopenfilename", place};
    if (!patterns.empty()) command.push_back(wish.title + " (" + patterns + ")\nAll files (*)");
    return command;
  }
  if (!hasZenity) return {};
  std::vector<std::string> command{"zenity", "--file-selection", "--title=" + wish.title, "--filename=" + place};
  if (!patterns.empty()) command.insert(command.end(), {"--file-filter=" + wish.title + " | " + patterns, "--file-filter=All files | *"});
  if (isWriting) command.insert(command.end(), {"--save", "--confirm-overwrite"});
  return command;
}

DesktopDialog::DesktopDialog(std::function<void()> onNews)
    : worker_(std::make_unique<NewestWorker<std::vector<std::string>, Answer>>(
          []() -> NewestWorker<std::vector<std::string>, Answer>::Work {
            return [](const std::vector<std::string>& command, Answer& answer, const std::stop_token& stop) {
              answer.hasFailed = true;  // unless it ends well
              const ProgramEnd end = endOfProgram(command, stop);
              constexpr int kChosen = 0, kNoneChosen = 1;
              std::string path = end.written;
              while (!path.empty() && path.back() == '\n') path.pop_back();
              answer.hasFailed = !(end.exitCode == kNoneChosen || (end.exitCode == kChosen && !path.empty()));
              if (answer.hasFailed) answer.error = command.front() + " ended with " + std::to_string(end.exitCode) + ": " + end.said;
              if (end.exitCode == kChosen && !path.empty()) answer.path = path;
            };
          },
          std::move(onNews))) {}

bool DesktopDialog::show(const DialogWish& wish) {
  if (isOpen_) return true;
  std::vector<std::string> command = desktopDialogCommand(wish);
  if (command.empty()) return false;
  isOpen_ = true;
  worker_->post(std::move(command));
  return true;
}

std::optional<DesktopDialog::Answer> DesktopDialog::tryTake() {
  std::optional<Answer> answer = worker_->tryTake();
  if (answer) isOpen_ = false;
  return answer;
}

}  // namespace warpscope
