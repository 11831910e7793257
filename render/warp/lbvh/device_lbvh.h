// The hierarchy of lbvh.h, built on the device. For .cu files and what they include.
// Karras 2012: a thread for each inner node; bounds from the leaves up, the second child to arrive going on (his section 4).
#pragma once

#include "render/warp/device/sorted_cloud.h"

namespace warpscope {

class DeviceLbvh {
 public:
  /// In stream order, without waiting and, once the buffers have their size, without allocating. `halfLines`, unless null, makes the samples capsules (see LbvhView): those of
  /// halfLineOf(), in device memory, where they stay until the next build.
  void build(const DeviceFrameView& frame, cudaStream_t stream, const glm::vec3* halfLines = nullptr);
  /// In device memory.
  LbvhView view() const { return {nodes_.data(), spheres_.data(), cloud_.ids(), cloud_.count(), reach_, halfLines_}; }

  /// For every pixel of `camera` the first sample that its ray meets, as SphereTracer::trace; `depth` may be null. `overflow` becomes 1 if a
  /// traversal gave up. Capsules are met by stable arithmetic.
  void trace(const Camera& camera, uint32_t* ids, float* depth, uint32_t* overflow, cudaStream_t stream,
             Arithmetic arithmetic = Arithmetic::stable) const;

 private:
  SortedCloud cloud_;
  float reach_ = 0.0f;
  const glm::vec3* halfLines_ = nullptr;
  cuda::DeviceBuffer<LbvhNode> nodes_;
  cuda::DeviceBuffer<Sphere> spheres_;
  cuda::DeviceBuffer<uint32_t> parents_;   // of inner nodes, then of leaves
  cuda::DeviceBuffer<uint32_t> arrivals_;  // at each inner node
};

}  // namespace warpscope
