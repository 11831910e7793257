// Holes: pixels that no sample covers although the reference shows something there. And pixels there that show a guess.
// An uncovered pixel where the reference is empty is background, not a hole.
#pragma once

#include "render/warp/warp.h"

namespace warpscope {

/// Least opacity at which the reference shows something.
inline constexpr float kShownAlpha = 1.0f / 255.0f;

struct HoleCount {
  size_t holes = 0;
  size_t filled = 0;  ///< pixels with the id kFilled
  size_t shown = 0;  ///< pixels where the reference shows something
  /// Holes among the shown pixels, 0..1; 0 where nothing is shown.
  double fraction() const { return ofShown(holes); }
  /// Likewise of those that were filled.
  double filledFraction() const { return ofShown(filled); }

 private:
  double ofShown(size_t count) const { return shown == 0 ? 0.0 : static_cast<double>(count) / static_cast<double>(shown); }
};

/// Throws InputError if the sizes differ or the reference holds NaN.
HoleCount countHoles(const WarpedImage& image, const Image<glm::vec4>& reference);

}  // namespace warpscope
