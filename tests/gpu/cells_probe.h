// A device's empty cells, for tests that have no device code of their own.
// Runs render/march/device_cells.h.
#pragma once

#include "render/volume/macrocells.h"

namespace warpscope {

/// Macrocells::emptyDistances by the device. Throws DeviceError.
std::vector<uint8_t> emptyDistancesOnDevice(const Macrocells& cells, const TransferTable& table);

}  // namespace warpscope
