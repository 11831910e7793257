// Ranges a cell a thread; distances axis by axis, both ways of an axis at once.
// See device_octants.h. One-sided Chebyshev distances come apart by axes as those of device_cells.cu do: of x two maps, of y four, of z eight.
#include "render/march/device_octants.h"

#include "render/march/visible_marks.cuh"

namespace warpscope {
namespace {

/// Cells' maps that findDistances() keeps beside the eight: marks, two of x, two of y.
constexpr size_t kScratchMaps = 5;
constexpr size_t kMaps = 8;

/// Beside what the device has free. Throws DeviceError.
bool isLittle(size_t bytes) {
  size_t freeBytes = 0, totalBytes = 0;
  WARPSCOPE_CUDA_CHECK(cudaMemGetInfo(&freeBytes, &totalBytes));
  return bytes <= freeBytes / 4;
}

template <class Voxel>
struct KeptVolume {
  const VoxelCell<Voxel>* cells;  // from -1 along each axis on, or null, if there are
  const Voxel* voxels;
  glm::ivec3 dims;
  ValueScale scale;

  __device__ float at(const glm::ivec3& p) const {
    const auto placeOf = [](const glm::ivec3& at, const glm::ivec3& of) {
      return (static_cast<size_t>(at.z) * static_cast<size_t>(of.y) + static_cast<size_t>(at.y)) * static_cast<size_t>(of.x) + static_cast<size_t>(at.x);
    };
    return interpolant(cells != nullptr ? cells[placeOf(p, dims + 1)].corners[7] : voxels[placeOf(p, dims)], scale);
  }
};

/// As Macrocells finds them.
template <class Voxel>
__global__ void findRanges(const KeptVolume<Voxel> volume, glm::ivec3 cellDims, int edge, size_t count, float* lowest, float* highest) {
  const size_t i = size_t{blockIdx.x} * blockDim.x + threadIdx.x;
  if (i >= count) return;
  const size_t row = static_cast<size_t>(cellDims.x), plane = row * static_cast<size_t>(cellDims.y);
  const glm::ivec3 first = glm::ivec3(static_cast<int>(i % row), static_cast<int>(i % plane / row), static_cast<int>(i / plane)) * edge;
  const glm::ivec3 last = glm::min(first + edge, volume.dims - 1);
  float low = INFINITY, high = -INFINITY;
  for (int z = first.z; z <= last.z; ++z)
    for (int y = first.y; y <= last.y; ++y)
      for (int x = first.x; x <= last.x; ++x) {
        const float value = volume.at({x, y, z});
        if (!(value - value == 0.0f)) continue;
        low = minOf(low, value);
        high = maxOf(high, value);
      }
  const bool any = low <= high;  // else the first is the greater one, which says that there is none
  lowest[i] = any ? low : 1.0f;
  highest[i] = any ? high : 0.0f;
}

/// The least, over the `most` cells that lie `stride` apart the one way and `from` itself, of the greater of the way there and the distance they have: looked
/// for outwards, and no farther than what is found already.
__device__ inline uint8_t nearestAlong(const uint8_t* from, int most, ptrdiff_t stride) {
  int nearest = *from;
  for (int steps = 1; steps < nearest && steps <= most; ++steps) nearest = minOf(nearest, maxOf(steps, static_cast<int>(from[steps * stride])));
  return static_cast<uint8_t>(nearest);
}

/// Along an axis of `length` cells that are `stride` apart, towards its end and towards its beginning.
__global__ void spreadBothWays(const uint8_t* from, uint8_t* onwards, uint8_t* backwards, size_t count, int length, size_t stride) {
  const size_t i = size_t{blockIdx.x} * blockDim.x + threadIdx.x;
  if (i >= count) return;
  const int place = static_cast<int>(i / stride % static_cast<size_t>(length));
  onwards[i] = nearestAlong(from + i, length - 1 - place, static_cast<ptrdiff_t>(stride));
  backwards[i] = nearestAlong(from + i, place, -static_cast<ptrdiff_t>(stride));
}

}  // namespace

DeviceOctants::DeviceOctants(const DeviceVolume& volume, const ValueScale& scale) {
  const glm::ivec3& voxels = volume.dims();
  const auto cellsOfEdge = [&](int bits) { return (voxels + (1 << bits) - 1) >> bits; };
  const auto countOf = [](const glm::ivec3& d) { return static_cast<size_t>(d.x) * static_cast<size_t>(d.y) * static_cast<size_t>(d.z); };
  while (countOf(cellsOfEdge(edgeBits_)) > kMostCells) ++edgeBits_;
  if (!isLittle(countOf(cellsOfEdge(edgeBits_)) * (2 * sizeof(float) + kMaps + kScratchMaps))) return;
  dims_ = cellsOfEdge(edgeBits_);
  lowest_.reserve(count());
  highest_.reserve(count());
  const cuda::Stream stream;
  visitDeviceVoxels(volume, [&]<class Voxel, bool kHasHoles, bool kByCells>() {
    const KeptVolume<Voxel> kept{volume.cellsAs<Voxel>(), volume.voxelsAs<Voxel>(), voxels, scale};
    findRanges<<<cuda::blocksFor(count(), kCellThreads), kCellThreads, 0, stream>>>(kept, dims_, edge(), count(), lowest_.data(), highest_.data());
    WARPSCOPE_CUDA_CHECK_LAUNCH();
  });
  stream.synchronize();
}

bool DeviceOctants::hasRoomFor(const cuda::DeviceBuffer<uint8_t>& distances) const {
  return distances.capacity() >= kMaps * count() || isLittle((kMaps + kScratchMaps) * count());
}

void DeviceOctants::findDistances(const VisibleBins& bins, cuda::DeviceBuffer<uint8_t>& distances, cuda::DeviceBuffer<uint8_t>& scratch,
                                  cudaStream_t stream) const {
  distances.reserve(kMaps * count());
  scratch.reserve(kScratchMaps * count());
  const unsigned blocks = cuda::blocksFor(count(), kCellThreads);
  const size_t row = static_cast<size_t>(dims_.x), plane = row * static_cast<size_t>(dims_.y);
  const auto scratchMap = [&](size_t i) { return scratch.data() + i * count(); };
  const auto spread = [&](const uint8_t* from, uint8_t* onwards, uint8_t* backwards, int length, size_t stride) {
    spreadBothWays<<<blocks, kCellThreads, 0, stream>>>(from, onwards, backwards, count(), length, stride);
    WARPSCOPE_CUDA_CHECK_LAUNCH();
  };
  uint8_t *const marks = scratchMap(0), *const ofX[2] = {scratchMap(1), scratchMap(2)}, *const ofY[2] = {scratchMap(3), scratchMap(4)};
  markVisible<<<blocks, kCellThreads, 0, stream>>>(bins, lowest_.data(), highest_.data(), count(), marks);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  spread(marks, ofX[0], ofX[1], dims_.x, 1);
  for (size_t x = 0; x < 2; ++x) {
    spread(ofX[x], ofY[0], ofY[1], dims_.y, row);
    for (size_t y = 0; y < 2; ++y) {
      uint8_t* const onwards = distances.data() + (x + 2 * y) * count();
      spread(ofY[y], onwards, onwards + 4 * count(), dims_.z, plane);
    }
  }
}

}  // namespace warpscope
