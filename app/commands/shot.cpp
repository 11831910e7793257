// `shot`: one picture without a window.
// A frame from the scene's first view, warped to the camera turned about the volume's vertical axis.
#include <CLI/CLI.hpp>
#include <iostream>
#include <nlohmann/json.hpp>

#include "app/commands/options.h"
#include "app/interrupt.h"
#include "app/json_document.h"
#include "app/log.h"
#include "app/output_files.h"
#include "app/picture.h"
#include "app/progress.h"
#include "render/core/range.h"

namespace warpscope {
namespace {

struct ShotOptions {
  CommonOptions common;
  TransportOptions transport;
  std::string technique = "spheres";
  double viewAngleDeg = 0.0;
  std::string out;
};

constexpr Range kViewAngleDegRange{-360.0, 360.0};

void shoot(const ShotOptions& options) {
  requireRange(options.viewAngleDeg, kViewAngleDegRange, "--view-angle");
  const WarpDescriptor& descriptor = findWarp(options.technique);
  const Interrupt interrupt;
  const Workplace work = prepare(options.common, options.transport, interrupt.token());
  requireWritable(options.out);
  auto progress = std::make_unique<Progress>("shot", descriptor.usesFrame ? 3 : 2, !options.common.showsProgress());
  HeadlessResources headless(work.marcher(), work.platform, work.backend);
  const WarpResources resources = headless.resources();
  const std::unique_ptr<Warp> warp = makeWarp(descriptor, resources);

  View view = work.scene.views.front();
  const Camera serverCamera = makeCamera(work.scene, view, work.width, work.height);
  view.angleDeg += options.viewAngleDeg;
  const Camera camera = makeCamera(work.scene, view, work.width, work.height);
  ServedFrame served;
  if (descriptor.usesFrame) {
    progress->step("the server's frame");
    served = work.serving()(serverCamera, work.march, interrupt.token());
  }
  const SampleFramePtr& frame = served.frame;
  progress->step(std::string(descriptor.name));
  warp->setFrame(frame, work.warp, interrupt.token());
  WarpedImage image;
  warp->draw(camera, work.warp, image, interrupt.token());
  if (frame) logFrame(*frame);
  logDetail("drew " + std::to_string(work.width) + "x" + std::to_string(work.height) + " pixels with " + std::string(descriptor.name));
  progress->step("the file");
  writeFileWhole(options.out, encodePng(toPicture(image, work.uncovered), interrupt.token()), interrupt.token());
  progress.reset();

  if (options.common.json) {
    const nlohmann::json report{{"out", options.out},
                                {"technique", descriptor.name},
                                {"viewAngleDeg", options.viewAngleDeg},
                                {"samples", frame ? frame->size() : 0},
                                {"bytes", served.bytes},
                                {"transport", toJson(work.transport)},
                                {"latency", frame ? toJson(served.latency) : nlohmann::json(nullptr)},
                                {"heuristic", nameOf(work.march.heuristic)},
                                {"radius", nameOf(work.march.radiusPolicy)}};
    std::cout << textOf(report);
  } else {
    logResult("wrote " + options.out);
  }
}

}  // namespace

void addShotCommand(CLI::App& program, std::function<void()>& chosen) {
  auto options = std::make_shared<ShotOptions>();
  CLI::App* command = program.add_subcommand("shot", "One picture, without a window");
  addCommonOptions(*command, options->common);
  // Pictures that are compared and kept show what warping does, not what compressing colours does.
  options->transport.color = nameOf(ColorCoding::lossless);
  addTransportOptions(*command, options->transport);
  std::string names;
  for (const WarpDescriptor& warp : warpRegistry()) names += (names.empty() ? "" : " ") + std::string(warp.name);
  command->add_option("--technique", options->technique, names)->capture_default_str();
  command->add_option("--view-angle", options->viewAngleDeg,
                      "Degrees that the camera turns about the vertical axis, " + rangeText(kViewAngleDegRange))
      ->capture_default_str();
  command->add_option("-o,--out", options->out, "PNG file to write")->required();
  command->callback([options, &chosen] { chosen = [options] { shoot(*options); }; });
}

}  // namespace warpscope
