// What the window remembers of its user from one time to the next: its size, how it looks, what is folded up, which files were opened.
// A file in user_folders.h's folder: JSON; whatever in it cannot be used is as if it were not there.
#pragma once

#include <filesystem>
#include <glm/vec2.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace warpscope {

struct Remembered {
  static constexpr size_t kMostRecent = 12;

  std::optional<glm::uvec2> windowSize;  ///< in screen coordinates
  bool isLight = false;
  bool hasSideBar = true;
  std::set<std::string> folded;          ///< sections, by their headings
  std::vector<std::string> recentFiles;  ///< absolute paths, the newest first; at most kMostRecent

  /// Puts the file in front of the others.
  void addFile(const std::filesystem::path& path);
  void setFolded(const std::string& section, bool isFolded);

  bool operator==(const Remembered&) const = default;
};

/// Never throws: without a usable file nothing is remembered.
Remembered readRemembered(const std::filesystem::path& file);
/// Throws InputError where it cannot be written.
void writeRemembered(const std::filesystem::path& file, const Remembered& remembered);

}  // namespace warpscope
