// Options that several commands share, and what is made of them.
// Names and meanings are the command line's contract; `--help` lists them.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "app/commands/knob_options.h"
#include "app/commands/transport_options.h"
#include "app/frames/backend.h"
#include "app/frames/frame_fetch.h"
#include "app/scene/scene.h"
#include "render/gl/context.h"
#include "render/march/march_knobs.h"
#include "render/warp/warp.h"

namespace warpscope {

/// As typed; checked by the functions below.
struct CommonOptions {
  std::optional<std::string> scene;  ///< default: kDefaultScene
  std::string volume, mask, transferFunction, volumeSize;
  std::optional<double> memoryMiB, deviceMemoryMiB;
  KnobOptions knobs;  ///< of marching and of techniques
  std::map<const MarchText*, std::optional<std::string>> texts;  ///< likewise, those that are lists
  std::string backend = "auto", gl = "auto";
  std::string size = "1024x1024";  ///< empty: none is asked for
  std::string uncovered, filled;
  std::optional<double> fovYDeg;
  std::optional<uint32_t> seed;
  bool json = false, quiet = false, verbose = false;

  /// A bar would be in the way of what the others print.
  bool showsProgress() const { return !json && !quiet && !verbose; }
};

/// Adds the scene, what its frames are to be, and where they are made: all that shapes what a server sends.
void addSceneOptions(CLI::App& command, CommonOptions& options);

/// Adds --size alone.
void addSizeOption(CLI::App& command, CommonOptions& options);

/// Adds the scene's options, those of techniques and of the pictures that they draw.
void addCommonOptions(CLI::App& command, CommonOptions& options);

/// Adds --backend alone.
void addBackendOption(CLI::App& command, CommonOptions& options);

/// Adds --quiet and --verbose, and sets the log up by them once the command line is read.
void addLogOptions(CLI::App& command, CommonOptions& options);

/// Lets every option that takes a value refuse, with a UsageError, an empty one and the name of the next option. Comes after all options of
/// the command. A file of such a name is written with its folder: ./--quiet.
void requireValues(CLI::App& command);

/// Throws UsageError where what is to be written is a file that is read: by what was typed, or by the scene. Empty names are none.
void requireUnread(const std::string& written, const CommonOptions& options, const Scene& scene);

/// What was asked for, before the scene is opened.
struct CheckedOptions {
  std::string sceneSpec;
  SceneOverrides overrides;
  GivenKnobs given;
  std::map<const MarchText*, std::string> givenTexts;  ///< read once, so that what is wrong was said
  WarpSettings warp;
  uint32_t width = 0;   ///< of the pictures, 0 where no size is asked for
  uint32_t height = 0;
  PixelMarks marks;
  gl::Platform platform = gl::Platform::automatic;
  Backend backend = Backend::automatic;

  /// The scene with the marching that was asked for. Throws UsageError or InputError, OperationCancelled if `stop` is set.
  Scene open(const std::stop_token& stop = {}) const;
  /// A server's scene with the camera and the marching that were asked for.
  void applyTo(Scene& served) const;
};

/// Checks every option, which is quick. Throws UsageError, or InputError for hardware that is not here.
CheckedOptions check(const CommonOptions& options);

/// What a command works with: what was asked for, and the scene. `warp.reference` is what the scene's picture is.
struct CommandContext : CheckedOptions {
  Scene scene;
  MarchSettings march;  ///< the scene's, as asked for
  MarcherPtr remote;    ///< of a server's scene; null for a scene that was opened here
  FrameSourcePtr source;  ///< of a server's frames; null likewise
  TransportSettings transport;
  std::function<void(uint16_t)> sayBusy{};  ///< that the server works for others; whoever asks says so once

  /// What marches the scene, there or on the chosen backend. Throws as makeMarcher() of app/frames/backend.h does.
  MarcherPtr marcher() const;
  /// Where frames come from: the server, or marcher() and the codec.
  FrameFetch fetch() const;
};

/// Checks every option before anything expensive, then opens the scene, with a bar on the terminal. Throws UsageError or InputError,
/// OperationCancelled if `stop` is set.
CommandContext prepare(const CommonOptions& options, const std::stop_token& stop);
/// As above, but the scene may be a server's. Throws InputError with the reason if that cannot be had.
CommandContext prepare(const CommonOptions& options, const TransportOptions& transport, const std::stop_token& stop);

/// Whether an option asks for something about a scene that is opened here.
bool namesScene(const CommonOptions& options);
/// Throws UsageError if an option asks for something about a scene that is a server's.
void requireNoSceneOf(const CommonOptions& options);

/// Techniques' resources for one thread: a marcher for the scene and an OpenGL context made when it is first needed.
class HeadlessResources {
 public:
  HeadlessResources(MarcherPtr marcher, gl::Platform platform, Backend backend)
      : marcher_(std::move(marcher)), platform_(platform), backend_(backend) {}
  WarpResources resources();
  /// The context's platform and renderer; empty if none was needed.
  std::string contextText();

 private:
  MarcherPtr marcher_;
  gl::Platform platform_;
  Backend backend_;
  std::unique_ptr<gl::Context> context_;
};

/// Says in the log how many samples a frame has and how long it took.
void logFrame(const SampleFrame& frame);

/// What `command` is and does; each adds itself to the program and runs when its turn comes.
void addServeCommand(CLI::App& program, std::function<void()>& chosen);
void addShotCommand(CLI::App& program, std::function<void()>& chosen);
void addCheckCommand(CLI::App& program, std::function<void()>& chosen);
void addCompareCommand(CLI::App& program, std::function<void()>& chosen);
void addBenchCommand(CLI::App& program, std::function<void()>& chosen);
void addPlanCommand(CLI::App& program, std::function<void()>& chosen);
void addStabilityCommand(CLI::App& program, std::function<void()>& chosen);
void addSweepCommand(CLI::App& program, std::function<void()>& chosen);
void addExportCommand(CLI::App& program, std::function<void()>& chosen);
void addInfoCommand(CLI::App& program, std::function<void()>& chosen);
void addReplayCommand(CLI::App& program, std::function<void()>& chosen);
void addViewCommand(CLI::App& program, std::function<void()>& chosen);

/// `view` of the default scene. Throws NoDisplay if there is no screen.
void viewDefaultScene();

/// `compare` of the default scene into `out`.
void compareDefaultScene(const std::filesystem::path& out);

}  // namespace warpscope
