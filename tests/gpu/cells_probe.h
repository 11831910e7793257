// A device's empty cells, for tests that have no device code of their own.
// Runs render/march/device_cells.h and device_octants.h.
#pragma once

#include "render/volume/macrocells.h"

namespace warpscope {

/// Macrocells::emptyDistances by the device. Throws DeviceError.
std::vector<uint8_t> emptyDistancesOnDevice(const Macrocells& cells, const TransferTable& table);

/// What render/march/device_octants.h finds of a volume.
struct OctantMaps {
  glm::ivec3 dims;
  int edge;
  bool isOfCells;  ///< the device keeps the volume so
  std::vector<uint8_t> distances;
};
/// Throws DeviceError.
OctantMaps octantsOnDevice(const Volume& volume, const ValueScale& scale, const TransferTable& table);

}  // namespace warpscope
