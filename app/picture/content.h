// What of a warped picture is looked at: itself, where and how much it is wrong, what its pixels are made of.
// One list and one set of operations on images for the window's panels and the command line.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "render/base/range.h"
#include "render/core/color.h"
#include "render/core/image.h"
#include "render/march/sample_frame.h"
#include "render/warp/segments/segment_look.h"
#include "render/warp/warp.h"

namespace warpscope {

enum class PictureContent { picture, difference, absoluteDifference, flip, holes, opacity, depth, radius, segments, age };

/// One row of pictureContents().
struct ContentDescriptor {
  std::string_view name;   ///< on the command line
  PictureContent value;
  std::string_view label;  ///< in the window
  std::string_view help;   ///< one sentence without its full stop
  bool usesReference = false;
  bool usesSamples = false;  ///< shows nothing of pictures whose pixels do not say which sample of a frame they show
  std::string_view unit;     ///< of the ramp's ends; empty where there is no ramp, "1" for pure numbers
  std::optional<float> usualRange;  ///< what the ramp's upper end stands for unless somebody says; nothing: the largest value in the picture, or no ramp
};

/// Of a picture that the technique itself drew of the frame (null: of none): what its rays meet of segments; nothing where it draws none. Throws as lookAtSegments().
std::optional<SegmentLook> segmentLookOf(const WarpDescriptor& technique, const SampleFrame* frame, const Camera& camera, const std::stop_token& stop = {});

/// What the upper end of a ramp may stand for.
inline constexpr Range kContentRange{1e-6, 1e6};

std::span<const ContentDescriptor> pictureContents();
const ContentDescriptor& describe(PictureContent content);

/// What a content is made of.
struct ContentInputs {
  const WarpedImage& image;
  Camera camera;            ///< that it was drawn for
  glm::vec3 background{0.0f};  ///< linear RGB
  PixelMarks marks{};          ///< for the picture itself, and the colours of holes (magenta and cyan where there are none)
  const Image<glm::vec4>* reference = nullptr;  ///< linear and premultiplied, as large as the image; where the content uses it
  const SampleFrame* frame = nullptr;  ///< that the image's samples are of; where the content uses it
  const Image<float>* flip = nullptr;  ///< FLIP of each pixel, if that was found already
  const SegmentLook* segments = nullptr;  ///< where the image is drawn of the frame's segments: contents of samples are of those then
};

/// A content as a screen shows it.
struct ShownContent {
  Image<Rgba8> picture;  ///< opaque
  bool hasRamp = false;
  float low = 0.0f, high = 0.0f;  ///< what the ramp's ends stand for; of a difference the ramp's middle is 0
};

/// `range`: what the ramp's upper end stands for, more than 0, in the content's unit; the lower end is 0 or, of a difference, its opposite. Without it:
/// usualRange, or the picture's own extent. Pixels of which the content says nothing are dark grey. Throws InputError where the reference or the frame is missing
/// or of another size, where a pixel is not finite, and where no pixel says which sample it shows.
ShownContent show(PictureContent content, const ContentInputs& inputs, std::optional<float> range = {});

/// Colours, opaque, of pixels with nothing and of guesses where holes are shown.
PixelMarks marksOfHoles(const PixelMarks& marks);

/// The colour at a share of the content's ramp, 0 to 1.
Rgba8 rampColor(PictureContent content, float share);

/// A ramp from blue at -1 over black at 0 to orange at 1: told apart with any colour vision. Clamps; NaN is 0.
Rgba8 differenceColor(float value);

}  // namespace warpscope
