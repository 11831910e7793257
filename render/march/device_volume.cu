// Copying and converting voxels.
// See device_volume.h.
#include "render/march/device_volume.h"

#include <algorithm>
#include <type_traits>

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
  if (wanted > DeviceVolume::kMostCellBytes || wanted > freeBytes / 2) return false;
  bytes = cuda::DeviceBuffer<std::byte>(wanted);
  constexpr unsigned kThreads = 128;
  constexpr unsigned kMostBlocks = 65535;
  const dim3 grid(cuda::blocksFor(cellDims.x, kThreads), std::min<unsigned>(cellDims.y, kMostBlocks), std::min<unsigned>(cellDims.z, kMostBlocks));
  toCells<<<grid, kThreads, 0, stream>>>(voxels, reinterpret_cast<VoxelCell<Voxel>*>(bytes.data()), dims);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  return true;
}

}  // namespace

DeviceVolume::DeviceVolume(const Volume& volume, const ValueScale& scale)
    : type_(volume.type()), dims_(volume.dims()), hasHoles_(volume.statistics().nonFinite > 0) {
  const size_t count = volume.voxelCount();
  const cuda::Stream stream;
  visitVoxelType(type_, [&](auto voxelTag) {
    using Voxel = decltype(voxelTag);
    if constexpr (sizeof(Voxel) <= 2) {
      bytes_ = cuda::DeviceBuffer<std::byte>(count * sizeof(Voxel));
      WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(bytes_.data(), volume.voxels(), count * sizeof(Voxel), cudaMemcpyHostToDevice, stream));
    } else {
      bytes_ = cuda::DeviceBuffer<std::byte>(count * sizeof(InterpolantVoxel));
      auto* values = reinterpret_cast<InterpolantVoxel*>(bytes_.data());
      cuda::DeviceBuffer<Voxel> chunk(count < kChunk ? count : kChunk);
      for (size_t first = 0; first < count; first += kChunk) {
        const size_t size = count - first < kChunk ? count - first : kChunk;
        chunk.upload({volume.voxelsAs<Voxel>() + first, size}, stream);
        constexpr unsigned kThreads = 256;
        toInterpolants<<<cuda::blocksFor(size, kThreads), kThreads, 0, stream>>>(chunk.data(), values + first, size, scale);
        WARPSCOPE_CUDA_CHECK_LAUNCH();
      }
    }
    using Kept = std::conditional_t<(sizeof(Voxel) > 2), InterpolantVoxel, Voxel>;
    cuda::DeviceBuffer<std::byte> cells;
    isInCells_ = makeCells(reinterpret_cast<const Kept*>(bytes_.data()), glm::ivec3(volume.dims()), cells, stream);
    if (isInCells_) {
      stream.synchronize();  // the voxels go
      bytes_ = std::move(cells);
    }
  });
  stream.synchronize();
}

}  // namespace warpscope
