// Ranges: what lies at their ends, outside, and nowhere.
// Mirrors render/core/range.h.
#include "render/core/range.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <string>

#include "render/core/error.h"

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
}

}  // namespace
}  // namespace warpscope
