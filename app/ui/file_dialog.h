// Choosing a file by looking through folders: to open one, or to name one that is to be written.
// The desktop's own dialog where it is wanted and there is one; else drawn by Dear ImGui.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/shell/desktop_dialog.h"
#include "app/ui/parts.h"

namespace warpscope::ui {

class FileDialog {
 public:
  enum class Purpose { open, saveSession, record };

  /// Asks by the desktop's dialogs from now on, where there are some. `onNews`: as DesktopDialog's.
  void useDesktop(std::function<void()> onNews) { desktop_.emplace(std::move(onNews)); }
  /// `name` is proposed for a file to be written. Begins in the folder where it was used last.
  void show(Purpose purpose, const std::string& name = "");
  /// Whether this one is: the desktop's are not the window's.
  bool isOpen() const { return isOpen_; }
  Purpose purpose() const { return purpose_; }
  void close() { isOpen_ = false; }
  /// The file that was chosen, once.
  std::optional<std::filesystem::path> draw(const Look& look);

 private:
  struct Entry {
    std::string name;
    bool isFolder = false;
    uintmax_t bytes = 0;
  };
  void enter(const std::filesystem::path& folder);
  void open();

  std::optional<DesktopDialog> desktop_;
  Purpose purpose_ = Purpose::open;
  bool isOpen_ = false;
  std::string toReplace_;  // the name of a file that is there, and that the user was asked about
  std::filesystem::path folder_;
  std::vector<Entry> entries_;
  std::string error_;
  std::array<char, 1024> name_{};
};

}  // namespace warpscope::ui
