// From the environment.
// See user_folders.h.
#include "app/shell/user_folders.h"

#include <cstdlib>

namespace warpscope {

std::optional<std::filesystem::path> stateFolder() {
  // Paths there that are not absolute are to be taken as if they were not set.
  const auto absolute = [](const char* name) -> std::optional<std::filesystem::path> {
    const char* value = std::getenv(name);
    if (value == nullptr || !std::filesystem::path(value).is_absolute()) return std::nullopt;
    return std::filesystem::path(value);
  };
  if (const auto state = absolute("XDG_STATE_HOME")) return *state / "warpscope";
  if (const auto home = absolute("HOME")) return *home / ".local" / "state" / "warpscope";
  return std::nullopt;
}

std::optional<std::filesystem::path> rememberedFile() {
  const auto folder = stateFolder();
  return folder ? std::optional(*folder / "window.json") : std::nullopt;
}

std::optional<std::filesystem::path> lastSessionFile() {
  const auto folder = stateFolder();
  return folder ? std::optional(*folder / "last-session.json") : std::nullopt;
}

std::optional<std::filesystem::path> lastSession() {
  std::optional<std::filesystem::path> file = lastSessionFile();
  std::error_code unknown;
  if (file && !std::filesystem::exists(*file, unknown)) file.reset();
  return file;
}

}  // namespace warpscope
