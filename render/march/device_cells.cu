// A cell a thread: what it shows, then the distances axis by axis.
// See device_cells.h. The Chebyshev distance is the least, over the cells along one axis, of the greater of the way
// there and the distance within the other axes (as Saito, Toriwaki 1994, for squared Euclidean ones): looked for
// outwards, and no farther than what is found already.
#include "render/march/device_cells.h"

#include "render/march/visible_marks.cuh"

namespace warpscope {
namespace {

/// Along an axis of `length` cells that are `stride` apart.
__global__ void spreadAlong(const uint8_t* from, uint8_t* to, size_t count, int length, size_t stride) {
  const size_t i = size_t{blockIdx.x} * blockDim.x + threadIdx.x;
  if (i >= count) return;
  const int place = static_cast<int>(i / stride % static_cast<size_t>(length));
  const int before = place, behind = length - 1 - place;
  const int most = maxOf(before, behind);
  int nearest = from[i];
  for (int steps = 1; steps < nearest && steps <= most; ++steps) {
    const size_t way = static_cast<size_t>(steps) * stride;
    if (steps <= before) nearest = minOf(nearest, maxOf(steps, static_cast<int>(from[i - way])));
    if (steps <= behind) nearest = minOf(nearest, maxOf(steps, static_cast<int>(from[i + way])));
  }
  to[i] = static_cast<uint8_t>(nearest);
}

}  // namespace

DeviceCells::DeviceCells(const Macrocells& cells) : dims_(cells.dims()) {
  const cuda::Stream stream;
  lowest_.upload({cells.lowest(), count()}, stream);
  highest_.upload({cells.highest(), count()}, stream);
  stream.synchronize();
}

void DeviceCells::findDistances(const VisibleBins& bins, cuda::DeviceBuffer<uint8_t>& distances,
                                cuda::DeviceBuffer<uint8_t>& scratch, cudaStream_t stream) const {
  distances.reserve(count());
  scratch.reserve(count());
  const unsigned blocks = cuda::blocksFor(count(), kCellThreads);
  markVisible<<<blocks, kCellThreads, 0, stream>>>(bins, lowest_.data(), highest_.data(), count(), scratch.data());
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  const auto spread = [&](const uint8_t* from, uint8_t* to, int length, size_t stride) {
    spreadAlong<<<blocks, kCellThreads, 0, stream>>>(from, to, count(), length, stride);
    WARPSCOPE_CUDA_CHECK_LAUNCH();
  };
  const size_t row = static_cast<size_t>(dims_.x), plane = row * static_cast<size_t>(dims_.y);
  spread(scratch.data(), distances.data(), dims_.x, 1);
  spread(distances.data(), scratch.data(), dims_.y, row);
  spread(scratch.data(), distances.data(), dims_.z, plane);
}

}  // namespace warpscope
