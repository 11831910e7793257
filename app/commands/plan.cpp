// `plan`: which stages a scene's march has, which it has not, why, and what each costs here.
// The JSON's keys are part of the command line's contract; app/README.md explains them.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>

#include "app/commands/choose.h"
#include "app/commands/options.h"
#include "app/experiment/plan_json.h"
#include "app/frames/backend.h"
#include "app/scene/json_document.h"
#include "app/scene/knob_json.h"
#include "app/shell/interrupt.h"
#include "app/shell/progress.h"
#include "render/base/error.h"

namespace warpscope {
namespace {

using Json = nlohmann::json;

struct PlanOptions {
  CommonOptions common;
  int runs = 5;
};

void print(const EffectPlan& plan, const StageCosts& costs) {
  for (const StageDescriptor& stage : kStages) {
    std::string cost;
    if (const Measured* added = costs.of(stage.stage)) {
      char text[48];
      std::snprintf(text, sizeof text, "%+9.2f ms ±%.2f", added->medianMs, 0.5 * added->spreadMs);
      cost = text;
    }
    std::printf("%-3s  %-17s %-19s %s\n", plan.has(stage.stage) ? "in" : "out", std::string(stage.name).c_str(), cost.c_str(),
                plan[stage.stage].reason.c_str());
  }
}

void planScene(const PlanOptions& options) {
  if (options.runs < 1 || options.runs > 1000) throw UsageError("--runs must be between 1 and 1000");
  const Interrupt interrupt;
  const CommandContext work = prepare(options.common, interrupt.token());
  const MarcherPtr marcher = work.marcher();
  const std::optional<EffectPlan> plan = marcher->plan(work.march.render, work.march.sample);
  if (!plan) throw InputError("what marches this scene does not tell its plan");
  const Camera camera = makeCamera(work.scene, work.scene.views.front(), work.width, work.height);
  StageCosts costs;
  {
    size_t steps = 1;
    for (const StageDescriptor& stage : kStages) steps += plan->has(stage.stage) && without(stage.stage, work.march) ? 1 : 0;
    Progress progress("plan", steps, !options.common.showsProgress());
    costs = measureStages(*marcher, camera, work.march, *plan, options.runs, [&](std::string_view stage) { progress.step(std::string(stage)); },
                          interrupt.token());
  }
  if (options.common.json) {
    Json report = toJson(work.march);
    report["scene"] = work.scene.name;
    report["width"] = work.width;
    report["height"] = work.height;
    report["device"] = deviceText(marcher->backend());
    report["backend"] = nameOf(marcher->backend());
    report["runs"] = options.runs;
    report["marchMs"] = costs.march.medianMs;
    report["marchSpreadMs"] = costs.march.spreadMs;
    report["stages"] = toJson(*plan, &costs);
    report["version"] = WARPSCOPE_VERSION;
    std::cout << textOf(report);
    return;
  }
  if (options.common.quiet) return;
  std::printf("%s, %ux%u, %s: march %.2f ms ±%.2f; by each stage:\n", work.scene.name.c_str(), work.width, work.height,
              deviceText(marcher->backend()).c_str(), costs.march.medianMs, 0.5 * costs.march.spreadMs);
  print(*plan, costs);
}

}  // namespace

void addPlanCommand(CLI::App& program, std::function<void()>& chosen) {
  CLI::App* command = program.add_subcommand("plan", "Say which stages a scene's march has, which not, why, and what each costs on this machine");
  const auto options = std::make_shared<PlanOptions>();
  addSceneOptions(*command, options->common);
  addSizeOption(*command, options->common);
  command->add_option("--runs", options->runs, "Marches with and without each stage")->capture_default_str();

  command->callback([options, &chosen] { chosen = [options] { planScene(*options); }; });
}

}  // namespace warpscope
