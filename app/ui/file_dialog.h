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
  enum class Purpose { open, openFunction, saveSession, record, exportFilm, saveFunction, saveColorMap };

  /// Asks by the desktop's dialogs from now on, where there are some. `onNews`: as DesktopDialog's.
  void useDesktop(std::function<void()> onNews) { desktop_.emplace(std::move(onNews)); }
  /// `name` is proposed for a file to be written. Begins in the folder where one of its kind was chosen last: data are not where results go, and transfer functions
  /// lie elsewhere.
  void show(Purpose purpose, const std::string& name = "");
  /// Whether this one is: the desktop's are not the window's.
  bool isOpen() const { return isOpen_; }
  Purpose purpose() const { return purpose_; }
  void close() { isOpen_ = false; }
  /// What was chosen last could not be written, or read: asks again, with the same name.
  void askAgain(const std::string& why);
  /// The file that was chosen, once.
  std::optional<std::filesystem::path> draw(const Look& look);

 private:
  struct Entry {
    std::string name;
    bool isFolder = false;
    std::optional<uintmax_t> bytes{};  ///< of a file whose size is known
  };
  /// That of what it is asked for now.
  std::filesystem::path& current();
  void enter(const std::filesystem::path& folder);
  void open();
  /// The folder's entries; true where a double click chose one.
  bool drawEntries(const Look& look);
  /// Where a name or a path is typed; true where Enter chose it.
  bool drawName(float width);
  /// What was chosen, unless that is a folder, which is entered, or a file that is there, which the user is asked about first.
  std::optional<std::filesystem::path> take();
  /// The entry before or after that of the name, as the arrow keys go.
  const Entry* neighbour(std::string_view name, int step);

  std::optional<DesktopDialog> desktop_;
  Purpose purpose_ = Purpose::open;
  bool isOpen_ = false;
  bool wantsFocus_ = false;  // the field is to have the keyboard
  bool showsAll_ = false;    // files that cannot be what is asked for, too
  std::optional<size_t> toScrollTo_;
  std::filesystem::path toReplace_;  // a file that is there, and that the user was asked about
  std::filesystem::path clicked_;    // the entry that was clicked last: a double click is two on the same
  std::array<std::filesystem::path, 3> folders_;  // of data, of results, of transfer functions
  std::vector<Entry> entries_;
  std::string error_;
  std::array<char, 1024> name_{};
};

}  // namespace warpscope::ui
