// Voxels of which this process has those that were asked for: memory for all of them is reserved, which costs nothing until it is written to.
// mmap(2) with MAP_NORESERVE, madvise(2) with MADV_DONTNEED.
#pragma once

#include <cstddef>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "render/base/memory_limit.h"
#include "render/volume/volume.h"

namespace warpscope {

class SparseVoxels final : public VoxelSource {
 public:
  /// Writes the voxels of some rows into their places; `voxels` is where the volume's first one is.
  using Fill = std::function<void(const VoxelRows& rows, std::byte* voxels, const std::stop_token& stop)>;

  /// Reserves addresses for the volume. `stamp`: as VoxelSource's. Throws InputError where there are none.
  /// `isDroppable`: no more slices are kept than the limit of memory has room for (kept_slices.h), where rows are asked for by hold().
  SparseVoxels(const VolumeGeometry& geometry, VoxelType type, Fill fill, std::string stamp = "", bool isDroppable = false);
  ~SparseVoxels() override;
  SparseVoxels(const SparseVoxels&) = delete;
  SparseVoxels& operator=(const SparseVoxels&) = delete;

  const void* voxels() const { return memory_; }

  void provide(const VoxelRows& rows, const std::stop_token& stop) override;
  std::unique_lock<std::mutex> hold(const VoxelRows& rows, const std::stop_token& stop) override;
  void release() override;
  std::string stamp() const override { return stamp_; }

 private:
  const glm::uvec3 dims_;
  const size_t sizeBytes_;
  const Fill fill_;
  const std::string stamp_;
  std::byte* memory_ = nullptr;
  std::vector<std::pair<uint32_t, uint32_t>> present_;  // of each slice, rows [first, second) that are there
  std::optional<Droppable> droppable_;
  std::mutex mutex_;  // held by who holds rows

  /// Lets go of whole slices that are not among these.
  void releaseBut(const VoxelRows& rows);
};

/// Whether so many bytes of voxels are more than half of the limit of memory, of which pictures take the rest: voxels that can be made by rows are better not kept then.
bool areTooManyToKeep(uint64_t bytes);

/// A volume of which voxels are made so; arguments as Volume's and SparseVoxels'. Without ranks, one that is droppable. Throws as it does.
VolumePtr makeSparseVolume(std::string name, VoxelType type, const VolumeGeometry& geometry, SparseVoxels::Fill fill, const std::stop_token& stop, RanksPtr ranks,
                           std::string stamp = "");

}  // namespace warpscope
