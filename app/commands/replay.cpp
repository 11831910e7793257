// `replay`: a recording of the window, shown again by any techniques: numbered pictures, and a film of them.
// The same file gives the same pictures on every run.
#include <CLI/CLI.hpp>
#include <iostream>
#include <nlohmann/json.hpp>

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
  std::vector<std::string> techniques;
  double picturesPerSecond = 30.0;
  bool hasNoLabels = false, hasErrors = false;
};

constexpr Range kRateRange{0.1, 240.0};

/// Those that were asked for, else those that were on show.
std::vector<TechniqueInUse> techniquesOf(const ReplayOptions& options, const Recording& recording, const KnobValues& knobs) {
  std::vector<TechniqueInUse> techniques;
  for (const std::string& name : options.techniques) techniques.push_back({&findWarp(name), knobs});
  if (techniques.empty() && !recording.text.empty())
    for (const PanelSettings& panel : readSessionText(recording.text, options.file).panels) techniques.push_back({panel.technique, panel.knobs});
  if (techniques.empty()) techniques.push_back({&findWarp("segments"), knobs});
  if (techniques.size() > kMaxPanels) throw UsageError("--techniques: give 1 to " + std::to_string(kMaxPanels));
  return techniques;
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
  settings.techniques = techniquesOf(options, recording, checked.warp.knobs);
  settings.picturesPerSecond = options.picturesPerSecond;
  settings.width = checked.width;
  settings.height = checked.height;
  settings.hasLabels = !options.hasNoLabels;
  settings.hasErrors = options.hasErrors;
  requireDrawable(recording, settings);  // before its volume is opened
  const bool marches = settings.hasErrors || std::ranges::any_of(settings.techniques, [](const TechniqueInUse& one) { return !one.technique->usesFrame; });
  HeadlessResources headless(marches ? marcherOf(recording, checked.backend, interrupt.token()) : nullptr, checked.platform, checked.backend);
  settings.resources = headless.resources();
  const ReplayFiles files{.folder = options.out, .film = isFilmed ? "replay." + options.video : std::string()};
  const std::filesystem::path film = files.folder / files.film;
  for (size_t i = 0; i < pictureCount(recording, settings.picturesPerSecond); ++i) requireNoneOf(files.folder / pictureNameOf(files.prefix, i), {options.file});
  auto progress = std::make_unique<Progress>("replay", stepsOf(recording, settings.picturesPerSecond, files), !options.common.showsProgress());
  const size_t count = writeReplay(recording, settings, files, [&](const std::string& what) { progress->step(what); }, interrupt.token());
  progress.reset();
  if (options.common.json) {
    nlohmann::json techniques = nlohmann::json::array();
    for (const TechniqueInUse& one : settings.techniques) techniques.push_back(one.technique->name);
    std::cout << textOf({{"out", options.out},
                         {"pictures", count},
                         {"seconds", recording.seconds},
                         {"frames", recording.frames.size()},
                         {"techniques", techniques},
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
