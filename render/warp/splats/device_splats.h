// Exact sphere splats on the device: what the rays of pixels would hit first, without a hierarchy. For .cu files.
// See footprint_walk.cuh.
#pragma once

#include "render/core/camera.h"
#include "render/warp/splats/footprint_walk.cuh"

namespace warpscope {

class DeviceSplats {
 public:
  /// For every pixel of `camera` the first sample that its ray meets, as SphereTracer::trace; `depth` may be null. In stream order, without
  /// waiting and, once the buffers have their size, without allocating.
  void draw(const DeviceFrameView& frame, const Camera& camera, uint32_t* ids, float* depth, cudaStream_t stream);

 private:
  cuda::DeviceBuffer<KeptHit> nearest_;
  FootprintWalk walk_;
};

}  // namespace warpscope
