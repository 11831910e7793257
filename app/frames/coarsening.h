// What a server leaves out while the camera moves, and what it says of that.
// The one place that knows which settings give way: who asks compares with it, who marches goes by it.
#pragma once

#include <optional>
#include <string>

#include "render/march/march_settings.h"

namespace warpscope {

/// How many times the step that was asked for may be taken at most. At 8 times 0.5 the thin ones of `vessels` are gone, and the march still takes 43 % of its
/// time (60 % at 4 times): leaping over what is empty does not depend on steps.
inline constexpr double kMostCoarsening = 4.0;

/// What gives way: the step first, and where that is not enough, what takes long besides.
struct Coarsening {
  double factor = 1.0;  ///< on the step; more than kMostCoarsening counts as that
  int leftOut = 0;      ///< groups of effects, the dearest first: 0..mostLeftOut(asked)

  bool operator==(const Coarsening&) const = default;
};

/// How many groups of effects `asked` has that can be left out: shadows, occlusion and pre-integration are one, shading is the next.
int mostLeftOut(const MarchSettings& asked);

/// `asked`, so much coarser. 1 or less, or NaN, as a factor is none.
MarchSettings coarsened(const MarchSettings& asked, const Coarsening& coarsening);

/// What made `marched` of `asked`: nothing of it where they are equal, std::nullopt where something else did.
std::optional<Coarsening> coarseningOf(const MarchSettings& asked, const MarchSettings& marched);

/// Whether `marched` is what coarsened() makes of `asked`, and something else than that.
bool isCoarsened(const MarchSettings& asked, const MarchSettings& marched);

/// "step 1.2 instead of 0.5, without shadows, shading"; empty where nothing differs.
std::string coarseningText(const MarchSettings& asked, const MarchSettings& marched);

}  // namespace warpscope
