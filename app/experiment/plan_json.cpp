// An array of stages.
// See plan_json.h.
#include "app/experiment/plan_json.h"

#include <nlohmann/json.hpp>

namespace warpscope {

nlohmann::json toJson(const EffectPlan& plan, const StageCosts* costs) {
  nlohmann::json stages = nlohmann::json::array();
  for (const StageDescriptor& stage : kStages) {
    nlohmann::json entry{{"stage", stage.name}, {"summary", stage.summary}, {"in", plan.has(stage.stage)}, {"reason", plan[stage.stage].reason}};
    if (const Measured* cost = costs != nullptr ? costs->of(stage.stage) : nullptr) {
      entry["addsMs"] = cost->medianMs;
      entry["addsSpreadMs"] = cost->spreadMs;
    }
    stages.push_back(entry);
  }
  return stages;
}

}  // namespace warpscope
