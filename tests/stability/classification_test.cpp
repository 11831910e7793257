// What a transfer function shows: cases 33, 37, 41 to 43 and 59 to 61. Truth: the function as it was written, in
// double, by brute force over values. Mirrors render/core/transfer_table.h and render/volume/value_scale.h.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "render/core/transfer_table.h"
#include "render/volume/value_scale.h"
#include "tests/marcher_cases.h"
#include "tests/stability/backends.h"
#include "tests/stability/magnitudes.h"
#include "tests/stability/record.h"
#include "tests/test_volumes.h"

namespace warpscope {
namespace {

constexpr float kVariation = TransferTable::kMostVariation;

TransferFunction stepAt(double value) { return {{{value, glm::vec3(1.0f), 0.0f}, {value, glm::vec3(1.0f), 1.0f}}}; }

struct Shown {
  glm::vec4 color{0.0f};
  float unitAlpha = 0.0f;
};

Shown shownBy(const TransferTable& table, float x) {
  const auto entry = static_cast<size_t>(table.lookup().entryOf(x));
  return {table.entries[entry], table.unitAlphas[entry]};
}

/// As the function says, corrected as the table's step wants it.
Shown written(const TransferFunction& function, double value, float step) {
  const glm::vec4 straight = function.at(value);
  const float alpha = correctOpacity(straight.a, step);
  return {{glm::vec3(straight) * alpha, alpha}, straight.a};
}

float differenceOf(const Shown& a, const Shown& b) {
  const glm::vec4 difference = glm::abs(a.color - b.color);
  return std::max({difference.r, difference.g, difference.b, difference.a, std::abs(a.unitAlpha - b.unitAlpha)});
}

void expectExact(const TransferTable& table, const TransferFunction& function, float x, double value,
                 const std::string& label) {
  const Shown is = shownBy(table, x), wanted = written(function, value, table.step);
  ASSERT_EQ(is.color, wanted.color) << label << ", at " << value;
  ASSERT_EQ(is.unitAlpha, wanted.unitAlpha) << label << ", at " << value;
}

/// Whether x lies between two corners of which one has opacity.
bool isWithinARamp(const TransferFunction& function, double x) {
  for (size_t i = 0; i + 1 < function.points.size(); ++i) {
    const TransferPoint &left = function.points[i], &right = function.points[i + 1];
    if (left.value < x && x < right.value) return left.alpha > 0.0f || right.alpha > 0.0f;
  }
  return false;
}

/// Whether the bin of x begins with nothing, and what lies in the next bin is shown.
bool isFootAt(const TransferTable& table, const TransferFunction& function, float x) {
  const double width = 1.0 / static_cast<double>(table.scale);
  const int bin = table.lookup().binOf(x);
  if (bin <= 0 || bin + 1 >= table.bins) return false;
  const double begin = (bin - static_cast<double>(table.offset)) / static_cast<double>(table.scale);
  // Borders are off by the roundings that the table's header states.
  const double slack = 4e-7 * (bin + 1.0 + std::abs(static_cast<double>(table.offset))) * width;
  const auto isNothing = [&](double at) { return function.at(at).a == 0.0f; };
  const bool beginsWithNothing =
      isNothing(begin - slack) || isNothing(begin + slack) ||
      std::any_of(function.points.begin(), function.points.end(), [&](const TransferPoint& point) {
        return point.value >= begin - slack && point.value <= static_cast<double>(x) && isNothing(point.value);
      });
  // What rounding puts into the bin before the one that holds the foot is part of it.
  const auto isShown = [&](int i) { return i < table.bins && table.alphas[static_cast<size_t>(i)] != 0.0f; };
  const bool isAtBorder = begin + width - static_cast<double>(x) <= 2.0 * slack;
  return beginsWithNothing && (isShown(bin + 1) || (isAtBorder && isShown(bin + 2)));
}

/// Within the bound, and visible if and only if the function shows it; what is hardly anything may be left out at the foot of
/// a ramp, where it rises out of nothing within a bin.
void expectBounded(const TransferTable& table, const TransferFunction& function, float x, const std::string& label) {
  const Shown is = shownBy(table, x), wanted = written(function, static_cast<double>(x), table.step);
  ASSERT_LE(differenceOf(is, wanted), kVariation * 1.0001f) << label << ", at " << x;
  const bool mayBeFoot = wanted.unitAlpha > 0.0f && wanted.unitAlpha <= TransferTable::kLeastShown && isFootAt(table, function, x);
  // Within a ramp, what at() rounds to nothing is something.
  const bool mayBeEnd = wanted.unitAlpha == 0.0f && isWithinARamp(function, static_cast<double>(x));
  if (is.color.a > 0.0f ? !mayBeEnd : !mayBeFoot)
    ASSERT_EQ(is.color.a > 0.0f, wanted.color.a > 0.0f)
        << label << ", at " << x << ", " << wanted.unitAlpha << ", bin " << table.lookup().binOf(x) << " of " << table.bins;
}

struct WholeType {
  const char* name;
  int lower, upper;
};
constexpr WholeType kWholeTypes[] = {
    {"uint8", 0, 255}, {"int8", -128, 127}, {"int16", -32768, 32767}, {"uint16", 0, 65535}};

// --- Case 59

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
        expectExact(table, function, static_cast<float>(value), value, "label " + std::to_string(label));
      EXPECT_TRUE(table.anyVisible(static_cast<float>(label), static_cast<float>(label)));
    }
  }
  recordExact("TransferTable, a label among 65536", "the written function");
}

