// `replay`: a recording of the window, shown again by any techniques: numbered pictures, and a film of them.
// The same file gives the same pictures on every run.
#include <CLI/CLI.hpp>
#include <iostream>
#include <nlohmann/json.hpp>

#include "app/commands/choose.h"
#include "app/commands/options.h"
#include "app/experiment/replay_files.h"
#include "app/scene/json_document.h"
#include "app/session/recorded_scene.h"
#include "app/shell/interrupt.h"
#include "app/shell/log.h"
#include "app/shell/output_files.h"
#include "app/shell/progress.h"
#include "render/base/error.h"
#include "render/base/nearest_name.h"
#include "render/base/range.h"
#include "render/core/picture_size.h"

namespace warpscope {
namespace {

struct ReplayOptions {
  CommonOptions common;
  std::string file, out, video;
  std::vector<std::string> techniques, contents;
  std::optional<float> range;
  double picturesPerSecond = 30.0;
  bool hasNoLabels = false, hasErrors = false;
};

constexpr Range kRateRange{0.1, 240.0};

/// What of the techniques' pictures is asked for, if anything is.
void showAsked(const ReplayOptions& options, std::vector<ReplayColumn>& columns) {
  const size_t count = options.contents.size();
  if (count > 1 && count != columns.size())
    throw UsageError("--show: one for all, or one for each of the " + std::to_string(columns.size()) + " techniques, not " + std::to_string(count));
  for (size_t i = 0; i < columns.size() && count > 0; ++i) {
    columns[i].content = choose("content", options.contents[count > 1 ? i : 0], pictureContents());
    columns[i].range.reset();  // that of what was on show
  }
  if (!options.range) return;
  requireRange(*options.range, kContentRange, "--range");
  if (std::ranges::none_of(columns, [](const ReplayColumn& column) { return !describe(column.content).unit.empty(); }))
    throw UsageError("--range is for contents with a ramp of colours: choose one with --show");
  for (ReplayColumn& column : columns) column.range = options.range;
}

/// Those that were asked for, else those that were on show.
std::vector<ReplayColumn> columnsOf(const ReplayOptions& options, const Recording& recording, const KnobValues& knobs) {
  std::vector<ReplayColumn> columns;
  for (const std::string& name : options.techniques) columns.push_back({{&findWarp(name), knobs}});
  if (columns.empty() && !recording.text.empty())
    for (const PanelSettings& panel : readSessionText(recording.text, options.file).panels)
      columns.push_back({{panel.technique, panel.knobs}, panel.content, panel.contentRange});
  if (columns.empty()) columns.push_back({{&findWarp("segments"), knobs}});
  showWhatThereIs(columns, true);
  if (columns.size() > kMaxPanels) throw UsageError("--techniques: give 1 to " + std::to_string(kMaxPanels));
  showAsked(options, columns);
  return columns;
}

void run(const ReplayOptions& options) {
  requireRange(options.picturesPerSecond, kRateRange, "--fps");
  const bool hasVideo = !options.video.empty();
  if (hasVideo && options.video != "mp4" && options.video != "gif") throw UsageError("--video makes mp4 or gif, not " + options.video);
  const bool isFilmed = hasVideo && canFilm();
  const CheckedOptions checked = check(options.common);
  const Interrupt interrupt;
  const Recording recording = readRecording(options.file, interrupt.token());
  ReplaySettings settings;
  settings.columns = columnsOf(options, recording, checked.warp.knobs);
  settings.picturesPerSecond = options.picturesPerSecond;
  settings.width = checked.width;
  settings.height = checked.height;
  settings.hasLabels = !options.hasNoLabels;
  settings.hasErrors = options.hasErrors;
  requireDrawable(recording, settings);  // before its volume is opened
  MarcherPtr marcher;
  if (needsMarcher(settings.columns, settings.hasErrors)) {
    try {
      marcher = marcherOf(recording, checked.backend, interrupt.token());
    } catch (const OperationCancelled&) {
      throw;
    } catch (const std::runtime_error& error) {  // InputError, UsageError of a scene that there is none of here
      if (options.contents.empty()) showWhatThereIs(settings.columns, false);
      if (needsMarcher(settings.columns, settings.hasErrors)) throw;
      logWarning(std::string("pictures in place of what was on show: ") + error.what());
    }
  }
  HeadlessResources headless(std::move(marcher), checked.platform, checked.backend);
  settings.resources = headless.resources();
  const ReplayFiles files{.folder = options.out, .film = isFilmed ? "replay." + options.video : std::string()};
  const std::filesystem::path film = files.folder / files.film;
  for (size_t i = 0; i < pictureCount(recording, settings.picturesPerSecond); ++i) requireNoneOf(files.folder / pictureNameOf(files.prefix, i), {options.file});
  auto progress = std::make_unique<Progress>("replay", stepsOf(recording, settings.picturesPerSecond, files), !options.common.showsProgress());
  const size_t count = writeReplay(recording, settings, files, [&](const std::string& what) { progress->step(what); }, interrupt.token());
  progress.reset();
  if (options.common.json) {
    nlohmann::json techniques = nlohmann::json::array();
    nlohmann::json contents = nlohmann::json::array();
    for (const ReplayColumn& one : settings.columns) {
      techniques.push_back(one.technique->name);
      contents.push_back(describe(one.content).name);
    }
    std::cout << textOf({{"out", options.out},
                         {"pictures", count},
                         {"seconds", recording.seconds},
                         {"frames", recording.frames.size()},
                         {"techniques", techniques},
                         {"contents", contents},
                         {"video", isFilmed ? nlohmann::json(film.string()) : nlohmann::json(nullptr)}});
  } else {
    logResult("wrote " + std::to_string(count) + " pictures of " + std::to_string(recording.frames.size()) + " frames to " + options.out +
              (isFilmed ? ", and " + film.string() : std::string()));
  }
  if (hasVideo && !isFilmed) throw InputError("there is no film of them: --video needs the program ffmpeg, which is not installed. The numbered pictures are in " + options.out);
}

}  // namespace

void addReplayCommand(CLI::App& program, std::function<void()>& chosen) {
  auto options = std::make_shared<ReplayOptions>();
  options->common.size = "512x512";
  CLI::App* command = program.add_subcommand("replay", "A recording of the window again, by any techniques: numbered pictures, a film");
  command->add_option("recording", options->file, "File of view --record, or of File, Record in the window")->required();
  command->add_option("--out", options->out, "Folder for 000001.png and so on")->required();
  command->add_option("--techniques", options->techniques, "Side by side, parted by commas: " + listOf(warpRegistry()) + "; default: those that were on show")->delimiter(',');
  command->add_option("--show", options->contents, "What of the pictures is shown, one for all or one for each technique: " + listOf(pictureContents()) + "; default: what was on show, and of --techniques the picture")->delimiter(',');
  command->add_option("--range", options->range, "What the upper end of such a content's ramp of colours stands for, " + rangeText(kContentRange) + "; default: as it was on show, or as `shot` has it");
  command->add_option("--fps", options->picturesPerSecond, "Pictures a second, " + rangeText(kRateRange))->capture_default_str();
  command->add_option("--size", options->common.size, "WxH of each technique's picture, " + pictureSizes())->capture_default_str();
  command->add_flag("--no-labels", options->hasNoLabels, "Pictures without names, ages, times and the link below them");
  command->add_flag("--errors", options->hasErrors, "PSNR, FLIP and holes below each picture as well, against the ground truth, which is marched for it");
  command->add_option("--video", options->video, "mp4 or gif: a film of the pictures as well, by the program ffmpeg");
  for (const Knob* knob : warpKnobs()) options->common.knobs.add(*command, *knob, textOf(*knob, knob->defaultValue), ownersOf(*knob));
  addBackendOption(*command, options->common);
  command->add_option("--gl", options->common.gl, "OpenGL without a window: auto egl osmesa")->capture_default_str();
  command->add_flag("--json", options->common.json, "One JSON document on standard output and nothing else");
  addLogOptions(*command, options->common);
  command->callback([options, &chosen] { chosen = [options] { run(*options); }; });
}

}  // namespace warpscope
