// Values along a ray.
// See ray_trace.h; the march itself is marcher_cpu.cpp's.
#include "render/march/ray_trace.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/base/error.h"
#include "render/base/input_file.h"
#include "render/volume/kept_slices.h"
#include "render/volume/voxel_access.h"

namespace warpscope {
namespace {

template <class Voxel>
double interpolated(const Voxel* voxels, const glm::uvec3& dims, const int (&index)[3], const float (&weight)[3]) {
  double sum = 0.0;
  for (uint32_t corner = 0; corner < 8; ++corner) {
    double share = 1.0;
    size_t place = 0, stride = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const bool isUpper = (corner >> axis & 1) != 0;
      share *= isUpper ? static_cast<double>(weight[axis]) : 1.0 - static_cast<double>(weight[axis]);
      place += stride * std::min(static_cast<uint32_t>(index[axis]) + (isUpper ? 1u : 0u), dims[axis] - 1);
      stride *= dims[axis];
    }
    if (share > 0.0) sum += share * static_cast<double>(voxels[place]);
  }
  return std::isfinite(sum) ? sum : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

void requireWholeRays(const Volume& volume) {
  if (slicesKept(volume) == volume.dims().z) return;
  constexpr uint64_t kMebibyte = 1 << 20;
  throw InputError(volume.name() + ": a ray is looked at as a whole, for which --memory is to be at least " +
                   std::to_string((limitForAll(volume.sizeBytes()) + kMebibyte - 1) / kMebibyte) + " (MiB); " + sizeText(*memoryLimit()) + " are too few");
}

std::vector<RayPlace> placesAlong(const Volume& volume, const TransferFunction& transferFunction, const Ray& ray, float begin, float end, float step) {
  std::vector<RayPlace> places;
  if (!(end > begin)) return places;
  const double length = static_cast<double>(end) - static_cast<double>(begin);
  const auto count = static_cast<size_t>(std::clamp(length / static_cast<double>(step) + 1.0, 2.0, static_cast<double>(kMostRayPlaces)));
  places.resize(count);
  const glm::vec3 lower = volume.bounds().lower, voxelsPerUnit = 1.0f / volume.geometry().voxelEdges();
  AxisEnds ends[3];
  for (int axis = 0; axis < 3; ++axis) ends[axis] = axisEndsOf(static_cast<int>(volume.dims()[axis]));
  visitVoxelType(volume.type(), [&](auto voxelTag) {
    using Voxel = decltype(voxelTag);
    const Voxel* voxels = volume.voxelsAs<Voxel>();
    for (size_t i = 0; i < count; ++i) {
      RayPlace& place = places[i];
      place.t = static_cast<float>(static_cast<double>(begin) + length * (static_cast<double>(i) / static_cast<double>(count - 1)));
      int index[3];
      float weight[3];
      for (int axis = 0; axis < 3; ++axis) {
        const float at = (ray.origin[axis] + place.t * ray.direction[axis] - lower[axis]) * voxelsPerUnit[axis] - 0.5f;
        axisCell(at, ends[axis], index[axis], weight[axis]);
      }
      place.value = interpolated(voxels, volume.dims(), index, weight);
      if (std::isfinite(place.value)) place.look = transferFunction.at(place.value);
    }
  });
  return places;
}

}  // namespace warpscope
