// Copying and converting voxels.
// See device_volume.h.
#include "render/march/device_volume.h"

#include <algorithm>
#include <span>
#include <type_traits>

#include "render/base/error.h"
#include "render/volume/kept_slices.h"

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

/// Voxels of the volume, from the first on.
struct VoxelSpan {
  size_t first = 0, end = 0;
};

/// These voxels into their places behind `to`, the first one's. Waits until they are there. Throws DeviceError, OperationCancelled if `stop` is set.
template <class Voxel>
void copyVoxels(const Volume& volume, const ValueScale& scale, std::span<const VoxelSpan> spans, std::byte* to, cuda::StagedCopy& copy, const std::stop_token& stop) {
  const auto onChunk = [&] {
    keepWithinMemoryLimit();
    if (stop.stop_requested()) throw OperationCancelled();
  };
  const Voxel* const voxels = volume.voxelsAs<Voxel>();
  if constexpr (sizeof(Voxel) <= 2) {
    std::vector<cuda::CopiedRange> ranges;
    for (const auto& [first, end] : spans)
      ranges.push_back({reinterpret_cast<const std::byte*>(voxels + first), to + first * sizeof(Voxel), (end - first) * sizeof(Voxel)});
    copy.copy(ranges, onChunk);
  } else {
    const cuda::Stream stream;
    cuda::DeviceBuffer<Voxel> chunk;
    auto* const values = reinterpret_cast<InterpolantVoxel*>(to);
    for (const auto& [begin, end] : spans)
      for (size_t first = begin; first < end; first += kChunk) {
        const size_t size = std::min(end - first, kChunk);
        onChunk();
        chunk.upload(std::span(voxels + first, size), stream);
        constexpr unsigned kThreads = 256;
        toInterpolants<<<cuda::blocksFor(size, kThreads), kThreads, 0, stream>>>(chunk.data(), values + first, size, scale);
        WARPSCOPE_CUDA_CHECK_LAUNCH();
      }
    stream.synchronize();
  }
}

}  // namespace

size_t roomOnDevice() {
  size_t freeBytes = 0, totalBytes = 0;
  WARPSCOPE_CUDA_CHECK(cudaMemGetInfo(&freeBytes, &totalBytes));
  // Frames, tables, rays under way.
  const size_t reserve = std::min(size_t{1} << 30, totalBytes / 8), own = freeBytes / static_cast<size_t>(deviceSharers());
  const size_t room = own > reserve ? own - reserve : 0;
  return static_cast<size_t>(std::min<uint64_t>(room, deviceMemoryLimit().value_or(room)));
}

int slicesOnDevice(const Volume& volume) {
  const size_t room = roomOnDevice(), slice = size_t{volume.dims().x} * volume.dims().y * bytesOnDevice(volume.type());
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
  cuda::StagedCopy copy;
  visitVoxelType(type_, [&](auto voxelTag) {
    using Voxel = decltype(voxelTag);
    forKeptVoxels(volume, {}, [&](size_t first, size_t end) {
      const VoxelSpan kept{first, end};
      copyVoxels<Voxel>(volume, scale, std::span(&kept, 1), bytes_.data(), copy, {});
    });
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
    : volume_(std::move(volume)), scale_(scale), roomBytes_(roomOnDevice()), memory_(volume_->voxelCount() * bytesOnDevice(volume_->type())), rows_(volume_->dims().z) {}

void DeviceBrick::forget() {
  memory_.release();
  rows_.assign(rows_.size(), {});
  lostRows_ = 0;
}

void DeviceBrick::provide(const VoxelRows& rows, const std::stop_token& stop) {
  const Rows wanted(rows.lower.x, std::max(rows.lower.x, rows.upper.x));
  size_t needed = 0, others = lostRows_;
  for (uint32_t z = 0; z < rows_.size(); ++z) {
    const Rows own = rows.lower.y <= z && z < rows.upper.y ? wanted : Rows{}, has = rows_[z];
    needed += own.second - own.first;
    others += has.second - has.first - std::max(0, static_cast<int>(std::min(own.second, has.second)) - static_cast<int>(std::max(own.first, has.first)));
  }
  const size_t rowBytes = volume_->dims().x * bytesOnDevice(type());
  if (4 * others > needed || (others > 0 && (needed + others) * rowBytes > roomBytes_)) forget();
  const bool hasOthers = memory_.backedBytes() > 0;
  try {
    try {
      addMissing(rows, stop);
    } catch (const DeviceError&) {
      if (!hasOthers) throw;
      cudaDeviceSynchronize();
      forget();  // they may be what there was too little room beside
      addMissing(rows, stop);
    }
  } catch (...) {
    cudaDeviceSynchronize();  // copies may be on their way
    forget();
    throw;
  }
}

void DeviceBrick::addMissing(const VoxelRows& rows, const std::stop_token& stop) {
  const Rows wanted(rows.lower.x, rows.upper.x);
  if (wanted.first >= wanted.second) return;
  const size_t row = volume_->dims().x, slice = row * volume_->dims().y, each = bytesOnDevice(type());
  if (wanted.first == 0 && wanted.second == volume_->dims().y)  // one piece of memory instead of one a slice
    memory_.back(rows.lower.y * slice * each, rows.upper.y * slice * each);
  std::vector<VoxelSpan> missing;
  for (uint32_t z = rows.lower.y; z < rows.upper.y; ++z) {
    Rows& has = rows_[z];
    const auto want = [&](uint32_t first, uint32_t second) {
      if (first >= second) return;
      missing.push_back({z * slice + first * row, z * slice + second * row});
      memory_.back(missing.back().first * each, missing.back().end * each);
    };
    // Where nothing of it is there, or another part, what lies between is not asked for, nor is it there.
    if (has.second < wanted.first || wanted.second < has.first || has.first == has.second) {
      lostRows_ += has.second - has.first;
      has = {wanted.first, wanted.first};
    }
    want(wanted.first, std::min(has.first, wanted.second));
    want(std::max(has.second, wanted.first), wanted.second);
    has = {std::min(has.first, wanted.first), std::max(has.second, wanted.second)};
  }
  visitVoxelType(type(), [&](auto voxelTag) { copyVoxels<decltype(voxelTag)>(*volume_, scale_, missing, memory_.data(), copy_, stop); });
}

}  // namespace warpscope
