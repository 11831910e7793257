// `view`: the window.
// Panels over the same frames; see app/session/session.h and app/ui/.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "app/commands/choose.h"
#include "app/commands/options.h"
#include "app/scene/transfer_file.h"
#include "app/session/recorded_scene.h"
#include "app/shell/interrupt.h"
#include "app/shell/output_files.h"
#include "app/shell/user_folders.h"
#include "app/ui/run_window.h"
#include "render/base/printable.h"
#include "render/base/range.h"
#include "render/volume/volume_format.h"

namespace warpscope {
namespace {

struct ViewOptions {
  ViewOptions() { common.size.clear(); }  // the window's, which goes by the screen unless it is given

  CommonOptions common;
  std::vector<std::string> panels;  ///< empty: kUsualPanels, or those of a session or a recording
  std::string left, right;
  TransportOptions transport;
  double uiScale = 0.0;
  std::string theme;
  std::string screenshot;
  double screenshotAfterMs = 3000.0;
  std::string report;
  std::string front;
  std::string session;
  std::string record;
  bool startsDemo = false;
  std::optional<double> budgetMs;
  KnobOptions ownKnobs;  ///< that the window alone has
};

constexpr std::array<const char*, 2> kUsualPanels{"points", "segments"};
constexpr Range kUiScaleRange{0.5, 4.0};
constexpr Range kWaitMsRange{0.0, 3600.0 * 1000.0};

bool isServerUrl(const std::string& text) { return text.starts_with("warp://") || text.starts_with("warps://"); }

/// The same, by paths that do not depend on the folder that the program was started in.
SceneOrigin fromAnywhere(SceneOrigin origin) {
  const auto absolute = [](const std::filesystem::path& path) {
    std::error_code ignored;
    return std::filesystem::exists(path, ignored) ? std::filesystem::absolute(path, ignored) : path;
  };
  if (!isBuiltinScene(origin.spec)) origin.spec = absolute(origin.spec).string();
  if (origin.overrides.volume) origin.overrides.volume = absolute(*origin.overrides.volume);
  if (origin.overrides.mask) origin.overrides.mask = absolute(*origin.overrides.mask);
  if (origin.overrides.transferFunction) origin.overrides.transferFunction = absolute(*origin.overrides.transferFunction);
  return origin;
}

/// What the options say of the panels. `knobs`: of techniques, for those that take options.
std::vector<PanelSettings> panelsOf(const ViewOptions& options, const KnobValues& knobs) {
  std::vector<std::string> names = options.panels;
  if (names.empty()) names.assign(kUsualPanels.begin(), kUsualPanels.end());
  if (names.size() > kMaxPanels) throw UsageError("--panels: give 1 to " + std::to_string(kMaxPanels) + " techniques");
  if (!options.left.empty()) names.front() = options.left;
  if (!options.right.empty()) names.back() = options.right;
  std::vector<PanelSettings> panels;
  for (const std::string& name : names) {
    PanelSettings& panel = panels.emplace_back();
    panel.isAutomatic = name == "auto";
    panel.technique = &findWarp(panel.isAutomatic ? "splats" : name);
    if (takesOptions(panels.size() - 1, names.size())) panel.knobs = knobs;
  }
  return panels;
}

/// What --session names, or what a recording says that is to be seen; nothing without them. `knobs`: as panelsOf()'s. Throws InputError, UsageError where there is
/// no last one.
std::optional<SessionFile> restoredBy(const ViewOptions& options, const KnobValues& knobs) {
  if (!options.session.empty()) {
    if (namesScene(options.common) || !options.transport.connect.empty()) throw UsageError("--session has a scene of its own: name no other");
    if (isSessionText(options.session)) return readSessionText(options.session, "--session");
    if (options.session != "last") return readSessionFile(options.session);
    const std::optional<std::filesystem::path> last = lastSession();
    if (!last) throw UsageError("--session last: no window was closed yet that showed something");
    return readSessionFile(*last);
  }
  if (!options.common.scene || !isRecording(*options.common.scene)) return std::nullopt;
  std::optional<SessionFile> recorded = sessionFileOfRecording(*options.common.scene);
  if (recorded && (!options.panels.empty() || !options.left.empty() || !options.right.empty())) {
    recorded->panels = panelsOf(options, knobs);
    recorded->arrangement.ownViews.assign(recorded->panels.size(), std::nullopt);
  }
  return recorded;
}

void view(const ViewOptions& options) {
  const CheckedOptions checked = check(options.common);
  const std::optional<SessionFile> restored = restoredBy(options, checked.warp.knobs);
  SessionSettings settings;
  settings.panels = panelsOf(options, checked.warp.knobs);
  if (options.budgetMs) requireRange(*options.budgetMs, kBudgetMsRange, "--budget-ms");
  settings.knobs.budgetMs = options.budgetMs.value_or(kDefaultBudgetMs);
  const TransportSettings transport = transportOf(options.transport);
  const std::optional<net::Address> server = serverOf(options.transport);
  if (options.uiScale != 0.0) requireRange(options.uiScale, kUiScaleRange, "--ui-scale");
  requireRange(options.screenshotAfterMs, kWaitMsRange, "--after-ms");
  if (server)
    requireNoSceneOf(options.common);
  else
    requireScene(checked.sceneSpec);
  if (!options.screenshot.empty() && lowered(std::filesystem::path(options.screenshot).extension().string()) != ".png")
    throw UsageError("--screenshot writes PNG files: " + options.screenshot + " is not named so");
  std::vector<std::filesystem::path> read{options.common.volume, options.common.mask, options.common.transferFunction, options.front};
  if (!isSessionText(options.session)) read.emplace_back(options.session);
  if (!server) read.emplace_back(checked.sceneSpec);
  const std::pair<const char*, const std::string&> files[] = {{"--screenshot", options.screenshot}, {"--report", options.report}, {"--record", options.record}};
  for (const auto& [option, file] : files)
    for (const auto& [otherOption, other] : files)
      if (&file != &other && isSameFile(file, other)) throw UsageError(std::string(option) + " and " + otherOption + " are the same file: " + printable(file));
  for (const std::string* const written : {&options.screenshot, &options.report, &options.record}) {
    if (written->empty()) continue;
    requireNoneOf(*written, read);
    requireWritable(*written);
  }
  settings.knobs.warp = checked.warp;
  settings.knobs.transport = transport;
  settings.knobs.marks = checked.marks;
  const std::optional<double> shortcuts = options.ownKnobs.check().find(kShortcutsKnob);
  settings.knobs.takesShortcuts = shortcuts.value_or(kShortcutsKnob.defaultValue) != 0.0;
  settings.platform = checked.platform;
  settings.resources.backend = checked.backend;
  settings.resources.onFallback = reportFallback;
  WindowSettings window;
  if (checked.width > 0) window.size = {checked.width, checked.height};
  window.uiScale = options.uiScale;
  if (!options.theme.empty()) {
    if (options.theme != "dark" && options.theme != "light") throw UsageError("--theme is dark or light, not " + options.theme);
    window.isLight = options.theme == "light";
  }
  window.screenshot = options.screenshot;
  window.screenshotAfterMs = options.screenshotAfterMs;
  window.report = options.report;
  window.recording = options.record;
  window.startsDemo = options.startsDemo;
  window.transferFile = options.common.transferFunction;
  if (!window.transferFile.empty()) readTransferFile(window.transferFile);  // what is wrong with it is said here, not in a window without a scene
  if (!options.front.empty()) {
    window.sweep = readSweepFile(options.front);
    if (!window.sweep) throw InputError(options.front + ": holds no sweep: it lacks the key 'rows'");
  }

  const Interrupt interrupt;
  SteadyClock clock;
  const auto io = std::make_shared<net::IoThread>();
  const auto host = [io, transport, backend = checked.backend](Scene scene, const std::function<void()>& onNews, const std::stop_token& stop) {
    const MarcherPtr marcher = makeMarcher(backend, scene.volume, scene.transferFunction);
    return hostScene(io, std::move(scene), marcher, transport, onNews, stop, DecodedPlace::device);
  };
  // Of servers that were connected to: what is said of them elsewhere, and may be kept in files, has no token.
  const auto known = std::make_shared<std::map<std::string, net::Address>>();
  const auto connectTo = [io, transport, checked, known](const net::Address& address) {
    known->insert_or_assign(net::toStringWithoutToken(address), address);
    return LoadJob{net::toStringWithoutToken(address),
                   [=](const std::function<void()>& onNews, const std::stop_token& stop) {
                     ConnectedScene loaded = connectScene(io, address, transport, onNews, stop, checked.backend, DecodedPlace::device);
                     checked.applyTo(loaded.scene);
                     return loaded;
                   },
                   SceneOrigin{net::toStringWithoutToken(address), {}}};
  };
  const SceneOpener openChosen = [=, seed = checked.overrides.seed](const SceneOrigin& chosen) {
    if (isServerUrl(chosen.spec)) {
      try {
        const auto same = known->find(chosen.spec);
        return connectTo(same != known->end() ? same->second : net::parseAddress(chosen.spec));
      } catch (const net::AddressError& error) {
        return LoadJob{"a server", [text = std::string(error.what())](const std::function<void()>&, const std::stop_token&) -> ConnectedScene {
                         throw InputError(text);
                       }};
      }
    }
    SceneOrigin origin = fromAnywhere(chosen);
    if (origin.overrides.seed == SceneOverrides{}.seed) origin.overrides.seed = seed;
    return LoadJob{chosen.spec,
                   [=, backend = checked.backend](const std::function<void()>& onNews, const std::stop_token& stop) {
                     if (isRecording(origin.spec)) return openRecording(origin.spec, backend, onNews, stop);
                     return host(openScene(origin.spec, origin.overrides, stop), onNews, stop);
                   },
                   origin};
  };
  const SessionMaker makeSession = [&](std::function<void()> onNews) {
    auto session = std::make_unique<Session>(settings, std::move(onNews));
    if (restored)
      restore(*restored, *session, openChosen);
    else if (isRecording(checked.sceneSpec))
      session->load(openChosen({checked.sceneSpec, {}}));
    else if (server)
      session->load(connectTo(*server));
    else
      session->load({checked.sceneSpec,
                     [=](const std::function<void()>& loadNews, const std::stop_token& stop) { return host(checked.open(stop), loadNews, stop); },
                     fromAnywhere({checked.sceneSpec, checked.overrides})});
    return session;
  };
  runWindow(makeSession, openChosen, clock, window, interrupt.token());
}

}  // namespace

void viewDefaultScene() {
  ViewOptions options;
  // Who has never closed a window sees first what this is about.
  options.startsDemo = lastSessionFile() && !lastSession();
  completeConnect(options.transport, false);
  view(options);
}

/// What a session, or a recording, says itself: of all options those may be given that are about the window. Throws UsageError for others.
void requireOnlyOfWindow(const CLI::App& command, const std::string& what, const std::vector<std::string>& besides) {
  static const std::set<std::string> kOfWindow{"--session", "--backend",  "--gl",     "--size",   "--quiet", "--verbose", "--ui-scale", "--theme",
                                               "--screenshot", "--after-ms", "--report", "--record", "--front"};
  for (const CLI::Option* const option : command.get_options()) {
    const std::string name = option->get_name();
    if (option->count() > 0 && !kOfWindow.contains(name) && std::ranges::find(besides, name) == besides.end())
      throw UsageError(what + " says that itself: leave out " + name);
  }
}

void addViewCommand(CLI::App& program, std::function<void()>& chosen) {
  auto options = std::make_shared<ViewOptions>();
  CLI::App* command = program.add_subcommand("view", "The window: techniques side by side, live");
  addCommonOptions(*command, options->common);
  command->remove_option(command->get_option("--json"));  // a window prints nothing
  command->get_option("--size")->description("WxH of the window, in screen coordinates; default: 1280x800 times the screen's scale, or less on a small screen")->default_str("");
  const std::string names = listOf(warpRegistry()) + ", or auto: what was measured to be best";
  CLI::Option* const panels = command->add_option("--panels", options->panels, "1 to " + std::to_string(kMaxPanels) + " panels, parted by commas; each " + names)
      ->delimiter(',')->default_str("points,segments");
  command->add_option("--left", options->left, "The first of two panels: " + names)->default_str("points")->excludes(panels);
  command->add_option("--right", options->right, "The second of two panels: " + names)->default_str("segments")->excludes(panels);
  command->add_option("--budget-ms", options->budgetMs, "Milliseconds that a picture may take, for auto, " + rangeText(kBudgetMsRange) + "; default 33");
  addTransportOptions(*command, options->transport);
  options->ownKnobs.add(*command, kShortcutsKnob, textOf(kShortcutsKnob, kShortcutsKnob.defaultValue));
  command->add_option("--ui-scale", options->uiScale, "Size of everything, 0.5 to 4; default: as the screen says");
  command->add_option("--theme", options->theme, "dark or light; default: as it was last");
  command->add_option("--screenshot", options->screenshot, "PNG file to write the window's picture to; then the window closes");
  command->add_option("--after-ms", options->screenshotAfterMs, "When the screenshot is taken, in milliseconds after the start")
      ->capture_default_str();
  command->add_option("--report", options->report, "JSON file to write figures to when the window closes: display rate, ages, latencies");
  command->add_option("--front", options->front, "sweep.json whose configurations the plot shows as hollow points, and that auto chooses by");
  command->add_option("--record", options->record, "File to record frames and the camera into, for replay");
  command->add_option("--session", options->session, "Session file to go on with (which may stand in a scene's place as well), its text, or last: the one that was on show when a window was closed last");
  command->callback([options, command, &chosen] {
    chosen = [options, command] {
      try {
        if (options->session.empty() && options->common.scene && isSessionFile(*options->common.scene)) {
          requireOnlyOfWindow(*command, "a session", {"scene"});
          options->session = *std::exchange(options->common.scene, std::nullopt);
        } else if (!options->session.empty() && !namesScene(options->common)) {
          requireOnlyOfWindow(*command, "a session", {});
        }
        if (options->session.empty() && options->common.scene && isRecording(*options->common.scene))
          requireOnlyOfWindow(*command, "a recording", {"scene", "--panels", "--left", "--right"});
        completeConnect(options->transport, namesScene(options->common) || !options->session.empty());
        view(*options);
      } catch (const NoDisplay& error) {
        throw InputError(error.what() + std::string("; compare and shot work without a display"));
      }
    };
  });
}

}  // namespace warpscope
