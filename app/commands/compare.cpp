// `compare`: every technique in every view of a scene, as pictures, a montage and metrics.json.
// metrics.json's rows are part of the command line's contract; README explains them.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>

#include "app/commands/choose.h"
#include "app/commands/options.h"
#include "app/experiment/comparison.h"
#include "app/picture/montage.h"
#include "app/picture/picture.h"
#include "app/scene/json_document.h"
#include "app/scene/knob_json.h"
#include "app/shell/interrupt.h"
#include "app/shell/log.h"
#include "app/shell/output_files.h"
#include "app/shell/progress.h"
#include "render/base/error.h"

namespace warpscope {
namespace {

using Json = nlohmann::json;

struct CompareOptions {
  CommonOptions common;
  TransportOptions transport = transportOfKeptPictures();
  std::vector<std::string> techniques;
  std::string out;
  uint32_t cellWidth = 320;
};

/// JSON knows no infinity: equal images have the PSNR null.
Json toJson(const ComparisonRow& row, const Comparison& comparison, const CommandContext& work) {
  const bool usesFrame = row.technique->usesFrame;
  const View& view = work.scene.views[row.view];
  return {{"technique", row.technique->name},
          {"heuristic", usesFrame ? Json(nameOf(work.march.sample.heuristic)) : Json(nullptr)},
          {"radius", usesFrame ? Json(nameOf(work.march.sample.radiusPolicy)) : Json(nullptr)},
          {"view", row.view},
          {"angleDeg", view.angleDeg - work.scene.views.front().angleDeg},
          {"elevationDeg", view.elevationDeg},
          {"distance", view.distance},
          {"psnrDb", finiteOrNull(row.psnrDb)},
          {"ssim", row.ssim},
          {"flip", row.flip},
          {"holeFraction", row.holeFraction},
          {"filledFraction", row.filledFraction},
          {"drawMs", row.draw.medianMs},
          {"drawSpreadMs", row.draw.spreadMs},
          {"draws", row.draws},
          {"uploadMs", row.build.upload.medianMs},
          {"buildMs", row.build.build.medianMs},
          {"samples", usesFrame ? comparison.frame->size() : 0},
          {"bytes", row.bytes},
          {"proxyBytes", row.proxyBytes}};
}

Json verdictOf(const Comparison& comparison, const CommandContext& work) {
  Json verdict = Json::array();
  for (const Gain& gain : gainsOf(comparison, "spheres", "points"))
    verdict.push_back({{"view", gain.view},
                       {"angleDeg", work.scene.views[gain.view].angleDeg - work.scene.views.front().angleDeg},
                       {"psnrDb", finiteOrNull(gain.psnrDb)},
                       {"flip", -gain.flip + 0.0},
                       {"holeFraction", -gain.holes + 0.0}});
  return verdict;
}

Json toJson(const Comparison& comparison, const CommandContext& work, std::string_view backend, const std::string& context) {
  Json rows = Json::array();
  for (const ComparisonRow& row : comparison.rows) rows.push_back(toJson(row, comparison, work));
  Json leftOut = Json::array();
  for (const WarpDescriptor& technique : warpRegistry())
    if (const std::string lack = lackOf(technique, work.march); !lack.empty()) leftOut.push_back({{"technique", technique.name}, {"reason", lack}});
  Json json{{"scene", work.scene.name},
          {"width", work.width},
          {"height", work.height},
          {"backend", backend},
          {"openGl", context},
          {"server", {{"marchMs", comparison.frame->timings.marchMs}, {"compactMs", comparison.frame->timings.compactMs},
                      {"width", comparison.frame->camera.width}, {"height", comparison.frame->camera.height}}},
          {"transport", toJson(work.transport)},
          {"latency", toJson(comparison.served.latency)},
          {"nonFiniteVoxels", work.scene.volume ? Json(work.scene.volume->statistics().nonFinite) : Json(nullptr)},
          {"version", WARPSCOPE_VERSION},
          {"spheresAgainstPoints", verdictOf(comparison, work)},
          {"rows", rows},
          {"leftOut", leftOut}};
  json.update(toJson(work.march));
  for (const Knob* knob : warpKnobs()) json[std::string(knob->key)] = jsonOf(*knob, work.warp.knobs[*knob]);
  return json;
}

/// Without times, which are never the same twice: the table and metrics.json have them.
std::string captionOf(const ComparisonRow& row) {
  if (!row.technique->usesFrame) return "";
  if (!std::isfinite(row.psnrDb)) return "identical";
  char text[80];
  std::snprintf(text, sizeof text, "%.1f dB, FLIP %.3f, holes %.1f %%", row.psnrDb, row.flip, 100.0 * row.holeFraction);
  return text;
}

/// Characters of UTF-8.
size_t widthOf(const std::string& text) {
  const auto isFirstByte = [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; };
  return static_cast<size_t>(std::count_if(text.begin(), text.end(), isFirstByte));
}

/// `text` behind as many blanks as make it `width` characters wide.
std::string padded(const std::string& text, size_t width) { return std::string(width - std::min(width, widthOf(text)), ' ') + text; }

void printTable(const Comparison& comparison, const Scene& scene, const std::vector<const WarpDescriptor*>& techniques) {
  constexpr size_t kNumbers = 25, kGap = 2;
  size_t cell = kNumbers;
  for (const View& view : scene.views) cell = std::max(cell, widthOf(viewCaption(view, scene.views.front())) + kGap);
  std::string table(11, ' ');
  for (const View& view : scene.views) table += padded(viewCaption(view, scene.views.front()), cell);
  for (const WarpDescriptor* const technique : techniques) {
    std::string name(technique->name);
    name.resize(std::max<size_t>(11, name.size()), ' ');
    table += "\n" + name;
    for (const ComparisonRow& row : comparison.rows) {
      if (row.technique != technique) continue;
      char text[80];
      if (std::isfinite(row.psnrDb))
        std::snprintf(text, sizeof text, "%.1f dB %5.1f %% %4.0f", row.psnrDb, 100.0 * row.holeFraction, row.draw.medianMs);
      else
        std::snprintf(text, sizeof text, "identical %5.1f %% %4.0f", 100.0 * row.holeFraction, row.draw.medianMs);
      table += padded(text, cell);
    }
  }
  printLines(table + "\n             (per view: PSNR, holes, ms a picture)\n");
}

/// The question of Zellmann 2020, figure 3: do spheres beat points, and by how much?
void printVerdict(const Comparison& comparison, const Scene& scene) {
  if (gainsOf(comparison, "spheres", "points").empty()) return;
  std::fputs("spheres against points, PSNR, FLIP (negative: less) and holes:\n", stderr);
  for (const Gain& gain : gainsOf(comparison, "spheres", "points")) {
    const bool isSharper = gain.psnrDb > 0.0, isCloser = gain.flip > 0.0;
    const char* verdict = isSharper && isCloser ? "spheres win" : !isSharper && !isCloser ? "points win" : isSharper ? "spheres by PSNR, points by FLIP" : "points by PSNR, spheres by FLIP";
    std::fprintf(stderr, "%s  %+.1f dB, %+.4f, %+.1f %%: %s\n", padded(viewCaption(scene.views[gain.view], scene.views.front()), 24).c_str(), gain.psnrDb,
                 -gain.flip + 0.0, -100.0 * gain.holes + 0.0, verdict);
  }
}

std::string nameOf(const WarpDescriptor& technique, size_t view) {
  return "view" + std::to_string(view) + "-" + std::string(technique.name) + ".png";
}

/// Of all files that are to come.
std::vector<std::string> namesOf(const std::vector<const WarpDescriptor*>& techniques, size_t views) {
  std::vector<std::string> names{"montage.png", "metrics.json"};
  for (const WarpDescriptor* const technique : techniques)
    for (size_t view = 0; view < views; ++view) names.push_back(nameOf(*technique, view));
  return names;
}

/// Throws UsageError where the montage would be too large for a file: before the work, not after it.
void requireMontage(size_t techniques, size_t views, uint32_t cellWidth, const CommandContext& work) {
  constexpr uint64_t kForTexts = 48, kForLabels = 1024;  // beside a picture, and beside all
  const uint64_t cellHeight = uint64_t{work.height} * cellWidth / work.width + 1;
  if (!fitsPng(views * (cellWidth + kForTexts) + kForLabels, techniques * (cellHeight + kForTexts) + kForLabels))
    throw UsageError("--cell: a montage of " + std::to_string(techniques) + " by " + std::to_string(views) + " pictures of " + std::to_string(cellWidth) + " pixels is too large for a PNG file");
}

/// Those that are named, or all that show something of the scene's frames; the reference among them. Says what is left out.
std::vector<const WarpDescriptor*> techniquesFor(const CompareOptions& options, const MarchSettings& march) {
  for (const WarpDescriptor& technique : warpRegistry()) {
    const std::string lack = lackOf(technique, march);
    const bool isNamed = std::ranges::find(options.techniques, technique.name) != options.techniques.end();
    if (!lack.empty() && isNamed) throw UsageError("--techniques " + std::string(technique.name) + ": " + lack);
    if (!lack.empty() && options.techniques.empty()) logWarning(std::string(technique.name) + " is left out: " + lack);
  }
  std::vector<const WarpDescriptor*> techniques = comparedTechniques(march);
  const auto isLeftOut = [&](const WarpDescriptor* technique) { return technique->usesFrame && std::ranges::find(options.techniques, technique->name) == options.techniques.end(); };
  if (!options.techniques.empty()) std::erase_if(techniques, isLeftOut);
  return techniques;
}

void compare(const CompareOptions& options) {
  for (const std::string& name : options.techniques) findWarp(name);  // throws where there is none
  if (options.cellWidth < 16 || options.cellWidth > 4096) throw UsageError("--cell: must be 16 to 4096 pixels");
  const Interrupt interrupt;
  const CommandContext work = prepare(options.common, options.transport, interrupt.token());
  const std::vector<const WarpDescriptor*> techniques = techniquesFor(options, work.march);
  requireMontage(techniques.size(), work.scene.views.size(), std::min(options.cellWidth, work.width), work);
  for (const std::string& name : namesOf(techniques, work.scene.views.size())) requireUnread((std::filesystem::path(options.out) / name).string(), options.common, work.scene);
  StagedFolder out(options.out, namesOf(techniques, work.scene.views.size()));  // fails before the work if it cannot be written
  HeadlessResources headless(work.marcher(), work.platform, work.backend);
  Montage montage;
  montage.title = work.scene.title + "  (" + std::string(nameOf(work.march.sample.heuristic)) + ", " +
                  std::string(nameOf(work.march.sample.radiusPolicy)) + " radius)";
  for (const View& view : work.scene.views) montage.columns.push_back(viewCaption(view, work.scene.views.front()));
  for (const WarpDescriptor* const technique : techniques) montage.rows.push_back({std::string(technique->label), {}});
  const auto rowOf = [&](const WarpDescriptor& technique) -> auto& {
    return montage.rows[static_cast<size_t>(std::ranges::find(techniques, &technique) - techniques.begin())];
  };

  ComparisonSettings settings;
  settings.techniques = techniques;
  settings.march = work.march;
  if (!options.techniques.empty()) {  // nothing is sent that none of them draws
    std::vector<TechniqueInUse> inUse;
    for (const WarpDescriptor* const technique : techniques) inUse.push_back({technique, work.warp.knobs});
    settings.march = neededBy(inUse, work.march);
  }
  settings.warp = work.warp;
  settings.fetch = work.fetch();
  settings.codec = work.transport.codec;
  settings.width = work.width;
  settings.height = work.height;
  const size_t pictures = techniques.size() * work.scene.views.size();
  Comparison comparison;
  {
    Progress progress("compare", pictures + 1, !options.common.showsProgress());
    comparison = compareTechniques(
        work.scene, headless.resources(), settings,
        [&](const WarpDescriptor& technique, size_t view, const WarpedImage& image) {
          out.write(nameOf(technique, view), encodePng(toPicture(image, work.marks), interrupt.token()));
          Image<Rgba8> screen = toScreen(image, work.scene.background, work.marks);
          const uint32_t width = std::min(options.cellWidth, work.width);
          const uint32_t height = std::max<uint32_t>(1, static_cast<uint32_t>(uint64_t{work.height} * width / work.width));
          rowOf(technique).cells.push_back({resized(screen, width, height), ""});
        },
        [&](const std::string& what) { progress.step(what); }, interrupt.token());
  }
  logFrame(*comparison.frame);
  for (const ComparisonRow& row : comparison.rows)
    rowOf(*row.technique).cells[row.view].caption = captionOf(row);
  out.write("montage.png", encodePng(drawMontage(montage, options.cellWidth), interrupt.token()));
  const Json report = toJson(comparison, work, nameOf(headless.resources().marcher->backend()), headless.contextText());
  out.write("metrics.json", textOf(report));  // last, so that where it is, everything is
  if (interrupt.token().stop_requested()) throw OperationCancelled();
  out.commit();

  if (options.common.json)
    std::cout << textOf(report);
  else if (!options.common.quiet) {
    printTable(comparison, work.scene, techniques);
    printVerdict(comparison, work.scene);
    logResult("wrote " + std::to_string(pictures) + " pictures, montage.png and metrics.json to " + options.out);
  }
}

}  // namespace

void addCompareCommand(CLI::App& program, std::function<void()>& chosen) {
  auto options = std::make_shared<CompareOptions>();
  CLI::App* command = program.add_subcommand("compare", "Every technique in every view: pictures, a montage, metrics.json");
  addCommonOptions(*command, options->common);
  addTransportOptions(*command, options->transport);
  command->add_option("--techniques", options->techniques, listOf(warpRegistry()) + ", joined by commas; default: all. The reference is always among them")->delimiter(',');
  command->add_option("--out", options->out, "Folder to write to")->required();
  command->add_option("--cell", options->cellWidth, "Width of a picture in the montage, in pixels")->capture_default_str();
  command->callback([options, &chosen] {
    chosen = [options] {
      completeConnect(options->transport, namesScene(options->common));
      compare(*options);
    };
  });
}

void compareDefaultScene(const std::filesystem::path& out) {
  CompareOptions options;
  options.out = out.string();
  completeConnect(options.transport, false);
  compare(options);
}

}  // namespace warpscope
