// What a server leaves out while the camera moves, and what it says of that.
// The one place that knows which settings give way: who asks compares with it, who marches goes by it.
#pragma once

#include <string>

#include "render/march/march_settings.h"

namespace warpscope {

/// How many times the step that was asked for may be taken at most. At 8 times 0.5 the thin ones of `vessels` are gone, and the march still takes 43 % of its
/// time (60 % at 4 times): leaping over what is empty does not depend on steps.
inline constexpr double kMostCoarsening = 4.0;

/// `asked` for a march that takes about a `factor`-th of the time; 1 or less: as it was asked for. More than kMostCoarsening counts as that.
MarchSettings coarsened(const MarchSettings& asked, double factor);

/// The factor that made `marched` of `asked`; 1 where they are equal, and where nothing of the sort did.
double coarseningOf(const MarchSettings& asked, const MarchSettings& marched);

/// Whether `marched` is what coarsened() makes of `asked`, and something else than that.
bool isCoarsened(const MarchSettings& asked, const MarchSettings& marched);

/// "step 1.2 instead of 0.5"; empty where nothing differs.
std::string coarseningText(const MarchSettings& asked, const MarchSettings& marched);

}  // namespace warpscope
