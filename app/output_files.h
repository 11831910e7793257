// Output that is there whole or not at all.
// Files are written under another name in the same folder and renamed when complete (POSIX rename is atomic).
#pragma once

#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

namespace warpscope {

/// Writes `bytes` to `path`, replacing what is there. Throws InputError naming the path and the reason; then nothing has changed.
void writeFileWhole(const std::filesystem::path& path, std::string_view bytes);

/// Gathers files for a folder and puts them there together. Without commit() everything that was written goes again, and the folder too
/// if it was made here.
class StagedFolder {
 public:
  /// Makes the folder if need be and makes sure that it can be written to. Throws InputError.
  explicit StagedFolder(std::filesystem::path folder);
  ~StagedFolder();
  StagedFolder(const StagedFolder&) = delete;
  StagedFolder& operator=(const StagedFolder&) = delete;

  /// Safe to call from several threads for different names. Throws InputError.
  void write(const std::string& name, std::string_view bytes);
  /// Moves everything into the folder, replacing files of the same names. Throws InputError.
  void commit();

 private:
  std::filesystem::path folder_;
  std::filesystem::path staging_;
  std::vector<std::filesystem::path> made_;  // folders that did not exist, outermost first
};

}  // namespace warpscope
