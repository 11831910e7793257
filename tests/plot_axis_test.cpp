// Places and ticks of axes.
// Mirrors app/picture/plot_axis.h.
#include "app/picture/plot_axis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace warpscope {
namespace {

TEST(AxisScale, EqualRatiosAreEquallyFarApart) {
  AxisScale axis(true, 100.0, 0.0);  // a y axis: places fall as values rise
  for (const double value : {0.01, 1.0, -3.0, 0.0, std::numeric_limits<double>::infinity()}) axis.include(value);
  axis.settle();
  EXPECT_NEAR(axis.place(0.1) - axis.place(0.01), axis.place(1.0) - axis.place(0.1), 1e-9);
  EXPECT_LT(axis.place(0.01), 100.0);  // a little room beyond the ends
  EXPECT_GT(axis.place(1.0), 0.0);
  EXPECT_EQ(axis.place(0.0), 100.0);  // what it cannot show stands at the lower end
  EXPECT_EQ(axis.place(50.0), 0.0);
  EXPECT_TRUE(std::isnan(axis.place(std::numeric_limits<double>::quiet_NaN())));
  EXPECT_EQ(axis.ticks(), (std::vector<double>{0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0}));
}

TEST(AxisScale, WithoutValuesThereIsStillAnAxis) {
  for (const bool isLogarithmic : {false, true}) {
    AxisScale axis(isLogarithmic, 0.0, 10.0);
    axis.settle();
    EXPECT_GE(axis.ticks().size(), 2u);
    EXPECT_TRUE(std::isfinite(axis.place(0.5)));
  }
}

TEST(AxisScale, OneValueStandsInTheMiddle) {
  AxisScale axis(true, 0.0, 10.0);
  axis.include(3.0);
  axis.settle();
  EXPECT_NEAR(axis.place(3.0), 5.0, 1e-9);
}

TEST(AxisScale, ANarrowRangeHasTicksToo) {
  AxisScale axis(true, 0.0, 10.0);
  axis.include(210.0);
  axis.include(250.0);  // 168 to 312.5: of 1, 2 and 5 only 200 is within
  axis.settle();
  EXPECT_EQ(axis.ticks(), (std::vector<double>{175.0, 200.0, 225.0, 250.0, 275.0, 300.0}));
}

TEST(TickText, IsShort) {
  EXPECT_EQ(tickText(0.05), "0.05");
  EXPECT_EQ(tickText(25.0), "25");
  EXPECT_EQ(tickText(20000.0), "20 k");
  EXPECT_EQ(tickText(-0.0), "0");
}

}  // namespace
}  // namespace warpscope
