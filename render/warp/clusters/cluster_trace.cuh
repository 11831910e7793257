// A warp's walk through the cluster tree, front to back, for one tile of pixels.
// See cluster_tree.h. What is gathered along the rays is the caller's: the nearest hit, or several.
#pragma once

#include "render/core/ray_sphere.h"
#include "render/cuda/pixel_tiles.cuh"
#include "render/cuda/warp_reduce.cuh"
#include "render/warp/clusters/cluster_tree.h"
#include "render/warp/device/earliest_hit.cuh"

namespace warpscope {

/// The box test's margin, relative to the distances of eye and spheres from the coordinates' origin: kLbvhMargin for the exact test and the
/// boxes, as much for the rays' directions, and as much for the planes, which are single precision here.
constexpr float kClusterMargin = 3.0f * kLbvhMargin;

/// Up to as many rays of a tile that still take any hit are asked one by one whether a sphere concerns them.
constexpr int kFewOpenRays = 16;

/// The planes through the eye that hold a tile's outermost rays. Normals point inwards.
struct TileFrustum {
  glm::vec3 normals[4];
  float normalsDotEye[4];
  glm::vec3 axis;  ///< the tile's middle ray
  float axisDotEye;
  float margin;

  __device__ TileFrustum(const Camera& camera, const PixelPlace& tile, uint32_t tileHeight, float reach) {
    const float edge = pixelEdge(camera);
    const auto columnAt = [&](uint32_t x) {
      return camera.forward + (static_cast<float>(x) + 0.5f - 0.5f * camera.width) * edge * camera.right;
    };
    const auto rowAt = [&](uint32_t y) {
      return camera.forward + (0.5f * camera.height - (static_cast<float>(y) + 0.5f)) * edge * camera.up;
    };
    const auto inwards = [](const glm::vec3& across, const glm::vec3& line, const glm::vec3& positive) {
      const glm::vec3 normal = glm::normalize(glm::cross(across, line));
      return glm::dot(normal, positive) < 0.0f ? -normal : normal;
    };
    const uint32_t lastX = min(tile.x + kTileWidth, camera.width) - 1;
    const uint32_t lastY = min(tile.y + tileHeight, camera.height) - 1;
    normals[0] = inwards(camera.up, columnAt(tile.x), camera.right);
    normals[1] = inwards(camera.up, columnAt(lastX), -camera.right);
    normals[2] = inwards(camera.right, rowAt(tile.y), -camera.up);
    normals[3] = inwards(camera.right, rowAt(lastY), camera.up);
    axis = pixelRay(camera, {0.5f * static_cast<float>(tile.x + lastX + 1), 0.5f * static_cast<float>(tile.y + lastY + 1)}).direction;
    for (int k = 0; k < 4; ++k) normalsDotEye[k] = glm::dot(normals[k], camera.eye);
    axisDotEye = glm::dot(axis, camera.eye);
    const glm::vec3 eye = glm::abs(camera.eye);
    margin = kClusterMargin * (eye.x + eye.y + eye.z + reach);
  }

  /// At most the distance along any of the tile's rays to anything in the box, not negative; infinite if no ray can meet it.
  __device__ float entryDistance(const float4& lower, const float4& upper) const {
    bool isOutside = false;
    for (int k = 0; k < 4; ++k) {
      // The corner that is farthest inside.
      const glm::vec3& n = normals[k];
      const float inside = fmaf(n.x, n.x > 0.0f ? upper.x : lower.x,
                                fmaf(n.y, n.y > 0.0f ? upper.y : lower.y, fmaf(n.z, n.z > 0.0f ? upper.z : lower.z, -normalsDotEye[k])));
      isOutside = isOutside || inside < -margin;
    }
    const auto along = [&](bool far) {
      return fmaf(axis.x, (axis.x > 0.0f) == far ? upper.x : lower.x,
                  fmaf(axis.y, (axis.y > 0.0f) == far ? upper.y : lower.y,
                       fmaf(axis.z, (axis.z > 0.0f) == far ? upper.z : lower.z, -axisDotEye)));
    };
    if (isOutside) return kNoHit;
    // A distance along a ray is at least that along the axis; the axis is within any ray's hemisphere or the bound below is 0.
    return fmaxf(along(false) - margin, 0.0f);
  }

