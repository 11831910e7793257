// Small files of text, read whole: scenes, transfer functions, plans, recorded delays, addresses.
// POSIX open and fstat: what is read is what was looked at, and nothing is waited for that is no file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace warpscope {

/// The bytes of a regular file. Throws InputError, which names the file, if there is none, it is a folder, a pipe, a socket or a device, or it holds
/// more than `maxBytes`; `what` says for what that is too much ("a scene file").
std::string readInputFile(const std::filesystem::path& path, uint64_t maxBytes, std::string_view what);

/// Of how many bytes, as messages say it: "16 MiB", "1.5 GiB".
std::string sizeText(uint64_t bytes);

}  // namespace warpscope
