// One picture after the other.
// See replay.h.
#include "app/experiment/replay.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <span>

#include "app/frames/recorded_frames.h"
#include "app/frames/wire_fields.h"
#include "app/picture/picture.h"
#include "app/picture/text.h"
#include "render/base/error.h"
#include "render/base/formatted.h"
#include "render/metrics/picture_errors.h"

namespace warpscope {
namespace {

constexpr uint32_t kLineHeightPx = 24, kGapPx = 4;
constexpr float kTextPx = 16.0f, kMarginPx = 6.0f;
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

const std::array<std::string, 3> kIsTruth{"ground truth", "ground truth", "truth"};

/// What is shown in place of the picture, and what its ramp stands for.
std::string textOf(const ReplayColumn& column, const ShownContent& shown) {
  const ContentDescriptor& content = describe(column.content);
  std::string text(content.label);
  if (!shown.hasRamp) return text;
  text += " " + formatted("%.3g", shown.low) + " to " + formatted("%.3g", shown.high);
  return content.unit == "1" ? text : text + " " + std::string(content.unit);
}

/// The first that is not wider than that, from the longest to the shortest; else the last, which is cut off.
std::string fitting(std::span<const std::string> choices, uint32_t widthPx) {
  const auto fits = [&](const std::string& text) { return textWidth(text, kTextPx) <= static_cast<float>(widthPx) - 2.0f * kMarginPx; };
  const auto chosen = std::ranges::find_if(choices, fits);
  return chosen != choices.end() ? *chosen : choices.back();
}

/// Lines of text below pictures.
class Labels {
 public:
  Labels(Image<Rgba8>& page, uint32_t top) : page_(page), top_(top) {}
  /// In a strip of the page, whose text ends where it does.
  void write(uint32_t line, uint32_t left, uint32_t widthPx, std::span<const std::string> choices) {
    Image<Rgba8> strip(widthPx, kLineHeightPx);
    std::fill(strip.begin(), strip.end(), kPaper);
    drawText(strip, kMarginPx, 4.0f, fitting(choices, widthPx), kTextPx, kInk);
    for (uint32_t y = 0; y < kLineHeightPx; ++y) std::copy_n(strip.row(y), widthPx, page_.row(top_ + line * kLineHeightPx + y) + left);
  }

 private:
  Image<Rgba8>& page_;
  const uint32_t top_;
};

std::string ageText(double seconds) { return seconds < 9.95 ? formatted("%.0f ms", 1e3 * seconds) : formatted("%.0f s", seconds); }

std::array<std::string, 3> errorTexts(const PictureErrors& errors) {
  const std::string psnr = std::isinf(errors.psnrDb) ? std::string("PSNR ∞") : formatted("PSNR %.1f dB", errors.psnrDb), flip = formatted("FLIP %.3f", errors.flip);
  return {psnr + ", " + flip + formatted(", holes %.1f %%", 100.0 * errors.holeFraction), psnr + ", " + flip, psnr};
}

/// For how long the camera of a frame has not been the current one any more.
class FrameAges {
 public:
  explicit FrameAges(const Recording& recording) : recording_(recording) {}
  /// Of the frame that is on show at that time; in seconds.
  double at(double seconds, const SampleFramePtr& frame) {
    if (frame != frame_)
      if (const std::optional<size_t> index = frameAt(recording_, seconds)) left_ = leftAt(recording_, viewAskedWith(recording_, recording_.frames[*index], frame->camera));
    frame_ = frame;
    return std::max(0.0, seconds - left_);
  }

