// Choosing a file by looking through folders: to open one, or to name one that is to be written.
// Drawn by Dear ImGui, so that it is the same everywhere and needs no desktop.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/ui/parts.h"

namespace warpscope::ui {

class FileDialog {
 public:
  enum class Purpose { open, saveSession, record };

  /// `name` is proposed for a file to be written. Begins in the folder where it was used last.
  void show(Purpose purpose, const std::string& name = "");
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

  Purpose purpose_ = Purpose::open;
  bool isOpen_ = false;
  std::string toReplace_;  // the name of a file that is there, and that the user was asked about
  std::filesystem::path folder_;
  std::vector<Entry> entries_;
  std::string error_;
  std::array<char, 1024> name_{};
};

}  // namespace warpscope::ui
