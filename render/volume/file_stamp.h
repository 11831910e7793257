// What tells a file, and its versions, apart without reading them: its number in its file system, its size and when it was written last, to the nanosecond.
// Linux: stat(2).
#pragma once

#include <sys/stat.h>

#include <filesystem>
#include <string>

namespace warpscope {

/// The same for two processes where they see the same file, on whatever machine; of a copy it is another one. Empty where it is not to be had.
inline std::string stampOf(const std::filesystem::path& file) {
  struct stat facts {};
  if (stat(file.c_str(), &facts) != 0) return "";
  return "file " + std::to_string(facts.st_ino) + ", " + std::to_string(facts.st_size) + " bytes of " + std::to_string(facts.st_mtim.tv_sec) + "." + std::to_string(facts.st_mtim.tv_nsec);
}

}  // namespace warpscope
