// Real volumes for tests. Data sets are no part of the repository: the environment variable WARPSCOPE_DATA names their folder.
// Open SciVis Datasets (Klacansky); SPM's brain template. A test without its file is skipped and says what to set.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

namespace warpscope {

/// A file of the data sets, which may be missing.
class RealData {
 public:
  explicit RealData(const std::string& name) {
    const char* folder = std::getenv("WARPSCOPE_DATA");
    if (folder != nullptr && *folder != '\0') path_ = std::filesystem::path(folder) / name;
    if (path_.empty())
      whyMissing_ = "set WARPSCOPE_DATA to the folder that holds " + name;
    else if (std::error_code ignored; !std::filesystem::exists(path_, ignored))
      whyMissing_ = path_.string() + " is not there; set WARPSCOPE_DATA to the folder that holds it";
#if !WARPSCOPE_WITH_ITK
    else if (!name.ends_with(".raw"))
      whyMissing_ = "this build reads raw volumes only";
#endif
  }

  const std::filesystem::path& path() const { return path_; }
  /// Empty if the file is there: else what GTEST_SKIP says.
  const std::string& whyMissing() const { return whyMissing_; }

 private:
  std::filesystem::path path_;
  std::string whyMissing_;
};

}  // namespace warpscope
