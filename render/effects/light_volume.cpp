// Where the places are.
// See light_volume.h.
#include "render/effects/light_volume.h"

#include <cmath>

namespace warpscope {

LightVolume lightVolumeLayout(const glm::uvec3& dims, int channels, float edge) {
  LightVolume volume;
  volume.channels = channels;
  for (;; edge += 1.0f) {
    volume.edge = edge;
    for (int axis = 0; axis < 3; ++axis) volume.dims[axis] = static_cast<int>(std::ceil(static_cast<double>(dims[axis] - 1) / static_cast<double>(edge))) + 1;
    if (volume.places() * static_cast<size_t>(channels) * sizeof(uint16_t) <= LightVolume::kMostBytes) break;
  }
  volume.perVoxel = 1.0f / volume.edge;
  for (int axis = 0; axis < 3; ++axis) volume.ends[axis] = axisEndsOf(volume.dims[axis]);
  return volume;
}

}  // namespace warpscope
