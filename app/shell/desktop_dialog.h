// The desktop's own dialogs for files, by the programs that its desktops come with for that: zenity (GNOME and others) and kdialog (KDE).
// In a thread of its own: they take as long as the user does.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "render/base/newest_worker.h"

namespace warpscope {

struct DialogWish {
  std::string title;
  std::filesystem::path folder;  ///< to begin in
  std::string name;              ///< proposed, of a file that is to be written; empty: a file is to be opened
  std::vector<std::string_view> endings{};  ///< of the names of such files, with the dot; others are shown on request. Empty: all files
};

/// What asks so; empty where there is no such program, or no desktop.
std::vector<std::string> desktopDialogCommand(const DialogWish& wish);

class DesktopDialog {
 public:
  /// `onNews` is called on another thread when there is an answer.
  explicit DesktopDialog(std::function<void()> onNews);

  /// False where there is none: nothing happens then. One at a time.
  bool show(const DialogWish& wish);
  bool isOpen() const { return isOpen_; }

  struct Answer {
    std::optional<std::filesystem::path> path;  ///< nothing: the user has chosen none
    bool hasFailed = false;                     ///< the program did not do what it should: another dialog is needed
    std::string error;                          ///< why
  };
  std::optional<Answer> tryTake();

 private:
  bool isOpen_ = false;
  std::unique_ptr<NewestWorker<std::vector<std::string>, Answer>> worker_;
};

}  // namespace warpscope
