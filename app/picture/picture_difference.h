// How far two pictures of one size are apart, channel by channel as displayed: what pixels that should be the same differ by.
// For what people see of it there is FLIP (render/metrics/flip.h).
#pragma once

#include "render/core/color.h"
#include "render/core/image.h"

namespace warpscope {

/// Two rasterisers may disagree about a pixel whose centre lies on a point's edge, and two processors in the last bit of a colour.
inline constexpr int kChannelTolerance = 2;  ///< of 255

struct PictureDifference {
  bool sameSize = false;  ///< and not empty
  double fraction = 1.0;  ///< of the pixels that differ by more than kChannelTolerance in any channel, opacity among them
  int largest = 255;      ///< over all channels

  bool isTolerable(double mostFraction) const { return sameSize && fraction <= mostFraction; }
};

PictureDifference comparePictures(const Image<Rgba8>& image, const Image<Rgba8>& expected);

/// Sixteen times the difference, opaque; black where the pictures are equal. Of what both have.
Image<Rgba8> amplifiedDifference(const Image<Rgba8>& image, const Image<Rgba8>& expected);

}  // namespace warpscope
