// Transfer functions to begin with: for what is often looked at, and colour maps that are read by everybody.
#pragma once

#include <span>
#include <string_view>

#include "render/core/transfer_function.h"
#include "render/volume/volume.h"

namespace warpscope {

struct TransferPreset {
  std::string_view name;     ///< "CT bone"
  std::string_view summary;  ///< one sentence without its full stop
};

std::span<const TransferPreset> transferPresets();

/// The named preset for values as those. Presets of computed tomography are in Hounsfield units where the values look like some (below -500 and above 500);
/// elsewhere, as all others are, shares of the values' range. Throws UsageError for a name that there is not.
TransferFunction presetFunction(std::string_view name, const VoxelStatistics& statistics);

/// Whether presetFunction() spreads a preset that is in Hounsfield units over the range, because the values look like none.
bool isSpread(std::string_view name, const VoxelStatistics& statistics);

/// Whether values are likely to be Hounsfield units.
bool areHounsfield(const VoxelStatistics& statistics);

}  // namespace warpscope
