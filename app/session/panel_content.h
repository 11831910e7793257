// What a panel shows in place of its picture.
// Found on the judge's thread (judge_worker.h), as errors are.
#pragma once

#include <optional>
#include <string>

#include "app/picture/content.h"
#include "app/picture/shown_picture.h"

namespace warpscope {

struct PanelContent {
  PictureContent what = PictureContent::picture;
  std::optional<float> range;      ///< that was asked for
  ShownPicture picture;            ///< of the size of the panel's
  bool hasRamp = false;
  float low = 0.0f, high = 0.0f;   ///< what the ramp's ends stand for
  std::string refusal;             ///< why there is none; mostly empty
};

}  // namespace warpscope
