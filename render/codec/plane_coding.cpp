// Pieces of a plane on all cores.
// See plane_coding.h.
#include "render/codec/plane_coding.h"

#include <algorithm>
#include <array>
#include <atomic>

#include "render/codec/tokens.h"
#include "render/codec/zstd_section.h"
#include "render/core/parallel.h"

// A layer's value follows from its last one. Clang (14, from -O2 on) vectorises such a loop as though no layer came twice, and other values come
// back; tests/plane_coding_test.cpp shows it.
#if defined(__clang__)
#define WARPSCOPE_ONE_AFTER_ANOTHER _Pragma("clang loop vectorize(disable)")
#else
#define WARPSCOPE_ONE_AFTER_ANOTHER
#endif

namespace warpscope {
namespace {

size_t piecesOf(size_t count) { return (count + kPlanePiece - 1) / kPlanePiece; }

std::span<const uint8_t> partOf(std::span<const uint8_t> layers, size_t begin, size_t end) {
  return layers.empty() ? layers : layers.subspan(begin, end - begin);
}

/// The difference of two integers of so many bytes, which wraps around, as a small number where it is small either way.
template <size_t kBytes>
uint32_t foldedDifference(uint32_t value, uint32_t likely) {
  constexpr uint32_t kUnused = 32 - 8 * kBytes;
  const uint32_t code = zigzag(static_cast<int32_t>((value - likely) << kUnused) >> kUnused);
  return code & (0xffffffffu >> kUnused);
}

template <size_t kBytes>
uint32_t unfolded(uint32_t code, uint32_t likely) {
  return (likely + static_cast<uint32_t>(unzigzag(code))) & (0xffffffffu >> (32 - 8 * kBytes));
}

template <size_t kBytes>
uint32_t load(const std::byte* value) {
  uint32_t number = 0;
  for (size_t byte = 0; byte < kBytes; ++byte) number |= std::to_integer<uint32_t>(value[byte]) << 8 * byte;
  return number;
}

template <size_t kBytes>
void packPiece(std::span<const std::byte> values, std::span<const uint8_t> layers, ByteVector& out) {
  const size_t count = values.size() / kBytes;
  std::array<uint32_t, 256> last{};  // value of each layer
  std::vector<uint8_t> bytes(values.size());
  WARPSCOPE_ONE_AFTER_ANOTHER
  for (size_t i = 0; i < count; ++i) {
    const uint32_t value = load<kBytes>(&values[i * kBytes]);
    uint32_t& likely = last[layers.empty() ? 0 : layers[i]];
    const uint32_t code = foldedDifference<kBytes>(value, likely);
    likely = value;
    for (size_t byte = 0; byte < kBytes; ++byte) bytes[byte * count + i] = static_cast<uint8_t>(code >> 8 * byte);
  }
  for (size_t byte = 0; byte < kBytes; ++byte) appendSection(out, std::span(bytes).subspan(byte * count, count));
}

template <size_t kBytes>
bool unpackPiece(std::span<const std::byte> packed, std::span<const uint8_t> layers, std::span<std::byte> values) {
  const size_t count = values.size() / kBytes;
  std::array<uint32_t, 256> last{};
  std::vector<uint8_t> bytes(values.size());
  ByteReader reader(packed);
  for (size_t byte = 0; byte < kBytes; ++byte)
    if (!takeSection(reader, std::span(bytes).subspan(byte * count, count))) return false;
  WARPSCOPE_ONE_AFTER_ANOTHER
  for (size_t i = 0; i < count; ++i) {
    uint32_t code = 0;
    for (size_t byte = 0; byte < kBytes; ++byte) code |= static_cast<uint32_t>(bytes[byte * count + i]) << 8 * byte;
    uint32_t& value = last[layers.empty() ? 0 : layers[i]];
    value = unfolded<kBytes>(code, value);
    for (size_t byte = 0; byte < kBytes; ++byte) values[i * kBytes + byte] = static_cast<std::byte>(value >> 8 * byte & 255);
  }
  return reader.left() == 0;
}

}  // namespace

void appendPlane(ByteVector& out, const SamplePlane& plane, std::span<const uint8_t> layers) {
  const size_t bytes = bytesOf(plane.element), count = plane.values.size() / bytes;
  std::vector<ByteVector> pieces(piecesOf(count));
  parallelForRanges(pieces.size(), 1, [&](size_t from, size_t to) {
    for (size_t piece = from; piece < to; ++piece) {
      const size_t begin = piece * kPlanePiece, end = std::min(begin + kPlanePiece, count);
      const auto values = std::span(plane.values).subspan(begin * bytes, (end - begin) * bytes);
      const auto pack = bytes == 1 ? packPiece<1> : bytes == 2 ? packPiece<2> : packPiece<4>;
      pack(values, partOf(layers, begin, end), pieces[piece]);
    }
  });
  for (const ByteVector& piece : pieces) appendLittle(out, static_cast<uint32_t>(piece.size()));
  for (const ByteVector& piece : pieces) out.insert(out.end(), piece.begin(), piece.end());
}

DecodeError takePlane(std::span<const std::byte> bytes, size_t count, std::span<const uint8_t> layers, SamplePlane& plane) {
  const size_t valueBytes = bytesOf(plane.element), pieces = piecesOf(count);
  const std::string what = "the plane \"" + plane.name + "\"";
  ByteReader reader(bytes);
  if (reader.left() / sizeof(uint32_t) < pieces) return what + " ends within its list of pieces";
  std::vector<size_t> starts{0};
  for (size_t piece = 0; piece < pieces; ++piece) starts.push_back(starts.back() + reader.take<uint32_t>());
  if (starts.back() != reader.left()) return "the pieces of " + what + " have other lengths than its list says";
  const std::span<const std::byte> all = reader.take(reader.left());
  plane.values.resize(count * valueBytes);
  std::atomic<bool> isDamaged = false;
  parallelForRanges(pieces, 1, [&](size_t from, size_t to) {
    for (size_t piece = from; piece < to; ++piece) {
      const size_t begin = piece * kPlanePiece, end = std::min(begin + kPlanePiece, count);
      const auto values = std::span(plane.values).subspan(begin * valueBytes, (end - begin) * valueBytes);
      const auto unpack = valueBytes == 1 ? unpackPiece<1> : valueBytes == 2 ? unpackPiece<2> : unpackPiece<4>;
      if (!unpack(all.subspan(starts[piece], starts[piece + 1] - starts[piece]), partOf(layers, begin, end), values)) isDamaged = true;
    }
  });
  if (isDamaged) return what + " is damaged";
  return std::nullopt;
}

}  // namespace warpscope
