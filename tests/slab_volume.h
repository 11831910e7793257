// A volume that the limit of memory has no room for, and the same in memory.
#pragma once

#include <optional>

#include "render/base/memory_limit.h"
#include "render/core/parallel.h"
#include "render/volume/kept_slices.h"
#include "render/volume/sparse_voxels.h"

namespace warpscope {

/// Sets a limit, as high as what this process has already asks for, and makes a volume that is too large for it; without the limit the same as a whole.
class SlabVolume {
 public:
  SlabVolume() {
    constexpr uint64_t kMiB = 1 << 20;
    // A volume of two sevenths of the limit, which the process has besides, with slabs of an eighth and pictures.
    limit_ = (residentMemory().bytes * 3 / 2 + 100 * kMiB) * 2;
    geometry_.dims = {kWidth, kHeight, static_cast<uint32_t>(limit_ * 2 / 7 / (kWidth * kHeight))};
    whole_ = make();
    setMemoryLimit(limit_);
    slabs_ = make();
  }
  ~SlabVolume() { setMemoryLimit(std::nullopt); }
  SlabVolume(const SlabVolume&) = delete;
  SlabVolume& operator=(const SlabVolume&) = delete;

  const VolumePtr& whole() const { return whole_; }
  const VolumePtr& slabs() const { return slabs_; }

 private:
  static constexpr uint32_t kWidth = 512, kHeight = 400;

  uint64_t limit_ = 0;
  VolumeGeometry geometry_;
  VolumePtr whole_, slabs_;

  VolumePtr make() const {
    const auto fill = [dims = geometry_.dims](const VoxelRows& rows, std::byte* first, const std::stop_token& stop) {
      parallelForRanges(rows.upper.y - rows.lower.y, 1, stop, [&](size_t begin, size_t end) {
        for (size_t z = rows.lower.y + begin; z < rows.lower.y + end; ++z)
          for (size_t y = rows.lower.x; y < rows.upper.x; ++y)
            for (size_t x = 0; x < dims.x; ++x) first[(z * dims.y + y) * dims.x + x] = static_cast<std::byte>((x * 3 + y * 5) ^ (z / 7));
      });
    };
    return makeSparseVolume("slabs", VoxelType::uint8, geometry_, fill, {}, nullptr);
  }
};

}  // namespace warpscope
