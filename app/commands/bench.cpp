// `bench`: the paper's Table 1 on this machine, for each backend that it has.
// The JSON's keys are part of the command line's contract; README explains them.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>

#include "app/commands/options.h"
#include "app/experiment/bench_comparison.h"
#include "app/experiment/benchmark.h"
#include "app/experiment/configuration.h"
#include "app/experiment/effect_costs.h"
#include "app/frames/backend.h"
#include "app/frames/process_json.h"
#include "app/frames/process_ranks.h"
#include "app/frames/wire_fields.h"
#include "app/scene/json_document.h"
#include "app/scene/knob_json.h"
#include "app/shell/interrupt.h"
#include "app/shell/log.h"
#include "app/shell/progress.h"
#include "render/base/error.h"
#include "render/base/printable.h"
#include "render/march/marcher_registry.h"

namespace warpscope {
namespace {

using Json = nlohmann::json;

struct BenchOptions {
  CommonOptions common;
  std::vector<std::string> techniques;
  int runs = 50;
  bool measuresEffects = false;
  std::string codec = codecWord({});
  std::string against;  ///< an earlier report; empty: none
};

/// What is measured; the figures come later.
Json reportOf(const BenchOptions& options, const CommandContext& work) {
  Json report = toJson(work.march);
  report["scene"] = work.scene.name;
  report["width"] = work.width;
  report["height"] = work.height;
  report["runs"] = options.runs;
  report["version"] = WARPSCOPE_VERSION;
  if (options.codec != codecWord({})) report["codec"] = options.codec;  // earlier reports do not say it
  return report;
}

/// An earlier report of the same, if one was named; throws before anything is measured.
std::optional<JsonDocument> earlierReport(const BenchOptions& options, const Json& report) {
  if (options.against.empty()) return std::nullopt;
  JsonDocument earlier = JsonDocument::fromFile(options.against, JsonDocument::kLargestMeasured);
  if (!earlier.value().is_object() || figuresOf(earlier.value()).empty()) throw InputError(options.against + ": has no figures of `warpscope bench --json`");
  if (const std::string why = whyNotComparable(earlier.value(), report); !why.empty()) throw UsageError("--against " + options.against + ": " + why);
  return earlier;
}

/// The report, or what `printRun` prints for people; and beside it the earlier one.
void say(const BenchOptions& options, Json report, const std::optional<JsonDocument>& earlier, const std::function<void()>& printRun) {
  if (options.common.json) {
    if (earlier) report["against"] = toJson(compared(earlier->value(), report));
    std::cout << textOf(report);
  } else if (!options.common.quiet) {
    printRun();
    if (earlier) std::fprintf(stderr, "\nagainst %s, medians and half of what is between their quartiles\n%s", options.against.c_str(), printableLines(textOf(compared(earlier->value(), report))).c_str());
  }
}

Json toJson(const FrameBenchmark& frame) {
  const auto& [march, coding, service, ranks] = frame;
  Json json{{"marchMs", march.march.medianMs},
          {"marchSpreadMs", march.march.spreadMs},
          {"compactMs", march.compact.medianMs},
          {"compactSpreadMs", march.compact.spreadMs},
          {"copyMs", march.copy.medianMs},
          {"copySpreadMs", march.copy.spreadMs},
          {"samplesMs", march.samples.medianMs},
          {"samplesSpreadMs", march.samples.spreadMs},
          {"encodeMs", coding.encode.medianMs},
          {"encodeSpreadMs", coding.encode.spreadMs},
          {"decodeMs", coding.decode.medianMs},
          {"decodeSpreadMs", coding.decode.spreadMs},
          {"cameraToBytesMs", service.medianMs},
          {"cameraToBytesSpreadMs", service.spreadMs},
          {"bytes", coding.bytes.ofFrame()}};
  if (ranks.empty()) return json;
  json["processes"] = Json::array();
  for (const net::ProcessFields& process : toFields(ranks)) json["processes"].push_back(warpscope::toJson(process));
  return json;
}

/// What processes did for a frame, a line each.
void printProcesses(const std::vector<RankWork>& ranks) {
  for (size_t rank = 0; rank < ranks.size(); ++rank) {
    const RankWork& work = ranks[rank];
    const glm::ivec3 &lower = work.block.lower, &upper = work.block.upper;
    std::fprintf(stderr, "    process %zu: cells %d,%d,%d to %d,%d,%d; %u tiles, %u by a device, threads' time: %.1f ms marching, %.1f waiting; %.2f MB sent\n", rank, lower.x, lower.y, lower.z, upper.x,
                 upper.y, upper.z, work.tiles, work.deviceTiles, work.marchMs, work.waitMs, static_cast<double>(work.sentBytes) * 1e-6);
  }
}

Json toJson(const TechniqueBenchmark& technique, const Scene& scene) {
  Json views = Json::array();
  for (size_t i = 0; i < technique.views.size(); ++i)
    views.push_back({{"angleDeg", scene.views[i].angleDeg - scene.views.front().angleDeg},
                     {"drawMs", technique.views[i].draw.medianMs},
                     {"drawSpreadMs", technique.views[i].draw.spreadMs},
                     {"fps", technique.views[i].framesPerSecond()}});
  Json json{{"technique", technique.technique->name},
            {"buildMs", technique.first.build.build.medianMs},
            {"buildSpreadMs", technique.first.build.build.spreadMs},
            {"uploadMs", technique.first.build.upload.medianMs},
            {"uploadSpreadMs", technique.first.build.upload.spreadMs},
            {"firstPictureMs", technique.first.firstPicture.medianMs},
            {"firstPictureSpreadMs", technique.first.firstPicture.spreadMs},
            {"bytesToPictureMs", technique.arrival.medianMs},
            {"bytesToPictureSpreadMs", technique.arrival.spreadMs},
            {"views", views}};
  if (technique.frame) json.update(toJson(*technique.frame));
  return json;
}

Json toJson(const BackendBenchmark& result, const Scene& scene) {
  Json techniques = Json::array();
  for (const TechniqueBenchmark& technique : result.techniques) techniques.push_back(toJson(technique, scene));
  Json json{{"device", deviceText(result.backend)},
            {"backend", nameOf(result.backend)},
            {"samples", result.samples()},
            {"serverMs", result.frame.serverMs()},
            {"rawBytes", result.rawBytes},
            {"techniques", techniques}};
  json.update(toJson(result.frame));
  // What Table 1 holds, for the paper's method.
  for (const TechniqueBenchmark& technique : result.techniques)
    if (technique.technique->name == "spheres") {
      const Json spheres = toJson(technique, scene);
      json["buildMs"] = spheres["buildMs"];
      json["views"] = spheres["views"];
    }
  return json;
}

void printResult(const BackendBenchmark& result, const Scene& scene) {
  std::fprintf(stderr, "\n%s (%s), %zu samples\n", std::string(nameOf(result.backend)).c_str(), deviceText(result.backend).c_str(),
               result.samples());
  std::fprintf(stderr, "  march %.3f ms, compaction %.3f ms, copy %.3f ms; camera to samples %.3f ms\n", result.frame.march.march.medianMs,
               result.frame.march.compact.medianMs, result.frame.march.copy.medianMs, result.frame.march.samples.medianMs);
  std::fprintf(stderr, "  encoding %.2f ms, camera to bytes %.2f ms, decoding %.2f ms; %.2f MB on the wire, %.2f MB as samples of 12 bytes\n",
               result.frame.coding.encode.medianMs, result.frame.service.medianMs, result.frame.coding.decode.medianMs, static_cast<double>(result.frame.coding.bytes.ofFrame()) * 1e-6,
               static_cast<double>(result.rawBytes) * 1e-6);
  printProcesses(result.frame.ranks);
  std::fprintf(stderr, "  %-10s %9s %9s %9s %9s   pictures a second in each view\n", "", "upload ms", "build ms", "first ms", "of bytes");
  for (const TechniqueBenchmark& technique : result.techniques) {
    std::fprintf(stderr, "  %-10s %9.3f %9.3f %9.3f %9.3f  ", std::string(technique.technique->name).c_str(), technique.first.build.upload.medianMs,
                 technique.first.build.build.medianMs, technique.first.firstPicture.medianMs, technique.arrival.medianMs);
    for (const BenchmarkView& view : technique.views) std::fprintf(stderr, " %8.1f", view.framesPerSecond());
    std::fputc('\n', stderr);
    if (!technique.frame) continue;
    const FrameBenchmark& frame = *technique.frame;
    std::fprintf(stderr, "    of its own frames: march %.3f ms, compaction %.3f ms, copy %.3f ms; encoding %.2f ms, camera to bytes %.2f ms, decoding %.2f ms; %.2f MB on the wire\n",
                 frame.march.march.medianMs, frame.march.compact.medianMs, frame.march.copy.medianMs, frame.coding.encode.medianMs, frame.service.medianMs,
                 frame.coding.decode.medianMs, static_cast<double>(frame.coding.bytes.ofFrame()) * 1e-6);
    printProcesses(frame.ranks);
  }
  std::fprintf(stderr, "  %-10s %9s %9s %9s %9s  ", "", "", "", "", "");
  for (const View& view : scene.views) std::fprintf(stderr, " %7.0f%s", view.angleDeg - scene.views.front().angleDeg, "°");
  std::fputc('\n', stderr);
}

Json toJson(const EffectCosts& costs) {
  Json effects = Json::array();
  for (const EffectCost& cost : costs.effects)
    effects.push_back({{"effect", cost.effect->name},
                       {"isExample", cost.isExample},
                       {"marchMs", cost.alone.medianMs},
                       {"marchSpreadMs", cost.alone.spreadMs},
                       {"addsMs", cost.adds.medianMs},
                       {"addsSpreadMs", cost.adds.spreadMs},
                       {"leftOutMs", cost.leftOut.medianMs},
                       {"leftOutSpreadMs", cost.leftOut.spreadMs},
                       {"savesMs", cost.saves.medianMs},
                       {"savesSpreadMs", cost.saves.spreadMs}});
  return {{"noneMs", costs.none.medianMs},    {"noneSpreadMs", costs.none.spreadMs},     {"allMs", costs.all.medianMs}, {"allSpreadMs", costs.all.spreadMs},
          {"addsMs", costs.allAdd.medianMs}, {"addsSpreadMs", costs.allAdd.spreadMs}, {"effects", effects}};
}

void printCosts(const EffectCosts& costs) {
  const auto line = [](const char* what, const Measured& march, const Measured& difference, const char* note) {
    std::fprintf(stderr, "  %-22s %9.3f ms ±%-7.3f %+9.3f ms ±%-7.3f %s\n", what, march.medianMs, 0.5 * march.spreadMs, difference.medianMs,
                 0.5 * difference.spreadMs, note);
  };
  std::fprintf(stderr, "  %-22s %9.3f ms ±%.3f\n", "no effect", costs.none.medianMs, 0.5 * costs.none.spreadMs);
  for (const EffectCost& cost : costs.effects) {
    const std::string than = "than " + (cost.effect->needs.empty() ? "none" : std::string(cost.effect->needs) + " alone");
    line((std::string(cost.effect->name) + " alone").c_str(), cost.alone, cost.adds,
         (than + (cost.isExample ? "; an example: " + std::string(cost.effect->example) : "")).c_str());
  }
  line("all", costs.all, costs.allAdd, "than none");
  for (const EffectCost& cost : costs.effects) {
    const Measured saved{-cost.saves.medianMs, cost.saves.spreadMs};
    line(("all but " + std::string(cost.effect->name)).c_str(), cost.leftOut, saved, "than all");
  }
}

/// Those that are compared, the fastest last. Several processes march by one of them, whichever way it is asked for.
std::vector<Backend> measured(Backend backend) {
  std::vector<Backend> backends;
  for (const MarcherDescriptor* marcher : marchersFor(backend)) backends.insert(backends.begin(), marcher->backend);
  if (processRanks()) backends.erase(backends.begin(), backends.end() - 1);
  return backends;
}

/// Each effect alone, all of them, all but one; on every backend.
void benchEffects(const BenchOptions& options) {
  if (!options.techniques.empty()) throw UsageError("--effects measures marches: it takes no --technique");
  const Interrupt interrupt;
  const CommandContext work = prepare(options.common, interrupt.token());
  Json report = reportOf(options, work);
  const std::optional<JsonDocument> earlier = earlierReport(options, report);
  const Camera camera = makeCamera(work.scene, work.scene.views.front(), work.width, work.height);
  const std::vector<Backend> asked = measured(work.backend);
  Json backends = Json::array();
  Progress progress("bench", effectSteps(options.runs) * asked.size(), !options.common.showsProgress());
  std::vector<std::pair<Backend, EffectCosts>> results;
  for (const Backend one : asked) {
    const MarcherPtr marcher = makeMarcher(one, work.scene.volume, work.scene.transferFunction);
    const std::string backend(nameOf(marcher->backend()));
    results.emplace_back(marcher->backend(), measureEffects(*marcher, camera, work.march, options.runs, [&] { progress.step(backend); }, interrupt.token()));
    Json json = toJson(results.back().second);
    json["backend"] = backend;
    json["device"] = deviceText(marcher->backend());
    backends.push_back(json);
  }
  report["backends"] = backends;
  say(options, std::move(report), earlier, [&] {
    for (const auto& [backend, costs] : results) {
      std::fprintf(stderr, "\n%s (%s), %s, %ux%u: a march, and what it takes more\n", std::string(nameOf(backend)).c_str(), deviceText(backend).c_str(),
                   work.scene.name.c_str(), work.width, work.height);
      printCosts(costs);
    }
  });
}

void bench(const BenchOptions& options) {
  if (options.runs < 1 || options.runs > 100000) throw UsageError("--runs must be between 1 and 100000");
  if (options.measuresEffects) return benchEffects(options);
  BenchmarkSettings settings;
  for (const std::string& name : options.techniques) settings.techniques.push_back(&findWarp(name));
  if (settings.techniques.empty())
    for (const WarpDescriptor& technique : warpRegistry())
      if (technique.usesFrame) settings.techniques.push_back(&technique);
  for (const WarpDescriptor* technique : settings.techniques)
    if (!technique->usesFrame) throw UsageError("--technique " + std::string(technique->name) + ": it draws no frames, so there is nothing to measure");
  const Interrupt interrupt;
  const CommandContext work = prepare(options.common, interrupt.token());
  std::erase_if(settings.techniques, [&](const WarpDescriptor* technique) {
    const std::string lack = lackOf(*technique, work.march, work.warp.knobs);
    if (lack.empty()) return false;
    if (!options.techniques.empty()) throw UsageError("--technique " + std::string(technique->name) + ": " + lack);
    logWarning(std::string(technique->name) + " is left out: " + lack);
    return true;
  });
  const Json conditions = reportOf(options, work);
  const std::optional<JsonDocument> earlier = earlierReport(options, conditions);
  settings.march = work.march;
  settings.warp = work.warp;
  settings.width = work.width;
  settings.height = work.height;
  settings.runs = options.runs;
  settings.coding = codecOfWord(options.codec);
  // Automatic: all there are, side by side.
  settings.backends = measured(work.backend);

  std::unique_ptr<HeadlessResources> headless;
  const auto resourcesOf = [&](Backend backend) {
    headless = std::make_unique<HeadlessResources>(makeMarcher(backend, work.scene.volume, work.scene.transferFunction), work.platform, backend);
    return headless->resources();
  };
  std::vector<BackendBenchmark> results;
  {
    Progress progress("bench", benchmarkSteps(settings), !options.common.showsProgress());
    results = runBenchmark(work.scene, settings, resourcesOf, [&](const std::string& what) { progress.step(what); }, interrupt.token());
  }
  Json backends = Json::array();
  for (const BackendBenchmark& result : results) backends.push_back(toJson(result, work.scene));
  Json report = backends.back();  // the fastest there is
  report.update(conditions);
  report["backends"] = backends;
  say(options, std::move(report), earlier, [&] {
    for (const BackendBenchmark& result : results) printResult(result, work.scene);
  });
}

}  // namespace

void addBenchCommand(CLI::App& program, std::function<void()>& chosen) {
  auto options = std::make_shared<BenchOptions>();
  CLI::App* command = program.add_subcommand("bench", "What march, compaction, build and pictures take on this machine");
  addCommonOptions(*command, options->common);
  command->add_option("--technique", options->techniques, "Technique to measure; may be given several times; default: all that draw frames");
  command->add_option("--runs", options->runs, "Times that everything is measured, after a warm-up")->capture_default_str();
  command->add_option("--codec", options->codec, "How frames are encoded: " + std::string(codecWords()) + "; tiled on each backend itself, else on the CPU")->capture_default_str();
  command->add_flag("--effects", options->measuresEffects,
                    "Measure effects instead: no effect, each alone, all together, all but each; an example of each that the scene has not");
  command->add_option("--against", options->against, "What `bench --json` wrote of an earlier run of the same: its figures beside today's, the ratio, and whether they differ by more than they vary");
  command->callback([options, &chosen] { chosen = [options] { bench(*options); }; });
}

}  // namespace warpscope
