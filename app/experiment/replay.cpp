// One picture after the other.
// See replay.h.
#include "app/experiment/replay.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "app/frames/wire_fields.h"
#include "app/picture/picture.h"
#include "app/picture/text.h"
#include "render/base/error.h"
#include "render/base/formatted.h"

namespace warpscope {
namespace {

constexpr uint32_t kLabelPx = 24, kGapPx = 4;
constexpr float kTextPx = 16.0f;
constexpr Rgba8 kPaper = 0xff181512u, kInk = 0xffe6e0dcu;

void paste(Image<Rgba8>& page, const Image<Rgba8>& picture, uint32_t left) {
  for (uint32_t y = 0; y < picture.height(); ++y) std::copy_n(picture.row(y), picture.width(), page.row(y) + left);
}

/// Why none of the frames has what the technique draws; empty where some have, or there are none.
std::string lackInAll(const Recording& recording, const TechniqueInUse& one) {
  std::string lack;
  for (const Recording::Frame& frame : recording.frames) {
    lack = lackOf(*one.technique, marchFrom(frame.head.settings), one.knobs);
    if (lack.empty()) break;
  }
  return lack;
}

}  // namespace

void requireDrawable(const Recording& recording, const ReplaySettings& settings) {
  const std::string file = recording.file.string();
  for (const TechniqueInUse& one : settings.techniques) {
    if (const std::string lack = lackInAll(recording, one); !lack.empty()) throw InputError(file + ": " + std::string(one.technique->name) + " can show nothing of its frames: " + lack);
    if (recording.frames.empty() && one.technique->usesFrame)
      throw InputError(file + ": holds no frames, only where the camera was: there is nothing to be drawn of them");
  }
}

size_t pictureCount(const Recording& recording, double picturesPerSecond) {
  return static_cast<size_t>(std::floor(recording.seconds * picturesPerSecond)) + 1;
}

uint32_t replayHeight(const ReplaySettings& settings) { return settings.height + (settings.hasLabels ? kLabelPx : 0); }

void replay(const Recording& recording, const ReplaySettings& settings, const std::function<void(size_t, const Image<Rgba8>&)>& onPicture,
            const std::stop_token& stop) {
  struct Row {
    std::unique_ptr<Warp> warp;
    WarpSettings warpSettings;
    SampleFramePtr frame;
  };
  std::vector<Row> rows;
  WarpResources resources = settings.resources;
  for (const TechniqueInUse& one : settings.techniques) {
    Row& row = rows.emplace_back();
    row.warp = makeWarp(*one.technique, resources);
    row.warpSettings.knobs = one.knobs.only(one.technique->knobs);
    row.warpSettings.reference = recording.scene.march.render;
    if (!one.technique->usesFrame) row.warp->setFrame(nullptr, row.warpSettings, stop);
  }
  RecordedFrames frames(recording);
  const auto columns = static_cast<uint32_t>(rows.size());
  Image<Rgba8> page(columns * settings.width + (columns - 1) * kGapPx, replayHeight(settings));
  WarpedImage image;
  const size_t count = pictureCount(recording, settings.picturesPerSecond);
  const TransferFunction* marchedBy = functionAt(recording, 0.0);
  // Those that march follow the function; those that draw frames have it with each.
  const auto follow = [&](const TransferFunction* function) {
    if (function == marchedBy || resources.marcher == nullptr) return;
    marchedBy = function;
    resources.marcher = resources.marcher->withTransferFunction(*function);
    for (size_t k = 0; k < rows.size(); ++k) {
      if (settings.techniques[k].technique->usesFrame) continue;
      rows[k].warp = makeWarp(*settings.techniques[k].technique, resources);
      rows[k].warp->setFrame(nullptr, rows[k].warpSettings, stop);
    }
  };
  for (size_t i = 0; i < count; ++i) {
    if (stop.stop_requested()) throw OperationCancelled();
    const double seconds = static_cast<double>(i) / settings.picturesPerSecond;
    const Camera camera = makeCamera(recording.scene, recording.path.at(seconds), settings.width, settings.height);
    const SampleFramePtr frame = frames.at(seconds);
    follow(functionAt(recording, seconds));
    std::fill(page.begin(), page.end(), kPaper);
    for (size_t k = 0; k < rows.size(); ++k) {
      Row& row = rows[k];
      const WarpDescriptor& technique = *settings.techniques[k].technique;
      const auto left = static_cast<uint32_t>(k) * (settings.width + kGapPx);
      if (technique.usesFrame && frame && row.frame != frame) row.warp->setFrame(row.frame = frame, row.warpSettings, stop);
      if (!technique.usesFrame || frame) {
        row.warp->draw(camera, row.warpSettings, image, stop);
        paste(page, toScreen(image, recording.scene.background), left);
      }
      if (!settings.hasLabels) continue;
      const std::string text = std::string(technique.label) + (technique.usesFrame && !frame ? ": no frame yet" : "") + formatted("   %.2f s", seconds);
      drawText(page, static_cast<float>(left) + 6.0f, static_cast<float>(settings.height) + 4.0f, text, kTextPx, kInk);
    }
    onPicture(i, page);
  }
}

}  // namespace warpscope
