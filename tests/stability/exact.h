// Oracles: a hundred decimal digits, and enclosures that tell what rounding in single precision may do to a formula.
// Interval arithmetic after Moore 1966; rounding errors after Higham 2002, chapter 2.
#pragma once

#include <algorithm>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>

#include "render/core/host_device.h"

namespace warpscope {

using Exact = boost::multiprecision::cpp_bin_float_100;

/// Unit roundoff of float: what one operation is off by, relative to its result.
inline constexpr double kUnitRoundoff = 0x1p-24;

struct ExactVec {
  Exact x, y, z;
  explicit ExactVec(const glm::vec3& v) : x(v.x), y(v.y), z(v.z) {}
  ExactVec(Exact px, Exact py, Exact pz) : x(std::move(px)), y(std::move(py)), z(std::move(pz)) {}
  ExactVec operator-(const ExactVec& o) const { return {x - o.x, y - o.y, z - o.z}; }
  ExactVec operator+(const ExactVec& o) const { return {x + o.x, y + o.y, z + o.z}; }
  ExactVec operator*(const Exact& s) const { return {x * s, y * s, z * s}; }
};
inline Exact dot(const ExactVec& a, const ExactVec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Exact length(const ExactVec& v) { return sqrt(dot(v, v)); }
inline ExactVec cross(const ExactVec& a, const ExactVec& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// |value - truth| in units of 2^-24 `scale`.
inline double roundoffs(const Exact& value, const Exact& truth, const Exact& scale) {
  const Exact difference = abs(value - truth);
  if (difference == 0) return 0.0;
  return static_cast<double>(difference / (scale * Exact(kUnitRoundoff)));
}

enum class Verdict { hit, miss, undecided };

/// Holds the real number that a formula stands for, and every number that the formula may become where each of its
/// operations is rounded to float: ends are moved apart by a roundoff after each. What is certain of it is certain of
/// both.
struct Enclosure {
  double lower, upper;

  Enclosure(double value) : lower(value), upper(value) {}  // a float, exactly
  Enclosure(double least, double greatest) : lower(least), upper(greatest) {}

  /// After an operation. Below the least normal float an absolute error comes in place of the relative one.
  static Enclosure rounded(double least, double greatest) {
    constexpr double kOff = 1.0001 * kUnitRoundoff;  // ends are doubles, and rounded themselves
    return {least - kOff * std::abs(least) - 0x1p-149, greatest + kOff * std::abs(greatest) + 0x1p-149};
  }
  /// Known no better than to `count` roundoffs.
  Enclosure widened(double count) const {
    const double off = count * kUnitRoundoff * std::max(std::abs(lower), std::abs(upper));
    return {lower - off, upper + off};
  }
  friend Enclosure operator+(const Enclosure& a, const Enclosure& b) {
    return rounded(a.lower + b.lower, a.upper + b.upper);
  }
  friend Enclosure operator-(const Enclosure& a, const Enclosure& b) {
    return rounded(a.lower - b.upper, a.upper - b.lower);
  }
  friend Enclosure operator*(const Enclosure& a, const Enclosure& b) {
    const auto [least, greatest] =
        std::minmax({a.lower * b.lower, a.lower * b.upper, a.upper * b.lower, a.upper * b.upper});
    return rounded(least, greatest);
  }
  Enclosure squared() const {
    const double a = lower * lower, b = upper * upper;
    return rounded(lower <= 0.0 && upper >= 0.0 ? 0.0 : std::min(a, b), std::max(a, b));
  }
  Enclosure root() const { return rounded(std::sqrt(std::max(0.0, lower)), std::sqrt(std::max(0.0, upper))); }
  /// Either of two.
  friend Enclosure hull(const Enclosure& a, const Enclosure& b) {
    return {std::min(a.lower, b.lower), std::max(a.upper, b.upper)};
  }

  bool isPositive() const { return lower > 0.0; }
  bool isNegative() const { return upper < 0.0; }
};

}  // namespace warpscope
