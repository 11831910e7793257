// Copying and converting voxels.
// See device_volume.h.
#include "render/march/device_volume.h"

#include <algorithm>
#include <span>
#include <type_traits>

#include "render/base/memory_limit.h"

namespace warpscope {
namespace {

/// Voxels that are converted at once: bounds the memory beside the volume's own.
constexpr size_t kChunk = size_t{1} << 24;

template <class Voxel>
__global__ void toInterpolants(const Voxel* voxels, InterpolantVoxel* values, size_t count, ValueScale scale) {
  const size_t i = size_t{blockIdx.x} * blockDim.x + threadIdx.x;
  if (i < count) values[i] = {interpolant(voxels[i], scale)};
}

template <class Voxel>
__global__ void toCells(const Voxel* voxels, VoxelCell<Voxel>* cells, glm::ivec3 dims) {
  const glm::ivec3 cellDims = dims + 1;
  const int x = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x);
  if (x >= cellDims.x) return;
  for (int z = static_cast<int>(blockIdx.z); z < cellDims.z; z += static_cast<int>(gridDim.z))
    for (int y = static_cast<int>(blockIdx.y); y < cellDims.y; y += static_cast<int>(gridDim.y))
      cells[(size_t(z) * cellDims.y + y) * cellDims.x + x] = voxelCellAt(voxels, dims, glm::ivec3(x, y, z) - 1);
}

/// The volume in cells, if the device has room for them beside the voxels and for what else it is to do.
template <class Voxel>
bool makeCells(const Voxel* voxels, const glm::ivec3& dims, cuda::DeviceBuffer<std::byte>& bytes, cudaStream_t stream) {
  const glm::ivec3 cellDims = dims + 1;
  const size_t wanted = size_t(cellDims.x) * cellDims.y * cellDims.z * sizeof(VoxelCell<Voxel>);
  size_t freeBytes = 0, totalBytes = 0;
  WARPSCOPE_CUDA_CHECK(cudaMemGetInfo(&freeBytes, &totalBytes));
  if (wanted > DeviceVolume::kMostCellBytes || wanted > freeBytes / 2 || wanted > deviceMemoryLimit().value_or(wanted)) return false;
  bytes = cuda::DeviceBuffer<std::byte>(wanted);
  constexpr unsigned kThreads = 128;
  constexpr unsigned kMostBlocks = 65535;
  const dim3 grid(cuda::blocksFor(cellDims.x, kThreads), std::min<unsigned>(cellDims.y, kMostBlocks), std::min<unsigned>(cellDims.z, kMostBlocks));
  toCells<<<grid, kThreads, 0, stream>>>(voxels, reinterpret_cast<VoxelCell<Voxel>*>(bytes.data()), dims);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  return true;
}

template <class Voxel>
using Kept = std::conditional_t<(sizeof(Voxel) > 2), InterpolantVoxel, Voxel>;

/// Voxels [first, end) of the volume into their places behind `to`, its first one's. `scratch`: used where they have to be converted. Waits for what it copies from
/// memory that is not page-locked.
template <class Voxel>
void copyVoxels(const Volume& volume, const ValueScale& scale, size_t first, size_t end, std::byte* to, cuda::DeviceBuffer<std::byte>& scratch, cudaStream_t stream) {
  const Voxel* const voxels = volume.voxelsAs<Voxel>();
  for (; first < end; first += kChunk) {
    const size_t size = std::min(end - first, kChunk);
    keepWithinMemoryLimit();
    if constexpr (sizeof(Voxel) <= 2) {
      WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(to + first * sizeof(Voxel), voxels + first, size * sizeof(Voxel), cudaMemcpyHostToDevice, stream));
    } else {
      auto* const values = reinterpret_cast<InterpolantVoxel*>(to);
      scratch.upload(std::as_bytes(std::span(voxels + first, size)), stream);
      constexpr unsigned kThreads = 256;
      toInterpolants<<<cuda::blocksFor(size, kThreads), kThreads, 0, stream>>>(reinterpret_cast<const Voxel*>(scratch.data()), values + first, size, scale);
      WARPSCOPE_CUDA_CHECK_LAUNCH();
    }
  }
}

}  // namespace

