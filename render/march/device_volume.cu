// Copying and converting voxels.
// See device_volume.h.
#include "render/march/device_volume.h"

namespace warpscope {
namespace {

/// Voxels that are converted at once: bounds the memory beside the volume's own.
constexpr size_t kChunk = size_t{1} << 24;

template <class Voxel>
__global__ void toUnit(const Voxel* voxels, UnitVoxel* units, size_t count, ValueScale scale) {
  const size_t i = size_t{blockIdx.x} * blockDim.x + threadIdx.x;
  if (i < count) units[i] = {unitFromVoxel(voxels[i], scale)};
}

}  // namespace

DeviceVolume::DeviceVolume(const Volume& volume) : type_(volume.type()), hasHoles_(volume.statistics().nonFinite > 0) {
  const size_t count = volume.voxelCount();
  const cuda::Stream stream;
  visitVoxelType(type_, [&](auto voxelTag) {
    using Voxel = decltype(voxelTag);
    if constexpr (!kNormalizeFirst<Voxel>) {
      bytes_ = cuda::DeviceBuffer<std::byte>(count * sizeof(Voxel));
      WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(bytes_.data(), volume.voxels(), count * sizeof(Voxel), cudaMemcpyHostToDevice, stream));
    } else {
      bytes_ = cuda::DeviceBuffer<std::byte>(count * sizeof(UnitVoxel));
      auto* units = reinterpret_cast<UnitVoxel*>(bytes_.data());
      cuda::DeviceBuffer<Voxel> chunk(count < kChunk ? count : kChunk);
      const ValueScale scale = valueScaleOf(volume.statistics());
      for (size_t first = 0; first < count; first += kChunk) {
        const size_t size = count - first < kChunk ? count - first : kChunk;
        chunk.upload({volume.voxelsAs<Voxel>() + first, size}, stream);
        constexpr unsigned kThreads = 256;
        toUnit<<<cuda::blocksFor(size, kThreads), kThreads, 0, stream>>>(chunk.data(), units + first, size, scale);
        WARPSCOPE_CUDA_CHECK_LAUNCH();
      }
    }
  });
  stream.synchronize();
}

}  // namespace warpscope
