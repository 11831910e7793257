// What is said of several angles or instants in one figure, for every command and for the window.
// Angles count alike, however often a picture was looked at from one; errors in decibels are averaged as the squares that they stand for.
#pragma once

#include <span>

#include "render/metrics/picture_errors.h"

namespace warpscope {

/// One configuration at one angle, or over several.
struct AngleFigures {
  double flip = 0.0;
  double holeFraction = 0.0;
  double frameMs = 0.0;  ///< SweepRow::frameMs
  double drawMs = 0.0;
};

/// Mean errors, and the times of the slowest view; `angles` are not empty.
AngleFigures overAngles(std::span<const AngleFigures> angles);

/// Errors at several instants of a motion. Those of parts of a picture have no mean: each instant has other parts.
class MeanErrors {
 public:
  void add(const PictureErrors& errors);
  /// Of at least one.
  PictureErrors mean() const;

 private:
  int count_ = 0;
  PictureErrors sum_;
  double square_ = 0.0, linearSquare_ = 0.0;
};

}  // namespace warpscope
