// Columns to planes of bytes, and back.
// See packed_words.h.
#include "render/bricks/packed_words.h"

#include <limits>
#include <stdexcept>

#include "render/codec/bytes.h"
#include "render/codec/zstd_section.h"

namespace warpscope {
namespace {

constexpr size_t kPlanes = sizeof(uint32_t);
/// Of what a message has in each stream: far more than tiles come to, so that nothing is made room for that nobody sent.
constexpr size_t kMostBytes = size_t{1} << 28;

[[noreturn]] void throwDamaged() { throw std::runtime_error("a packed message between processes is damaged"); }

void appendStream(std::vector<std::byte>& out, std::span<const uint8_t> bytes) {
  if (bytes.size() > kMostBytes) throw std::runtime_error("a message between processes is too long to be packed");
  appendLittle(out, static_cast<uint32_t>(bytes.size()));
  appendSection(out, bytes);
}

std::vector<uint8_t> takeStream(ByteReader& reader) {
  const auto size = reader.take<uint32_t>();
  if (size > kMostBytes) throwDamaged();
  std::vector<uint8_t> bytes(size);
  if (!takeSection(reader, bytes)) throwDamaged();
  return bytes;
}

}  // namespace

std::vector<std::byte> PackedWriter::take() {
  const std::vector<std::byte> plain = plain_.take();
  std::vector<std::byte> out;
  appendStream(out, {reinterpret_cast<const uint8_t*>(plain.data()), plain.size()});
  size_t words = 0;
  appendLittle(out, static_cast<uint32_t>(columns_.size()));
  for (const std::vector<uint32_t>& column : columns_) {
    appendLittle(out, static_cast<uint32_t>(column.size()));
    words += column.size();
  }
  std::vector<uint8_t> planes(words * kPlanes);
  uint8_t* next = planes.data();
  for (const std::vector<uint32_t>& column : columns_)
    for (size_t plane = 0; plane < kPlanes; ++plane)
      for (size_t i = 0; i < column.size(); ++i) *next++ = static_cast<uint8_t>((column[i] - (i > 0 ? column[i - 1] : 0)) >> (8 * plane));
  appendStream(out, planes);
  columns_.clear();
  return out;
}

PackedReader::PackedReader(std::span<const std::byte> bytes) {
  ByteReader reader(bytes);
  plain_ = takeStream(reader);
  const auto count = reader.take<uint32_t>();
  if (count > reader.left() / sizeof(uint32_t)) throwDamaged();
  columns_.resize(count);
  read_.resize(count);
  uint64_t words = 0;
  std::vector<uint32_t> sizes(count);
  for (uint32_t& size : sizes) words += size = reader.take<uint32_t>();
  const std::vector<uint8_t> planes = takeStream(reader);
  if (reader.ranOut() || words * kPlanes != planes.size()) throwDamaged();
  const uint8_t* next = planes.data();
  for (size_t c = 0; c < count; ++c) {
    std::vector<uint32_t>& column = columns_[c];
    column.resize(sizes[c]);
    for (size_t plane = 0; plane < kPlanes; ++plane)
      for (uint32_t& word : column) word |= uint32_t{*next++} << (8 * plane);
    for (size_t i = 1; i < column.size(); ++i) column[i] += column[i - 1];
  }
  reader_ = RankReader(std::as_bytes(std::span(plain_)));
}

uint32_t PackedReader::nextOf(size_t column) {
  if (column >= columns_.size() || read_[column] == columns_[column].size()) throwDamaged();
  return columns_[column][read_[column]++];
}

}  // namespace warpscope
