// `replay`: a recording of the window, shown again by any techniques: numbered pictures, and a film of them.
// The same file gives the same pictures on every run.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>

#include "app/commands/options.h"
#include "app/experiment/replay.h"
#include "app/frames/wire_fields.h"
#include "app/picture/picture.h"
#include "app/scene/json_document.h"
#include "app/session/recorded_scene.h"
#include "app/shell/child_process.h"
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
  bool hasNoLabels = false;
};

constexpr Range kRateRange{0.1, 240.0};

std::string nameOf(size_t index) {
  char name[32];
  std::snprintf(name, sizeof name, "%06zu.png", index + 1);
  return name;
}

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

/// Why none of the frames has what the technique draws; empty where some have, or there are none.
std::string lackInAll(const Recording& recording, const TechniqueInUse& one) {
  std::string lack;
  for (const Recording::Frame& frame : recording.frames) {
    lack = lackOf(*one.technique, marchFrom(frame.head.settings), one.knobs);
    if (lack.empty()) break;
  }
  return lack;
}

/// Numbered pictures of an earlier run that had more.
void removeLaterPictures(const std::filesystem::path& folder, size_t count) {
  std::error_code failed;
  for (size_t index = count; std::filesystem::remove(folder / nameOf(index), failed);) ++index;
}

/// `pattern`: "folder/%06d.png".
void makeVideo(const std::string& pattern, const std::filesystem::path& film, double picturesPerSecond, const std::stop_token& stop) {
  const std::string rate = nlohmann::json(picturesPerSecond).dump();
  std::vector<std::string> command{"ffmpeg", "-nostdin", "-y", "-loglevel", "error", "-framerate", rate, "-i", pattern};
  if (film.extension() == ".gif") {
    for (const char* word : {"-vf", "split[a][b];[a]palettegen[p];[b][p]paletteuse"}) command.emplace_back(word);
  } else {
    for (const char* word : {"-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p", "-movflags", "+faststart"}) command.emplace_back(word);
  }
  command.push_back(film.string());
  runProgram(command, stop);
}

void run(const ReplayOptions& options) {
  requireRange(options.picturesPerSecond, kRateRange, "--fps");
  const bool hasVideo = !options.video.empty();
  if (hasVideo && options.video != "mp4" && options.video != "gif") throw UsageError("--video makes mp4 or gif, not " + options.video);
  const bool canFilm = hasVideo && hasProgram("ffmpeg");
  const CheckedOptions checked = check(options.common);
  const Interrupt interrupt;
  const Recording recording = readRecording(options.file, interrupt.token());
  ReplaySettings settings;
  settings.techniques = techniquesOf(options, recording, checked.warp.knobs);
  settings.picturesPerSecond = options.picturesPerSecond;
  settings.width = checked.width;
  settings.height = checked.height;
  settings.hasLabels = !options.hasNoLabels;
  for (const TechniqueInUse& one : settings.techniques)
    if (const std::string lack = lackInAll(recording, one); !lack.empty()) throw InputError(options.file + ": " + std::string(one.technique->name) + " can show nothing of its frames: " + lack);
  if (recording.frames.empty() && std::ranges::any_of(settings.techniques, [](const TechniqueInUse& one) { return one.technique->usesFrame; }))
    throw InputError(options.file + ": holds no frames, only where the camera was: there is nothing to be drawn of them");
  const bool marches = std::ranges::any_of(settings.techniques, [](const TechniqueInUse& one) { return !one.technique->usesFrame; });
  HeadlessResources headless(marches ? marcherOf(recording, checked.backend, interrupt.token()) : nullptr, checked.platform, checked.backend);
  settings.resources = headless.resources();
  const size_t count = pictureCount(recording, settings.picturesPerSecond);
  StagedFolder folder(options.out);
  auto progress = std::make_unique<Progress>("replay", count + (canFilm ? 1 : 0), !options.common.showsProgress());
  replay(
      recording, settings,
      [&](size_t index, const Image<Rgba8>& picture) {
        progress->step("picture " + std::to_string(index + 1) + " of " + std::to_string(count));
        folder.write(nameOf(index), encodePng(picture, interrupt.token()));
      },
      interrupt.token());
  folder.commit();
  removeLaterPictures(options.out, count);
  const std::filesystem::path film = std::filesystem::path(options.out) / ("replay." + options.video);
  if (canFilm) {
    progress->step(film.filename().string());
    makeVideo((std::filesystem::path(options.out) / "%06d.png").string(), film, settings.picturesPerSecond, interrupt.token());
  }
  progress.reset();
  if (options.common.json) {
    nlohmann::json techniques = nlohmann::json::array();
    for (const TechniqueInUse& one : settings.techniques) techniques.push_back(one.technique->name);
    std::cout << textOf({{"out", options.out},
                         {"pictures", count},
                         {"seconds", recording.seconds},
                         {"frames", recording.frames.size()},
                         {"techniques", techniques},
                         {"video", canFilm ? nlohmann::json(film.string()) : nlohmann::json(nullptr)}});
  } else {
    logResult("wrote " + std::to_string(count) + " pictures of " + std::to_string(recording.frames.size()) + " frames to " + options.out +
              (canFilm ? ", and " + film.string() : std::string()));
  }
  if (hasVideo && !canFilm) throw InputError("there is no film of them: --video needs the program ffmpeg, which is not installed. The numbered pictures are in " + options.out);
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
  command->add_flag("--no-labels", options->hasNoLabels, "Pictures without names and times below them");
  command->add_option("--video", options->video, "mp4 or gif: a film of the pictures as well, by the program ffmpeg");
  for (const Knob* knob : warpKnobs()) options->common.knobs.add(*command, *knob, textOf(*knob, knob->defaultValue), ownersOf(*knob));
  addBackendOption(*command, options->common);
  command->add_option("--gl", options->common.gl, "OpenGL without a window: auto egl osmesa")->capture_default_str();
  command->add_flag("--json", options->common.json, "One JSON document on standard output and nothing else");
  addLogOptions(*command, options->common);
  command->callback([options, &chosen] { chosen = [options] { run(*options); }; });
}

}  // namespace warpscope
