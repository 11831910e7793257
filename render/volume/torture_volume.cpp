// What is in each voxel.
// See torture_volume.h.
#include "render/volume/torture_volume.h"

#include <limits>

#include "render/base/error.h"
#include "render/base/nearest_name.h"
#include "render/volume/procedural_fields.h"

namespace warpscope {
namespace {

using procedural::hash;

template <class Voxel>
constexpr VoxelType typeOf() {
  if constexpr (std::is_same_v<Voxel, uint8_t>) return VoxelType::uint8;
  if constexpr (std::is_same_v<Voxel, uint16_t>) return VoxelType::uint16;
  return VoxelType::float32;
}

VolumeGeometry cubes(const glm::uvec3& dims) {
  VolumeGeometry geometry;
  geometry.dims = dims;
  return geometry;
}

/// Deep boxes of few voxels: a unit is a voxel's edge along z.
VolumeGeometry deepBox() {
  VolumeGeometry geometry = cubes({2, 2, 1000});
  geometry.spacing = {500.0, 500.0, 1.0};
  return geometry;
}

template <class Voxel, class Fill>
VolumePtr filled(std::string_view name, const VolumeGeometry& geometry, const std::stop_token& stop, const Fill& fill) {
  const auto voxels = std::make_shared<std::vector<Voxel>>(size_t{geometry.dims.x} * geometry.dims.y * geometry.dims.z);
  fill(voxels->data());
  const void* first = voxels->data();
  return std::make_shared<Volume>(std::string(name), typeOf<Voxel>(), geometry, std::shared_ptr<const void>(voxels, first),
                                  first, stop);
}

/// Every voxel by `valueAt(x, y, z)`.
template <class Voxel, class F>
VolumePtr byPlace(std::string_view name, const VolumeGeometry& geometry, const std::stop_token& stop, const F& valueAt) {
  return filled<Voxel>(name, geometry, stop, [&](Voxel* voxels) {
    for (uint32_t z = 0; z < geometry.dims.z; ++z)
      for (uint32_t y = 0; y < geometry.dims.y; ++y)
        for (uint32_t x = 0; x < geometry.dims.x; ++x) *voxels++ = valueAt(x, y, z);
  });
}

constexpr uint32_t kSide = 48;

VolumePtr shells(std::string_view name, const VolumeGeometry& geometry, const std::stop_token& stop) {
  return filled<uint8_t>(name, geometry, stop,
                         [&](uint8_t* voxels) { procedural::fillShells(voxels, procedural::Wanted::all(geometry.dims, 1), stop); });
}

/// 1 in the middle of a cube of kSide voxels, falling to 0 at its faces' middles.
float ball(uint32_t x, uint32_t y, uint32_t z) {
  const glm::vec3 place = (glm::vec3(x, y, z) + 0.5f) / (0.5f * kSide) - 1.0f;
  return glm::max(0.0f, 1.0f - glm::length(place));
}

VolumePtr farOrigin(std::string_view name, const std::stop_token& stop) {
  VolumeGeometry geometry = cubes(glm::uvec3(kSide));
  geometry.origin = glm::dvec3(1e7, -1e7, 1e7);
  return shells(name, geometry, stop);
}

VolumePtr tinySpacing(std::string_view name, const std::stop_token& stop) {
  VolumeGeometry geometry = cubes(glm::uvec3(kSide));
  geometry.spacing = glm::dvec3(1e-9);
  return shells(name, geometry, stop);
}

VolumePtr thinSlab(std::string_view name, const std::stop_token& stop) {
  return byPlace<uint8_t>(name, cubes({64, 64, 1}), stop, [](uint32_t, uint32_t, uint32_t) { return uint8_t{50}; });
}

/// Blocks of eight voxels: the label in one of five, its neighbours in number and labels far away in the others.
VolumePtr labelSteps(std::string_view name, const std::stop_token& stop) {
  constexpr uint16_t kLabels[] = {0, 30001, 30000, 30002, 65535};
  return byPlace<uint16_t>(name, cubes(glm::uvec3(kSide)), stop, [&](uint32_t x, uint32_t y, uint32_t z) {
    return kLabels[hash(x / 8 + 16 * (y / 8) + 256 * (z / 8)) % 5];
  });
}

VolumePtr outlier(std::string_view name, const std::stop_token& stop) {
  return byPlace<float>(name, cubes(glm::uvec3(kSide)), stop,
                        [](uint32_t x, uint32_t y, uint32_t z) { return x + y + z == 0 ? -9999.0f : ball(x, y, z); });
}

VolumePtr nanSprinkled(std::string_view name, const std::stop_token& stop) {
  return byPlace<float>(name, cubes(glm::uvec3(kSide)), stop, [](uint32_t x, uint32_t y, uint32_t z) {
    const bool isMissing = hash(x + kSide * (y + kSide * z)) % 100 == 0;
    return isMissing ? std::numeric_limits<float>::quiet_NaN() : ball(x, y, z);
  });
}

VolumePtr grazingPlanes(std::string_view name, const std::stop_token& stop) {
  return byPlace<uint8_t>(name, cubes({96, 33, 96}), stop,
                          [](uint32_t, uint32_t y, uint32_t) { return static_cast<uint8_t>(y % 8 == 0 ? 255 : 0); });
}

VolumePtr longWay(std::string_view name, const std::stop_token& stop) {
  // The wall is seen last from where z grows.
  return byPlace<uint8_t>(name, deepBox(), stop,
                          [](uint32_t, uint32_t, uint32_t z) { return static_cast<uint8_t>(z < 4 ? 255 : 100); });
}

VolumePtr haze(std::string_view name, const std::stop_token& stop) {
  return byPlace<uint8_t>(name, deepBox(), stop, [](uint32_t, uint32_t, uint32_t) { return uint8_t{100}; });
}

}  // namespace

VolumePtr makeTortureVolume(std::string_view name, const std::stop_token& stop) {
  using Make = VolumePtr (*)(std::string_view, const std::stop_token&);
  constexpr Make kMakers[] = {farOrigin, tinySpacing,  thinSlab,      labelSteps, outlier,
                              nanSprinkled, grazingPlanes, longWay, haze};
  static_assert(std::size(kMakers) == kTortureVolumes.size());
  const TortureVolume* known = findNamed(kTortureVolumes, name);
  if (known == nullptr) throw InputError("there is an " + unknownNameIn(kTortureVolumes, "torture volume", name));
  return kMakers[known - kTortureVolumes.data()](name, stop);
}

}  // namespace warpscope
