// A volume without what a mask hides.
// See masked_volume.h.
#include "render/volume/masked_volume.h"

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "render/base/error.h"
#include "render/base/memory.h"
#include "render/core/parallel.h"
#include "render/volume/kept_slices.h"

namespace warpscope {
namespace {

std::string sizeText(const Volume& volume) {
  const glm::uvec3& dims = volume.dims();
  return std::to_string(dims.x) + "x" + std::to_string(dims.y) + "x" + std::to_string(dims.z) + " voxels";
}

void requireSamePlace(const Volume& volume, const Volume& mask) {
  const std::string both = "the mask " + mask.name() + " and the volume " + volume.name();
  if (volume.dims() != mask.dims()) throw InputError(both + " differ in size: " + sizeText(mask) + " and " + sizeText(volume));
  const VolumeGeometry &a = volume.geometry(), &b = mask.geometry();
  if (!a.hasOrientation || !b.hasOrientation) return;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 index = glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2) * (glm::dvec3(a.dims) - 1.0);
    const auto placeIn = [&](const VolumeGeometry& geometry) { return geometry.origin + geometry.direction * (geometry.spacing * index); };
    if (glm::length(placeIn(a) - placeIn(b)) > 0.1 * a.unit()) throw InputError(both + " lie in different places");
  }
}

constexpr size_t kVoxelsAtOnce = 1u << 16;

/// Calls `body` with a typed pointer to the volume's voxels, for ranges of them in parallel.
template <class Body>
void forVoxels(const Volume& volume, const std::stop_token& stop, const Body& body) {
  visitVoxelType(volume.type(), [&](auto voxelTag) {
    const auto* const voxels = volume.voxelsAs<decltype(voxelTag)>();
    forKeptVoxels(volume, stop, [&](size_t first, size_t last) {
      parallelForRanges(last - first, kVoxelsAtOnce, stop, [&](size_t begin, size_t end) {
        for (size_t i = first + begin; i < first + end; ++i) body(i, voxels[i]);
      });
    });
  });
}

template <class Kept>
VolumePtr maskedAs(VoxelType type, const Volume& volume, const Volume& mask, const std::stop_token& stop) {
  requireMemory(volume.voxelCount() * (sizeof(Kept) + 1), "the volume " + volume.name() + " under a mask");
  std::vector<uint8_t> isKept(mask.voxelCount());
  forVoxels(mask, stop, [&](size_t i, auto mark) { isKept[i] = mark == mark && mark != decltype(mark)(0); });
  auto kept = std::make_shared<std::vector<Kept>>(volume.voxelCount());
  forVoxels(volume, stop, [&](size_t i, auto voxel) { (*kept)[i] = isKept[i] ? static_cast<Kept>(voxel) : std::numeric_limits<Kept>::quiet_NaN(); });
  const void* const voxels = kept->data();
  auto result = std::make_shared<const Volume>(volume.name(), type, volume.geometry(), std::move(kept), voxels, stop);
  if (result->statistics().nonFinite == result->voxelCount())
    throw InputError("the mask " + mask.name() + " leaves nothing of the volume " + volume.name() + ": where it is not 0 there is no value");
  return result;
}

}  // namespace

VolumePtr masked(const Volume& volume, const Volume& mask, const std::stop_token& stop) {
  requireSamePlace(volume, mask);
  switch (volume.type()) {
    case VoxelType::uint32:
    case VoxelType::int32:
    case VoxelType::float64: return maskedAs<double>(VoxelType::float64, volume, mask, stop);
    default: return maskedAs<float>(VoxelType::float32, volume, mask, stop);
  }
}

}  // namespace warpscope
