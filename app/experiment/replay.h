// A recording shown again in virtual time: by any techniques, at any rate and size; the same file gives the same pictures on every run.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "app/frames/recording.h"
#include "app/picture/content.h"
#include "render/core/color.h"
#include "render/warp/warp.h"

namespace warpscope {

/// A technique, how its knobs are set, and what of its pictures is shown.
struct ReplayColumn : TechniqueInUse {
  PictureContent content = PictureContent::picture;
  std::optional<float> range{};  ///< as show() takes it
};

struct ReplaySettings {
  std::vector<ReplayColumn> columns;       ///< beside each other, from the left
  double picturesPerSecond = 30.0;
  uint32_t width = 512, height = 512;      ///< of each technique's picture
  bool hasLabels = true;                   ///< below each the technique's name, what else than its picture is shown, and its frame's age, below all the time and what was simulated of the link
  bool hasErrors = false;                  ///< below each how far it is from the ground truth, which `resources.marcher` marches
  WarpResources resources;                 ///< of techniques; `marcher` for those that march
};

/// How many pictures there are: at least one.
size_t pictureCount(const Recording& recording, double picturesPerSecond);
/// Height of a picture, with its labels.
uint32_t replayHeight(const ReplaySettings& settings);

/// Why there is nothing of what is to be shown of the technique, whatever it is given; empty where there is.
std::string lackOfContent(const ReplayColumn& column);
/// Shows the pictures themselves in place of contents of which there is nothing, and without a ground truth of those that need it: as the window's panels do.
void showWhatThereIs(std::vector<ReplayColumn>& columns, bool hasTruth);

/// Whether `resources.marcher` is needed: for techniques that march, and for a ground truth.
bool needsMarcher(std::span<const ReplayColumn> columns, bool hasErrors);

/// Throws InputError, naming the recording, where one of the techniques can show nothing of its frames, or nothing of what is to be shown of it.
void requireDrawable(const Recording& recording, const ReplaySettings& settings);

/// Calls `onPicture` for each picture, in order. Throws InputError for a frame that cannot be decoded, OperationCancelled if `stop` is set; and as techniques do.
void replay(const Recording& recording, const ReplaySettings& settings, const std::function<void(size_t index, const Image<Rgba8>&)>& onPicture,
            const std::stop_token& stop);

}  // namespace warpscope
