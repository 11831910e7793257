// Ranges: what lies at their ends, outside, and nowhere.
// Mirrors render/base/range.h.
#include "render/base/range.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <string>

#include "render/base/error.h"

namespace warpscope {
namespace {

constexpr Range kRange{1e-6, 0.1};  // neither end is a float

template <class T>
std::string complaint(T value) {
  try {
    requireRange(value, kRange, "the knob");
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

template <class T>
class RangeTest : public testing::Test {};
using Numbers = testing::Types<float, double>;
TYPED_TEST_SUITE(RangeTest, Numbers);

TYPED_TEST(RangeTest, BothEndsBelongToIt) {
  const auto lowest = static_cast<TypeParam>(kRange.lowest), highest = static_cast<TypeParam>(kRange.highest);
  const TypeParam infinity = std::numeric_limits<TypeParam>::infinity();
  for (const TypeParam inside : {lowest, highest, static_cast<TypeParam>(0.05)}) EXPECT_EQ(complaint(inside), "") << inside;
  for (const TypeParam outside : {std::nextafter(lowest, -infinity), std::nextafter(highest, infinity), infinity, -infinity,
                                  std::numeric_limits<TypeParam>::quiet_NaN(), TypeParam(0)})
    EXPECT_NE(complaint(outside), "") << outside;
}

TEST(Range, ComplaintsNameTheKnobTheRangeAndTheValue) {
  EXPECT_EQ(complaint(0.25), "the knob must be between 1e-06 and 0.1, not 0.25");
  EXPECT_EQ(complaint(0.7f), "the knob must be between 1e-06 and 0.1, not 0.7");
  // What lies just outside must not look as if it lay inside.
  EXPECT_EQ(complaint(0.10000000000000002), "the knob must be between 1e-06 and 0.1, not 0.10000000000000002");
  EXPECT_EQ(complaint(1e300), "the knob must be between 1e-06 and 0.1, not 1e+300");
  EXPECT_EQ(complaint(-1e-300), "the knob must be between 1e-06 and 0.1, not -1e-300");
}

TEST(Range, NumbersAreAllOfTheirText) {
  EXPECT_EQ(parseNumber("0.25"), 0.25);
  EXPECT_EQ(parseNumber("-1e-3"), -1e-3);
  for (const char* text : {"", " 1", "1 ", "1x", "+1", "0,5", "one"}) EXPECT_EQ(parseNumber(text), std::nullopt) << text;
  EXPECT_EQ(requireNumber("4711", kRange, "the knob"), 4711.0);
  try {
    requireNumber("many", kRange, "the knob");
    ADD_FAILURE();
  } catch (const UsageError& error) {
    EXPECT_STREQ(error.what(), "'many' is no number; the knob must be 1e-06 to 0.1");
  }
}

TEST(Range, TextsOfRanges) {
  EXPECT_EQ(rangeText({1e-3, 1e3}), "0.001 to 1000");
  EXPECT_EQ(rangeText({-360.0, 360.0}), "-360 to 360");
}

}  // namespace
}  // namespace warpscope
