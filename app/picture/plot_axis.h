// One axis of a plot: from values to places, and where its ticks are.
// For plots in files and in the window alike.
#pragma once

#include <string>
#include <vector>

namespace warpscope {

class AxisScale {
 public:
  /// `from` and `to` are the places of the axis's ends; they may fall.
  AxisScale(bool isLogarithmic, double from, double to) : isLogarithmic_(isLogarithmic), from_(from), to_(to) {}

  /// The axis shall reach this value; those that it cannot show (not finite, or 0 and less where it is logarithmic) are left out.
  void include(double value);
  /// Leaves a little room beyond the ends. Once, when all values are included, and before what follows.
  void settle();

  /// Values beyond the ends stand at them. NaN for NaN.
  double place(double value) const;
  /// By rising value: 1, 2 and 5 times powers of ten where it is logarithmic and has room for three of them, else about six even ones.
  std::vector<double> ticks() const;

 private:
  bool isLogarithmic_;
  double from_, to_;
  double lowest_ = 0.0, highest_ = 0.0;
  bool isEmpty_ = true;
};

/// "25", "0.05", "20 k": thousands and millions by their signs.
std::string tickText(double value);

}  // namespace warpscope
