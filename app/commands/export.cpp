// `export`: the sample cloud of the scene's first view as a PLY file, and how uncertain its depths are as a picture.
// PLY, binary little endian (Turk 1994): x y z, radius and, where samples have one, spread of depth in world units, 8-bit sRGB colour and alpha.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>

#include "app/commands/options.h"
#include "app/picture/heat_map.h"
#include "app/picture/picture.h"
#include "app/picture/spread_map.h"
#include "app/scene/json_document.h"
#include "app/shell/interrupt.h"
#include "app/shell/log.h"
#include "app/shell/output_files.h"
#include "app/shell/progress.h"
#include "render/base/error.h"
#include "render/base/printable.h"
#include "render/march/own_picture.h"

namespace warpscope {
namespace {

struct ExportOptions {
  CommonOptions common;
  std::string ply;        // either may be empty
  std::string spreadMap;
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
std::string commentsOf(const VolumeGeometry& geometry, bool hasSpreads) {
  const std::string axes = geometry.hasOrientation ? "the axes that the volume's file states, z upwards"
                                                   : "the volume's own axes: x runs along a row of voxels, y from row to row, z from slice to slice";
  return "comment samples of a volume rendering, seen from the scene's first view; those of opacity 0 are left out\n"
         "comment axes: " + axes + "\n"
         "comment units: x y z " + std::string(hasSpreads ? "radius and spread" : "and radius") + " are in the volume file's unit of length, millimetres in medical files\n"
         "comment colours: 8-bit sRGB, not multiplied by alpha\n";
}

/// Samples that show something. Throws OperationCancelled if `stop` is set.
std::string toPly(const SampleFrame& frame, size_t seenCount, const VolumeGeometry& geometry, const std::stop_token& stop) {
  constexpr size_t kSamplesPerLook = 1 << 16;
  const SamplePlane* const spreads = frame.plane(kSpreadPlane);
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\n" + commentsOf(geometry, spreads != nullptr) + "element vertex " + std::to_string(seenCount) +
      "\nproperty double x\nproperty double y\nproperty double z\nproperty double radius\n" + (spreads != nullptr ? "property double spread\n" : "") +
      "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\nend_header\n";
  bytes.reserve(bytes.size() + seenCount * 44);
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
    if (spreads != nullptr) {
      float spread;
      std::memcpy(&spread, spreads->values.data() + i * sizeof spread, sizeof spread);
      appendLittleEndian(bytes, geometry.unit() * spread);
    }
    appendLittleEndian(bytes, frame.colors[i]);
  }
  return bytes;
}

/// Where depths are uncertain, and how much the brightest pixel is.
struct SpreadPicture {
  std::string png;
  double mean = 0.0, most = 0.0;  ///< of pixels with a sample, in the volume file's unit of length
};

SpreadPicture pictureSpreads(const SampleFrame& frame, double unit, const std::stop_token& stop) {
  Image<float> map = spreadMap(frame);
  SpreadPicture picture;
  const float most = *std::max_element(map.begin(), map.end());
  double sum = 0.0;
  for (const float spread : map) sum += static_cast<double>(spread);
  const Image<uint32_t> seen = ownPicture(frame);
  const auto covered = static_cast<double>(std::ranges::count_if(seen, [](uint32_t sample) { return sample != kNoSample; }));
  picture.most = unit * static_cast<double>(most);
  picture.mean = covered > 0.0 ? unit * sum / covered : 0.0;
  picture.png = encodePng(heatMap(map, most > 0.0f ? 1.0f / most : 1.0f), stop);
  return picture;
}

std::string shortText(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

void exportSamples(const ExportOptions& options) {
  if (options.ply.empty() && options.spreadMap.empty()) throw UsageError("give --ply, --spread-map or both");
  if (isSameFile(options.ply, options.spreadMap)) throw UsageError("--ply and --spread-map are the same file: " + printable(options.ply));
  const Interrupt interrupt;
  CommandContext work = prepare(options.common, interrupt.token());
  for (const std::string& file : {options.ply, options.spreadMap}) {
    requireUnread(file, options.common, work.scene);
    if (!file.empty()) requireWritable(file);
  }
  work.march = neededBy({}, work.march);
  if (!options.spreadMap.empty()) work.march.sample.sendsSpread = true;
  auto progress = std::make_unique<Progress>("export", 2, !options.common.showsProgress());
  progress->step("the server's frame");
  const MarcherPtr marcher = makeMarcher(work.backend, work.scene.volume, work.scene.transferFunction);
  const SampleFrame frame = marcher->march(makeCamera(work.scene, work.scene.views.front(), work.width, work.height),
                                           work.march, interrupt.token());
  logFrame(frame);
  const auto seenCount = static_cast<size_t>(std::ranges::count_if(frame.colors, isSeen));
  const size_t clearCount = frame.size() - seenCount;
  progress->step("the files");
  const VolumeGeometry& geometry = work.scene.volume->geometry();
  nlohmann::json report;
  std::vector<std::string> sentences;
  // Both are made before either is written: who interrupts this has none of them, and where one cannot be written the other stays what it was.
  const std::string ply = options.ply.empty() ? "" : toPly(frame, seenCount, geometry, interrupt.token());
  const SpreadPicture picture = options.spreadMap.empty() ? SpreadPicture{} : pictureSpreads(frame, geometry.unit(), interrupt.token());
  if (interrupt.token().stop_requested()) throw OperationCancelled();
  std::vector<FileBytes> files;
  if (!options.ply.empty()) files.push_back({options.ply, ply});
  if (!options.spreadMap.empty()) files.push_back({options.spreadMap, picture.png});
  writeFilesWhole(files);
  if (!options.ply.empty()) {
    report["ply"] = options.ply;
    sentences.push_back("wrote " + std::to_string(seenCount) + " samples to " + options.ply +
                        (clearCount > 0 ? ", without " + std::to_string(clearCount) + " of opacity 0" : ""));
  }
  report["samples"] = seenCount;
  report["leftOut"] = clearCount;
  if (!options.spreadMap.empty()) {
    report["spreadMap"] = options.spreadMap;
    report["meanSpread"] = picture.mean;
    report["mostSpread"] = picture.most;
    sentences.push_back("wrote " + options.spreadMap + ": depths are spread by " + shortText(picture.mean) + " of the file's units in the mean, by " +
                        shortText(picture.most) + " where it is brightest");
  }
  progress.reset();
  if (options.common.json)
    std::cout << textOf(report);
  else
    for (const std::string& sentence : sentences) logResult(sentence);
}

}  // namespace

void addExportCommand(CLI::App& program, std::function<void()>& chosen) {
  auto options = std::make_shared<ExportOptions>();
  CLI::App* command = program.add_subcommand("export", "The sample cloud of the first view as a file, and how uncertain its depths are");
  addSceneOptions(*command, options->common);
  addSizeOption(*command, options->common);
  command->add_option("--ply", options->ply, "PLY file to write: every sample that shows something");
  command->add_option("--spread-map", options->spreadMap, "PNG file to write: how uncertain each pixel's depth is; implies --spread true");
  command->callback([options, &chosen] { chosen = [options] { exportSamples(*options); }; });
}

}  // namespace warpscope
