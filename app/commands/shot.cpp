// `shot`: one picture without a window.
// A frame from the scene's first view, warped to the camera turned about the volume's vertical axis.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>

#include "app/commands/choose.h"
#include "app/commands/options.h"
#include "app/experiment/auto_choice.h"
#include "app/frames/frame_budget.h"
#include "app/experiment/ray_look.h"
#include "app/experiment/sweep.h"
#include "app/experiment/sweep_file.h"
#include "app/picture/content.h"
#include "app/picture/picture.h"
#include "app/scene/json_document.h"
#include "app/scene/knob_json.h"
#include "app/shell/interrupt.h"
#include "app/shell/log.h"
#include "app/shell/output_files.h"
#include "app/shell/progress.h"
#include "app/shell/time_limit.h"
#include "render/base/error.h"
#include "render/base/range.h"
#include "render/codec/codec.h"
#include "render/codec/jpeg.h"
#include "render/warp/fill.h"

namespace warpscope {
namespace {

struct ShotOptions {
  CommonOptions common;
  TransportOptions transport = transportOfKeptPictures();
  std::string technique = "spheres";
  double viewAngleDeg = 0.0;
  std::string out;
  std::string front;
  std::string show = "picture";
  std::optional<double> range;
  std::optional<double> budgetMs, timeoutS;
  std::vector<uint32_t> ray;  ///< column and row of a pixel, or empty
};

constexpr std::string_view kAuto = "auto";

enum class PictureFormat { png, jpeg };

/// By the ending of the file's name; without one, PNG. Throws UsageError.
PictureFormat formatOf(const std::string& file) {
  std::string ending = std::filesystem::path(file).extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
  if (ending.empty() || ending == ".png") return PictureFormat::png;
  if (ending == ".jpg" || ending == ".jpeg") return PictureFormat::jpeg;
  throw UsageError("--out " + file + ": pictures are written as .png or .jpg, not as " + ending);
}

std::string encode(const Image<Rgba8>& picture, PictureFormat format, const std::stop_token& stop) {
  switch (format) {
    case PictureFormat::png:
      return encodePng(picture, stop);
    case PictureFormat::jpeg: {
      ByteVector bytes;
      appendJpeg(bytes, picture.data(), picture.width(), picture.height(), CodecSettings().jpegQuality);
      return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    }
  }
  throw std::logic_error("a picture's format is none");
}

/// What of the picture is written. A PNG of the picture itself is transparent where nothing is; JPEG knows no transparency, and shows what a screen does.
ShownContent shownOf(const WarpedImage& image, PictureContent content, PictureFormat format, const ContentInputs& inputs, const ShotOptions& options,
                     const CommandContext& work) {
  if (content == PictureContent::picture && format == PictureFormat::png) return {.picture = toPicture(image, work.marks)};
  return show(content, inputs, options.range ? std::optional(static_cast<float>(*options.range)) : std::nullopt);
}

/// "depth from 212 to 530 volume units".
std::string rampText(const ShownContent& shown, const ContentDescriptor& content) {
  char ends[64];
  std::snprintf(ends, sizeof ends, " from %.4g to %.4g", static_cast<double>(shown.low), static_cast<double>(shown.high));
  return std::string(content.name) + ends + (content.unit == "1" ? "" : " " + std::string(content.unit));
}

constexpr Range kViewAngleDegRange{-360.0, 360.0};
constexpr Range kTimeoutSRange{1.0, 86400.0};

/// What `auto` may choose: what was asked for stays.
bool isAllowed(const Configuration& configuration, uint32_t sidePx, const CommandContext& work) {
  Configuration scene;
  scene.march = work.march;
  const bool isOfThatSize = work.transport.frameKib > 0 ? configuration.serverSidePx <= sidePx : configuration.serverSidePx == sidePx;
  if (!isOfThatSize) return false;
  // Bytes are those of the codec that they were measured with; and what draws the copy alone was charged for no frame, but one has to come.
  const bool drawsCopyAlone = configuration.technique->uses.proxy && !configuration.technique->uses.segments;
  if (work.transport.frameKib > 0 && (!(configuration.codec == work.transport.codec) || drawsCopyAlone)) return false;
  for (const ConfigurationKnob& row : configurationKnobs()) {
    if (!row.matters(configuration)) continue;
    const bool isOfPicture = row.knob().owner == KnobOwner::rendering || row.knob().owner == KnobOwner::effect;
    const std::optional<double> asked = isOfPicture ? row.get(scene) : work.given.find(row.knob());
    if (asked && row.get(configuration) != *asked) return false;
  }
  return true;
}

/// Where bytes are few, fewer rays with more segments each may show more.
void tryOtherFrames(SweepPlan& plan, const CommandContext& work) {
  const uint32_t sidePx = std::max(work.width, work.height);
  std::vector<double>& sides = plan.values(kServerSideKnob);
  sides = {static_cast<double>(sidePx)};
  for (const double share : {0.75, 0.5, 0.375})
    if (const double side = std::floor(share * sidePx); side >= FrameSizeRule::kLeastSidePx) sides.push_back(side);
  if (work.march.sample.segments > 0 && !work.given.find(kSegmentsKnob)) plan.values(kSegmentsKnob) = {2, 4, 8};
}

/// From a sweep's file, or measured here and now.
AutoChoice measuredFront(const ShotOptions& options, const CommandContext& work, HeadlessResources& headless, const std::stop_token& stop) {
  if (!options.front.empty()) {
    const std::optional<SweepFile> sweep = readSweepFile(options.front);
    if (!sweep || !sweep->choice) throw InputError(options.front + ": holds no sweep with anything that draws a frame");
    if (sweep->scene != work.scene.name) logWarning(options.front + " was measured with another scene, " + sweep->scene);
    const uint32_t measuredPx = sweep->choice->largestSidePx(), sidePx = std::max(work.width, work.height);
    if (work.transport.frameKib == 0 && measuredPx != sidePx)
      logWarning(options.front + " was measured with frames of " + std::to_string(measuredPx) + " pixels, and this one has " + std::to_string(sidePx) + ": its times and errors are others");
    return *sweep->choice;
  }
  SweepSettings settings;
  settings.plan = quickPlan(work.march, work.width, work.height, options.viewAngleDeg);
  for (const ConfigurationKnob& row : configurationKnobs())
    if (const auto value = work.given.find(row.knob())) settings.plan.values(row.knob()) = {*value};
  if (work.transport.frameKib > 0) tryOtherFrames(settings.plan, work);
  settings.plan.codecs = {work.transport.codec};
  settings.width = work.width;
  settings.height = work.height;
  settings.warp = work.warp;
  Progress progress("measuring what is best", unitsOf(settings.plan).size(), !options.common.showsProgress());
  SweepJournal journal;
  return AutoChoice(Sweep(work.scene, headless.resources(), settings, stop).run(journal, [&](const std::string& what) { progress.step(what); }));
}

/// Replaces the technique and its settings by what is best; says what that is.
AutoChoice::Choice chooseFor(const ShotOptions& options, CommandContext& work, HeadlessResources& headless, const std::stop_token& stop) {
  const double budgetMs = options.budgetMs.value_or(kDefaultBudgetMs);
  const AutoChoice front = measuredFront(options, work, headless, stop);
  const AutoChoice::Budget budget{.ms = budgetMs, .bytes = work.transport.frameKib > 0 ? bytesOfFrame(work.transport) : 0};
  const auto choice = front.choose(options.viewAngleDeg, budget, [&](const Configuration& configuration) {
    return isAllowed(configuration, front.largestSidePx(), work);
  });
  if (!choice)
    throw InputError((options.front.empty() ? std::string() : options.front + ": ") + "nothing was measured with the settings that were asked for" +
                     (budget.bytes > 0 ? ", and frames of no more than " + std::to_string(work.transport.frameKib) + " KiB" : ""));
  takeOver(choice->configuration, work.march, work.warp);
  logResult("auto: " + choice->reason);
  return *choice;
}

/// What the technique shows nothing without is asked for, whatever the scene says, unless the command line says that there is to be none.
void askForWhatIsDrawn(const WarpDescriptor& technique, CommandContext& work) {
  const auto ask = [&](bool isDrawn, const Knob& knob, int SampleSettings::*value, std::string_view what) {
    if (!isDrawn || work.march.sample.*value > 0) return;
    if (work.given.find(knob))
      throw UsageError("--technique " + std::string(technique.name) + " draws " + std::string(what) + ": " + std::string(knob.option) + " must be more than 0");
    work.march.sample.*value = defaultMarch().sample.*value;
  };
  ask(technique.uses.segments, kSegmentsKnob, &SampleSettings::segments, "segments");
  ask(drawsProxy(technique, work.warp.knobs) && !technique.uses.segments, kProxyKnob, &SampleSettings::proxy, "the volume's copy here");
}

void requireRay(const ShotOptions& options, const CommandContext& work) {
  if (options.ray[0] >= work.width || options.ray[1] >= work.height)
    throw UsageError("--ray " + std::to_string(options.ray[0]) + "," + std::to_string(options.ray[1]) + ": the picture has " + std::to_string(work.width) + " x " +
                     std::to_string(work.height) + " pixels, the first is 0,0");
  if (!work.scene.volume) throw UsageError("--ray looks at the volume's values, which the server has: leave out --connect where the volume is");
  requireWholeRays(*work.scene.volume);
}

/// What there is along the ray behind a pixel of the picture.
nlohmann::json rayReport(const ShotOptions& options, const CommandContext& work, const MarchSettings& settings, const ContentInputs& inputs,
                         const std::stop_token& stop) {
  const RayOfPixel ray = rayBehind(inputs, {options.ray[0], options.ray[1]});
  return toJson(makeRayTracer(work.scene.volume, work.scene.transferFunction)->trace(ray.camera, settings, ray.pixel, stop), ray, settings);
}

/// `limit`: of all that is had from a server.
void shoot(const ShotOptions& options, const Interrupt& interrupt, TimeLimit& limit) {
  requireRange(options.viewAngleDeg, kViewAngleDegRange, "--view-angle");
  const PictureFormat format = formatOf(options.out);
  const PictureContent content = choose("content", options.show, pictureContents());
  if (options.range) {
    requireRange(*options.range, kContentRange, "--range");
    if (describe(content).unit.empty()) throw UsageError("--range is for contents with a ramp of colours, which --show " + options.show + " has not");
  }
  const bool isAutomatic = options.technique == kAuto;
  const WarpDescriptor* chosen = isAutomatic ? nullptr : &findWarp(options.technique);
  if (!isAutomatic && (options.budgetMs || !options.front.empty()))
    throw UsageError("--budget-ms and --front are for --technique auto, not for " + options.technique);
  if (options.budgetMs) requireRange(*options.budgetMs, kBudgetMsRange, "--budget-ms");
  if (isAutomatic && options.front.empty() && !options.transport.connect.empty())
    throw UsageError("--technique auto measures its choices where the volume is: with --connect, give --front with the sweep.json of a sweep");
  CommandContext work = prepare(options.common, options.transport, limit.token());
  requireUnread(options.out, options.common, work.scene);
  if (!options.out.empty()) requireWritable(options.out);
  if (!options.ray.empty()) requireRay(options, work);
  HeadlessResources headless(work.marcher(), work.platform, work.backend);
  std::optional<AutoChoice::Choice> choice;
  if (isAutomatic) {
    choice = chooseFor(options, work, headless, interrupt.token());
    chosen = choice->configuration.technique;
  }
  const WarpDescriptor& descriptor = *chosen;
  const bool hasReference = describe(content).usesReference;
  if (describe(content).usesSamples && !descriptor.usesFrame)
    throw UsageError("--show " + options.show + " is about samples, and --technique " + std::string(descriptor.name) + " draws none");
  auto progress = std::make_unique<Progress>("shot", (descriptor.usesFrame ? 3 : 2) + (hasReference ? 1 : 0), !options.common.showsProgress());
  const WarpResources resources = headless.resources();
  const std::unique_ptr<Warp> warp = makeWarp(descriptor, resources);

  View view = work.scene.views.front();
  const Camera fullCamera = makeCamera(work.scene, view, work.width, work.height);
  const bool isOfChosenSize = choice && work.transport.frameKib > 0;
  const Camera serverCamera = isOfChosenSize ? ofLongerSide(fullCamera, std::min(choice->configuration.serverSidePx, longerSide(fullCamera))) : fullCamera;
  view.angleDeg += options.viewAngleDeg;
  const Camera camera = makeCamera(work.scene, view, work.width, work.height);
  ServedFrame served;
  const MarchSettings asked = work.march;  // with what this technique does not draw
  if (descriptor.usesFrame) {
    progress->step("the server's frame");
    work.march = neededBy(std::array{TechniqueInUse{&descriptor, work.warp.knobs}}, work.march);
    askForWhatIsDrawn(descriptor, work);
    served = work.fetch()(serverCamera, work.march, limit.token());
  }
  const SampleFramePtr& frame = served.frame;
  if (frame) limit.lift();  // what draws without a frame asks the server for the picture
  progress->step(std::string(descriptor.name));
  warp->setFrame(frame, work.warp, limit.token());
  WarpedImage image;
  warp->draw(camera, work.warp, image, limit.token());
  WarpedImage truth;
  if (hasReference) {
    progress->step("the ground truth");
    const std::unique_ptr<Warp> reference = makeWarp(findWarp("reference"), resources);
    reference->setFrame(nullptr, work.warp, limit.token());
    reference->draw(camera, work.warp, truth, limit.token());
  }
  limit.lift();
  if (frame) logFrame(*frame);
  logDetail("drew " + std::to_string(work.width) + "x" + std::to_string(work.height) + " pixels with " + std::string(descriptor.name));
  progress->step("the file");
  std::optional<SegmentLook> segments;
  if (describe(content).usesSamples) segments = segmentLookOf(descriptor, frame.get(), camera, interrupt.token());
  const ContentInputs inputs{.image = image,
                             .camera = camera,
                             .background = work.scene.background,
                             .marks = work.marks,
                             .reference = hasReference ? &truth.color : nullptr,
                             .frame = frame.get(),
                             .segments = segments ? &*segments : nullptr};
  const nlohmann::json ray = options.ray.empty() ? nlohmann::json() : rayReport(options, work, asked, inputs, interrupt.token());
  const ShownContent shown = shownOf(image, content, format, inputs, options, work);
  if (!options.out.empty()) writeFileWhole(options.out, encode(shown.picture, format, interrupt.token()), interrupt.token());
  progress.reset();

  if (options.common.json || !ray.is_null()) {
    nlohmann::json report{{"out", options.out.empty() ? nlohmann::json(nullptr) : nlohmann::json(options.out)},
                                {"technique", descriptor.name},
                                {"viewAngleDeg", options.viewAngleDeg},
                                {"samples", frame ? frame->size() : 0},
                                {"server", frame ? nlohmann::json{{"width", frame->camera.width}, {"height", frame->camera.height}} : nlohmann::json(nullptr)},
                                {"bytes", served.bytes.ofFrame()},
                                {"proxyBytes", served.bytes.proxy},
                                {"transport", toJson(work.transport)},
                                {"latency", frame ? toJson(served.latency) : nlohmann::json(nullptr)}};
    report["show"] = {{"content", options.show}};
    if (shown.hasRamp) report["show"].update({{"low", shown.low}, {"high", shown.high}, {"unit", describe(content).unit}});
    report.update(toJson(work.march));
    if (choice)
      report["auto"] = {{"reason", choice->reason}, {"flip", choice->flip}, {"frameMs", choice->frameMs}, {"configuration", toJson(choice->configuration)}};
    if (!ray.is_null()) report["ray"] = ray;
    std::cout << textOf(report);
  } else {
    logResult("wrote " + options.out + (shown.hasRamp ? ": " + rampText(shown, describe(content)) : std::string()));
  }
}

void shootInTime(const ShotOptions& options) {
  if (options.timeoutS) {
    requireRange(*options.timeoutS, kTimeoutSRange, "--timeout");
    if (options.transport.connect.empty())
      throw UsageError("--timeout is about waiting for a server, and frames are made here: add --connect URL, or leave it out");
  }
  const Interrupt interrupt;
  TimeLimit limit(options.timeoutS ? std::optional(std::chrono::duration<double>(*options.timeoutS)) : std::nullopt, interrupt.token());
  try {
    shoot(options, interrupt, limit);
  } catch (const OperationCancelled& cancelled) {
    if (!limit.isOver() || interrupt.token().stop_requested()) throw;
    const auto* const waited = dynamic_cast<const WaitCancelled*>(&cancelled);
    throw InputError(net::toString(serverOf(options.transport)->where) + " has not answered all that was asked within " + numberText(*options.timeoutS) +
                     " s (--timeout); nothing was written" + (waited != nullptr && !waited->trouble().empty() ? ": " + waited->trouble() : ""));
  }
}

}  // namespace

void addShotCommand(CLI::App& program, std::function<void()>& chosen) {
  auto options = std::make_shared<ShotOptions>();
  CLI::App* command = program.add_subcommand("shot", "One picture, without a window");
  addCommonOptions(*command, options->common);
  addTransportOptions(*command, options->transport);
  command->add_option("--technique", options->technique, listOf(warpRegistry()) + ", or auto: what was measured to be best")->capture_default_str();
  command->add_option("--budget-ms", options->budgetMs, "Milliseconds that a picture may take, for auto, " + rangeText(kBudgetMsRange) + "; default 33");
  command->add_option("--front", options->front, "sweep.json that auto chooses by; without it, the choices are measured first");
  command->add_option("--view-angle", options->viewAngleDeg,
                      "Degrees that the camera turns about the vertical axis, " + rangeText(kViewAngleDegRange))
      ->capture_default_str();
  command->add_option("--show", options->show, "What of the picture is written: " + listOf(pictureContents()))->capture_default_str();
  command->add_option("--range", options->range,
                      "What the upper end of the content's colours stands for, " + rangeText(kContentRange) + "; default: 0.5 for differences and flip, else the largest in the picture");
  command->add_option("--timeout", options->timeoutS,
                      "Seconds that all answers of a server may take together, " + rangeText(kTimeoutSRange) + "; default: as long as it is there");
  command->add_option("--ray", options->ray,
                      "X,Y of a pixel, from 0,0 at the upper left: what there is along the ray behind it, as JSON: values, opacities, segments, every heuristic's depth")
      ->delimiter(',')->expected(2)->allow_extra_args(false);
  command->add_option("-o,--out", options->out, "PNG or JPEG file to write, as its ending says: .png or .jpg; needed, but for --ray");
  command->callback([options, &chosen] {
    chosen = [options] {
      if (options->out.empty() && options->ray.empty()) throw UsageError("--out is required: the picture's file; see warpscope shot --help");
      completeConnect(options->transport, namesScene(options->common));
      shootInTime(*options);
    };
  });
}

}  // namespace warpscope
