// What the stages of a plan cost on the machine at hand: a march as planned and one without a stage, in turns, compared pair by pair.
// Pairs, because what disturbs the one disturbs the other: Hoefler, Belli 2015, section 3.2. The camera moves a little from pair to pair, as it does while
// somebody waits for frames.
#pragma once

#include <functional>
#include <map>
#include <stop_token>
#include <vector>

#include "app/experiment/measured.h"
#include "render/march/marcher.h"

namespace warpscope {

/// The settings with one stage left out; nothing where a stage cannot be left out by itself.
std::optional<MarchSettings> without(PlanStage stage, const MarchSettings& settings);

/// Milliseconds.
struct StageCosts {
  Measured march;                   ///< the whole, as planned
  std::map<PlanStage, Measured> added;  ///< by each stage that is in and can be left out: below 0 where it saves

  /// Null where it was not measured.
  const Measured* of(PlanStage stage) const {
    const auto found = added.find(stage);
    return found != added.end() ? &found->second : nullptr;
  }
};

/// `runs` marches for each stage and as many without it, after one that does not count; each pair from a camera turned by a thousandth, so that a light
/// volume that goes with the camera is made anew. Throws OperationCancelled.
StageCosts measureStages(Marcher& marcher, const Camera& camera, const MarchSettings& settings, const EffectPlan& plan, int runs,
                         const std::function<void(std::string_view stage)>& onStage, const std::stop_token& stop);

}  // namespace warpscope
