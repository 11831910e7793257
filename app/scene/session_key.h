// How session files are told from scenes, which are JSON as well.
#pragma once

#include <string_view>

namespace warpscope {

/// The key that only sessions have (session/session_file.h).
inline constexpr std::string_view kSessionKey = "warpscopeSession";

}  // namespace warpscope
