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
  /// `kept`: how many slices are looked at at once where there is no room for all (kept_slices.h), so that hold() lets go of others; nothing: all. Throws InputError where the
  /// limit of memory has no room for those.
  SparseVoxels(const VolumeGeometry& geometry, VoxelType type, Fill fill, std::string stamp = "", std::optional<uint32_t> kept = {});
  ~SparseVoxels() override;
  SparseVoxels(const SparseVoxels&) = delete;
  SparseVoxels& operator=(const SparseVoxels&) = delete;

  const void* voxels() const { return memory_; }

  void provide(const VoxelRows& rows, const std::stop_token& stop) override;
  /// Throws InputError where rows are of clearly more slices than are to be kept.
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
  std::optional<uint32_t> mostSlices_;
  std::optional<Droppable> droppable_;
  std::mutex mutex_;  // held by who holds rows
  std::mutex next_;   // by who is the next to

  /// Lets go of whole slices that are not among these.
  void releaseBut(const VoxelRows& rows);
};

/// Whether the limit of memory has no room for all of such a volume, so that it is better made by rows.
bool isTooLargeToKeep(const VolumeGeometry& geometry, VoxelType type);

/// A volume of which voxels are made so; arguments as Volume's and SparseVoxels'. Without ranks, one that isTooLargeToKeep(). Throws as they do.
VolumePtr makeSparseVolume(std::string name, VoxelType type, const VolumeGeometry& geometry, SparseVoxels::Fill fill, const std::stop_token& stop, RanksPtr ranks,
                           std::string stamp = "");

}  // namespace warpscope