 private:
  const Recording& recording_;
  SampleFramePtr frame_;
  double left_ = 0.0;
};

}  // namespace

void requireDrawable(const Recording& recording, const ReplaySettings& settings) {
  const std::string file = recording.file.string();
  for (const ReplayColumn& one : settings.columns) {
    if (const std::string lack = lackOfContent(one); !lack.empty()) throw InputError(lack);
    if (const std::string lack = lackInAll(recording, one); !lack.empty()) throw InputError(file + ": " + std::string(one.technique->name) + " can show nothing of its frames: " + lack);
    if (recording.frames.empty() && one.technique->usesFrame)
      throw InputError(file + ": holds no frames, only where the camera was: there is nothing to be drawn of them");
  }
}

std::string lackOfContent(const ReplayColumn& column) {
  const std::string label(describe(column.content).label), name(column.technique->name);
  if (describe(column.content).usesSamples && !column.technique->usesFrame) return label + ": is about samples, and " + name + " draws none";
  if (column.content == PictureContent::segments && !column.technique->uses.segments) return label + ": " + name + " draws none";
  return "";
}

void showWhatThereIs(std::vector<ReplayColumn>& columns, bool hasTruth) {
  for (ReplayColumn& column : columns)
    if (!lackOfContent(column).empty() || (describe(column.content).usesReference && !hasTruth)) column.content = PictureContent::picture;
}

bool needsMarcher(std::span<const ReplayColumn> columns, bool hasErrors) {
  return hasErrors || std::ranges::any_of(columns, [](const ReplayColumn& one) { return !one.technique->usesFrame || describe(one.content).usesReference; });
}

size_t pictureCount(const Recording& recording, double picturesPerSecond) {
  return static_cast<size_t>(std::floor(recording.seconds * picturesPerSecond)) + 1;
}

uint32_t replayHeight(const ReplaySettings& settings) { return settings.height + kLineHeightPx * ((settings.hasLabels ? 2 : 0) + (settings.hasErrors ? 1 : 0)); }

void replay(const Recording& recording, const ReplaySettings& settings, const std::function<void(size_t, const Image<Rgba8>&)>& onPicture,
            const std::stop_token& stop) {
  struct Row {
    const WarpDescriptor* technique;
    std::unique_ptr<Warp> warp;
    WarpSettings warpSettings;
    SampleFramePtr frame;
    WarpedImage image;
  };
  std::vector<Row> rows;
  WarpResources resources = settings.resources;
  const auto make = [&](Row& row) {
    row.warp = makeWarp(*row.technique, resources);
    if (!row.technique->usesFrame) row.warp->setFrame(nullptr, row.warpSettings, stop);
  };
  const auto add = [&](const WarpDescriptor& technique, const KnobValues& knobs) {
    Row& row = rows.emplace_back();
    row.technique = &technique;
    row.warpSettings.knobs = knobs.only(technique.knobs);
    row.warpSettings.reference = recording.scene.march.render;
    make(row);
  };
  for (const ReplayColumn& one : settings.columns) add(*one.technique, one.knobs);
  const auto columns = static_cast<uint32_t>(rows.size());
  // What the others are judged by: `reference` as it is without knobs of its own, behind the others where it is not among them.
  std::optional<size_t> truth;
  if (settings.hasErrors || std::ranges::any_of(settings.columns, [](const ReplayColumn& one) { return describe(one.content).usesReference; })) {
    const WarpDescriptor& reference = findWarp("reference");
    const KnobValues usual = KnobValues{}.only(reference.knobs);
    truth = static_cast<size_t>(std::ranges::find_if(rows, [&](const Row& row) { return row.technique == &reference && row.warpSettings.knobs == usual; }) - rows.begin());
    if (*truth == rows.size()) add(reference, usual);
  }
  RecordedFrames frames(recording);
  FrameAges ages(recording);
  Image<Rgba8> page(columns * settings.width + (columns - 1) * kGapPx, replayHeight(settings));
  Labels labels(page, settings.height);
  const uint32_t errorLine = settings.hasLabels ? 1 : 0, pageLine = errorLine + (settings.hasErrors ? 1 : 0);
  const size_t count = pictureCount(recording, settings.picturesPerSecond);
  const TransferFunction* marchedBy = functionAt(recording, 0.0);
  // Those that march follow the function; those that draw frames have it with each.
  const auto follow = [&](const TransferFunction* function) {
    if (function == marchedBy || resources.marcher == nullptr) return;
    marchedBy = function;
    resources.marcher = resources.marcher->withTransferFunction(*function);
    for (Row& row : rows)
      if (!row.technique->usesFrame) make(row);
  };
  for (size_t i = 0; i < count; ++i) {
    if (stop.stop_requested()) throw OperationCancelled();
    const double seconds = static_cast<double>(i) / settings.picturesPerSecond;
    const Camera camera = makeCamera(recording.scene, recording.path.at(seconds), settings.width, settings.height);
    const SampleFramePtr frame = frames.at(seconds);
    follow(functionAt(recording, seconds));
    std::fill(page.begin(), page.end(), kPaper);
    for (Row& row : rows) {
      if (row.technique->usesFrame && frame && row.frame != frame) row.warp->setFrame(row.frame = frame, row.warpSettings, stop);
      if (!row.technique->usesFrame || frame) row.warp->draw(camera, row.warpSettings, row.image, stop);
    }
    std::optional<PictureJudge> judge;
    if (settings.hasErrors) judge.emplace(rows[*truth].image.color, recording.scene.background);
    for (size_t k = 0; k < columns; ++k) {
      const Row& row = rows[k];
      const WarpDescriptor& technique = *row.technique;
      const auto left = static_cast<uint32_t>(k) * (settings.width + kGapPx);
      const ReplayColumn& column = settings.columns[k];
      std::string content;
      if (!technique.usesFrame || frame) {
        paste(page, toScreen(row.image, recording.scene.background), left);
        if (column.content != PictureContent::picture) {
          try {
            const std::optional<SegmentLook> segments = describe(column.content).usesSamples ? segmentLookOf(technique, frame.get(), camera, stop) : std::nullopt;
            const ShownContent shown = show(column.content,
                                            {.image = row.image,
                                             .camera = camera,
                                             .background = recording.scene.background,
                                             .reference = truth ? &rows[*truth].image.color : nullptr,
                                             .frame = technique.usesFrame ? frame.get() : nullptr,
                                             .segments = segments ? &*segments : nullptr},
                                            column.range);
            paste(page, shown.picture, left);
            content = ", " + textOf(column, shown);
          } catch (const InputError& error) {
            content = std::string(", ") + error.what();  // of this picture, which stays; of another one there may be
          }
        }
        if (judge) labels.write(errorLine, left, settings.width, k == *truth ? kIsTruth : errorTexts(judge->errorsOf(row.image)));
      }
      if (!settings.hasLabels) continue;
      const std::string name(technique.label);
      const std::string age = frame ? "frame " + ageText(ages.at(seconds, frame)) + " old" : std::string("no frame yet");
      labels.write(0, left, settings.width, technique.usesFrame ? std::array{name + content + ", " + age, name + content, name} : std::array{name + content, name, name});
    }
    if (settings.hasLabels) {
      const std::string time = formatted("%.2f s", seconds);
      const LinkSign sign = linkAt(recording, seconds);
      labels.write(pageLine, 0, page.width(), sign.full.empty() ? std::array{time, time, time} : std::array{time + "   " + sign.full, time + "   " + sign.brief, time});
    }
    onPicture(i, page);
  }
}

}  // namespace warpscope
