// What a march of pieces on a device is told, and how it is started. For .cu files.
// The rays: ray_relay.h. Compiled by piece_kernels_*.cu, one for each kind of voxel.
#pragma once

#include "render/cuda/memory.h"
#include "render/effects/clip.h"
#include "render/effects/jitter.h"
#include "render/effects/shading.h"
#include "render/march/cell_block.h"
#include "render/march/ray_relay.h"
#include "render/march/ray_segments.h"

namespace warpscope {

/// A ray under way, as it comes.
struct PieceRay {
  uint32_t x = 0, y = 0;  ///< pixel of the picture
  int32_t met = -1;       ///< which of the states it has; below 0: it has met nothing yet
  bool isLast = false;    ///< nothing else lies behind the block
};

/// As it goes on.
struct PieceResult {
  int32_t met = -1;  ///< which of the states that are left is its; below 0: it has met nothing yet
  bool isDone = false;
};

/// A sample that counts, for a heuristic that needs all of them at hand.
struct ListedSample {
  uint32_t ray = 0;  ///< of those that are marched at once
  CountingSample sample;
};

/// Rays that are marched at once. All pointers are to device memory.
struct PieceRays {
  uint32_t count = 0;  ///< of rays
  const PieceRay* rays = nullptr;
  const RelayedState* met = nullptr;
  const SegmentMerger* metSegments = nullptr;  ///< as many; null where nobody wants any
  PieceResult* results = nullptr;              ///< one a ray
  // Room for one a ray; those of rays that have met anything are in front, in any order.
  RelayedState* left = nullptr;
  SegmentMerger* leftSegments = nullptr;  ///< null where nobody wants any
  uint32_t* leftCount = nullptr;          ///< of them; 0 before
  // Those of one ray near to far, among others'.
  ListedSample* listed = nullptr;   ///< null where samples are folded
  uint32_t listedRoom = 0;
  uint32_t* listedCount = nullptr;  ///< that there are to be; 0 before. If that is more than there is room for, the rest is not there
};

template <class Voxel>
struct PieceJob : PieceRays {
  VolumeView<Voxel> view;  ///< whose voxels are those that the block's samples read
  ClipSetup clip;
  Jitter jitter;  ///< its noise on the device
  PixelGrid pixels;
  CellBlock block;
  float step = 0.5f;
  RayLimits limits;
  // What the plan has.
  bool isClipped = false;
  bool wantsSamples = false;  ///< folded by `depth`, a heuristic of one pass, or listed
  bool hasSpread = false;
  AnyDepth<false> depth;
  float threshold = 0.0f;
  int segmentSlots = 0;  ///< most segments of a ray; 0: nobody wants any
};

/// Marches each ray's samples in the block, behind what it has met, in the light of `shading`; rays that are done then have no more segments than are wanted.
template <class Voxel, bool kHasHoles>
void launchPieces(const PieceJob<Voxel>& job, const ShadingSetup& shading, cudaStream_t stream);

}  // namespace warpscope
