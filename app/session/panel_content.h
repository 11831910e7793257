// What a panel shows in place of its picture, and what is known of the picture's pixels.
// Found on the judge's thread (judge_worker.h), as errors are.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "app/picture/content.h"
#include "app/picture/shown_picture.h"
#include "app/session/warp_job.h"

namespace warpscope {

struct PanelContent {
  PictureContent what = PictureContent::picture;
  std::optional<float> range;      ///< that was asked for
  ShownPicture picture;            ///< of the size of the panel's
  bool hasRamp = false;
  float low = 0.0f, high = 0.0f;   ///< what the ramp's ends stand for
  std::string refusal;             ///< why there is none; mostly empty
};

/// Of a picture that was judged.
struct PanelPixels {
  ShownPicture picture;     ///< that it is about; none where the image is an earlier camera's
  std::shared_ptr<const WarpedImage> image;
  std::shared_ptr<const ReferenceImage> reference;
  SampleFramePtr frame;     ///< in host memory where there is a picture or a content to it; null where the technique draws none
  glm::vec3 background{0.0f};
  PixelMarks marks;
  Image<float> flip;
  std::optional<SegmentLook> segments;  ///< where the picture is drawn of them

  /// The pixel at a place in shares of the picture's width and height from its upper left corner.
  glm::uvec2 at(const glm::dvec2& place) const {
    const glm::dvec2 size(image->color.width(), image->color.height());
    return glm::uvec2(glm::clamp(place * size, glm::dvec2(0.0), size - 1.0));
  }
  ContentInputs inputs() const {
    return {.image = *image,
            .camera = reference->job().camera,
            .background = background,
            .marks = marks,
            .reference = &reference->color(),
            .frame = frame.get(),
            .flip = &flip,
            .segments = segments ? &*segments : nullptr};
  }
};

}  // namespace warpscope
