// Medians and quartiles of repeated timings.
// Mirrors app/experiment/measured.h.
#include "app/experiment/measured.h"

#include <gtest/gtest.h>

namespace warpscope {
namespace {

TEST(Measured, MedianAndQuartilesAreInterpolatedInAnyOrder) {
  EXPECT_EQ(measuredOf({7.0}), (Measured{7.0, 0.0}));
  EXPECT_EQ(measuredOf({3.0, 1.0}), (Measured{2.0, 1.0}));                // quartiles 1.5 and 2.5
  EXPECT_EQ(measuredOf({5.0, 1.0, 3.0}), (Measured{3.0, 2.0}));           // 2 and 4
  EXPECT_EQ(measuredOf({40.0, 10.0, 30.0, 20.0}), (Measured{25.0, 15.0}));  // 17.5 and 32.5
}

TEST(Measured, AnOutlierHardlyMatters) {
  EXPECT_EQ(measuredOf({1.0, 2.0, 3.0, 4.0, 5.0}), measuredOf({1.0, 2.0, 3.0, 4.0, 5000.0}));
}

}  // namespace
}  // namespace warpscope
