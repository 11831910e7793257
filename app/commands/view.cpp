// `view`: the window.
// Two panels over the same frames and the same camera; see app/session.h and app/ui/.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdlib>
#include <iostream>

#include "app/commands/options.h"
#include "app/interrupt.h"
#include "app/output_files.h"
#include "app/ui/run_window.h"
#include "render/core/range.h"

namespace warpscope {
namespace {

struct ViewOptions {
  CommonOptions common;
  std::string left = "points", right = "spheres";
  double delayMs = 0.0;
  double uiScale = 0.0;
  std::string screenshot;
  double screenshotAfterMs = 3000.0;
};

constexpr Range kDelayMsRange{0.0, 10000.0};
constexpr Range kUiScaleRange{0.5, 4.0};
constexpr Range kWaitMsRange{0.0, 3600.0 * 1000.0};

void view(const ViewOptions& options) {
  const CheckedOptions checked = check(options.common);
  SessionSettings settings;
  settings.techniques = {&findWarp(options.left), &findWarp(options.right)};
  requireRange(options.delayMs, kDelayMsRange, "--delay-ms");
  if (options.uiScale != 0.0) requireRange(options.uiScale, kUiScaleRange, "--ui-scale");
  requireRange(options.screenshotAfterMs, kWaitMsRange, "--after-ms");
  requireScene(checked.sceneSpec);
  if (!options.screenshot.empty()) requireWritable(options.screenshot);
  settings.knobs.warp = checked.warp;
  settings.knobs.delayMs = options.delayMs;
  settings.knobs.uncovered = checked.uncovered;
  settings.platform = checked.platform;
  settings.resources.backend = checked.backend;
  settings.resources.onFallback = reportFallback;
  settings.makeMarcher = [backend = checked.backend](const Scene& scene) {
    return makeMarcher(backend, scene.volume, scene.transferFunction);
  };
  WindowSettings window;
  window.uiScale = options.uiScale;
  window.screenshot = options.screenshot;
  window.screenshotAfterMs = options.screenshotAfterMs;

  const Interrupt interrupt;
  SteadyClock clock;
  const SessionMaker makeSession = [&](std::function<void()> onNews) {
    auto session = std::make_unique<Session>(settings, clock, std::move(onNews));
    session->load({checked.sceneSpec, [checked](const std::stop_token& loadStop) { return checked.open(loadStop); }});
    return session;
  };
  const SceneOpener openChosen = [seed = checked.overrides.seed](const std::string& spec) {
    return LoadJob{spec, [spec, seed](const std::stop_token& loadStop) {
                     SceneOverrides overrides;
                     overrides.seed = seed;
                     return openScene(spec, overrides, loadStop);
                   }};
  };
  const bool hasEnded = runWindow(makeSession, openChosen, clock, window, interrupt.token());
  // A reader that cannot be interrupted must not keep a closed window's process: there is nothing left to be tidied up.
  if (!hasEnded) std::_Exit(EXIT_SUCCESS);
}

}  // namespace

void viewDefaultScene() { view({}); }

void addViewCommand(CLI::App& program, std::function<void()>& chosen) {
  auto options = std::make_shared<ViewOptions>();
  CLI::App* command = program.add_subcommand("view", "The window: two techniques side by side, live");
  addCommonOptions(*command, options->common);
  std::string names;
  for (const WarpDescriptor& warp : warpRegistry()) names += (names.empty() ? "" : " ") + std::string(warp.name);
  command->add_option("--left", options->left, names)->capture_default_str();
  command->add_option("--right", options->right, names)->capture_default_str();
  command->add_option("--delay-ms", options->delayMs, "Round trip to the server, in milliseconds")->capture_default_str();
  command->add_option("--ui-scale", options->uiScale, "Size of everything, 0.5 to 4; default: as the screen says");
  command->add_option("--screenshot", options->screenshot, "PNG file to write the window's picture to; then the window closes");
  command->add_option("--after-ms", options->screenshotAfterMs, "When the screenshot is taken, in milliseconds after the start")
      ->capture_default_str();
  command->callback([options, &chosen] {
    chosen = [options] {
      try {
        view(*options);
      } catch (const NoDisplay& error) {
        throw InputError(error.what() + std::string("; compare and shot work without a display"));
      }
    };
  });
}

}  // namespace warpscope
