// Boxes, level by level, and the nearest hits.
// See cluster_tree.h.
#include "render/warp/clusters/cluster_tree.h"

#include "render/warp/clusters/cluster_trace.cuh"

namespace warpscope {
namespace {

constexpr unsigned kTreeThreads = 256;

/// Order within a cluster does not matter: 16 bits an axis tell 2^16 cells apart along the longest one, and save sorting passes.
constexpr int kTreeCodeBits = 48;

__device__ void storeBox(float4* boxes, uint32_t i, const Box& box) {
  boxes[2 * size_t{i}] = {box.lower.x, box.lower.y, box.lower.z, 0.0f};
  boxes[2 * size_t{i} + 1] = {box.upper.x, box.upper.y, box.upper.z, 0.0f};
}

/// A lane a sphere, a warp a cluster.
__global__ void gatherClusters(DeviceFrameView frame, const uint32_t* ids, float4* spheres, float4* boxes) {
  const uint32_t i = blockIdx.x * kTreeThreads + threadIdx.x;
  Box box;
  if (i < frame.count) {
    const Sphere sphere = unpackSample(frame.samples[ids[i]], frame.grid);
    spheres[i] = {sphere.center.x, sphere.center.y, sphere.center.z, sphere.radius};
    box = sphereBounds(sphere);
  }
  box = boxOfWarp(box);
  if (threadIdx.x % 32 == 0 && i < frame.count) storeBox(boxes, i / kClusterWidth, box);
}

/// A lane a box of the level below, a warp a box.
__global__ void uniteBoxes(const float4* below, uint32_t count, float4* boxes) {
  const uint32_t i = blockIdx.x * kTreeThreads + threadIdx.x;
  Box box;
  if (i < count) {
    const float4 lower = below[2 * size_t{i}], upper = below[2 * size_t{i} + 1];
    box = {{lower.x, lower.y, lower.z}, {upper.x, upper.y, upper.z}};
  }
  box = boxOfWarp(box);
  if (threadIdx.x % 32 == 0 && i < count) storeBox(boxes, i / kClusterWidth, box);
}

/// The nearest hit of one ray; of equally near ones the one that comes first in the frame.
class NearestHit {
 public:
  NearestHit() = default;
  __device__ NearestHit(const uint32_t* ids, bool isWanted) : ids_(ids), t_(isWanted ? kNoHit : -1.0f) {}
  __device__ float farthest() const { return t_; }
  __device__ void add(uint32_t place, float t) {
    if (t == t_ && !(ids_[place] < id())) return;
    t_ = t;
    place_ = place;
  }
  __device__ float t() const { return t_; }
  __device__ uint32_t id() const { return place_ == kNoSample ? kNoSample : ids_[place_]; }

 private:
  const uint32_t* ids_ = nullptr;
  float t_ = kNoHit;
  uint32_t place_ = kNoSample;
};

/// kRays: pixels of each lane. With two, half as many tiles walk the tree, and each sphere is fetched for twice as many rays; but the tiles
/// with most spheres take longer, and where spheres are small on the screen the picture waits for these.
template <int kRays>
__global__ void __launch_bounds__(kTileBlockThreads) traceNearest(const __grid_constant__ ClusterTreeView tree,
                                                                  const __grid_constant__ Camera camera, uint32_t* ids, float* depth) {
  __shared__ ClusterWarpMemory memory[kTilesPerBlock];
  const PixelPlace tile = tileOfThread(0, kRays);
  if (tile.x >= camera.width || tile.y >= camera.height) return;  // the whole warp
  const auto isInside = [&](const PixelPlace& pixel) { return pixel.x < camera.width && pixel.y < camera.height; };
  glm::vec3 directions[kRays];
  NearestHit hits[kRays];
  for (int ray = 0; ray < kRays; ++ray) {
    const PixelPlace pixel = pixelOfTile(tile, static_cast<unsigned>(ray));
    directions[ray] = rayOfPixel(camera, pixel).direction;
    hits[ray] = NearestHit(tree.ids, isInside(pixel));
  }
  traceClusters(tree, camera, tile, directions, memory[threadIdx.x / 32], hits);
  for (int ray = 0; ray < kRays; ++ray) {
    const PixelPlace pixel = pixelOfTile(tile, static_cast<unsigned>(ray));
    if (!isInside(pixel)) continue;
    const size_t i = size_t{pixel.y} * camera.width + pixel.x;
    ids[i] = hits[ray].id();
    if (depth != nullptr) depth[i] = hits[ray].t();
  }
}

}  // namespace

void DeviceClusterTree::build(const DeviceFrameView& frame, cudaStream_t stream) {
  cloud_.build(frame, kTreeCodeBits, stream);
  if (frame.count == 0) return;
  center_ = frame.grid.bounds.center();
  typicalRadius_ = 1.5f * frame.grid.radiusUnit;
  spheres_.reserve(frame.count);
  size_t boxes = 0;
  for (uint32_t n = frame.count; n > 1 || boxes == 0;) boxes += n = (n - 1) / kClusterWidth + 1;
  boxes_.reserve(2 * boxes);
  const ClusterTreeView tree = view();
  gatherClusters<<<cuda::blocksFor(frame.count, kTreeThreads), kTreeThreads, 0, stream>>>(frame, cloud_.ids(), spheres_.data(),
                                                                                          const_cast<float4*>(tree.boxes[0]));
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  for (int level = 1; level < tree.levels; ++level) {
    uniteBoxes<<<cuda::blocksFor(tree.boxCount[level - 1], kTreeThreads), kTreeThreads, 0, stream>>>(
        tree.boxes[level - 1], tree.boxCount[level - 1], const_cast<float4*>(tree.boxes[level]));
    WARPSCOPE_CUDA_CHECK_LAUNCH();
  }
}

ClusterTreeView DeviceClusterTree::view() const {
  ClusterTreeView tree;
  tree.spheres = spheres_.data();
  tree.ids = cloud_.ids();
  tree.count = cloud_.count();
  tree.reach = cloud_.reach();
  const float4* boxes = boxes_.data();
  for (uint32_t n = tree.count; n > 0 && (tree.levels == 0 || n > kClusterWidth);) {
    n = (n - 1) / kClusterWidth + 1;
    tree.boxes[tree.levels] = boxes;
    tree.boxCount[tree.levels++] = n;
    boxes += 2 * size_t{n};
  }
  return tree;
}

void DeviceClusterTree::trace(const Camera& camera, uint32_t* ids, float* depth, cudaStream_t stream) const {
  // How large spheres are on the screen, in the middle of the cloud. Where one ray a lane and two are as fast was measured on an H200, with
  // clouds of volumes of 256^3 voxels at 1024 x 1024 pixels.
  constexpr float kPixelsForTwo = 2.2f;
  const bool takesTwo = typicalRadius_ > kPixelsForTwo * pixelEdge(camera) * glm::length(center_ - camera.eye);
  if (takesTwo)
    traceNearest<2><<<tileGrid(camera.width, camera.height, 2), kTileBlockThreads, 0, stream>>>(view(), camera, ids, depth);
  else
    traceNearest<1><<<tileGrid(camera.width, camera.height, 1), kTileBlockThreads, 0, stream>>>(view(), camera, ids, depth);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
}

}  // namespace warpscope
