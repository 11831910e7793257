// A frame's own picture, as seen by a camera that was only turned: from the same eye, whatever its directions, field of
// view and size. The map between two such pictures is a homography of the plane and knows no depth: Hartley, Zisserman,
// Multiple View Geometry (2004), 8.4.
#pragma once

#include <stop_token>

#include "render/warp/warp.h"

namespace warpscope {

/// What the frame's own camera sees: the rays of own_picture.h, and their colours.
WarpedImage ownImageOf(const SampleFrame& frame);

/// Gives every pixel of `camera` what the picture `own` of the camera `from` shows in the direction of the pixel's
/// centre; the eyes of both are taken to be one. `image` gets the size of `camera` and is another one than `own`.
///
/// Colours are interpolated linearly between the centres of the picture's pixels, premultiplied, since what is between
/// two rays is between their light: the nearest one would move edges by up to half a pixel (FLIP of a picture a quarter
/// larger, by the test: 0.010 instead of 0.019). A pixel without a sample is one in which nothing is seen, and counts
/// as that; towards the border the outermost centres stay. The id is that of the nearest covered one of the centres
/// that were mixed. What has none, or lies outside the picture or behind its eye, is covered by nothing.
///
/// With a `nearness` above 0 the eyes may be two: the picture is taken to lie on the plane at forward depth 1 / nearness of its own camera, seen from before
/// or behind.
///
/// Within 1/2000 of a pixel of the place that the two cameras, as they are given, mean, wherever the eye is, which is
/// not looked at where `nearness` is 0; for fields of view of a millionth of a degree and more. Throws InputError for an unusable camera,
/// OperationCancelled if `stop` is set.
void drawRotated(const WarpedImage& own, const Camera& from, const Camera& camera, WarpedImage& image,
                 const std::stop_token& stop = {}, double nearness = 0.0);

}  // namespace warpscope