  /// As entryDistance for a sphere at `distance` from the eye.
  __device__ float entryDistance(const glm::vec3& toCenter, float radius, float distance) const {
    const float reach = radius + margin;
    bool isOutside = false;
    for (int k = 0; k < 4; ++k) isOutside = isOutside || fmaf(normals[k].x, toCenter.x, fmaf(normals[k].y, toCenter.y, normals[k].z * toCenter.z)) < -reach;
    if (isOutside) return kNoHit;
    return fmaxf(distance - reach, 0.0f);
  }
};

/// As many spheres are met side by side, whose tests do not depend on one another: a tile that sees many keeps the picture waiting, and its warp waits for its own results else.
constexpr int kSpheresTogether = 4;

/// What the warps of a block share among their lanes.
struct ClusterWarpMemory {
  float depths[kMaxClusterLevels][kClusterWidth];  // of the open nodes' children; infinite for those that are done
  uint32_t firstChild[kMaxClusterLevels];
  // Of a cluster's spheres those that the tile may see, one behind the other, and then some that nothing meets.
  float4 spheres[kClusterWidth + kSpheresTogether - 1];  // centre from the eye, and widenedSquare
  float4 exact[kClusterWidth];  // of SeenSphere: radius, outside; bits of the place
};

/// Walks the tree for the tile of the calling warp, all of whose lanes must call, each for `kRays` pixels (see pixel_tiles.cuh) with their
/// rays' directions. `hits` gathers for each of these:
///   float farthest() const                       distance beyond which nothing is wanted any more; negative for a pixel outside the image
///   void add(uint32_t place, float t)            a hit at t <= farthest(), at most once for each place in Morton order
template <int kRays, class Hits>
__device__ inline void traceClusters(const ClusterTreeView& tree, const Camera& camera, const PixelPlace& tile,
                                     const glm::vec3 (&directions)[kRays], ClusterWarpMemory& memory, Hits (&hits)[kRays]) {
  if (tree.levels == 0) return;
  const unsigned lane = threadIdx.x % 32;
  const TileFrustum frustum(camera, tile, kRays * kTileHeight, tree.reach);

  // Beyond which none of the tile's rays wants anything; infinite while some are open, that is, want whatever there is. What the others want.
  float farthest = 0.0f, farthestOfOthers = 0.0f;
  uint32_t open[kRays];
  int openCount = 0;
  const auto askRays = [&] {
    float own = 0.0f;
    openCount = 0;
    for (int ray = 0; ray < kRays; ++ray) {
      const float wanted = hits[ray].farthest();
      open[ray] = __ballot_sync(kAllLanes, wanted == kNoHit);
      openCount += __popc(open[ray]);
      if (wanted != kNoHit) own = fmaxf(own, wanted);
    }
    farthestOfOthers = warpMax(own);
    farthest = openCount > 0 ? kNoHit : farthestOfOthers;
  };
  askRays();

  // Of the node that is open at the current level; those above wait in the warp's memory.
  uint32_t firstChild = 0;
  float depth = kNoHit;

  const auto openNode = [&](int level, uint32_t first) {
    firstChild = first;
    depth = kNoHit;
    if (first + lane < tree.boxCount[level]) {
      const float4* box = tree.boxes[level] + 2 * size_t{first + lane};
      depth = frustum.entryDistance(box[0], box[1]);
    }
  };

  const auto meetSpheres = [&](uint32_t cluster) {
    const uint32_t first = cluster * kClusterWidth;
    bool isNear = false, isForOpen = false;
    float4 widened{0.0f, 0.0f, 0.0f, 0.0f};
    SeenSphere seen{};
    if (first + lane < tree.count) {
      const float4 sphere = tree.spheres[first + lane];
      const glm::vec3 toCenter = glm::vec3(sphere.x, sphere.y, sphere.z) - camera.eye;
      const float distance = sqrtf(glm::dot(toCenter, toCenter));
      const float nearest = frustum.entryDistance(toCenter, sphere.w, distance);
      isNear = nearest <= farthestOfOthers && nearest < kNoHit;
      isForOpen = nearest < kNoHit && !isNear;
      seen = seenSphere(toCenter, sphere.w);
      widened = {toCenter.x, toCenter.y, toCenter.z, widenedSquare(distance, seen.radius)};
    }
    if (openCount > kFewOpenRays) {
      isNear = isNear || isForOpen;
    } else if (__any_sync(kAllLanes, isForOpen)) {
      // A ray at a time, all spheres at once: behind a silhouette few rays are open, and many spheres lie in the tile's way but in none of theirs.
      for (int ray = 0; ray < kRays; ++ray)
        for (uint32_t rest = open[ray]; rest != 0; rest &= rest - 1) {
          const int owner = __ffs(static_cast<int>(rest)) - 1;
          const glm::vec3 direction(__shfl_sync(kAllLanes, directions[ray].x, owner), __shfl_sync(kAllLanes, directions[ray].y, owner),
                                    __shfl_sync(kAllLanes, directions[ray].z, owner));
          isNear = isNear || (isForOpen && earliestHit(direction, widened) < kNoHit);
        }
    }
    const uint32_t near = __ballot_sync(kAllLanes, isNear);
    if (near == 0) return;
    const int count = __popc(near);
    if (isNear) {
      const int slot = __popc(near & ((1u << lane) - 1));
      memory.spheres[slot] = widened;
      memory.exact[slot] = {seen.radius, seen.outside, __uint_as_float(first + lane), 0.0f};
    }
    if (lane < kSpheresTogether - 1) memory.spheres[count + static_cast<int>(lane)] = {0.0f, 0.0f, 0.0f, -1.0f};
    __syncwarp();
    for (int begin = 0; begin < count; begin += kSpheresTogether) {
      float4 spheres[kSpheresTogether];
      for (int k = 0; k < kSpheresTogether; ++k) spheres[k] = memory.spheres[begin + k];
      for (int ray = 0; ray < kRays; ++ray) {
        uint32_t met = 0;
        for (int k = 0; k < kSpheresTogether; ++k) met |= earliestHit(directions[ray], spheres[k]) <= hits[ray].farthest() ? 1u << k : 0u;
        for (; met != 0; met &= met - 1) {
          const int slot = begin + __ffs(static_cast<int>(met)) - 1;
          const float4 sphere = memory.spheres[slot], exact = memory.exact[slot];
          const float t = intersectSphereFromOrigin(directions[ray], {sphere.x, sphere.y, sphere.z}, exact.x, exact.y);
          if (t <= hits[ray].farthest() && t < kNoHit) hits[ray].add(__float_as_uint(exact.z), t);
        }
      }
    }
    __syncwarp();
    askRays();
  };

  const int top = tree.levels - 1;
  int level = top;
  openNode(top, 0);
  for (;;) {
    const float nearest = warpMin(depth);
    if (!(nearest <= farthest) || nearest == kNoHit) {  // nothing more at this level
      if (++level > top) return;
      depth = memory.depths[level][lane];
      firstChild = memory.firstChild[level];
      continue;
    }
    const int pick = __ffs(static_cast<int>(__ballot_sync(kAllLanes, depth == nearest))) - 1;
    if (static_cast<int>(lane) == pick) depth = kNoHit;
    const uint32_t child = firstChild + static_cast<uint32_t>(pick);
    if (level == 0) {
      meetSpheres(child);
      continue;
    }
    memory.depths[level][lane] = depth;
    if (lane == 0) memory.firstChild[level] = firstChild;
    __syncwarp();
    openNode(--level, child * kClusterWidth);
  }
}

}  // namespace warpscope
