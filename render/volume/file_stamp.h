// What tells versions of a file apart without reading them: its size and when it was written last.
#pragma once

#include <filesystem>
#include <string>

namespace warpscope {

/// Empty where it is not to be had.
inline std::string stampOf(const std::filesystem::path& file) {
  std::error_code failed;
  const uintmax_t bytes = std::filesystem::file_size(file, failed);
  if (failed) return "";
  const auto written = std::filesystem::last_write_time(file, failed);
  return failed ? "" : std::to_string(bytes) + " bytes of " + std::to_string(written.time_since_epoch().count());
}

}  // namespace warpscope
