// Small volumes in memory for tests, from a function of the voxel's place.
// Every stored type; the volume owns its voxels.
#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <vector>

#include "render/volume/volume.h"

namespace warpscope {

inline constexpr std::array<VoxelType, 8> kAllVoxelTypes{VoxelType::uint8,  VoxelType::int8,  VoxelType::uint16,  VoxelType::int16,
                                                         VoxelType::uint32, VoxelType::int32, VoxelType::float32, VoxelType::float64};

using FieldFunction = std::function<double(const glm::ivec3&)>;

/// A volume of `type` whose voxel at p is value(p), converted.
inline VolumePtr makeTestVolume(VoxelType type, const VolumeGeometry& geometry, const FieldFunction& value) {
  return visitVoxelType(type, [&](auto tag) -> VolumePtr {
    using Voxel = decltype(tag);
    const glm::ivec3 n(geometry.dims);
    auto voxels = std::make_shared<std::vector<Voxel>>();
    voxels->reserve(size_t{geometry.dims.x} * geometry.dims.y * geometry.dims.z);
    for (int z = 0; z < n.z; ++z)
      for (int y = 0; y < n.y; ++y)
        for (int x = 0; x < n.x; ++x) voxels->push_back(static_cast<Voxel>(value({x, y, z})));
    return std::make_shared<Volume>("test", type, geometry, voxels, voxels->data());
  });
}

inline VolumePtr makeTestVolume(VoxelType type, const glm::uvec3& dims, const FieldFunction& value) {
  VolumeGeometry geometry;
  geometry.dims = dims;
  return makeTestVolume(type, geometry, value);
}

/// Values from 0 to 100, which every type holds: soft blobs in empty space, with detail of a voxel's size on them.
inline FieldFunction blobs(const glm::uvec3& dims, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<glm::dvec4> balls;
  for (int i = 0; i < 5; ++i) {
    const double x = unit(random), y = unit(random), z = unit(random);
    balls.push_back({x * dims.x, y * dims.y, z * dims.z, (0.1 + 0.15 * unit(random)) * glm::max(dims.x, glm::max(dims.y, dims.z))});
  }
  return [balls](const glm::ivec3& p) {
    const auto noise = static_cast<double>((static_cast<uint32_t>(p.x) * 73856093u ^ static_cast<uint32_t>(p.y) * 19349663u ^
                                            static_cast<uint32_t>(p.z) * 83492791u) * 2654435761u >> 16) / 65536.0;
    double value = 0.0;
    for (const glm::dvec4& ball : balls) {
      const double inside = 1.0 - glm::length(glm::dvec3(p) - glm::dvec3(ball)) / ball.w;
      if (inside > 0.0) value += 70.0 * inside + 20.0 * noise;
    }
    return std::floor(std::min(value, 100.0));
  };
}

}  // namespace warpscope
