// Exact sphere splats on the device: what the rays of pixels would hit first, without a hierarchy. For .cu files and what they include.
// A thread for each sphere walks the pixels of its footprint and keeps the smallest (distance, place in the frame) with a 64-bit minimum;
// footprints that would hold a warp up are walked by the whole warp, and those that would hold the frame up by many blocks.
#pragma once

#include "render/core/camera.h"
#include "render/warp/device/device_frame.h"

namespace warpscope {

class DeviceSplats {
 public:
  /// For every pixel of `camera` the first sample that its ray meets, as SphereTracer::trace; `depth` may be null. In stream order, without
  /// waiting and, once the buffers have their size, without allocating.
  void draw(const DeviceFrameView& frame, const Camera& camera, uint32_t* ids, float* depth, cudaStream_t stream);

 private:
  cuda::DeviceBuffer<unsigned long long> nearest_;  // a pixel: bits of the distance above, place in the frame below; all ones: nothing
  cuda::DeviceBuffer<uint32_t> large_;              // samples with large footprints
  cuda::DeviceBuffer<uint32_t> largeCount_{1};
};

}  // namespace warpscope
