// The samples of a frame that stand for all, for whoever chooses how spheres are drawn (sphere_ways.h), also where the frame is in device memory alone.
// For .cu files and what they include.
#pragma once

#include "render/core/transfer_vector.h"
#include "render/cuda/pinned_memory.h"
#include "render/warp/device/device_frame.h"
#include "render/warp/sphere_ways.h"

namespace warpscope {

/// Keeps its memory. Works in one stream.
class SphereSamples {
 public:
  /// `there`: the same frame on the device. Waits for the stream where the frame is away. Throws DeviceError.
  SphereLoadProbe probeOf(const SampleFrame& frame, const DeviceFrameView& there, cudaStream_t stream);

 private:
  // Page-locked: the device reads and writes them where they are.
  TransferVector<uint32_t> places_{TransferAllocator<uint32_t>(cuda::pinnedMemory())};
  TransferVector<PackedSample> samples_{TransferAllocator<PackedSample>(cuda::pinnedMemory())};
};

}  // namespace warpscope
