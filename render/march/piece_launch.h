// What a march of pieces on a device is told, and how it is started. For .cu files.
// The rays: ray_relay.h. Compiled by piece_kernels_*.cu, one for each kind of voxel.
#pragma once

#include "render/core/segment_table.h"
#include "render/cuda/memory.h"
#include "render/effects/clip.h"
#include "render/effects/isosurface.h"
#include "render/effects/jitter.h"
#include "render/effects/light_volume.h"
#include "render/effects/mip.h"
#include "render/effects/shading.h"
#include "render/march/cell_block.h"
#include "render/march/ray_relay.h"
#include "render/march/ray_samples.h"
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
  uint32_t ray = 0;     ///< of those that are marched at once
  uint32_t closed = 0;  ///< on the second way: parts of the ray that ended here before it
  CountingSample sample;
};

/// A ray that is cut into parts, on its second way: as it comes, and then as it goes on.
struct PartedRay {
  uint32_t x = 0, y = 0;  ///< pixel of the picture
  int next = 0;           ///< RelayedState's
  float accumulatedEnd = 0.0f;
  RayPart<RayPiece> part;
};

/// A part that has ended.
struct ClosedPart {
  uint32_t ray = 0;
  glm::vec4 color{0.0f};  ///< linear, premultiplied
};

/// Rays on their second way that are marched at once. All pointers are to device memory.
struct PartedRays {
  uint32_t count = 0;  ///< of rays
  int mostParts = 1;   ///< of a ray
  PartedRay* rays = nullptr;
  // Of one ray near to far, among others'. Samples as PieceRays has them; of parts there is room for mostParts a ray.
  ListedSample* listed = nullptr;
  uint32_t listedRoom = 0;
  uint32_t* listedCount = nullptr;
  ClosedPart* closed = nullptr;
  uint32_t* closedCount = nullptr;  ///< 0 before
};

/// Where light that depends on the eye falls on a segment.
struct LitPlace {
  uint32_t x = 0, y = 0;  ///< pixel of the picture
  float t = 0.0f;         ///< along its ray
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
  PartedRays parted;     ///< in place of the others, where there are any
};

/// Marches each ray's samples in the block, behind what it has met, in the light of `shading`, as far as `lightVolume` lets it through; rays that are done then have no
/// more segments than are wanted.
template <class Voxel, bool kHasHoles>
void launchPieces(const PieceJob<Voxel>& job, const ShadingSetup& shading, const LightVolume& lightVolume, cudaStream_t stream);

/// As launchPieces, for rays of which the greatest value alone is seen.
template <class Voxel, bool kHasHoles>
void launchMipPieces(const PieceJob<Voxel>& job, const MipSetup& setup, cudaStream_t stream);

/// As launchPieces, for rays that see surfaces.
template <class Voxel, bool kHasHoles>
void launchIsosurfacePieces(const PieceJob<Voxel>& job, const IsosurfaceSetup& setup, const ShadingSetup& shading, cudaStream_t stream);

/// As launchPieces, for steps that are classified by the values at their ends.
template <class Voxel>
void launchSegmentPieces(const PieceJob<Voxel>& job, const SegmentLookup& setup, const ShadingSetup& shading, const LightVolume& lightVolume, cudaStream_t stream);

/// Finds the normals at `count` places whose voxels the block has, for light of `shading`.
template <class Voxel, bool kHasHoles>
void launchPieceNormals(const PieceJob<Voxel>& job, const ShadingSetup& shading, const LitPlace* places, uint32_t count, NormalCode* normals, cudaStream_t stream);

}  // namespace warpscope
