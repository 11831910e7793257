// What a table shows, and what the function says that it was baked from: the oracle of tests of tables. Truth: the
// function as it was written, in double.
// Mirrors the promises of TransferLookup in render/core/transfer_table.h.
#pragma once

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <utility>

#include "render/core/transfer_table.h"

namespace warpscope {

inline TransferFunction stepAt(double value) {
  return {{{value, glm::vec3(1.0f), 0.0f}, {value, glm::vec3(1.0f), 1.0f}}};
}

struct Shown {
  glm::vec4 color{0.0f};
  float unitAlpha = 0.0f;

  bool operator==(const Shown&) const = default;
};

inline Shown shownBy(const TransferTable& table, float x) {
  const auto entry = static_cast<size_t>(table.lookup().entryOf(x));
  return {table.entries[entry], table.unitAlphas[entry]};
}

/// As the function says, corrected as the table's step wants it.
inline Shown written(const TransferFunction& function, double value, float step) {
  const glm::vec4 straight = function.at(value);
  const float alpha = correctOpacity(straight.a, step);
  return {{glm::vec3(straight) * alpha, alpha}, straight.a};
}

inline float differenceOf(const Shown& a, const Shown& b) {
  const glm::vec4 difference = glm::abs(a.color - b.color);
  return std::max({difference.r, difference.g, difference.b, difference.a, std::abs(a.unitAlpha - b.unitAlpha)});
}

/// What a test says where `is` was not wanted: where, what is shown, what is written.
inline std::string complaint(const TransferTable& table, float x, const Shown& is, const Shown& wanted) {
  std::ostringstream text;
  text.precision(9);
  text << "at " << x << ", bin " << table.lookup().binOf(x) << " of " << table.bins;
  for (const auto& [words, shown] : {std::pair(": shown is ", &is), std::pair(", written is ", &wanted)})
    text << words << '(' << shown->color.r << ' ' << shown->color.g << ' ' << shown->color.b << ' ' << shown->color.a
         << ") of unit opacity " << shown->unitAlpha;
  return text.str();
}

/// What is wrong where `x`, which stands for `value`, has to show exactly what is written; empty: nothing.
inline std::string wrongExactly(const TransferTable& table, const TransferFunction& function, float x, double value) {
  const Shown is = shownBy(table, x), wanted = written(function, value, table.step);
  return is == wanted ? std::string() : complaint(table, x, is, wanted);
}

/// Whether x lies between two corners of which one has opacity.
inline bool isWithinARamp(const TransferFunction& function, double x) {
  for (size_t i = 0; i + 1 < function.points.size(); ++i) {
    const TransferPoint &left = function.points[i], &right = function.points[i + 1];
    if (left.value < x && x < right.value) return left.alpha > 0.0f || right.alpha > 0.0f;
  }
  return false;
}

/// Whether the bin of x begins with nothing, and what lies in the next bin is shown.
inline bool isFootAt(const TransferTable& table, const TransferFunction& function, float x) {
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

/// What is wrong at `x`, which need not be a whole number; empty: nothing. Right is what is within the bound, and
/// visible if and only if the function shows it. What is hardly anything may be left out at the foot of a ramp, where
/// it rises out of nothing within a bin.
inline std::string wrongBeyondTheBound(const TransferTable& table, const TransferFunction& function, float x) {
  const Shown is = shownBy(table, x), wanted = written(function, static_cast<double>(x), table.step);
  if (!(differenceOf(is, wanted) <= TransferTable::kMostVariation * 1.0001f)) return complaint(table, x, is, wanted);
  if ((is.color.a > 0.0f) == (wanted.color.a > 0.0f)) return {};
  const bool mayBeFoot =
      wanted.unitAlpha > 0.0f && wanted.unitAlpha <= TransferTable::kLeastShown && isFootAt(table, function, x);
  // Within a ramp, what at() rounds to nothing is something.
  const bool mayBeEnd = wanted.unitAlpha == 0.0f && isWithinARamp(function, static_cast<double>(x));
  return (is.color.a > 0.0f ? mayBeEnd : mayBeFoot) ? std::string() : complaint(table, x, is, wanted);
}

}  // namespace warpscope
