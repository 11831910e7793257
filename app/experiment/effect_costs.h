// What effects cost on the machine at hand: one at a time, all together, and all but one.
// In turns with the march that has none, compared pair by pair: Hoefler, Belli 2015, section 3.2.
#pragma once

#include <functional>
#include <span>
#include <stop_token>
#include <string_view>
#include <vector>

#include "app/experiment/measured.h"
#include "render/march/marcher.h"

namespace warpscope {

/// An effect that can be there or not, whatever the others are.
struct MeasuredEffect {
  std::string_view name;
  std::string_view example;  ///< what is measured where the scene has none
  bool (*isOn)(const Effects&);
  void (*leaveOut)(Effects&);
  void (*set)(Effects&, const Volume&);  ///< to the example
  std::string_view needs = {};           ///< the effect without which this one does nothing
};

/// Every effect that scenes can ask for: one row each.
std::span<const MeasuredEffect> measuredEffects();

/// Milliseconds.
struct EffectCost {
  const MeasuredEffect* effect = nullptr;
  bool isExample = false;  ///< the scene has none
  Measured alone;          ///< a march with this effect and no other but what it needs
  Measured adds;           ///< what it takes more than one without this one: below 0 where it saves
  Measured leftOut;        ///< a march with all the others
  Measured saves;          ///< what one with all takes more than that
};
struct EffectCosts {
  Measured none, all, allAdd;
  std::vector<EffectCost> effects;
};

/// As many as `onStep` is called.
size_t effectSteps(int runs);

/// `runs` rounds of all these marches after one that does not count. Throws OperationCancelled; InputError where an effect does not change the picture,
/// so that what would be timed is not the effect.
EffectCosts measureEffects(Marcher& marcher, const Camera& camera, const MarchSettings& settings, int runs, const std::function<void()>& onStep,
                           const std::stop_token& stop);

}  // namespace warpscope
