// One function for each content.
// See content.h.
#include "app/picture/content.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "app/picture/heat_map.h"
#include "app/picture/picture.h"
#include "render/base/error.h"
#include "render/core/parallel.h"
#include "render/metrics/holes.h"
#include "render/metrics/picture_errors.h"

namespace warpscope {
namespace {

constexpr std::array<ContentDescriptor, 10> kContents{{
    {"picture", PictureContent::picture, "Picture", "What the technique draws", false, false, "", {}},
    {"difference", PictureContent::difference, "Difference", "Where the picture is brighter (orange) or darker (blue) than the ground truth, as displayed", true, false, "1",
     0.5f},
    {"absolute", PictureContent::absoluteDifference, "Absolute difference", "How far red, green and blue are from the ground truth's, as displayed", true, false, "1", 0.5f},
    {"flip", PictureContent::flip, "FLIP", "How different from the ground truth people find each pixel (Andersson et al. 2020)", true, false, "1", 1.0f / kHeatGain},
    {"holes", PictureContent::holes, "Holes", "Pixels that nothing covers though the ground truth shows something there, and those that show a guess", true, false, "", {}},
    {"opacity", PictureContent::opacity, "Opacity", "From black, where the background shows through, to white", false, false, "1", 1.0f},
    {"depth", PictureContent::depth, "Depth", "How far from the eye the samples or the segments are that pixels show", false, true, "volume units", {}},
    {"radius", PictureContent::radius, "Radius", "How large the samples are that pixels show", false, true, "volume units", {}},
    {"segments", PictureContent::segments, "Segments", "How many of the frame's segments a pixel's ray goes through", false, true, "segments", {}},
    {"age", PictureContent::age, "Age", "Which of the frames that are kept (--keep) pixels are of, counted back from the newest, which is 0", false, false, "frames", 7.0f},
}};

constexpr Rgba8 kUnknown = 0xff303030u, kHole = 0xffc700ffu, kGuess = 0xffffd900u;

/// A picture of `perPixel(i)`, as large as `like`.
template <class Pixel, class Like, class PerPixel>
Image<Pixel> made(const Image<Like>& like, const PerPixel& perPixel) {
  Image<Pixel> picture(like.width(), like.height());
  parallelForRanges(picture.size(), 1 << 14, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) picture[i] = perPixel(i);
  });
  return picture;
}

glm::vec3 displayed(const glm::vec4& premultiplied, const glm::vec3& background) {
  const glm::vec3 linear = glm::clamp(glm::vec3(premultiplied) + (1.0f - premultiplied.a) * background, 0.0f, 1.0f);
  return {srgbFromLinear(linear.r), srgbFromLinear(linear.g), srgbFromLinear(linear.b)};
}

/// Rec. 709 weights, of values as displayed.
float luma(const glm::vec3& rgb) { return glm::dot(rgb, glm::vec3(0.2126f, 0.7152f, 0.0722f)); }

Rgba8 opaque(const glm::vec3& rgb) {
  return quantizeUnorm8(rgb.r) | quantizeUnorm8(rgb.g) << 8 | quantizeUnorm8(rgb.b) << 16 | 0xff000000u;
}

void requireFinite(const Image<glm::vec4>& image, std::string_view what) {
  for (size_t i = 0; i < image.size(); ++i)
    if (!std::isfinite(image[i].r + image[i].g + image[i].b + image[i].a)) throw InputError("a pixel of the " + std::string(what) + " is no number");
}

Image<Rgba8> holesOf(const ContentInputs& inputs) {
  const PixelMarks marks = marksOfHoles(inputs.marks);
  return made<Rgba8>(inputs.image.color, [&](size_t i) {
    const uint32_t sample = inputs.image.samples[i];
    if (sample == kFilled) return marks.filled;
    if (sample == kNoSample && (*inputs.reference)[i].a >= kShownAlpha) return marks.uncovered;
    return opaque(glm::vec3(0.5f * luma(displayed(inputs.image.color[i], inputs.background))));  // dimmed, so that marks stand out
  });
}

/// A value for each pixel, NaN where its sample is not known.
template <class PerSample>
Image<float> ofSamples(const ContentInputs& inputs, const PerSample& perSample) {
  const SampleGrid grid = inputs.frame->grid();
  return made<float>(inputs.image.samples, [&](size_t i) {
    const uint32_t sample = inputs.image.samples[i];
    return sample < inputs.frame->size() ? perSample(unpackSample(inputs.frame->samples[sample], grid)) : std::numeric_limits<float>::quiet_NaN();
  });
}

ShownContent ramped(const Image<float>& values, float low, float high) {
  return {made<Rgba8>(values, [&](size_t i) { return std::isnan(values[i]) ? kUnknown : heatColor((values[i] - low) / (high - low)); }), true, low, high};
}

