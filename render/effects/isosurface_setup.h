// What is prepared once for pictures of surfaces: values as rays compare them, colours, and which cells hold a surface. Host only.
// See isosurface.h.
#pragma once

#include <cstdint>
#include <vector>

#include "render/core/transfer_function.h"
#include "render/effects/isosurface.h"
#include "render/effects/mode_settings.h"
#include "render/volume/macrocells.h"

namespace warpscope {

/// Values of opacity 0 are left out. Colours are the function's at the values; its opacity does not matter.
IsosurfaceSetup prepareIsosurfaces(const IsoValues& values, const TransferFunction& function, const ValueScale& scale);

/// As Macrocells::emptyDistances, for cells that a surface runs through.
std::vector<uint8_t> surfaceDistances(const Macrocells& cells, const IsosurfaceSetup& setup);

/// Throws UsageError unless there is a value and each lies in the volume's range.
void requireIsoValues(const IsoValues& values, const Volume& volume);

}  // namespace warpscope