TEST(Case59, OutliersInDataOfZeroToOne) {
  const TransferFunction function{{{0.0, {0, 0, 1}, 0.0f},
                                   {0.3, {1, 0, 0}, 0.0f},
                                   {0.31, {1, 1, 0}, 0.5f},
                                   {0.6, {0, 1, 1}, 0.02f},
                                   {0.6, {1, 1, 1}, 0.9f}}};
  for (const double outlier : {-9999.0, 1e30, -1e30, 3.4e38, 7.0}) {
    for (const VoxelType type : {VoxelType::float32, VoxelType::float64}) {
      const VolumePtr volume = makeTestVolume(type, {2, 2, 2}, [&](const glm::ivec3& p) {
        return p == glm::ivec3(0) ? outlier : 0.125 * (p.x + 2 * p.y + 4 * p.z);
      });
      const ValueScale scale = valueScaleOf(type, volume->statistics(), function);
      const TransferTable table = bakeTransferTable(function, *volume, scale, 0.5f);
      TransferFunction ofInterpolants = function;
      for (TransferPoint& point : ofInterpolants.points)
        point.value = static_cast<double>(static_cast<float>(scale.interpolantOf(point.value)));
      std::mt19937 random(59);
      std::uniform_real_distribution<double> unit(-0.1, 1.1);
      for (int i = 0; i < 20000; ++i) {
        const double value = i < 1000 ? 0.299 + 0.012 * i / 1000.0 : unit(random);
        const auto x = static_cast<float>(
            scale.interpolantOf(type == VoxelType::float32 ? static_cast<double>(static_cast<float>(value)) : value));
        // The corners may be an ulp off: a value that close may be on either side.
        const bool isTie =
            std::any_of(ofInterpolants.points.begin(), ofInterpolants.points.end(), [&](const TransferPoint& point) {
              return std::abs(static_cast<double>(x) - point.value) <= std::abs(point.value) * 1.2e-7;
            });
        if (!isTie)
          expectBounded(table, ofInterpolants, x, std::string(nameOf(type)) + " with " + std::to_string(outlier));
        if (HasFatalFailure()) return;
      }
      EXPECT_EQ(shownBy(table, static_cast<float>(scale.interpolantOf(outlier))).color,
                written(function, outlier, 0.5f).color)
          << outlier;
    }
  }
  recordExact("TransferTable, outliers of -9999 to 1e30 in 0 to 1, within kMostVariation", "the written function");
}

// --- Case 60

