// `export`: the sample cloud of the scene's first view as a PLY file.
// PLY, binary little endian (Turk 1994): x y z in world units, radius in world units, 8-bit sRGB colour and alpha.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <bit>
#include <cstring>
#include <iostream>
#include <nlohmann/json.hpp>

#include "app/commands/options.h"
#include "app/scene/json_document.h"
#include "app/shell/interrupt.h"
#include "app/shell/log.h"
#include "app/shell/output_files.h"
#include "app/shell/progress.h"
#include "render/base/error.h"

namespace warpscope {
namespace {

struct ExportOptions {
  CommonOptions common;
  std::string ply;
};

template <class T>
void appendLittleEndian(std::string& bytes, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof value);
  if constexpr (std::endian::native == std::endian::big)
    for (size_t i = 0; i < sizeof(T) / 2; ++i) std::swap(raw[i], raw[sizeof(T) - 1 - i]);
  bytes.append(raw, sizeof(T));
}

bool isSeen(Rgba8 color) { return color >> 24 != 0; }

/// What a reader cannot know from the numbers.
std::string commentsOf(const VolumeGeometry& geometry) {
  const std::string axes = geometry.hasOrientation ? "the axes that the volume's file states, z upwards"
                                                   : "the volume's own axes: x runs along a row of voxels, y from row to row, z from slice to slice";
  return "comment samples of a volume rendering, seen from the scene's first view; those of opacity 0 are left out\n"
         "comment axes: " + axes + "\n"
         "comment units: x y z and radius are in the volume file's unit of length, millimetres in medical files\n"
         "comment colours: 8-bit sRGB, not multiplied by alpha\n";
}

/// Samples that show something. Throws OperationCancelled if `stop` is set.
std::string toPly(const SampleFrame& frame, size_t seenCount, const VolumeGeometry& geometry, const std::stop_token& stop) {
  constexpr size_t kSamplesPerLook = 1 << 16;
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\n" + commentsOf(geometry) + "element vertex " + std::to_string(seenCount) +
      "\nproperty double x\nproperty double y\nproperty double z\nproperty double radius\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\nend_header\n";
  bytes.reserve(bytes.size() + seenCount * 36);
  // Doubles: world coordinates may be large where the volume is small.
  const glm::dvec3 center =
      geometry.origin + geometry.direction * (0.5 * (glm::dvec3(geometry.dims) - 1.0) * geometry.spacing);
  const SampleGrid grid = frame.grid();
  for (size_t i = 0; i < frame.size(); ++i) {
    if (i % kSamplesPerLook == 0 && stop.stop_requested()) throw OperationCancelled();
    if (!isSeen(frame.colors[i])) continue;
    const Sphere sphere = unpackSample(frame.samples[i], grid);
    const glm::dvec3 world = center + geometry.direction * (geometry.unit() * glm::dvec3(sphere.center));
    for (int axis = 0; axis < 3; ++axis) appendLittleEndian(bytes, world[axis]);
    appendLittleEndian(bytes, geometry.unit() * sphere.radius);
    appendLittleEndian(bytes, frame.colors[i]);
  }
  return bytes;
}

void exportSamples(const ExportOptions& options) {
  const Interrupt interrupt;
  const CommandContext work = prepare(options.common, interrupt.token());
  requireWritable(options.ply);
  auto progress = std::make_unique<Progress>("export", 2, !options.common.showsProgress());
  progress->step("the server's frame");
  const MarcherPtr marcher = makeMarcher(work.backend, work.scene.volume, work.scene.transferFunction);
  const SampleFrame frame = marcher->march(makeCamera(work.scene, work.scene.views.front(), work.width, work.height),
                                           work.march, interrupt.token());
  logFrame(frame);
  const auto seenCount = static_cast<size_t>(std::ranges::count_if(frame.colors, isSeen));
  const size_t clearCount = frame.size() - seenCount;
  progress->step("the file");
  writeFileWhole(options.ply, toPly(frame, seenCount, work.scene.volume->geometry(), interrupt.token()), interrupt.token());
  progress.reset();
  if (options.common.json)
    std::cout << textOf({{"ply", options.ply}, {"samples", seenCount}, {"leftOut", clearCount}});
  else
    logResult("wrote " + std::to_string(seenCount) + " samples to " + options.ply +
              (clearCount > 0 ? ", without " + std::to_string(clearCount) + " of opacity 0" : ""));
}

}  // namespace

void addExportCommand(CLI::App& program, std::function<void()>& chosen) {
  auto options = std::make_shared<ExportOptions>();
  CLI::App* command = program.add_subcommand("export", "The sample cloud of the first view as a file");
  addCommonOptions(*command, options->common);
  command->add_option("--ply", options->ply, "PLY file to write")->required();
  command->callback([options, &chosen] { chosen = [options] { exportSamples(*options); }; });
}

}  // namespace warpscope
