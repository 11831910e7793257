// What tells a file, and its versions, apart without reading them: its number in its file system, its size, and to the nanosecond when it was written and when
// anything of it was changed last, which who copies a file cannot set.
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
  const auto textOf = [](const timespec& time) { return std::to_string(time.tv_sec) + "." + std::to_string(time.tv_nsec); };
  return "file " + std::to_string(facts.st_ino) + ", " + std::to_string(facts.st_size) + " bytes of " + textOf(facts.st_mtim) + " and " + textOf(facts.st_ctim);
}

}  // namespace warpscope
