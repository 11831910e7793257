// Numbers and texts as bytes, and that nothing is read beyond the end.
// Mirrors net/wire.h.
#include "net/wire.h"

#include <gtest/gtest.h>

#include <limits>

namespace warpscope::net {
namespace {

std::vector<std::byte> bytesOf(std::initializer_list<int> values) {
  std::vector<std::byte> bytes;
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

TEST(Wire, NumbersAreLittleEndian) {
  std::vector<std::byte> bytes;
  WireWriter writer(bytes);
  writer.number(uint8_t{1});
  writer.number(uint16_t{0x0203});
  writer.number(uint32_t{0x04050607});
  writer.number(uint64_t{0x08090a0b0c0d0e0f});
  writer.number(1.0f);
  writer.number(-2.0);
  EXPECT_EQ(bytes, bytesOf({1, 3, 2, 7, 6, 5, 4, 15, 14, 13, 12, 11, 10, 9, 8, 0, 0, 0x80, 0x3f, 0, 0, 0, 0, 0, 0, 0, 0xc0}));
}

TEST(Wire, NumbersComeBack) {
  std::vector<std::byte> bytes;
  WireWriter writer(bytes);
  const std::array<uint64_t, 3> wanted{0, 1, std::numeric_limits<uint64_t>::max()};
  writer.numbers(wanted);
  writer.number(std::numeric_limits<float>::denorm_min());
  writer.number(-std::numeric_limits<double>::infinity());
  WireReader reader(bytes);
  std::array<uint64_t, 3> numbers;
  float single;
  double twice;
  reader.numbers(numbers);
  reader.number(single);
  reader.number(twice);
  EXPECT_EQ(numbers, wanted);
  EXPECT_EQ(single, std::numeric_limits<float>::denorm_min());
  EXPECT_EQ(twice, -std::numeric_limits<double>::infinity());
  EXPECT_TRUE(reader.isComplete());
}

TEST(Wire, BeyondTheEndThereAreZerosAndAFlag) {
  const std::vector<std::byte> bytes = bytesOf({1, 2, 3});
  WireReader reader(bytes);
  uint16_t first = 9;
  uint32_t second = 9;
  uint8_t third = 9;
  reader.number(first);
  EXPECT_FALSE(reader.hasFailed());
  EXPECT_FALSE(reader.isComplete());
  reader.number(second);  // of which there is one byte
  EXPECT_TRUE(reader.hasFailed());
  reader.number(third);  // what was left is not given out any more
  EXPECT_EQ(first, 0x0201);
  EXPECT_EQ(second, 0u);
  EXPECT_EQ(third, 0);
  EXPECT_FALSE(reader.isComplete());
  EXPECT_TRUE(reader.take(0).empty());
  EXPECT_TRUE(reader.take(std::numeric_limits<size_t>::max()).empty());
}

TEST(Wire, NothingIsEmptyAndComplete) {
  WireReader reader({});
  EXPECT_TRUE(reader.isComplete());
  uint64_t number = 1;
  reader.number(number);
  EXPECT_EQ(number, 0u);
  EXPECT_TRUE(reader.hasFailed());
}

TEST(Wire, TextsHaveALengthAndALimit) {
  std::vector<std::byte> bytes;
  WireWriter(bytes).text("fish");
  EXPECT_EQ(bytes, bytesOf({4, 0, 'f', 'i', 's', 'h'}));
  std::string text;
  {
    WireReader reader(bytes);
    reader.text(text, 4);
    EXPECT_EQ(text, "fish");
    EXPECT_TRUE(reader.isComplete());
  }
  {
    WireReader reader(bytes);
    reader.text(text, 3);
    EXPECT_TRUE(reader.hasFailed());
    EXPECT_EQ(text, "");
  }
  for (size_t size = 0; size < bytes.size(); ++size) {
    WireReader reader(std::span<const std::byte>(bytes).first(size));
    reader.text(text, 4);
    EXPECT_TRUE(reader.hasFailed()) << size;
    EXPECT_EQ(text, "");
  }
}

TEST(Wire, LongTextsAreCutOff) {
  std::vector<std::byte> bytes;
  WireWriter(bytes).text(std::string(70'000, 'x'));
  EXPECT_EQ(bytes.size(), 2u + 0xffff);
  std::string text;
  WireReader reader(bytes);
  reader.text(text, 0xffff);
  EXPECT_EQ(text.size(), 0xffffu);
  EXPECT_TRUE(reader.isComplete());
}

}  // namespace
}  // namespace warpscope::net
