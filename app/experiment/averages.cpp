// Sums and shares.
// See averages.h.
#include "app/experiment/averages.h"

#include <algorithm>
#include <cmath>

namespace warpscope {
namespace {

double squareOf(double decibels) { return std::pow(10.0, -0.1 * decibels); }

}  // namespace

AngleFigures overAngles(std::span<const AngleFigures> angles) {
  AngleFigures over;
  for (const AngleFigures& one : angles) {
    over.flip += one.flip;
    over.holeFraction += one.holeFraction;
    over.frameMs = std::max(over.frameMs, one.frameMs);
    over.drawMs = std::max(over.drawMs, one.drawMs);
  }
  over.flip /= static_cast<double>(angles.size());
  over.holeFraction /= static_cast<double>(angles.size());
  return over;
}

void MeanErrors::add(const PictureErrors& errors) {
  ++count_;
  sum_.ssim += errors.ssim;
  sum_.flip += errors.flip;
  sum_.holeFraction += errors.holeFraction;
  sum_.filledFraction += errors.filledFraction;
  square_ += squareOf(errors.psnrDb);
  linearSquare_ += squareOf(errors.psnrLinearDb);
}

PictureErrors MeanErrors::mean() const {
  const double share = 1.0 / count_;
  PictureErrors mean;
  mean.ssim = sum_.ssim * share;
  mean.flip = sum_.flip * share;
  mean.holeFraction = sum_.holeFraction * share;
  mean.filledFraction = sum_.filledFraction * share;
  mean.psnrDb = -10.0 * std::log10(square_ * share);
  mean.psnrLinearDb = -10.0 * std::log10(linearSquare_ * share);
  return mean;
}

}  // namespace warpscope