/// `beginsAtZero`: the ramp does, where nobody says how far it goes.
ShownContent rampedOverExtent(const Image<float>& values, std::optional<float> range, bool beginsAtZero) {
  float low = std::numeric_limits<float>::infinity(), high = -low;
  for (size_t i = 0; i < values.size(); ++i)
    if (!std::isnan(values[i])) low = std::min(low, values[i]), high = std::max(high, values[i]);
  if (!(low <= high)) throw InputError("no pixel of the picture says which sample it shows: the technique does not draw samples, or nothing is to be seen");
  if (range || beginsAtZero) low = 0.0f;
  if (range) high = *range;
  return ramped(values, low, std::max(high, std::nextafter(low, std::numeric_limits<float>::infinity())));
}

}  // namespace

std::optional<SegmentLook> segmentLookOf(const WarpDescriptor& technique, const SampleFrame* frame, const Camera& camera, const std::stop_token& stop) {
  const bool hasSome = technique.uses.segments && frame != nullptr && !frame->segments.empty();
  return hasSome ? std::optional(lookAtSegments(*frame, camera, stop)) : std::nullopt;
}

std::span<const ContentDescriptor> pictureContents() { return kContents; }

const ContentDescriptor& describe(PictureContent content) { return kContents[static_cast<size_t>(content)]; }

PixelMarks marksOfHoles(const PixelMarks& marks) {
  return {marks.uncovered != 0 ? marks.uncovered | 0xff000000u : kHole, marks.filled != 0 ? marks.filled | 0xff000000u : kGuess};
}

Rgba8 rampColor(PictureContent content, float share) {
  switch (content) {
    case PictureContent::difference: return differenceColor(2.0f * share - 1.0f);
    case PictureContent::absoluteDifference:
    case PictureContent::opacity: return opaque(glm::vec3(share));
    default: return heatColor(share);
  }
}

Rgba8 differenceColor(float value) {
  const float share = std::isnan(value) ? 0.0f : std::clamp(value, -1.0f, 1.0f);
  constexpr glm::vec3 kBlue{0.25f, 0.6f, 1.0f}, kOrange{1.0f, 0.6f, 0.1f};
  return opaque(std::abs(share) * (share < 0.0f ? kBlue : kOrange));
}

ShownContent show(PictureContent content, const ContentInputs& inputs, std::optional<float> range) {
  const ContentDescriptor& described = describe(content);
  const Image<glm::vec4>& color = inputs.image.color;
  if (described.usesReference &&
      (inputs.reference == nullptr || inputs.reference->width() != color.width() || inputs.reference->height() != color.height()))
    throw InputError("there is no ground truth of the picture's size");
  if (described.usesSamples && inputs.frame == nullptr) throw InputError("the technique draws no frame, so that its pixels show no samples");
  if (range && !(*range > 0.0f && std::isfinite(*range))) throw InputError("a range is more than 0");
  requireFinite(color, "picture");
  if (described.usesReference) requireFinite(*inputs.reference, "ground truth");
  const float scale = range ? *range : described.usualRange.value_or(1.0f);
  const auto ofPicture = [&](size_t i) { return displayed(color[i], inputs.background); };
  const auto ofTruth = [&](size_t i) { return displayed((*inputs.reference)[i], inputs.background); };
  switch (content) {
    case PictureContent::picture: return {.picture = toScreen(inputs.image, inputs.background, inputs.marks)};
    case PictureContent::difference:
      return {made<Rgba8>(color, [&](size_t i) { return differenceColor((luma(ofPicture(i)) - luma(ofTruth(i))) / scale); }), true, -scale, scale};
    case PictureContent::absoluteDifference:
      return {made<Rgba8>(color, [&](size_t i) { return opaque(glm::abs(ofPicture(i) - ofTruth(i)) / scale); }), true, 0.0f, scale};
    case PictureContent::flip: {
      if (inputs.flip != nullptr) return ramped(*inputs.flip, 0.0f, scale);
      Image<float> map;
      PictureJudge(*inputs.reference, inputs.background).errorsOf(inputs.image, nullptr, &map);
      return ramped(map, 0.0f, scale);
    }
    case PictureContent::holes: return {.picture = holesOf(inputs)};
    case PictureContent::opacity:
      return {made<Rgba8>(color, [&](size_t i) { return opaque(glm::vec3(color[i].a / scale)); }), true, 0.0f, scale};
    case PictureContent::depth: {
      if (inputs.segments != nullptr) return rampedOverExtent(inputs.segments->depth, range, false);
      const glm::vec3 eye = inputs.camera.eye;
      return rampedOverExtent(ofSamples(inputs, [&](const Sphere& sphere) { return glm::length(sphere.center - eye); }), range, false);
    }
    case PictureContent::age:
      return ramped(made<float>(inputs.image.samples, [&](size_t i) {
                      const uint32_t id = inputs.image.samples[i];
                      return id == kNoSample || id == kFilled ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(framesBack(id));
                    }), 0.0f, scale);
    case PictureContent::segments:
      if (inputs.segments == nullptr) throw InputError("the technique draws no segments");
      return rampedOverExtent(inputs.segments->count, range, true);
    case PictureContent::radius: return rampedOverExtent(ofSamples(inputs, [](const Sphere& sphere) { return sphere.radius; }), range, true);
  }
  throw std::logic_error("a picture's content is none");
}

}  // namespace warpscope
