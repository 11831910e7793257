// Plans and what their stages cost, as JSON: for `plan` and the window's report.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "app/experiment/stage_costs.h"

namespace warpscope {

/// Every stage, in their order; `costs` may be null. app/README.md explains the keys.
nlohmann::json toJson(const EffectPlan& plan, const StageCosts* costs);

}  // namespace warpscope
