// Where this program keeps what it remembers of its user: the XDG Base Directory Specification.
#pragma once

#include <filesystem>
#include <optional>

namespace warpscope {

/// $XDG_STATE_HOME/warpscope, or .local/state/warpscope in the home folder; nothing where neither is known. It need not be there.
std::optional<std::filesystem::path> stateFolder();

/// The file of the session that was on show when a window was closed last, in that folder.
std::optional<std::filesystem::path> lastSessionFile();
/// The same, if it is there.
std::optional<std::filesystem::path> lastSession();

/// The file of what windows remember (session/remembered.h), in that folder.
std::optional<std::filesystem::path> rememberedFile();

}  // namespace warpscope
