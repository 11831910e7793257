// Checking what was typed.
// See options.h.
#include "app/commands/options.h"

#include <charconv>
#include <cstdio>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "app/commands/choose.h"
#include "app/frames/frame_budget.h"
#include "app/frames/process_ranks.h"
#include "app/frames/recording.h"
#include "app/frames/scene_connection.h"
#include "app/scene/voxel_shape.h"
#include "app/shell/log.h"
#include "app/shell/progress.h"
#include "app/shell/output_files.h"
#include "render/base/error.h"
#include "render/base/memory_limit.h"
#include "render/base/range.h"
#include "render/core/picture_size.h"
#include "render/march/marcher_registry.h"
#include "render/volume/procedural.h"
#include "render/warp/fill.h"
#include "render/warp/spheres_warp.h"

namespace warpscope {
namespace {

constexpr Range kMemoryMiBRange{128.0, 1e7};  // the program itself takes some 75, and a small picture 25
constexpr Range kDeviceMemoryMiBRange{64.0, 1e7};

template <class Value>
struct Choice {
  std::string_view name;
  Value value;
};

/// Parses numbers separated by 'x': exactly `count` of them, each within 1..largest.
std::vector<uint32_t> parseSize(const std::string& option, const std::string& text, size_t count, uint32_t largest) {
  std::vector<uint32_t> numbers;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (numbers.size() < count) {
    uint32_t number = 0;
    const auto [next, error] = std::from_chars(at, end, number);
    if (error != std::errc() || number < 1 || number > largest) break;
    numbers.push_back(number);
    at = next;
    if (numbers.size() == count) break;
    if (at == end || *at != 'x') break;
    ++at;
  }
  if (numbers.size() != count || at != end)
    throw UsageError(option + " " + text.substr(0, 40) + ": give " + (count == 2 ? "WxH" : "XxYxZ") +
                     ", each 1 to " + std::to_string(largest));
  return numbers;
}

Rgba8 parseColor(const std::string& option, const std::string& text) {
  if (text.empty() || text == "transparent") return 0;
  uint32_t rgb = 0;
  const char* const digits = text.data() + (text[0] == '#' ? 1 : 0);
  const char* const end = text.data() + text.size();
  const auto [next, error] = std::from_chars(digits, end, rgb, 16);
  if (error != std::errc() || next != end || end - digits != 6)
    throw UsageError(option + " " + text.substr(0, 40) + ": give a colour as RRGGBB in hexadecimal, or transparent");
  return (rgb >> 16 & 255) | (rgb & 0xff00) | (rgb & 255) << 16 | 0xff000000u;
}

/// "auto", and every marcher by its name.
std::vector<Choice<Backend>> backendChoices() {
  std::vector<Choice<Backend>> choices{{nameOf(Backend::automatic), Backend::automatic}};
  for (const MarcherDescriptor& marcher : marcherRegistry()) choices.push_back({marcher.name, marcher.backend});
  return choices;
}

/// Where the marcher that comes first works. Throws DeviceError if there is none.
Backend firstOf(Backend backend) { return marchersFor(backend).front()->backend; }

void logBackend(Backend backend) {
  if (!isDetailLogged()) return;
  std::string reasons;
  if (backend == Backend::automatic)
    for (const MarcherDescriptor& marcher : marcherRegistry())
      if (const std::string reason = marcher.whyUnavailable(); !reason.empty())
        reasons += (reasons.empty() ? ", because " : "; ") + reason;
  logDetail("backend: " + std::string(nameOf(firstOf(backend))) + reasons);
}

void addVolumeOptions(CLI::App& command, CommonOptions& options) {
  const HelpSection section(command, "Volume");
  command.add_option("--volume", options.volume, "Replaces the scene's volume by this file");
  command.add_option("--mask", options.mask, "Crops the volume to where this one, with as many voxels, is not 0");
  command.add_option("--volume-size", options.volumeSize, "XxYxZ: voxels of a built-in volume");
  command.add_option("--memory", options.memoryMiB, "MiB of memory that the program takes at most, " + rangeText(kMemoryMiBRange) + ": of built-in volumes, raw ones, and NIfTI, NRRD and MetaImage files as several processes share them, it keeps what it is at and makes or reads the rest again; others have to fit");
  command.add_option("--device-memory", options.deviceMemoryMiB, "MiB of a GPU's memory that the volume takes at most, " + rangeText(kDeviceMemoryMiBRange) + ": of a larger one slabs go to the GPU one after the other; by itself what is free");
  command.add_option("--seed", options.seed, "Of what is random in the built-in volumes vessels and shells; default: 1");
  command.add_option("--tf", options.transferFunction, "Transfer function file: JSON of this program or a colour map of ParaView");
}

void addMarchOptions(CLI::App& command, CommonOptions& options) {
  const auto add = [&](bool isOfPicture) {
    for (const MarchKnob& row : marchKnobs())
      if ((row.shapes == FramePart::picture) == isOfPicture) options.knobs.add(command, *row.knob, "the scene's");
  };
  {
    const HelpSection section(command, "What a frame says of each pixel");
    add(false);
  }
  const HelpSection section(command, "What is marched");
  add(true);
  for (const MarchText& text : marchTexts())
    command.add_option(std::string(text.option), options.texts[&text], std::string(text.help) + ": " + std::string(text.values) + "; default: the scene's")
        ->type_name("TEXT");
  command.add_option("--fov", options.fovYDeg, "Vertical field of view in degrees, " + rangeText(kFovYDegRange) + "; default: the scene's");
}

}  // namespace

void addSceneOptions(CLI::App& command, CommonOptions& options) {
  command.add_option("scene", options.scene, "A built-in scene (" + listOf(kProceduralVolumes) + "; default: vessels), a scene file or a volume file");
  addBackendOption(command, options);
  command.add_flag("--json", options.json, "One JSON document on standard output and nothing else");
  addLogOptions(command, options);
  addVolumeOptions(command, options);
  addMarchOptions(command, options);
}

void addSizeOption(CLI::App& command, CommonOptions& options) {
  command.add_option("--size", options.size, "WxH of the pictures, in pixels")->capture_default_str();
}

void addCommonOptions(CLI::App& command, CommonOptions& options) {
  addSceneOptions(command, options);
  addSizeOption(command, options);
  const HelpSection section(command, "How techniques draw");
  for (const Knob* knob : warpKnobs()) options.knobs.add(command, *knob, textOf(*knob, knob->defaultValue), ownersOf(*knob));
  command.add_option("--uncovered", options.uncovered, "Colour (RRGGBB) of pixels that no sample covers; default transparent");
  command.add_option("--filled", options.filled, "Colour (RRGGBB) of pixels that --fill filled; default: as they were filled");
  command.add_option("--gl", options.gl, "OpenGL without a window: auto egl osmesa")->capture_default_str();
}

void addBackendOption(CLI::App& command, CommonOptions& options) {
  command.add_option("--backend", options.backend, listOf(backendChoices()))->capture_default_str();
}

void addLogOptions(CLI::App& command, CommonOptions& options) {
  command.add_flag("--quiet", options.quiet, "Errors only");
  command.add_flag("--verbose", options.verbose, "More about what is being done, on standard error");
  command.parse_complete_callback([&options] { setUpLog(options.quiet, options.verbose); });
}

void requireValues(CLI::App& command) {
  for (CLI::Option* option : command.get_options())
    if (option->get_items_expected_max() > 0 && !option->get_positional())
      option->check([&command, option](const std::string& value) {
        const bool isName = value.starts_with("--") || (value.starts_with('-') && command.get_option_no_throw(value) != nullptr);
        if (value.empty() || isName)
          throw UsageError(option->get_name() + " needs a value");
        return std::string();
      });
}

void requireUnread(const std::string& written, const CommonOptions& options, const Scene& scene) {
  if (written.empty()) return;
  std::vector<std::filesystem::path> read{options.scene.value_or(""), options.volume, options.mask, options.transferFunction};
  read.insert(read.end(), scene.files.begin(), scene.files.end());
  requireNoneOf(written, read);
}

CheckedOptions check(const CommonOptions& options) {
  CheckedOptions checked;
  checked.sceneSpec = options.scene.value_or(std::string(kDefaultScene));
  if (!options.size.empty()) {
    const std::vector<uint32_t> size = parseSize("--size", options.size, 2, kMaxImageSide);
    if (!isPictureSize(size[0], size[1]))
      throw UsageError("--size " + options.size + ": pictures have " + pictureSizes());
    checked.width = size[0];
    checked.height = size[1];
  }
  checked.marks = {parseColor("--uncovered", options.uncovered), parseColor("--filled", options.filled)};
  checked.platform = choose("OpenGL platform", options.gl, gl::kPlatforms);
  checked.backend = choose("backend", options.backend, backendChoices());
  checked.given = options.knobs.check();
  for (const auto& [text, typed] : options.texts) {
    if (!typed) continue;
    MarchSettings trial;
    text->set(trial, *typed, text->option);
    checked.givenTexts[text] = *typed;
  }
  for (const Knob* knob : warpKnobs())
    if (const auto value = checked.given.find(*knob)) checked.warp.knobs.set(*knob, *value);
  if (options.fovYDeg) requireRange(*options.fovYDeg, kFovYDegRange, "--fov");

  if (options.seed) checked.overrides.seed = *options.seed;
  checked.overrides.fovYDeg = options.fovYDeg;
  if (!options.volume.empty()) checked.overrides.volume = options.volume;
  if (!options.mask.empty()) checked.overrides.mask = options.mask;
  if (!options.transferFunction.empty()) checked.overrides.transferFunction = options.transferFunction;
  if (options.memoryMiB) {
    requireRange(*options.memoryMiB, kMemoryMiBRange, "--memory");
    setMemoryLimit(static_cast<uint64_t>(*options.memoryMiB * (1 << 20)));
  }
  if (options.deviceMemoryMiB) {
    requireRange(*options.deviceMemoryMiB, kDeviceMemoryMiBRange, "--device-memory");
    setDeviceMemoryLimit(static_cast<uint64_t>(*options.deviceMemoryMiB * (1 << 20)));
  }
  if (!options.volumeSize.empty()) {
    const std::vector<uint32_t> dims = parseSize("--volume-size", options.volumeSize, 3, 65536);
    checked.overrides.proceduralDims = {dims[0], dims[1], dims[2]};
  }
  validate(checked.warp);
  if (checked.warp.knobs.choice<Fill>(kFillKnob) == Fill::proxy && checked.given.find(kProxyKnob) == 0.0)
    throw UsageError("--fill proxy: there is nothing to fill gaps with where --proxy is 0");
  // One that was named and cannot be used is refused further down, after what was typed wrong.
  const Backend first = checked.backend == Backend::automatic ? firstOf(checked.backend) : checked.backend;
  const bool isOnDevice = first == Backend::cuda;
  const auto tracing = checked.warp.knobs.choice<SphereTracing>(kSphereTracingKnob);
  if (tracing == SphereTracing::clusters && !isOnDevice)
    throw UsageError("--via clusters: for CUDA devices; choose auto, lbvh, embree or footprints");
  if (tracing == SphereTracing::embree && isOnDevice)
    throw UsageError("--via embree: Embree traces on the CPU; add --backend cpu, or choose auto, lbvh, clusters or footprints");
  firstOf(checked.backend);
  logBackend(checked.backend);
  return checked;
}

Scene CheckedOptions::open(const std::stop_token& stop) const {
  if (isRecording(sceneSpec)) throw InputError(sceneSpec + ": is a recording, which view and replay show");
  SceneOverrides shared = overrides;
  shared.ranks = processRanks();
  Scene opened = openScene(sceneSpec, shared, stop);
  applyTo(opened);
  if (const auto warning = radiusWarning(opened.volume->geometry(), opened.march.sample.radiusPolicy)) logWarning(*warning);
  return opened;
}

void CheckedOptions::applyTo(Scene& served) const {
  const MarchSettings described = served.march;
  for (const MarchKnob& row : marchKnobs())
    if (const auto value = given.find(*row.knob)) row.set(served.march, *value);
  for (const auto& [text, value] : givenTexts) text->set(served.march, value, text->option);
  if (!(served.march == described)) served.describedMarch = described;
  if (overrides.fovYDeg) served.fovYDeg = *overrides.fovYDeg;
}

namespace {

/// Files beside the volume may differ from machine to machine.
void requireSameScene(const Scene& scene, Ranks& ranks) {
  ranks.requireSame(std::as_bytes(std::span(scene.transferFunction.points)), "transfer function");
  std::vector<double> knobs;
  for (const MarchKnob& row : marchKnobs()) knobs.push_back(row.get(scene.march));
  ranks.requireSame(std::as_bytes(std::span<const double>(knobs)), "knobs of the march");
}

}  // namespace

CommandContext prepare(const CommonOptions& options, const std::stop_token& stop) {
  return prepare(options, {}, stop);
}

CommandContext prepare(const CommonOptions& options, const TransportOptions& transportOptions, const std::stop_token& stop) {
  CommandContext work{check(options), {}, {}, {}, {}, transportOf(transportOptions)};
  const std::optional<net::Address> server = serverOf(transportOptions);
  requireServerFor(transportOptions);
  if (server && processRanks()) throw UsageError("--connect is for one process; start it without mpirun");
  if (server) requireNoSceneOf(options);
  Progress progress("opening", 1, !options.showsProgress());
  progress.step(server ? net::toStringWithoutToken(*server) : work.sceneSpec);
  if (server) {
    const auto io = std::make_shared<net::IoThread>();
    ConnectedScene loaded = connectScene(io, *server, work.transport, [] {}, stop, work.backend);
    work.scene = std::move(loaded.scene);
    work.applyTo(work.scene);
    work.source = std::move(loaded.source);
    // Ground truth comes as it is, without what is simulated for frames; a server that is gone is given up.
    TransportSettings plain;
    plain.codec = work.transport.codec;
    work.sayBusy = [isSaid = std::make_shared<std::once_flag>()](uint16_t others) {
      std::call_once(*isSaid, [&] { logWarning(busySentence(others)); });
    };
    work.remote = connectMarcher(io, *server, plain, work.sayBusy, work.backend);
  } else {
    if (processRanks()) processRanks()->endWith(stop);
    work.scene = work.open(stop);
    if (const RanksPtr& ranks = processRanks()) {
      requireSameScene(work.scene, *ranks);
      if (!ranks->isFirst()) {
        followFirst(work.scene.volume, work.backend, stop);
        throw FollowedToTheEnd();
      }
      leaderOf(work.scene.volume, work.backend);
    }
  }
  work.march = work.scene.march;
  work.warp.reference = work.march.render;
  return work;
}

MarcherPtr CommandContext::marcher() const { return remote ? remote : makeMarcher(backend, scene.volume, scene.transferFunction); }

FrameFetch CommandContext::fetch() const {
  FrameFetch whole = source ? fetchFrom(source, sayBusy) : fetchHere(marcher(), transport.codec);
  return transport.frameKib == 0 ? whole : withinBudget(std::move(whole), bytesOfFrame(transport));
}

namespace {

/// What says something about a scene that is opened here; null if nothing does.
const char* givenOfScene(const CommonOptions& options) {
  const std::pair<const char*, bool> given[] = {{"a scene", options.scene.has_value()},
                                                {"--volume", !options.volume.empty()},
                                                {"--mask", !options.mask.empty()},
                                                {"--volume-size", !options.volumeSize.empty()},
                                                {"--memory", options.memoryMiB.has_value()},
                                                {"--device-memory", options.deviceMemoryMiB.has_value()},
                                                {"--seed", options.seed.has_value()},
                                                {"--tf", !options.transferFunction.empty()}};
  for (const auto& [name, isGiven] : given)
    if (isGiven) return name;
  return nullptr;
}

}  // namespace

bool namesScene(const CommonOptions& options) { return givenOfScene(options) != nullptr; }

void requireNoSceneOf(const CommonOptions& options) {
  if (const char* const name = givenOfScene(options)) throw UsageError(std::string("--connect shows the server's scene: leave out ") + name);
}

void logFrame(const SampleFrame& frame) {
  char text[128];
  std::snprintf(text, sizeof text, "marched %zu samples of %ux%u pixels in %.1f ms, compacted in %.1f ms", frame.size(), frame.camera.width, frame.camera.height,
                frame.timings.marchMs, frame.timings.compactMs);
  logDetail(text);
}

WarpResources HeadlessResources::resources() {
  return {marcher_,
          [this]() -> gl::Context& {
            if (!context_) {
              context_ = gl::makeHeadlessContext(platform_);
              logDetail("OpenGL: " + contextText());
            }
            context_->makeCurrent();
            return *context_;
          },
          backend_, reportFallback};
}

std::string HeadlessResources::contextText() {
  if (!context_) return {};
  context_->makeCurrent();
  return std::string(context_->platformName()) + ", " + context_->renderer();
}

}  // namespace warpscope
