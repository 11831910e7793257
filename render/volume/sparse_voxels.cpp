// What is there of each slice, and what is missing.
// See sparse_voxels.h.
#include "render/volume/sparse_voxels.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "render/base/error.h"

namespace warpscope {

SparseVoxels::SparseVoxels(const VolumeGeometry& geometry, VoxelType type, Fill fill, std::string stamp, bool isDroppable)
    : dims_(geometry.dims), sizeBytes_(size_t{dims_.x} * dims_.y * dims_.z * warpscope::sizeBytes(type)), fill_(std::move(fill)), stamp_(std::move(stamp)), present_(dims_.z) {
  void* const memory = mmap(nullptr, sizeBytes_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (memory == MAP_FAILED) throw InputError("no addresses for " + std::to_string(sizeBytes_) + " bytes of voxels: " + std::strerror(errno));
  memory_ = static_cast<std::byte*>(memory);
  if (!isDroppable) return;
  try {
    const size_t sliceBytes = sizeBytes_ / dims_.z;
    droppable_.emplace(memory_, nullptr, sliceBytes * slicesAtATime(sliceBytes, dims_.z));
  } catch (...) {
    munmap(memory_, sizeBytes_);
    throw;
  }
}

SparseVoxels::~SparseVoxels() { munmap(memory_, sizeBytes_); }

void SparseVoxels::provide(const VoxelRows& rows, const std::stop_token& stop) {
  // Slices in which the same rows are missing are filled together.
  const auto missingIn = [&](uint32_t z) -> VoxelRows {
    const auto& [first, end] = present_[z];
    VoxelRows missing{{rows.lower.x, z}, {rows.upper.x, z + 1}};
    if (first >= end || missing.lower.x > end || missing.upper.x < first) return missing;  // nothing, or apart: what was there is forgotten
    if (missing.lower.x >= first) missing.lower.x = std::min(end, missing.upper.x);
    if (missing.upper.x <= end) missing.upper.x = std::max(first, missing.lower.x);
    return missing;  // on one side, none, or, where it lies around what is there, all
  };
  for (uint32_t z = rows.lower.y; z < rows.upper.y;) {
    VoxelRows missing = missingIn(z);
    uint32_t end = z + 1;
    for (; end < rows.upper.y; ++end) {
      const VoxelRows next = missingIn(end);
      if (next.lower.x != missing.lower.x || next.upper.x != missing.upper.x) break;
    }
    missing.upper.y = end;
    if (missing.lower.x < missing.upper.x) fill_(missing, memory_, stop);
    for (; z < end; ++z) {
      auto& [first, last] = present_[z];
      if (first >= last || rows.lower.x > last || rows.upper.x < first)
        present_[z] = {rows.lower.x, rows.upper.x};
      else
        present_[z] = {std::min(first, rows.lower.x), std::max(last, rows.upper.x)};
    }
  }
}

std::unique_lock<std::mutex> SparseVoxels::hold(const VoxelRows& rows, const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  if (droppable_) releaseBut(rows);
  provide(rows, stop);
  return lock;
}

void SparseVoxels::releaseBut(const VoxelRows& rows) {
  const size_t page = static_cast<size_t>(sysconf(_SC_PAGESIZE)), sliceBytes = sizeBytes_ / dims_.z;
  const size_t begin = rows.lower.y * sliceBytes / page * page, end = (rows.upper.y * sliceBytes + page - 1) / page * page;  // pages are others' as well there
  madvise(memory_, begin, MADV_DONTNEED);
  if (end < sizeBytes_) madvise(memory_ + end, sizeBytes_ - end, MADV_DONTNEED);
  for (uint32_t z = 0; z < dims_.z; ++z)
    if (z < rows.lower.y || z >= rows.upper.y) present_[z] = {};
}

void SparseVoxels::release() {
  madvise(memory_, sizeBytes_, MADV_DONTNEED);  // reads as zeros from now on
  std::ranges::fill(present_, std::pair<uint32_t, uint32_t>{});
}

bool areTooManyToKeep(uint64_t bytes) {
  const std::optional<uint64_t> limit = memoryLimit();
  return limit && bytes > *limit / 2;
}

VolumePtr makeSparseVolume(std::string name, VoxelType type, const VolumeGeometry& geometry, SparseVoxels::Fill fill, const std::stop_token& stop, RanksPtr ranks,
                           std::string stamp) {
  const auto source = std::make_shared<SparseVoxels>(geometry, type, std::move(fill), std::move(stamp), ranks == nullptr);
  return std::make_shared<Volume>(std::move(name), type, geometry, source, source->voxels(), stop, std::move(ranks), source);
}

}  // namespace warpscope
