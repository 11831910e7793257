// A recording shown again in virtual time: by any techniques, at any rate and size; the same file gives the same pictures on every run.
#pragma once

#include <functional>
#include <stop_token>
#include <vector>

#include "app/frames/recording.h"
#include "render/core/color.h"
#include "render/warp/warp.h"

namespace warpscope {

struct ReplaySettings {
  std::vector<TechniqueInUse> techniques;  ///< beside each other, from the left
  double picturesPerSecond = 30.0;
  uint32_t width = 512, height = 512;      ///< of each technique's picture
  bool hasLabels = true;                   ///< below each the technique's name and its frame's age, below all the time and what was simulated of the link
  bool hasErrors = false;                  ///< below each how far it is from the ground truth, which `resources.marcher` marches
  WarpResources resources;                 ///< of techniques; `marcher` for those that march
};

/// How many pictures there are: at least one.
size_t pictureCount(const Recording& recording, double picturesPerSecond);
/// Height of a picture, with its labels.
uint32_t replayHeight(const ReplaySettings& settings);

/// Throws InputError, naming the recording, where one of the techniques can show nothing of its frames.
void requireDrawable(const Recording& recording, const ReplaySettings& settings);

/// Calls `onPicture` for each picture, in order. Throws InputError for a frame that cannot be decoded, OperationCancelled if `stop` is set; and as techniques do.
void replay(const Recording& recording, const ReplaySettings& settings, const std::function<void(size_t index, const Image<Rgba8>&)>& onPicture,
            const std::stop_token& stop);

}  // namespace warpscope
