// A wide hierarchy over spheres in Morton order, as wide as a warp: each 32 neighbours share a box, each 32 boxes the next, up to a
// topmost level of at most 32. There are no pointers and nothing to build but boxes. For .cu files.
// A warp walks it for its tile of pixels: every lane tests another child against the tile's frustum (cf. Wald, Boulos, Shirley 2007), and
// the spheres that remain are met by all of the tile's rays.
#pragma once

#include "render/core/camera.h"
#include "render/warp/device/sorted_cloud.h"

namespace warpscope {

inline constexpr uint32_t kClusterWidth = 32;
/// 32^7 exceeds what a frame can hold; the topmost level is not stored below the one above it.
inline constexpr int kMaxClusterLevels = 7;

/// The tree as kernels see it; device memory, another's.
struct ClusterTreeView {
  const float4* spheres = nullptr;  ///< centre and radius, in Morton order
  const uint32_t* ids = nullptr;    ///< each sphere's place in the frame
  uint32_t count = 0;
  /// Per level, from clusters of spheres upwards: boxes as pairs of float4 (lower, upper; w unused).
  const float4* boxes[kMaxClusterLevels] = {};
  uint32_t boxCount[kMaxClusterLevels] = {};
  int levels = 0;  ///< 0 for an empty tree; the topmost has at most kClusterWidth boxes
  float reach = 0.0f;  ///< at least the distance of any point of any sphere from the coordinates' origin
};

class DeviceClusterTree {
 public:
  /// In stream order, without waiting and, once the buffers have their size, without allocating.
  void build(const DeviceFrameView& frame, cudaStream_t stream);
  ClusterTreeView view() const;

  /// For every pixel of `camera` the first sample that its ray meets, as SphereTracer::trace; `depth` may be null.
  void trace(const Camera& camera, uint32_t* ids, float* depth, cudaStream_t stream) const;

 private:
  SortedCloud cloud_;
  glm::vec3 center_{0.0f};      // of the frame's bounds
  float typicalRadius_ = 0.0f;  // the middle of the largest octave of radii
  cuda::DeviceBuffer<float4> spheres_;
  cuda::DeviceBuffer<float4> boxes_;  // all levels, one behind the other
};

}  // namespace warpscope
