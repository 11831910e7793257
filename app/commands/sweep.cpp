// `sweep`: accuracy against time, for every combination of what is to be compared.
// sweep.csv, sweep.json and report.html; what is done survives an interrupt.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "app/commands/options.h"
#include "app/experiment/findings.h"
#include "app/experiment/report.h"
#include "app/experiment/sweep.h"
#include "app/scene/json_document.h"
#include "app/scene/knob_json.h"
#include "app/shell/interrupt.h"
#include "app/shell/log.h"
#include "app/shell/output_files.h"
#include "app/shell/progress.h"
#include "render/base/error.h"
#include "render/cuda/devices.h"
#include "render/warp/fill.h"

namespace warpscope {
namespace {

using Json = nlohmann::json;

struct SweepOptions {
  CommonOptions common;
  std::string out, plan;
  bool hasOracle = false;
  std::map<std::string_view, std::string> axes;  // by option, as typed; empty: not given
};

/// Sees to it that techniques which are named have something to draw, unless there is to be none of it: then they are refused. Others are left out.
/// `isNamed`: whether the axis of that key and option is.
template <class IsNamed>
void requireDrawn(SweepPlan& plan, const CommandContext& work, const IsNamed& isNamed) {
  const bool areNamed = isNamed("techniques", "--techniques");
  const MarchSettings usual = defaultMarch();
  for (const auto& [knob, value] : {std::pair(&kSegmentsKnob, usual.sample.segments), std::pair(&kProxyKnob, usual.sample.proxy)})
    if (std::vector<double>& values = plan.values(*knob); areNamed && values == std::vector{0.0} && !work.given.find(*knob) && !isNamed(knob->axis.key, knob->axis.option))
      values = {static_cast<double>(value)};
  // Why a technique draws nothing whatever values of the plan's are combined; empty where it draws with some.
  const auto lackOfAll = [&](const WarpDescriptor& technique) {
    std::string lack;
    MarchSettings march;
    KnobValues knobs;
    for (const double segments : plan.values(kSegmentsKnob))
      for (const double proxy : plan.values(kProxyKnob))
        for (const double fill : plan.values(kFillKnob)) {
          march.sample.segments = static_cast<int>(segments);
          march.sample.proxy = static_cast<int>(proxy);
          knobs.set(kFillKnob, fill);
          lack = lackOf(technique, march, knobs);
          if (lack.empty()) return lack;
        }
    return lack;
  };
  for (const WarpDescriptor* technique : plan.techniques) {
    const std::string name(technique->name), lack = lackOfAll(*technique);
    if (lack.empty()) continue;
    if (areNamed) throw UsageError("--techniques " + name + ": " + lack);
    logWarning(name + " is left out: " + lack);
  }
}

SweepPlan planOf(const SweepOptions& options, const CommandContext& work) {
  SweepPlan plan = defaultPlan(work.march, work.width, work.height);
  std::optional<JsonDocument> document;
  if (!options.plan.empty()) {
    document = JsonDocument::fromFile(options.plan);
    applyPlanFile(document->root(), plan);
  }
  // What other commands take one of is one value of an axis here.
  for (const ConfigurationKnob& row : configurationKnobs())
    if (const auto value = work.given.find(row.knob())) plan.values(row.knob()) = {*value};
  for (const SweepAxis& axis : sweepAxes())
    if (const auto given = options.axes.find(axis.option); given != options.axes.end() && !given->second.empty())
      applyPlanOption(axis, given->second, plan);
  requireDrawn(plan, work, [&](std::string_view key, std::string_view option) {
    const auto typed = options.axes.find(option);
    return (typed != options.axes.end() && !typed->second.empty()) || (document && document->root().find(key));
  });
  return plan;
}

Json machineOf(const std::string& backend, const std::string& openGl) {
  Json devices = Json::array();
  if (backend == "cuda")
    for (const cuda::Device& device : cuda::listDevices().devices) devices.push_back(device.name);
  return {{"backend", backend}, {"openGl", openGl}, {"devices", devices}, {"threads", std::thread::hardware_concurrency()}};
}

/// Size and time of a file, so that another file of its name is told from it; null for what is no file.
Json fileIdentity(const std::string& path) {
  std::error_code error;
  const auto time = std::filesystem::last_write_time(path, error);
  if (path.empty() || error) return nullptr;
  return {std::filesystem::absolute(path, error).string(), std::filesystem::file_size(path, error), time.time_since_epoch().count()};
}

/// All that results depend on, beside what `head` says.
Json identityOf(const Json& head, const SweepOptions& options, const CommandContext& work, const std::string& backend) {
  Json identity = head;
  const CommonOptions& common = options.common;
  identity["sceneSpec"] = work.sceneSpec;
  Json files = {fileIdentity(work.sceneSpec), fileIdentity(common.volume), fileIdentity(common.mask), fileIdentity(common.transferFunction)};
  for (const std::filesystem::path& file : work.scene.files) files.push_back(fileIdentity(file.string()));  // that the scene's description names
  identity["files"] = std::move(files);
  identity["gl"] = common.gl;
  identity["march"] = toJson(work.march);
  identity["machine"] = machineOf(backend, "");
  return identity;
}

void sweep(const SweepOptions& options) {
  const Interrupt interrupt;
  const CommandContext work = prepare(options.common, interrupt.token());
  SweepSettings settings;
  settings.plan = planOf(options, work);
  settings.width = work.width;
  settings.height = work.height;
  settings.warp = work.warp;
  const std::vector<std::string> names{"sweep.csv", "report.html", "sweep.json"};
  for (const std::string& name : names) {
    const std::filesystem::path file = std::filesystem::path(options.out) / name;
    requireUnread(file.string(), options.common, work.scene);
    requireNoneOf(file, {options.plan});
  }
  StagedFolder out(options.out, names);  // fails before the work if it cannot be written
  HeadlessResources headless(work.marcher(), work.platform, work.backend);
  const std::string backend(nameOf(headless.resources().marcher->backend()));

  Json head{{"scene", work.scene.name},   {"width", work.width},
            {"height", work.height},      {"plan", toJson(settings.plan)},
            {"volumeSeed", work.overrides.seed}, {"version", WARPSCOPE_VERSION},
            {"fovYDeg", work.scene.fovYDeg},     {"volumeSize", options.common.volumeSize}};
  for (const Knob* knob : warpKnobs())
    if (knob->axis.key.empty()) head[std::string(knob->key)] = jsonOf(*knob, work.warp.knobs[*knob]);  // what no axis goes through
  SweepJournal journal(options.out, identityOf(head, options, work, backend), settings.plan.base);
  if (journal.found() > 0) logResult("going on with a sweep of which " + std::to_string(journal.found()) + " parts are done");

  Sweep run(work.scene, headless.resources(), settings, interrupt.token());
  SweepReport report;
  try {
    Progress progress("sweep", run.unfinished(journal).size() + 2 + (options.hasOracle ? 1 : 0), !options.common.showsProgress());
    const auto step = [&](const std::string& what) {
      logDetail(what);
      progress.step(what);
    };
    report.rows = run.run(journal, step);
    step("the ground truth's own error");
    report.floors = run.floors();
    if (options.hasOracle) {
      step("bounds: what one dot a ray could show, and a perfect warp");
      report.bounds = run.bounds();
    }
    step("pictures for the report");
    report.summaries = summariesOf(report.rows);
    report.findings = findingsOf(report.rows);
    for (const Configuration& configuration : shownConfigurations(report.summaries, report.findings))
      report.strips.push_back({configuration, run.pictures(configuration)});
  } catch (const OperationCancelled&) {
    throw InputError("stopped; what is done is kept in " + options.out + ", and the same command goes on from there");
  }
  if (const auto last = nameOf(headless.resources().marcher->backend()); last != backend)
    throw InputError("the sweep began on " + backend + " and went on on " + std::string(last) + ", whose times cannot be compared: choose --backend cpu, or try again");
  head["machine"] = machineOf(backend, headless.contextText());
  report.head = head;
  report.background = work.scene.background;
  report.links = settings.plan.links;
  report.title = work.scene.title;

  Json document = head;
  document["rows"] = Json::array();
  for (const SweepRow& row : report.rows) document["rows"].push_back(toJson(row));
  document["floors"] = Json::array();
  for (const SweepFloor& floor : report.floors) document["floors"].push_back(toJson(floor));
  if (options.hasOracle) {
    document["bounds"] = Json::array();
    for (const SweepBound& bound : report.bounds) document["bounds"].push_back(toJson(bound));
  }
  document["findings"] = toJson(report.findings);
  out.write("sweep.csv", csvOf(report.rows));
  out.write("report.html", htmlOf(report));
  out.write("sweep.json", textOf(document));  // last, so that where it is, everything is
  if (interrupt.token().stop_requested()) throw OperationCancelled();
  out.commit();
  journal.remove();

  if (options.common.json)
    std::cout << textOf(document);
  else if (!options.common.quiet) {
    printLines(report.findings.answer);
    logResult("wrote sweep.csv, sweep.json and report.html to " + options.out);
  }
}

/// Of an axis: "default: 0,5,10", as it would be typed. `plan`: the one without options, as JSON.
std::string defaultOf(const SweepAxis& axis, const Json& plan) {
  for (const ConfigurationKnob& row : configurationKnobs()) {
    const Knob& knob = row.knob();
    if (knob.axis.key != axis.key) continue;
    if (&knob == &kServerSideKnob) return "default: the picture's and half of it";
    if (knob.axis.values.empty()) return "default: what " + std::string(knob.option) + " says";
  }
  const Json& value = plan.at(std::string(axis.key));
  if (!value.is_array()) return "default: " + value.dump();
  if (value.size() == warpRegistry().size() && axis.key == "techniques") return "default: all";
  std::string text;
  for (const Json& one : value) text += (text.empty() ? "" : std::string(1, axis.separator)) + (one.is_string() ? one.get<std::string>() : one.dump());
  return "default: " + text;
}

}  // namespace

void addSweepCommand(CLI::App& program, std::function<void()>& chosen) {
  auto options = std::make_shared<SweepOptions>();
  options->common.size = "512x512";
  CLI::App* command = program.add_subcommand("sweep", "Accuracy against time: sweep.csv, sweep.json, report.html");
  addCommonOptions(*command, options->common);
  command->add_option("--out", options->out, "Folder to write to")->required();
  command->add_option("--plan", options->plan, "JSON file with the axes' values; options below replace what it names");
  command->add_flag("--oracle", options->hasOracle,
                    "Bounds as well: what no choice of one depth a ray can beat, and the volume itself wherever the frame knows it");
  const Json plan = toJson(defaultPlan({}, 1024, 1024));
  for (const SweepAxis& axis : sweepAxes())
    command->add_option(std::string(axis.option), options->axes[axis.option], std::string(axis.help) + (axis.most > 1 ? std::string(", joined by '") + axis.separator + "'" : "") + "; " + defaultOf(axis, plan));
  command->callback([options, &chosen] { chosen = [options] { sweep(*options); }; });
}

}  // namespace warpscope
