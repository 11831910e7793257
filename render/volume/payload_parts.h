// What the readers of headers share: bytes and fields of a header, files that belong to one, and the sentence that refuses it.
// Mirrors nothing by itself: see payload.h, whose limits and errors these are.
#pragma once

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <vector>

#include "render/volume/payload.h"

namespace warpscope::payload_parts {

/// Throws InputError, which names `path`.
[[noreturn]] void fail(const std::filesystem::path& path, const std::string& reason);

/// Throws InputError unless `part`, which belongs to `path` and is called `name` there, is a file.
void requirePart(const std::filesystem::path& path, const std::filesystem::path& part, const std::string& name);

/// The first bytes of a file, decompressed if it is a gzip file; fewer where it ends before.
std::vector<unsigned char> headOf(const std::filesystem::path& path, size_t sizeBytes);

/// A file that is either plain or wholly gzipped, with its voxels after `skipBytes`.
Payload wholeFile(const std::filesystem::path& path, uint64_t skipBytes);

template <class T>
T fieldAt(const std::vector<unsigned char>& head, size_t offset, bool swap) {
  std::array<unsigned char, sizeof(T)> bytes;
  std::copy_n(head.begin() + static_cast<std::ptrdiff_t>(offset), sizeof(T), bytes.begin());
  if (swap) std::reverse(bytes.begin(), bytes.end());
  T value;
  std::memcpy(&value, bytes.data(), sizeof(T));
  return value;
}

}  // namespace warpscope::payload_parts