TEST(Case60, RangesOfAFewValuesAnywhereInATypeEndAsWritten) {
  std::mt19937_64 random(60);
  const auto check = [&](VoxelType type, int64_t least, int64_t greatest) {
    for (int round = 0; round < 400; ++round) {
      const auto count = static_cast<int64_t>(random() % 10);  // values beside the first
      const int64_t lower =
          round == 0   ? least
          : round == 1 ? greatest - count
                       : least + static_cast<int64_t>(random() % static_cast<uint64_t>(greatest - least - count));
      const VolumePtr volume = makeTestVolume(type, {static_cast<unsigned>(count) + 1, 1, 1},
                                              [&](const glm::ivec3& p) { return static_cast<double>(lower + p.x); });
      for (int64_t shown = lower; shown <= lower + count; ++shown) {
        const TransferFunction function = stepAt(static_cast<double>(shown));
        const ValueScale scale = valueScaleOf(type, volume->statistics(), function);
        const TransferTable table = bakeTransferTable(function, *volume, scale, 1.0f);
        for (int64_t value = lower; value <= lower + count; ++value)
          ASSERT_EQ(shownBy(table, static_cast<float>(scale.interpolantOf(static_cast<double>(value)))).color.a,
                    value >= shown ? 1.0f : 0.0f)
              << "seed 60: " << nameOf(type) << " " << lower << " to " << lower + count << ", shown from " << shown
              << ", at " << value;
      }
    }
  };
  check(VoxelType::int16, -32768, 32767);
  check(VoxelType::uint16, 0, 65535);
  check(VoxelType::int32, std::numeric_limits<int32_t>::lowest(), std::numeric_limits<int32_t>::max());
  check(VoxelType::uint32, 0, std::numeric_limits<uint32_t>::max());
  recordExact("TransferTable, ranges of 1 to 10 values of 16 and 32 bits", "the written function");
}

TEST(Case60, LabelsOf32BitsBesideAnOutlier) {
  for (const double outlier : {-2147483648.0, 2147483647.0}) {
    const VolumePtr volume = makeTestVolume(VoxelType::int32, {3, 1, 1},
                                            [&](const glm::ivec3& p) { return p.x == 0 ? outlier : 1000.0 + p.x; });
    const TransferFunction function{{{-2147483648.0, glm::vec3(1.0f), 0.0f},
                                     {1002.0, glm::vec3(1.0f), 0.0f},
                                     {1002.0, glm::vec3(1.0f), 1.0f},
                                     {1003.0, glm::vec3(1.0f), 1.0f},
                                     {1003.0, glm::vec3(1.0f), 0.0f},
                                     {2147483647.0, glm::vec3(1.0f), 0.0f}}};
    const ValueScale scale = valueScaleOf(VoxelType::int32, volume->statistics(), function);
    const TransferTable table = bakeTransferTable(function, *volume, scale, 1.0f);
    for (const double value : {outlier, 1001.0, 1002.0, 1003.0, 1004.0})
      EXPECT_EQ(shownBy(table, static_cast<float>(scale.interpolantOf(value))).color.a, value == 1002.0 ? 1.0f : 0.0f)
          << value << " beside " << outlier;
  }
  recordExact("TransferTable, labels of 32 bits beside an outlier", "the written function");
}

// --- Cases 41 to 43, as properties

/// Corners anywhere in [lower, upper] and beyond, some repeated, some close to each other.
TransferFunction anyFunction(std::mt19937& random, double lower, double upper, bool isWhole) {
  std::uniform_real_distribution<double> place(lower - 0.2 * (upper - lower), upper + 0.2 * (upper - lower));
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  TransferFunction function;
  const int corners = 1 + static_cast<int>(random() % 12);
  for (int i = 0; i < corners; ++i) {
    double value = place(random);
    if (random() % 2) value = std::round(value);
    if (isWhole && random() % 4 == 0) value += 0.5;
    if (!function.points.empty() && random() % 4 == 0)
      value = function.points.back().value + (random() % 2 ? 0.0 : 1e-4 * (upper - lower));
    function.points.push_back({value, {unit(random), unit(random), unit(random)}, random() % 3 ? unit(random) : 0.0f});
  }
  std::stable_sort(function.points.begin(), function.points.end(),
                   [](const TransferPoint& a, const TransferPoint& b) { return a.value < b.value; });
  return function;
}

