// Files that the user keeps of what is on show: "warpscope-1.png", "warpscope-2-1-spheres.png" and so on, under a number that is not taken.
// Made and written by threads of their own: encoding a picture takes longer than the window may wait.
#pragma once

#include <filesystem>
#include <functional>
#include <future>
#include <optional>
#include <string>
#include <vector>

namespace warpscope {

class FileKeeper {
 public:
  /// Into that folder. `onNews` is called on another thread when something was written, or could not be.
  FileKeeper(std::filesystem::path folder, std::function<void()> onNews);
  /// Waits until all is written.
  ~FileKeeper() = default;

  /// Files that belong together have one number.
  struct File {
    std::string ending;                   ///< of the name: ".png", "-1-spheres.png"
    std::function<std::string()> content; ///< called on another thread; may throw
  };
  void keep(std::vector<File> files);
  /// What became of it, a sentence without its full stop; once.
  std::optional<std::string> takeNote();

 private:
  const std::filesystem::path folder_;
  const std::function<void()> onNews_;
  std::vector<std::future<std::string>> work_;
};

}  // namespace warpscope
