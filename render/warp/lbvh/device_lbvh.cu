// Nodes, bounds, rays.
// See device_lbvh.h.
#include "render/warp/lbvh/device_lbvh.h"

#include "render/cuda/pixel_tiles.cuh"

namespace warpscope {
namespace {

constexpr unsigned kLbvhThreads = 256;
constexpr int kLbvhCodeBits = 63;

__global__ void gatherSpheres(DeviceFrameView frame, const uint32_t* ids, Sphere* spheres) {
  const uint32_t i = blockIdx.x * kLbvhThreads + threadIdx.x;
  if (i < frame.count) spheres[i] = unpackSample(frame.samples[ids[i]], frame.grid);
}

__global__ void emitNodes(const uint64_t* codes, uint32_t count, LbvhNode* nodes, uint32_t* parents) {
  const uint32_t i = blockIdx.x * kLbvhThreads + threadIdx.x;
  if (i + 1 >= count) return;
  const MortonRange range = determineRange(codes, count, i);
  const uint32_t split = findSplit(codes, count, range);
  const uint32_t children[2] = {leftReference(range, split), rightReference(range, split)};
  LbvhNode& node = nodes[i];
  for (int side = 0; side < 2; ++side) {
    const uint32_t child = children[side];
    node.child[side] = child;
    // The lowest bit tells the child which side of its parent it is.
    parents[child & kLbvhLeafBit ? count - 1 + (child & ~kLbvhLeafBit) : child] = 2 * i + side;
  }
}

/// `halfLines` by id, null where all are spheres.
__global__ void boundNodes(const Sphere* spheres, const uint32_t* ids, const glm::vec3* halfLines, uint32_t count, LbvhNode* nodes, const uint32_t* parents, uint32_t* arrivals) {
  const uint32_t leaf = blockIdx.x * kLbvhThreads + threadIdx.x;
  if (leaf >= count) return;
  Box box = halfLines == nullptr ? sphereBounds(spheres[leaf]) : capsuleBounds(spheres[leaf], halfLines[ids[leaf]]);
  float smallestRadius = spheres[leaf].radius;
  uint32_t place = parents[count - 1 + leaf];
  for (;;) {
    const uint32_t parent = place / 2;
    nodes[parent].bounds[place % 2] = box;
    nodes[parent].smallestRadius[place % 2] = smallestRadius;
    __threadfence();
    if (atomicAdd(&arrivals[parent], 1) == 0) return;  // the other child is not there yet, and will go on
    __threadfence();
    // Another thread wrote it: past the first-level cache.
    const float* other = &nodes[parent].bounds[1 - place % 2].lower.x;
    Box sibling;
    for (int axis = 0; axis < 3; ++axis) {
      sibling.lower[axis] = __ldcg(other + axis);
      sibling.upper[axis] = __ldcg(other + 3 + axis);
    }
    box.include(sibling);
    smallestRadius = minOf(smallestRadius, __ldcg(&nodes[parent].smallestRadius[1 - place % 2]));
    if (parent == 0) return;
    place = parents[parent];
  }
}

template <class Intersection>
__global__ void __launch_bounds__(kTileBlockThreads) traceRays(const __grid_constant__ LbvhView view,
                                                               const __grid_constant__ Camera camera, uint32_t* ids, float* depth,
                                                               uint32_t* overflow) {
  const PixelPlace pixel = pixelOfThread(0);
  if (pixel.x >= camera.width || pixel.y >= camera.height) return;
  const Ray ray = rayOfPixel(camera, pixel);
  const LbvhHit hit = closestHit<Intersection>(view, ray);
  if (hit.overflow) *overflow = 1;
  const size_t i = size_t{pixel.y} * camera.width + pixel.x;
  ids[i] = hit.id;
  if (depth != nullptr) depth[i] = hit.t;
}

}  // namespace

void DeviceLbvh::build(const DeviceFrameView& frame, cudaStream_t stream, const glm::vec3* halfLines) {
  cloud_.build(frame, kLbvhCodeBits, stream);
  halfLines_ = halfLines;
  // No line's half is longer than the bounds, and each coordinate gets at most that.
  reach_ = cloud_.reach() + (halfLines != nullptr ? 3.0f * glm::length(frame.grid.bounds.extent()) : 0.0f);
  const uint32_t count = frame.count;
  if (count == 0) return;
  spheres_.reserve(count);
  gatherSpheres<<<cuda::blocksFor(count, kLbvhThreads), kLbvhThreads, 0, stream>>>(frame, cloud_.ids(), spheres_.data());
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  if (count == 1) return;
  nodes_.reserve(count - 1);
  parents_.reserve(2 * size_t{count} - 1);
  arrivals_.reserve(count - 1);
  WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(arrivals_.data(), 0, (count - 1) * sizeof(uint32_t), stream));
  emitNodes<<<cuda::blocksFor(count - 1, kLbvhThreads), kLbvhThreads, 0, stream>>>(cloud_.codes(), count, nodes_.data(), parents_.data());
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  boundNodes<<<cuda::blocksFor(count, kLbvhThreads), kLbvhThreads, 0, stream>>>(spheres_.data(), cloud_.ids(), halfLines_, count, nodes_.data(), parents_.data(),
                                                                                arrivals_.data());
  WARPSCOPE_CUDA_CHECK_LAUNCH();
}

void DeviceLbvh::trace(const Camera& camera, uint32_t* ids, float* depth, uint32_t* overflow, cudaStream_t stream,
                       Arithmetic arithmetic) const {
  const auto traceBy = [&](auto policy) {
    traceRays<decltype(policy)>
        <<<tileGrid(camera.width, camera.height), kTileBlockThreads, 0, stream>>>(view(), camera, ids, depth, overflow);
  };
  if (halfLines_ != nullptr)
    traceBy(StableCapsule{});
  else
    visitSphereArithmetic(arithmetic, traceBy);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
}

}  // namespace warpscope
