// `stability`: what stable arithmetic buys and costs, case by case: a table, a page, pictures.
// The JSON's keys are part of the command line's contract; README of app/ explains them.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>

#include "app/commands/options.h"
#include "app/experiment/stability.h"
#include "app/experiment/stability_page.h"
#include "app/frames/backend.h"
#include "app/picture/picture.h"
#include "app/scene/json_document.h"
#include "app/shell/interrupt.h"
#include "app/shell/log.h"
#include "app/shell/output_files.h"
#include "app/shell/progress.h"
#include "render/base/error.h"
#include "render/base/nearest_name.h"
#include "render/march/marcher_registry.h"

namespace warpscope {
namespace {

using Json = nlohmann::json;

struct StabilityOptions {
  CommonOptions common;  // --json, --quiet, --verbose, --backend
  std::vector<std::string> cases;
  std::string out;
  int runs = 5;
};

Json toJson(const StabilityForm& form) {
  return {{"worst", form.worst}, {"wrongShare", form.wrongShare}, {"drawMs", form.time.medianMs}, {"drawSpreadMs", form.time.spreadMs}};
}

Json toJson(const StabilityResult& result) {
  const StabilityCase& what = *result.what;
  return {{"case", what.name},
          {"subject", wordsOf(what.subject).name},
          {"scene", what.scene.empty() ? Json(nullptr) : Json(what.scene)},
          {"backend", nameOf(result.backend)},
          {"width", what.sidePx},
          {"height", what.sidePx},
          {"stable", toJson(result.stable)},
          {"textbook", toJson(result.textbook)},
          {"bound", what.bound},
          {"isStable", result.isStable()},
          {"costNs", result.costNs()}};
}

void printTable(const std::vector<StabilityResult>& results) {
  std::fprintf(stderr, "%-16s %-7s  %22s  %22s  %9s  %s\n", "", "", "stable: worst, wrong", "textbook: worst, wrong", "bound", "stability costs");
  for (const StabilityResult& result : results)
    std::fprintf(stderr, "%-16s %-7s  %10s %9.2f %%  %10s %9.2f %%  %9s  %+.1f ns a pixel%s\n", std::string(result.what->name).c_str(),
                 std::string(nameOf(result.backend)).c_str(), errorText(result.stable.worst).c_str(), 100.0 * result.stable.wrongShare,
                 errorText(result.textbook.worst).c_str(), 100.0 * result.textbook.wrongShare, errorText(result.what->bound).c_str(), result.costNs(),
                 result.isStable() ? "" : "  EXCEEDED");
  if (results.empty()) return;
  std::fputs("             (against the same picture in double precision; worst: the largest difference of a colour or of opacity, 0 to 1; wrong: pixels that differ by more than 1/255\n"
             "             or show another sample; bound: what the stable form may not exceed; costs below 0: the stable form is the faster one)\n",
             stderr);
}

std::string pictureName(const StabilityResult& result, std::string_view form) {
  return std::string(result.what->name) + "-" + std::string(nameOf(result.backend)) + "-" + std::string(form) + ".png";
}

void writePictures(StagedFolder& out, const StabilityResult& result, const std::stop_token& stop) {
  const auto write = [&](std::string_view form, const Image<glm::vec4>& picture) {
    if (picture.size() == 0) return;
    out.write(pictureName(result, form), encodePng(toScreen(picture, result.background), stop));
  };
  write("exact", result.exact);
  write("stable", result.stable.picture);
  write("textbook", result.textbook.picture);
}

void runStabilityCommand(const StabilityOptions& options) {
  if (options.runs < 1 || options.runs > 100000) throw UsageError("--runs must be between 1 and 100000");
  StabilitySettings settings;
  settings.runs = options.runs;
  for (const std::string& name : options.cases) {
    const StabilityCase* known = findNamed(stabilityCases(), name);
    if (known == nullptr) throw UsageError("--case: " + unknownNameIn(stabilityCases(), "case", name));
    settings.cases.push_back(known);
  }
  if (settings.cases.empty())
    for (const StabilityCase& known : stabilityCases()) settings.cases.push_back(&known);
  for (const MarcherDescriptor* marcher : marchersFor(check(options.common).backend))
    settings.backends.insert(settings.backends.begin(), marcher->backend);

  const Interrupt interrupt;
  StagedFolder out(options.out, {"stability.html", "stability.json"});  // fails before the work if it cannot be written
  std::vector<StabilityResult> results;
  {
    Progress progress("stability", settings.cases.size() * settings.backends.size(), !options.common.showsProgress());
    results = runStability(settings, [&](const std::string& what) { progress.step(what); }, interrupt.token());
  }
  Json rows = Json::array();
  std::string exceeded;
  for (const StabilityResult& result : results) {
    rows.push_back(toJson(result));
    writePictures(out, result, interrupt.token());
    if (!result.isStable()) exceeded += (exceeded.empty() ? "" : ", ") + std::string(result.what->name) + " on " + std::string(nameOf(result.backend));
  }
  std::string machine = "warpscope " WARPSCOPE_VERSION;
  Json devices = Json::array();
  for (const Backend backend : settings.backends) {
    const std::string device = deviceText(backend);
    devices.push_back(device);
    machine += "; " + device;
  }
  const Json report{{"version", WARPSCOPE_VERSION}, {"devices", devices}, {"runs", options.runs}, {"cases", rows}};
  out.write("stability.html", stabilityPage(results, machine));
  out.write("stability.json", textOf(report));
  if (interrupt.token().stop_requested()) throw OperationCancelled();
  out.commit();
  if (options.common.json)
    std::cout << textOf(report);
  else if (!options.common.quiet) {
    printTable(results);
    logResult("wrote stability.html, stability.json and pictures to " + options.out);
  }
  if (!exceeded.empty()) throw InputError("the stable form exceeds its bound: " + exceeded);
}

}  // namespace

void addStabilityCommand(CLI::App& program, std::function<void()>& chosen) {
  auto options = std::make_shared<StabilityOptions>();
  CLI::App* command = program.add_subcommand("stability", "Hard cases by stable arithmetic and by the textbook's: a page, a table, pictures");
  std::string names;
  for (const StabilityCase& known : stabilityCases()) names += " " + std::string(known.name);
  command->add_option("--case", options->cases, "Case to run; may be given several times; default: all of" + names);
  addBackendOption(*command, options->common);
  command->add_option("--runs", options->runs, "Pictures of each that are timed, after one that is not; fewer where one takes long")->capture_default_str();
  command->add_option("--out", options->out, "Folder to write to")->required();
  command->add_flag("--json", options->common.json, "One JSON document on standard output and nothing else");
  addLogOptions(*command, options->common);
  command->callback([options, &chosen] { chosen = [options] { runStabilityCommand(*options); }; });
}

}  // namespace warpscope
