// Value ranges of cells and the distance map over them.
// See macrocells.h. The distance map is the two-pass chamfer of Rosenfeld, Pfaltz 1966, exact for the Chebyshev metric.
#include "render/volume/macrocells.h"

#include <algorithm>
#include <cmath>

#include "render/core/parallel.h"
#include "render/volume/voxel_access.h"

namespace warpscope {

Macrocells::Macrocells(const Volume& volume, const ValueScale& scale) {
  const glm::ivec3 n(volume.dims());
  // Small cells skip more; in large volumes the map over them would take long to make.
  constexpr size_t kLargeVolume = size_t{1} << 27;
  edge_ = volume.voxelCount() < kLargeVolume ? 4 : 8;
  dims_ = (n + edge_ - 1) / edge_;
  ranges_.resize(size_t(dims_.x) * dims_.y * dims_.z);
  visitVoxelType(volume.type(), [&](auto voxelTag) {
    using Voxel = decltype(voxelTag);
    const Voxel* voxels = volume.voxelsAs<Voxel>();
    parallelForRanges(size_t(dims_.y) * dims_.z, 4, [&](size_t begin, size_t end) {
      for (size_t row = begin; row < end; ++row) {
        const int cy = static_cast<int>(row % dims_.y);
        const int cz = static_cast<int>(row / dims_.y);
        for (int cx = 0; cx < dims_.x; ++cx) {
          const glm::ivec3 first = glm::ivec3(cx, cy, cz) * edge_;
          const glm::ivec3 last = glm::min(first + edge_, n - 1);
          bool any = false;
          Voxel lowest = std::numeric_limits<Voxel>::max();
          Voxel highest = std::numeric_limits<Voxel>::lowest();
          for (int z = first.z; z <= last.z; ++z)
            for (int y = first.y; y <= last.y; ++y) {
              const Voxel* line = voxels + (size_t(z) * n.y + y) * n.x;
              for (int x = first.x; x <= last.x; ++x) {
                if (!isFiniteVoxel(line[x])) continue;
                any = true;
                lowest = std::min(lowest, line[x]);
                highest = std::max(highest, line[x]);
              }
            }
          if (any)
            ranges_[row * dims_.x + cx] = {interpolant(lowest, scale), interpolant(highest, scale)};
          else
            ranges_[row * dims_.x + cx] = {1.0f, 0.0f};
        }
      }
    });
  });
}

std::vector<uint8_t> Macrocells::emptyDistances(const TransferTable& table) const {
  // Interpolation may leave a cell's range by its rounding: three blends of two roundings each, and with holes eight products, their sum and a quotient.
  constexpr float kSlack = 0x1p-20f;
  std::vector<uint8_t> distances(ranges_.size());
  for (size_t i = 0; i < ranges_.size(); ++i) {
    const glm::vec2 range = ranges_[i];
    const float slack = range.x < range.y ? kSlack * std::max(std::abs(range.x), std::abs(range.y)) : 0.0f;
    distances[i] = range.x <= range.y && table.anyVisible(range.x - slack, range.y + slack) ? 0 : 255;
  }

  const auto relax = [&](int x, int y, int z, int sign) {
    uint8_t& here = distances[(size_t(z) * dims_.y + y) * dims_.x + x];
    if (here == 0) return;
    int nearest = here;
    // The 13 neighbours that the sweep has passed already.
    for (int dz = -1; dz <= 0; ++dz)
      for (int dy = -1; dy <= (dz < 0 ? 1 : 0); ++dy)
        for (int dx = -1; dx <= (dz < 0 || dy < 0 ? 1 : -1); ++dx) {
          const int nx = x + sign * dx, ny = y + sign * dy, nz = z + sign * dz;
          if (nx < 0 || ny < 0 || nz < 0 || nx >= dims_.x || ny >= dims_.y || nz >= dims_.z) continue;
          nearest = std::min(nearest, distances[(size_t(nz) * dims_.y + ny) * dims_.x + nx] + 1);
        }
    here = static_cast<uint8_t>(nearest);
  };
  for (int z = 0; z < dims_.z; ++z)
    for (int y = 0; y < dims_.y; ++y)
      for (int x = 0; x < dims_.x; ++x) relax(x, y, z, 1);
  for (int z = dims_.z - 1; z >= 0; --z)
    for (int y = dims_.y - 1; y >= 0; --y)
      for (int x = dims_.x - 1; x >= 0; --x) relax(x, y, z, -1);
  return distances;
}

}  // namespace warpscope