TEST(Case41, PropertyWholeNumbersAreClassifiedExactlyAndWhatLiesBetweenWithinTheBound) {
  checkProperty([](uint32_t seed) {
    std::mt19937 random(seed);
    const WholeType type = kWholeTypes[random() % 4];
    std::uniform_int_distribution<int> any(type.lower, type.upper);
    const int a = any(random), b = random() % 4 ? any(random) : a;
    const int lower = std::min(a, b), upper = std::max(a, b);
    const TransferFunction function = anyFunction(random, lower, upper, true);
    const float step = std::exp2(std::uniform_real_distribution<float>(-6.0f, 4.0f)(random));
    const TransferTable table =
        bakeTransferTable(function, {static_cast<float>(lower), static_cast<float>(upper), true}, step);
    const std::string label = "seed " + std::to_string(seed);
    const int stride = std::max(1, (upper - lower) / 5000);
    for (int value = lower; value <= upper; value += stride)
      expectExact(table, function, static_cast<float>(value), value, label);
    for (int i = 0; i < 2000; ++i) {
      const float x =
          std::uniform_real_distribution<float>(static_cast<float>(lower), static_cast<float>(upper))(random);
      expectBounded(table, function, x, label);
      if (testing::Test::HasFailure()) break;
    }
    RC_ASSERT(!testing::Test::HasFailure());
  });
  recordExact("TransferTable at whole numbers; between them within kMostVariation", "the written function");
}

TEST(Case42, PropertyRangesOfAllMagnitudesAreClassifiedWithinTheBound) {
  checkProperty([](uint32_t seed) {
    std::mt19937 random(seed);
    const double size = std::pow(10.0, std::uniform_real_distribution<double>(-30.0, 30.0)(random));
    const double offset =
        random() % 2 ? 0.0 : size * std::pow(10.0, std::uniform_real_distribution<double>(-3.0, 5.0)(random));
    const auto lower = static_cast<float>(offset), upper = static_cast<float>(offset + size);
    TransferFunction function = anyFunction(random, static_cast<double>(lower), static_cast<double>(upper), false);
    const TransferTable table = bakeTransferTable(function, {lower, upper, false}, 0.5f);
    const std::string label = "seed " + std::to_string(seed);
    for (int i = 0; i < 3000; ++i) {
      const float x =
          std::min(upper, std::max(lower, static_cast<float>(offset + size * std::uniform_real_distribution<double>(
                                                                                 0.0, 1.0)(random))));
      expectBounded(table, function, x, label);
      if (testing::Test::HasFailure()) break;
    }
    for (const TransferPoint& point : function.points) {
      const auto near = static_cast<float>(point.value);
      for (const float x : {std::nextafter(near, -1e38f), near, std::nextafter(near, 1e38f)})
        if (x >= lower && x <= upper) expectBounded(table, function, x, label + ", a corner");
    }
    RC_ASSERT(!testing::Test::HasFailure());
  });
  recordExact("TransferTable over ranges from 1e-30 to 1e30, within kMostVariation", "the written function");
}

