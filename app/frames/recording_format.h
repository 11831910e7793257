// How a recording's file begins and what its records are: see recording.h. For those who write and read it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <string_view>

namespace warpscope {

/// Its last byte is the format's version.
inline constexpr std::string_view kRecordingMagic{"WSCOPER\x01", 8};

enum class RecordType : uint8_t { scene = 1, text = 2, view = 3, frame = 4, function = 5, link = 6 };

/// When, what and how long.
inline constexpr size_t kRecordHeadBytes = 8 + 1 + 4;
/// In the record of a link, between what is said in full and in brief.
inline constexpr char kBetweenSigns = '\n';

/// Reads bytes of a file; false where there are not as many.
inline bool readExactly(std::ifstream& file, std::byte* into, size_t count) {
  file.read(reinterpret_cast<char*>(into), static_cast<std::streamsize>(count));
  return static_cast<size_t>(file.gcount()) == count;
}

}  // namespace warpscope
