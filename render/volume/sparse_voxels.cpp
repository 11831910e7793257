// What is there of each slice, and what is missing.
// See sparse_voxels.h.
#include "render/volume/sparse_voxels.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

#include "render/base/error.h"

namespace warpscope {

SparseVoxels::SparseVoxels(const VolumeGeometry& geometry, VoxelType type, Fill fill, std::string stamp, std::optional<uint32_t> kept)
    : dims_(geometry.dims), sizeBytes_(size_t{dims_.x} * dims_.y * dims_.z * warpscope::sizeBytes(type)), fill_(std::move(fill)), stamp_(std::move(stamp)), present_(dims_.z) {
  void* const memory = mmap(nullptr, sizeBytes_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (memory == MAP_FAILED) throw InputError("no addresses for " + std::to_string(sizeBytes_) + " bytes of voxels: " + std::strerror(errno));
  memory_ = static_cast<std::byte*>(memory);
  if (!kept) return;
  constexpr uint32_t kBeside = 2;  // who looks at pieces of whole cells sees one more, and one of a step's length another
  mostSlices_ = std::min(*kept + kBeside, dims_.z);
  try {
    const size_t sliceBytes = sizeBytes_ / dims_.z;
    const auto bytesAtOnce = [=, slices = dims_.z](uint64_t limit) { return sliceBytes * std::min(slicesAtATime(sliceBytes, slices, limit) + kBeside, slices); };
    droppable_.emplace(memory_, [] {}, bytesAtOnce);  // it lets go by itself
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

namespace {

std::unique_lock<std::mutex> lockUnlessStopped(std::mutex& mutex, const std::stop_token& stop) {
  std::unique_lock lock(mutex, std::try_to_lock);
  while (!lock.owns_lock()) {
    if (stop.stop_requested()) throw OperationCancelled();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));  // slabs take tens of them
    if (lock.try_lock()) break;
  }
  return lock;
}

}  // namespace

std::unique_lock<std::mutex> SparseVoxels::hold(const VoxelRows& rows, const std::stop_token& stop) {
  // In two steps, so that who has just held rows is not the next to while another one waits.
  std::unique_lock next = lockUnlessStopped(next_, stop);
  std::unique_lock lock = lockUnlessStopped(mutex_, stop);
  next.unlock();
  if (mostSlices_) {
    if (const uint32_t slices = rows.upper.y - rows.lower.y; slices > *mostSlices_)
      throw InputError(std::to_string(slices) + " slices of voxels are looked at at once, so long are the steps, and --memory leaves room for " + std::to_string(*mostSlices_));
    releaseBut(rows);
  }
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

namespace {

uint32_t slicesToKeep(const VolumeGeometry& geometry, VoxelType type) {
  return slicesAtATime(uint64_t{geometry.dims.x} * geometry.dims.y * warpscope::sizeBytes(type), geometry.dims.z);
}

}  // namespace

bool isTooLargeToKeep(const VolumeGeometry& geometry, VoxelType type) { return slicesToKeep(geometry, type) < geometry.dims.z; }

VolumePtr makeSparseVolume(std::string name, VoxelType type, const VolumeGeometry& geometry, SparseVoxels::Fill fill, const std::stop_token& stop, RanksPtr ranks,
                           std::string stamp) {
  std::optional<uint32_t> kept;
  if (!ranks && isTooLargeToKeep(geometry, type)) kept = slicesToKeep(geometry, type);
  std::shared_ptr<SparseVoxels> source;
  try {
    source = std::make_shared<SparseVoxels>(geometry, type, std::move(fill), std::move(stamp), kept);
  } catch (const InputError& error) {
    throw InputError(name + ": " + error.what());
  }
  return std::make_shared<Volume>(std::move(name), type, geometry, source, source->voxels(), stop, std::move(ranks), source);
}

}  // namespace warpscope
