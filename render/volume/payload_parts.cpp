// Looking at files.
// See payload_parts.h. Decompression: zlib.
#include "render/volume/payload_parts.h"

#include <zlib.h>

#include <fstream>
#include <memory>

#include "render/base/error.h"

namespace warpscope::payload_parts {

namespace fs = std::filesystem;
using Encoding = Payload::Encoding;

void fail(const fs::path& path, const std::string& reason) {
  throw InputError(path.string() + ": " + reason);
}

void requirePart(const fs::path& path, const fs::path& part, const std::string& name) {
  std::error_code error;
  const fs::file_status status = fs::status(part, error);
  if (status.type() == fs::file_type::regular) return;
  if (status.type() == fs::file_type::not_found) fail(path, name + " is missing");
  if (status.type() == fs::file_type::none) fail(path, name + " cannot be looked at: " + error.message());
  fail(path, name + (status.type() == fs::file_type::directory ? " is a folder" : " is no regular file but a pipe or a device"));
}

std::vector<unsigned char> headOf(const fs::path& path, size_t sizeBytes) {
  std::vector<unsigned char> head(sizeBytes);
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> file(gzopen(path.string().c_str(), "rb"), gzclose);
  const int got = file ? gzread(file.get(), head.data(), static_cast<unsigned>(sizeBytes)) : 0;
  head.resize(got > 0 ? static_cast<size_t>(got) : 0);
  return head;
}

namespace {

bool isGzip(const fs::path& path) {
  std::array<char, 2> magic{};
  std::ifstream(path, std::ios::binary).read(magic.data(), 2);
  return magic[0] == '\x1f' && magic[1] == '\x8b';
}

}  // namespace

Payload wholeFile(const fs::path& path, uint64_t skipBytes) {
  Payload payload{.file = path};
  payload.encoding = isGzip(path) ? Encoding::deflated : Encoding::plain;
  (payload.encoding == Encoding::plain ? payload.offsetBytes : payload.skipBytes) = skipBytes;
  return payload;
}

}  // namespace warpscope::payload_parts