TEST(Case43, PropertyAnyVisibleNeverMissesWhatIsShown) {
  checkProperty([](uint32_t seed) {
    std::mt19937 random(seed);
    const bool isWhole = random() % 2;
    const TransferFunction function = anyFunction(random, 0.0, isWhole ? 1000.0 : 1.0, isWhole);
    const float upper = isWhole ? 1000.0f : 1.0f;
    const TransferTable table = bakeTransferTable(function, {0.0f, upper, isWhole}, 0.5f);
    std::uniform_real_distribution<float> any(0.0f, upper);
    for (int i = 0; i < 300; ++i) {
      float a = any(random), b = i % 5 ? any(random) : a;
      if (a > b) std::swap(a, b);
      bool shows = shownBy(table, a).color.a > 0.0f || shownBy(table, b).color.a > 0.0f;
      for (const TransferPoint& point : function.points)
        if (point.value >= static_cast<double>(a) && point.value <= static_cast<double>(b))
          shows = shows || function.at(point.value).a > 0.0f;
      if (shows) RC_ASSERT(table.anyVisible(a, b));
    }
    RC_ASSERT(!table.anyVisible(0.7f, 0.3f));
  });
  recordExact("TransferTable::anyVisible misses nothing", "the written function");
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

TEST(Case42, DoublesFromTheLeastToTheGreatest) {
  for (const double size :
       {5e-324, 5.6e-309, 1e-306, 1e-300, 1e-40, 1.0, 1e40, 1e300, std::numeric_limits<double>::max()}) {
    const VolumePtr volume =
        makeTestVolume(VoxelType::float64, {3, 1, 1}, [&](const glm::ivec3& p) { return size * (p.x - 1); });
    for (const double at : {-size, 0.0, size}) {
      const TransferFunction function = stepAt(at);
      const ValueScale scale = valueScaleOf(VoxelType::float64, volume->statistics(), function);
      const TransferTable table = bakeTransferTable(function, *volume, scale, 1.0f);
      for (const double value : {-size, 0.0, size})
        EXPECT_EQ(shownBy(table, interpolant(value, scale)).color.a, value >= at ? 1.0f : 0.0f)
            << value << ", shown from " << at;
    }
    const auto& histogram = volume->statistics().histogram;
    EXPECT_EQ(histogram.front(), 1u) << size;
    EXPECT_EQ(histogram[127] + histogram[128], 1u) << size;  // at a border
    EXPECT_EQ(histogram.back(), 1u) << size;
  }
  recordExact("ValueScale of doubles from 5e-324 to 1.8e308", "the written function");
}

// --- Through the marcher

Image<glm::vec4> pictureOf(Backend backend, const VolumePtr& volume, const TransferFunction& function,
                           const MarchSettings& settings = {}) {
  return rendered(*marcherOn(backend, volume, function), lookingFrom({20.0f, 9.0f, 15.0f}, {}, 24, 24), settings);
}

/// Which of the values a marcher shows: each fills a column of its own, seen through its middle.
std::vector<bool> shownColumns(Backend backend, VoxelType type, const std::vector<double>& values,
                               const TransferFunction& function) {
  const auto count = static_cast<uint32_t>(values.size());
  const VolumePtr volume = makeTestVolume(type, {8 * count, 8, 8},
                                          [&](const glm::ivec3& p) { return values[static_cast<size_t>(p.x / 8)]; });
  const MarcherPtr marcher = marcherOn(backend, volume, function);
  std::vector<bool> shown;
  for (uint32_t i = 0; i < count; ++i) {
    const float x = 8.0f * (static_cast<float>(i) + 0.5f) - 4.0f * static_cast<float>(count);
    const float alpha = rendered(*marcher, lookingFrom({x, 0.0f, 60.0f}, {x, 0.0f, 0.0f}, 1, 1, 1e-3f))(0, 0).a;
    EXPECT_TRUE(alpha == 0.0f || alpha > 0.99f) << values[i] << ": " << alpha;
    shown.push_back(alpha > 0.0f);
  }
  return shown;
}

TEST_P(Case43, RepeatedCornersAreAStep) {
  const TransferFunction function{{{0.0, glm::vec3(1.0f), 0.0f},
                                   {50.0, glm::vec3(1.0f), 0.0f},
                                   {50.0, glm::vec3(1.0f), 1.0f},
                                   {51.0, glm::vec3(1.0f), 1.0f},
                                   {51.0, glm::vec3(1.0f), 0.0f}}};
  for (const VoxelType type : kAllVoxelTypes)
    EXPECT_EQ(shownColumns(GetParam(), type, {49.0, 50.0, 51.0, 0.0}, function),
              std::vector<bool>({false, true, false, false}))
        << nameOf(type);
  recordExact("march by a function of repeated corners", "the written function", GetParam());
}

TEST_P(Case59, LabelsAndOutliersAreShownAsWritten) {
  for (const double label : {1.0, 255.0, 30001.0, 65534.0}) {
    const TransferFunction needle{
        {{label - 0.5, glm::vec3(1.0f), 0.0f}, {label, glm::vec3(1.0f), 1.0f}, {label + 0.5, glm::vec3(1.0f), 0.0f}}};
    EXPECT_EQ(shownColumns(GetParam(), VoxelType::uint16, {0.0, label - 1.0, label, label + 1.0, 65535.0}, needle),
              std::vector<bool>({false, false, true, false, false}))
        << label;
  }
  for (const double outlier : {-9999.0, 1e30}) {
    const TransferFunction band{{{0.3, glm::vec3(1.0f), 0.0f},
                                 {0.3, glm::vec3(1.0f), 1.0f},
                                 {0.6, glm::vec3(1.0f), 1.0f},
                                 {0.6, glm::vec3(1.0f), 0.0f}}};
    EXPECT_EQ(shownColumns(GetParam(), VoxelType::float32, {outlier, 0.25, 0.35, 0.55, 0.65}, band),
              std::vector<bool>({false, false, true, true, false}))
        << outlier;
  }
  recordExact("march of a label among 65536 and of data beside outliers", "the written function", GetParam());
}

TEST_P(Case60, RangesOfAFewValuesAreShownAsWritten) {
  for (const auto& [type, least] : {std::pair(VoxelType::int16, -32768.0),
                                    {VoxelType::uint16, 65532.0},
                                    {VoxelType::int32, 2147483644.0},
                                    {VoxelType::uint32, 4294967292.0}})
    for (int from = 0; from < 4; ++from) {
      std::vector<bool> expected;
      for (int i = 0; i < 4; ++i) expected.push_back(i >= from);
      EXPECT_EQ(shownColumns(GetParam(), type, {least, least + 1.0, least + 2.0, least + 3.0}, stepAt(least + from)),
                expected)
          << nameOf(type) << " from " << from;
    }
  recordExact("march of ranges of 4 values at the ends of types", "the written function", GetParam());
}

TEST_P(Case41, ACubeOfOneInZeroIsShown) {
  const auto cube = [](double inside, double outside) {
    return [=](const glm::ivec3& p) {
      return glm::all(glm::greaterThan(p, glm::ivec3(2))) && glm::all(glm::lessThan(p, glm::ivec3(6))) ? inside
                                                                                                       : outside;
    };
  };
  for (const VoxelType type : kAllVoxelTypes)
    EXPECT_GT(largestAlpha(pictureOf(GetParam(), makeTestVolume(type, glm::uvec3(9), cube(1, 0)), stepAt(1.0))), 0.99f)
        << nameOf(type);
  EXPECT_GT(largestAlpha(pictureOf(GetParam(), makeTestVolume(VoxelType::int16, glm::uvec3(9), cube(-32764, -32767)),
                                   stepAt(-32764.0))),
            0.99f);
  EXPECT_GT(largestAlpha(pictureOf(GetParam(), makeTestVolume(VoxelType::uint16, glm::uvec3(9), cube(65535, 0)),
                                   stepAt(65535.0))),
            0.99f);
  EXPECT_EQ(largestAlpha(pictureOf(GetParam(), makeTestVolume(VoxelType::uint16, glm::uvec3(9), cube(65534, 0)),
                                   stepAt(65535.0))),
            0.0f);
  recordExact("march of a cube of one in zero, of every type", "the written function", GetParam());
}

// --- Cases 33, 37 and 61: the last, partial step

TEST_P(Case61, AWholeStepThatSaturatesThenAPartialOne) {
  // One voxel, seen through its middle along an axis.
  Worst worst;
  for (const float alpha : {0.9f, 0.0003f, 0.5f, 0.999f, 1e-6f})
    for (const float step : {0.25f, 1.0f, 3.0f, 8.0f, 100.0f, 1e4f}) {
      const VolumePtr volume = makeTestVolume(VoxelType::uint8, glm::uvec3(1), [](const glm::ivec3&) { return 5.0; });
      MarchSettings settings;
      settings.render.step = std::min(step, 1000.0f);
      settings.render.contribution = 1e-6f;
      const Camera camera = lookingFrom({0.0f, 0.0f, 5.0f}, {}, 1, 1);
      const Image<glm::vec4> image = rendered(*marcherOn(GetParam(), volume, everywhere(alpha)), camera, settings);
      worst.see(std::abs(static_cast<double>(image(0, 0).a) - static_cast<double>(alpha)) /
                (1e-6 * static_cast<double>(alpha) + 1e-7));
      EXPECT_NEAR(image(0, 0).r, image(0, 0).a, 1e-6) << "step " << step;
    }
  record({"march by steps that saturate, then a part of one", "closed form", "of 1e-6 of the opacity and 1e-7",
          worst.value(), 1.0, GetParam()});
}

}  // namespace
}  // namespace warpscope
