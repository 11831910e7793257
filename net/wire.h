// Numbers and texts as bytes, little-endian, field by field: what messages are written with and read from.
// Reading takes nothing on trust: beyond the end there are zeros and a flag, never somebody else's memory.
#pragma once

#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace warpscope::net {

/// Appends to a buffer.
class WireWriter {
 public:
  explicit WireWriter(std::vector<std::byte>& out) : out_(out) {}

  template <std::unsigned_integral Number>
  void number(Number value) {
    for (size_t i = 0; i < sizeof(Number); ++i) out_.push_back(static_cast<std::byte>(value >> (8 * i) & 0xff));
  }
  void number(float value) { number(std::bit_cast<uint32_t>(value)); }
  void number(double value) { number(std::bit_cast<uint64_t>(value)); }
  template <class Number, size_t kCount>
  void numbers(const std::array<Number, kCount>& values) {
    for (const Number& value : values) number(value);
  }
  void bytes(std::span<const std::byte> bytes) {
    for (const std::byte byte : bytes) out_.push_back(byte);  // these are few; GCC 12 warns of what insert() would do
  }
  /// A length of 16 bits, then the bytes; what is longer is cut off.
  void text(std::string_view text) {
    const std::string_view kept = text.substr(0, 0xffff);
    number(static_cast<uint16_t>(kept.size()));
    bytes(std::as_bytes(std::span(kept)));
  }

 private:
  std::vector<std::byte>& out_;
};

/// Reads what a WireWriter wrote.
class WireReader {
 public:
  explicit WireReader(std::span<const std::byte> bytes) : rest_(bytes) {}

  template <std::unsigned_integral Number>
  void number(Number& value) {
    value = 0;
    const std::span<const std::byte> read = take(sizeof(Number));
    for (size_t i = 0; i < read.size(); ++i) value = static_cast<Number>(value | std::to_integer<Number>(read[i]) << (8 * i));
  }
  void number(float& value) {
    uint32_t bits;
    number(bits);
    value = std::bit_cast<float>(bits);
  }
  void number(double& value) {
    uint64_t bits;
    number(bits);
    value = std::bit_cast<double>(bits);
  }
  template <class Number, size_t kCount>
  void numbers(std::array<Number, kCount>& values) {
    for (Number& value : values) number(value);
  }
  /// At most `longest` bytes; a longer one is a failure.
  void text(std::string& text, size_t longest) {
    uint16_t length;
    number(length);
    if (length > longest) fail();
    const std::span<const std::byte> read = take(length);
    text.assign(reinterpret_cast<const char*>(read.data()), read.size());
  }
  /// The next `count` bytes; none, and a failure, if there are fewer.
  std::span<const std::byte> take(size_t count) {
    if (hasFailed_ || count > rest_.size()) {
      fail();
      return {};
    }
    const std::span<const std::byte> taken = rest_.first(count);
    rest_ = rest_.subspan(count);
    return taken;
  }

  void fail() {
    hasFailed_ = true;
    rest_ = {};
  }
  bool hasFailed() const { return hasFailed_; }
  /// Nothing was missing and nothing is left.
  bool isComplete() const { return !hasFailed_ && rest_.empty(); }

 private:
  std::span<const std::byte> rest_;
  bool hasFailed_ = false;
};

}  // namespace warpscope::net
