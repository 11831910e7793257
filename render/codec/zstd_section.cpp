// Sections: zeros, plain bytes or a Zstandard frame.
// See zstd_section.h.
#include "render/codec/zstd_section.h"

#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <new>

namespace warpscope {
namespace {

enum class Kept : uint32_t { zeros, plain, compressed };

constexpr uint32_t kLengthBits = 30;
// What is left after prediction has little that repeats; the entropy coder does the work, and higher levels only search longer.
constexpr int kLevel = 1;

// A context takes longer to make than a section to compress: one for each thread.
ZSTD_CCtx& zstdCompressor() {
  thread_local const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(), ZSTD_freeCCtx);
  if (!context) throw std::bad_alloc();
  return *context;
}

ZSTD_DCtx& zstdDecompressor() {
  thread_local const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(), ZSTD_freeDCtx);
  if (!context) throw std::bad_alloc();
  return *context;
}

}  // namespace

bool isZero(std::span<const uint8_t> bytes) {
  constexpr size_t kPiece = 1024;  // after each of which it may be known that not
  for (size_t begin = 0; begin < bytes.size(); begin += kPiece) {
    uint8_t any = 0;
    for (const uint8_t byte : bytes.subspan(begin, std::min(kPiece, bytes.size() - begin))) any |= byte;
    if (any != 0) return false;
  }
  return true;
}

template <class Allocator>
void appendSection(std::vector<std::byte, Allocator>& out, std::span<const uint8_t> bytes) {
  const size_t head = out.size();
  Kept kept = Kept::zeros;
  size_t length = 0;
  if (!isZero(bytes)) {
    kept = Kept::compressed;
    const size_t room = ZSTD_compressBound(bytes.size());
    out.resize(head + 4 + room);
    length = ZSTD_compressCCtx(&zstdCompressor(), out.data() + head + 4, room, bytes.data(), bytes.size(), kLevel);
    if (ZSTD_isError(length) || length >= bytes.size()) {
      kept = Kept::plain;
      length = bytes.size();
      std::memcpy(out.data() + head + 4, bytes.data(), length);
    }
  }
  out.resize(head + 4 + length);
  storeLittle(out.data() + head, static_cast<uint32_t>(kept) << kLengthBits | static_cast<uint32_t>(length));
}
template void appendSection(ByteVector& out, std::span<const uint8_t> bytes);
template void appendSection(std::vector<std::byte>& out, std::span<const uint8_t> bytes);

bool takeSection(ByteReader& reader, std::span<uint8_t> bytes) {
  const auto word = reader.take<uint32_t>();
  const std::span<const std::byte> stored = reader.take(word & ((1u << kLengthBits) - 1));
  if (reader.ranOut()) return false;
  switch (static_cast<Kept>(word >> kLengthBits)) {
    case Kept::zeros:
      std::fill(bytes.begin(), bytes.end(), uint8_t{0});
      return stored.empty();
    case Kept::plain:
      if (stored.size() != bytes.size()) return false;
      std::transform(stored.begin(), stored.end(), bytes.begin(), [](std::byte byte) { return std::to_integer<uint8_t>(byte); });
      return true;
    case Kept::compressed: {
      // Zstandard writes at most what it is given room for.
      const size_t length = ZSTD_decompressDCtx(&zstdDecompressor(), bytes.data(), bytes.size(), stored.data(), stored.size());
      return !ZSTD_isError(length) && length == bytes.size();
    }
  }
  return false;
}

}  // namespace warpscope
