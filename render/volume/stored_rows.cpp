// pread(2): slices in parallel, each in pieces.
// See stored_rows.h.
#include "render/volume/stored_rows.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>

#include "render/base/error.h"
#include "render/core/parallel.h"

namespace warpscope {
namespace {

/// An open file, for any number of threads.
class OpenFile {
 public:
  explicit OpenFile(const std::filesystem::path& path) : name_(path.string()), file_(open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (file_ < 0) throw InputError(name_ + ": cannot be read: " + std::strerror(errno));
  }
  ~OpenFile() { close(file_); }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  void read(uint64_t at, std::byte* to, size_t bytes) const {
    while (bytes > 0) {
      const ssize_t got = pread(file_, to, std::min(bytes, kPiece), static_cast<off_t>(at));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0)
        throw InputError(name_ + ": bytes " + std::to_string(at) + " to " + std::to_string(at + bytes) + " cannot be read: " + (got < 0 ? std::strerror(errno) : "the file ends before"));
      at += static_cast<uint64_t>(got);
      to += got;
      bytes -= static_cast<size_t>(got);
    }
  }

 private:
  static constexpr size_t kPiece = size_t{64} << 20;
  const std::string name_;
  const int file_;
};

void swapBytes(std::byte* first, size_t bytes, size_t each) {
  for (size_t at = 0; at < bytes; at += each) std::reverse(first + at, first + at + each);
}

}  // namespace

SparseVoxels::Fill storedRows(const std::filesystem::path& file, uint64_t offsetBytes, const glm::uvec3& dims, size_t voxelBytes, bool isSwapped) {
  const auto opened = std::make_shared<const OpenFile>(file);
  return [=](const VoxelRows& rows, std::byte* voxels, const std::stop_token& stop) {
    const size_t rowBytes = dims.x * voxelBytes, bytes = rowBytes * (rows.upper.x - rows.lower.x);
    parallelForRanges(rows.upper.y - rows.lower.y, 1, stop, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        const size_t at = ((rows.lower.y + i) * dims.y + rows.lower.x) * rowBytes;
        opened->read(offsetBytes + at, voxels + at, bytes);
        if (isSwapped) swapBytes(voxels + at, bytes, voxelBytes);
      }
    });
  };
}

}  // namespace warpscope
