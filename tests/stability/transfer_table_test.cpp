// The table of a transfer function: cases 41 to 43 and 59. Truth: the function as it was written, in double, by brute
// force over values. Mirrors render/core/transfer_table.h. Of volumes' values: value_scale_test.cpp.
#include "render/core/transfer_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>
#include <vector>

#include "tests/stability/magnitudes.h"
#include "tests/stability/record.h"
#include "tests/stability/written_function.h"

namespace warpscope {
namespace {

struct WholeType {
  const char* name;
  int lower, upper;
};
constexpr WholeType kWholeTypes[] = {
    {"uint8", 0, 255}, {"int8", -128, 127}, {"int16", -32768, 32767}, {"uint16", 0, 65535}};

// --- Examples

TEST(Case59, AStepAtAnyIntegerShowsExactlyWhatIsWritten) {
  for (const WholeType& type : kWholeTypes) {
    const TransferDomain domain{static_cast<float>(type.lower), static_cast<float>(type.upper), true};
    for (int step = type.lower; step <= type.upper; ++step) {
      const TransferTable table = bakeTransferTable(stepAt(step), domain, 0.5f);
      for (const int value : {type.lower, step - 1, step, step + 1, type.upper}) {
        if (value < type.lower || value > type.upper) continue;
        ASSERT_EQ(shownBy(table, static_cast<float>(value)).color.a, value >= step ? 1.0f : 0.0f)
            << type.name << ", step at " << step << ", " << value;
      }
      // Between two values of the data, by interpolation.
      const float below = step == 0 ? -1e-6f : std::nextafter(static_cast<float>(step), -1e9f);
      ASSERT_EQ(shownBy(table, below).color.a, 0.0f) << type.name << ", step at " << step;
    }
  }
  recordExact("TransferTable, a step at any integer of 8 and 16 bits", "the written function");
}

TEST(Case59, ALabelAmong65536) {
  const TransferDomain domain{0.0f, 65535.0f, true};
  for (const int label : {1, 255, 4096, 30001, 65534}) {
    // A tent, a box and a needle that rises within one value; each with something else far away, so that the table
    // spans all labels.
    const double at = label;
    const std::vector<TransferFunction> functions = {{{{0.0, {0, 0, 1}, 0.0f},
                                                       {at - 1, {1, 0, 0}, 0.0f},
                                                       {at, {1, 0, 0}, 0.75f},
                                                       {at + 1, {1, 0, 0}, 0.0f},
                                                       {65535.0, {0, 1, 0}, 0.5f}}},
                                                     {{{0.0, {0, 0, 1}, 0.5f},
                                                       {0.5, {0, 0, 1}, 0.0f},
                                                       {at, {1, 0, 0}, 0.0f},
                                                       {at, {1, 0, 0}, 1.0f},
                                                       {at + 1, {1, 0, 0}, 1.0f},
                                                       {at + 1, {1, 0, 0}, 0.0f},
                                                       {65535.0, {0, 1, 0}, 0.0f}}},
                                                     {{{0.0, {0, 0, 1}, 0.0f},
                                                       {at - 0.25, {1, 0, 0}, 0.0f},
                                                       {at, {1, 1, 0}, 1.0f},
                                                       {at + 0.25, {1, 0, 0}, 0.0f},
                                                       {65535.0, {0, 1, 0}, 0.01f}}}};
    for (const TransferFunction& function : functions) {
      const TransferTable table = bakeTransferTable(function, domain, 0.5f);
      for (int value = 0; value <= 65535; value += value >= label - 40 && value < label + 40 ? 1 : 31)
        ASSERT_EQ(wrongExactly(table, function, static_cast<float>(value), value), "") << "label " << label;
      EXPECT_TRUE(table.anyVisible(static_cast<float>(label), static_cast<float>(label)));
    }
  }
  recordExact("TransferTable, a label among 65536", "the written function");
}

TEST(Case43, TheValueWhereARampBeginsShowsNothing) {
  // Air is often just where an automatic function begins: skipping it must not be lost.
  const TransferFunction ramp{{{0.0, glm::vec3(1.0f), 0.0f}, {100.0, glm::vec3(1.0f), 0.5f}}};
  for (const bool isWhole : {false, true}) {
    const TransferTable table = bakeTransferTable(ramp, {0.0f, 255.0f, isWhole}, 0.5f);
    EXPECT_FALSE(table.anyVisible(0.0f, 0.0f));
    EXPECT_TRUE(table.anyVisible(0.0f, 0.1f));  // beyond the foot's bin
    EXPECT_TRUE(table.anyVisible(1.0f, 1.0f));
  }
  recordExact("TransferTable::anyVisible where a ramp begins", "the written function");
}

TEST(Case42, ARangeWithoutExtentIsItsOneValue) {
  for (const bool isWhole : {false, true})
    for (const float value : {0.0f, 7.0f, -32768.0f}) {
      const TransferTable table = bakeTransferTable(stepAt(static_cast<double>(value)), {value, value, isWhole}, 1.0f);
      EXPECT_EQ(shownBy(table, value).color.a, 1.0f);
      EXPECT_EQ(shownBy(table, value == 0.0f ? -1e-6f : std::nextafter(value, -1e9f)).color.a, 0.0f);
      EXPECT_TRUE(table.anyVisible(value, value));
    }
  recordExact("TransferTable of a range without extent", "the written function");
}

TEST(Case42, NumbersThatAreNoneAreTheFirstBins) {
  const TransferTable table = bakeTransferTable(stepAt(0.5), {0.0f, 1.0f, false}, 1.0f);
  EXPECT_EQ(shownBy(table, std::nanf("")).color.a, 0.0f);
  EXPECT_EQ(shownBy(table, std::numeric_limits<float>::infinity()).color.a, 1.0f);
  EXPECT_EQ(shownBy(table, -std::numeric_limits<float>::infinity()).color.a, 0.0f);
  recordExact("TransferTable of NaN and infinity", "definition");
}

// --- Properties

/// What a corner is made of before its function's range is known.
struct CornerParts {
  int side;        ///< 0 to 4: in the range; 5, 6: below, above it
  float share;     ///< of the range, from its lower end; beyond it, of a fifth of it
  bool isRounded;  ///< to a whole number
  int quarter;     ///< 3, of whole numbers: half a number farther
  int link;        ///< 6: where the corner before is; 7: hardly beyond it
  glm::vec3 color;
  float alpha;
};

/// Elements of any size in lists of `most` at most: how large rapidcheck wants things to be goes for the list alone.
template <class T>
rc::Gen<std::vector<T>> anyList(int most, rc::Gen<T> element) {
  return rc::gen::resize(most,
                         rc::gen::container<std::vector<T>>(rc::gen::resize(rc::kNominalSize, std::move(element))));
}

rc::Gen<std::vector<CornerParts>> anyCorners() {
  const auto color = rc::gen::tuple(anyFraction(), anyFraction(), anyFraction());
  const auto corner = rc::gen::map(
      rc::gen::tuple(rc::gen::inRange(0, 7), anyFraction(), rc::gen::arbitrary<bool>(), rc::gen::inRange(0, 4),
                     rc::gen::inRange(0, 8), color, rc::gen::tuple(rc::gen::inRange(0, 3), anyFraction())),
      [](const auto& parts) {
        const auto& [side, share, isRounded, quarter, link, rgb, opacity] = parts;
        const auto& [red, green, blue] = rgb;
        return CornerParts{side,
                           share,
                           isRounded,
                           quarter,
                           link,
                           {red, green, blue},
                           std::get<0>(opacity) == 0 ? 0.0f : std::get<1>(opacity)};
      });
  return rc::gen::nonEmpty(anyList(12, corner));
}

/// Corners anywhere in [lower, upper] and beyond, some repeated, some close to each other.
TransferFunction functionOf(const std::vector<CornerParts>& corners, double lower, double upper, bool isWhole) {
  const double size = upper - lower;
  TransferFunction function;
  for (const CornerParts& corner : corners) {
    const auto share = static_cast<double>(corner.share);
    double value = corner.side == 5   ? lower - 0.2 * share * size
                   : corner.side == 6 ? upper + 0.2 * share * size
                                      : lower + share * size;
    if (corner.isRounded) value = std::round(value);
    if (isWhole && corner.quarter == 3) value += 0.5;
    if (!function.points.empty() && corner.link >= 6)
      value = function.points.back().value + (corner.link == 6 ? 0.0 : 1e-4 * size);
    function.points.push_back({value, corner.color, corner.alpha});
  }
  std::stable_sort(function.points.begin(), function.points.end(),
                   [](const TransferPoint& a, const TransferPoint& b) { return a.value < b.value; });
  return function;
}

/// A table, and where to look at it.
struct TableCase {
  TransferFunction function;
  TransferDomain domain;
  float step;
  std::vector<float> places;
};

TableCase tableCase(const std::vector<CornerParts>& corners, const TransferDomain& domain, float step,
                    const std::vector<float>& shares) {
  const double lower = domain.lower, upper = domain.upper;
  TableCase result{functionOf(corners, lower, upper, domain.isWhole), domain, step, {}};
  for (const float share : shares)
    result.places.push_back(std::clamp(static_cast<float>(lower + static_cast<double>(share) * (upper - lower)),
                                       domain.lower, domain.upper));
  return result;
}

/// Any two whole numbers of a type, one number now and then.
rc::Gen<TransferDomain> anyRangeOf(const WholeType& type) {
  const auto any = anyInteger(type.lower, type.upper);
  return rc::gen::map(rc::gen::tuple(any, any, rc::gen::inRange(0, 4)), [](const std::tuple<int, int, int>& ends) {
    const auto& [a, other, quarter] = ends;
    const int b = quarter == 0 ? a : other;
    return TransferDomain{static_cast<float>(std::min(a, b)), static_cast<float>(std::max(a, b)), true};
  });
}

rc::Gen<TableCase> anyWholeTable() {
  const auto range = rc::gen::oneOf(anyRangeOf(kWholeTypes[0]), anyRangeOf(kWholeTypes[1]), anyRangeOf(kWholeTypes[2]),
                                    anyRangeOf(kWholeTypes[3]));
  return rc::gen::map(rc::gen::tuple(anyCorners(), range, anyPositive(-6, 3), anyList(4000, anyFraction())),
                      [](const auto& parts) {
                        const auto& [corners, domain, step, shares] = parts;
                        return tableCase(corners, domain, step, shares);
                      });
}

/// Ranges of all magnitudes, that begin at 0 or up to 2^17 of their sizes away from it.
rc::Gen<TableCase> anyTable() {
  return rc::gen::map(rc::gen::tuple(anyCorners(), anyPositive(-99, 99), rc::gen::arbitrary<bool>(),
                                     anyPositive(-10, 16), anyList(6000, anyFraction())),
                      [](const auto& parts) {
                        const auto& [corners, size, isAway, away, shares] = parts;
                        const double lower = isAway ? static_cast<double>(size) * static_cast<double>(away) : 0.0;
                        const TransferDomain domain{static_cast<float>(lower),
                                                    static_cast<float>(lower + static_cast<double>(size)), false};
                        return tableCase(corners, domain, 0.5f, shares);
                      });
}

void showValue(const TableCase& c, std::ostream& out) {
  out.precision(17);
  out << (c.domain.isWhole ? "whole numbers of " : "") << '[' << c.domain.lower << ", " << c.domain.upper << "], step "
      << c.step << ", corners";
  for (const TransferPoint& p : c.function.points)
    out << " {" << p.value << ", (" << p.color.r << ' ' << p.color.g << ' ' << p.color.b << "), " << p.alpha << '}';
  out << ", seen at";
  for (const float place : c.places) out << ' ' << place;
}

/// Fails the property, with the reason.
void requireNothing(const std::string& wrong) {
  if (!wrong.empty()) RC_FAIL(wrong);
}

TEST(Case41, PropertyWholeNumbersAreClassifiedExactlyAndWhatLiesBetweenWithinTheBound) {
  checkProperty([] {
    const TableCase c = *anyWholeTable();
    const TransferTable table = bakeTransferTable(c.function, c.domain, c.step);
    const int lower = static_cast<int>(c.domain.lower), upper = static_cast<int>(c.domain.upper);
    const int stride = std::max(1, (upper - lower) / 5000);
    for (int value = lower; value <= upper; value += stride)
      requireNothing(wrongExactly(table, c.function, static_cast<float>(value), value));
    for (const float x : c.places) requireNothing(wrongBeyondTheBound(table, c.function, x));
  });
  recordExact("TransferTable at whole numbers; between them within kMostVariation", "the written function");
}

TEST(Case42, PropertyRangesOfAllMagnitudesAreClassifiedWithinTheBound) {
  checkProperty([] {
    const TableCase c = *anyTable();
    const TransferTable table = bakeTransferTable(c.function, c.domain, c.step);
    for (const float x : c.places) requireNothing(wrongBeyondTheBound(table, c.function, x));
    for (const TransferPoint& point : c.function.points) {
      const auto corner = static_cast<float>(point.value);
      for (const float x : {std::nextafter(corner, -1e38f), corner, std::nextafter(corner, 1e38f)})
        if (x >= c.domain.lower && x <= c.domain.upper) requireNothing(wrongBeyondTheBound(table, c.function, x));
    }
  });
  recordExact("TransferTable over ranges from 1e-30 to 1e30, within kMostVariation", "the written function");
}

/// From each place to the one before it; each fifth by itself.
TEST(Case43, PropertyAnyVisibleNeverMissesWhatIsShown) {
  checkProperty([] {
    const bool isWhole = *rc::gen::arbitrary<bool>();
    const TransferDomain domain{0.0f, isWhole ? 1000.0f : 1.0f, isWhole};
    const TableCase c = *rc::gen::map(
        rc::gen::tuple(anyCorners(), anyList(600, anyFraction())),
        [=](const auto& parts) { return tableCase(std::get<0>(parts), domain, 0.5f, std::get<1>(parts)); });
    const TransferTable table = bakeTransferTable(c.function, c.domain, c.step);
    for (size_t i = 0; i < c.places.size(); ++i) {
      const float to = c.places[i % 5 == 0 ? i : i - 1];
      const float a = std::min(c.places[i], to), b = std::max(c.places[i], to);
      bool shows = shownBy(table, a).color.a > 0.0f || shownBy(table, b).color.a > 0.0f;
      for (const TransferPoint& point : c.function.points)
        if (point.value >= static_cast<double>(a) && point.value <= static_cast<double>(b))
          shows = shows || c.function.at(point.value).a > 0.0f;
      if (shows) RC_ASSERT(table.anyVisible(a, b));
    }
    RC_ASSERT(!table.anyVisible(0.7f, 0.3f));
  });
  recordExact("TransferTable::anyVisible misses nothing", "the written function");
}

}  // namespace
}  // namespace warpscope