int slicesOnDevice(const Volume& volume) {
  size_t freeBytes = 0, totalBytes = 0;
  WARPSCOPE_CUDA_CHECK(cudaMemGetInfo(&freeBytes, &totalBytes));
  size_t room = std::min(freeBytes, totalBytes / 10 * 9);
  room = static_cast<size_t>(std::min<uint64_t>(room, deviceMemoryLimit().value_or(room)));
  const size_t slice = size_t{volume.dims().x} * volume.dims().y * bytesOnDevice(volume.type());
  return static_cast<int>(std::min<size_t>(room / slice, volume.dims().z));
}

size_t bytesOnDevice(VoxelType type) {
  size_t bytes = 0;
  visitVoxelType(type, [&](auto voxelTag) { bytes = sizeof(Kept<decltype(voxelTag)>); });
  return bytes;
}

DeviceVolume::DeviceVolume(const Volume& volume, const ValueScale& scale)
    : type_(volume.type()), dims_(volume.dims()), hasHoles_(volume.statistics().nonFinite > 0), bytes_(volume.voxelCount() * bytesOnDevice(volume.type())) {
  const cuda::Stream stream;
  cuda::DeviceBuffer<std::byte> scratch;
  visitVoxelType(type_, [&](auto voxelTag) {
    using Voxel = decltype(voxelTag);
    copyVoxels<Voxel>(volume, scale, 0, volume.voxelCount(), bytes_.data(), scratch, stream);
    cuda::DeviceBuffer<std::byte> cells;
    isInCells_ = makeCells(reinterpret_cast<const Kept<Voxel>*>(bytes_.data()), glm::ivec3(volume.dims()), cells, stream);
    if (isInCells_) {
      stream.synchronize();  // the voxels go
      bytes_ = std::move(cells);
    }
  });
  stream.synchronize();
}

DeviceBrick::DeviceBrick(VolumePtr volume, const ValueScale& scale)
    : volume_(std::move(volume)), scale_(scale), memory_(volume_->voxelCount() * bytesOnDevice(volume_->type())), rows_(volume_->dims().z) {}

void DeviceBrick::provide(const VoxelRows& rows) {
  const Rows wanted(rows.lower.x, rows.upper.x);
  const bool isAny = wanted.first < wanted.second;
  size_t needed = 0, others = 0;
  for (uint32_t z = 0; z < rows_.size(); ++z) {
    const bool isIn = isAny && rows.lower.y <= z && z < rows.upper.y;
    const Rows own = isIn ? wanted : Rows{}, has = rows_[z];
    needed += own.second - own.first;
    others += has.second - has.first - std::max(0, static_cast<int>(std::min(own.second, has.second)) - static_cast<int>(std::max(own.first, has.first)));
  }
  const auto forget = [&] {
    memory_.release();
    rows_.assign(rows_.size(), {});
  };
  if (4 * others > needed) forget();
  try {
    if (isAny && wanted.first == 0 && wanted.second == volume_->dims().y) {  // one piece of memory instead of one a slice
      const size_t slice = size_t{volume_->dims().x} * volume_->dims().y * bytesOnDevice(type());
      memory_.back(rows.lower.y * slice, rows.upper.y * slice);
    }
    for (uint32_t z = rows.lower.y; isAny && z < rows.upper.y; ++z) {
      Rows& has = rows_[z];
      if (has.second < wanted.first || wanted.second < has.first || has.first == has.second) {  // what lies between is not asked for, nor is it there
        copy(z, wanted);
        has = wanted;
        continue;
      }
      if (wanted.first < has.first) copy(z, {wanted.first, has.first});
      if (has.second < wanted.second) copy(z, {has.second, wanted.second});
      has = {std::min(has.first, wanted.first), std::max(has.second, wanted.second)};
    }
    stream_.synchronize();
  } catch (...) {
    cudaStreamSynchronize(stream_);
    forget();
    throw;
  }
}

void DeviceBrick::copy(uint32_t slice, const Rows& rows) {
  const glm::uvec3& dims = volume_->dims();
  const size_t begin = (size_t{slice} * dims.y + rows.first) * dims.x, end = (size_t{slice} * dims.y + rows.second) * dims.x, each = bytesOnDevice(type());
  memory_.back(begin * each, end * each);
  visitVoxelType(type(), [&](auto voxelTag) { copyVoxels<decltype(voxelTag)>(*volume_, scale_, begin, end, memory_.data(), scratch_, stream_); });
}

}  // namespace warpscope
