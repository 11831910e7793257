// What a march on a device is told, and how it is started. For .cu files.
// Compiled by march_kernels_*.cu, one for each kind of voxel, because a kernel for each heuristic takes the compiler long.
#pragma once

#include <optional>

#include "render/core/color.h"
#include "render/core/segment_table.h"
#include "render/cuda/memory.h"
#include "render/effects/clip.h"
#include "render/effects/jitter.h"
#include "render/effects/isosurface.h"
#include "render/effects/mip.h"
#include "render/effects/light_volume_march.h"
#include "render/effects/shading.h"
#include "render/march/frame_segments.h"
#include "render/march/march.h"
#include "render/march/sample_radius.h"
#include "render/march/volume_view.h"

namespace warpscope {

/// Rows [firstRow, endRow) of an image. All pointers are to device memory; a pass writes either samples and colours,
/// `slots` elements for each pixel of the whole image, or the image, one for each.
template <class Voxel>
struct MarchJob {
  VolumeView<Voxel> view;
  ClipSetup clip;
  Jitter jitter;  ///< its noise on the device
  Camera camera;
  PixelGrid pixels;  ///< of the camera; its near plane is in front of the bounds
  float step = 0.5f;
  RayLimits limits;
  float threshold = 0.0f;
  uint32_t firstRow = 0;
  uint32_t endRow = 0;
  int slots = 1;  ///< most samples of a ray
  // What the plan has.
  bool isClipped = false;
  bool hasSecondPass = false;
  bool isDivided = false;  ///< rays, for several samples
  bool hasSpread = false;  ///< of depth: for `spreads`, for radii, or both
  SampleRule rule;
  const ColorTables* colorTables = nullptr;
  PackedSample* samples = nullptr;
  Rgba8* colors = nullptr;
  float* spreads = nullptr;  ///< of depth, as many as samples; null where they are not sent
  glm::vec4* image = nullptr;
  // Of the ray's segments: those of the pixel begin at its number times segmentSlots.
  int segmentSlots = 0;  ///< for each pixel; 0: nobody wants any
  RaySegmentCount* segmentCounts = nullptr;  ///< one for each pixel
  SegmentSlots segments;                     ///< of the first pixel
};

/// Marches samples by `heuristic`, or colours alone without one, in the light of `shading`, as far as `lightVolume` lets it through. The parameters: those of
/// visitDeviceVoxels.
template <class Voxel, bool kHasHoles, bool kByCells>
void launchMarch(const MarchJob<Voxel>& job, const RenderSettings& settings, const ShadingSetup& shading, const LightVolume& lightVolume,
                 std::optional<Heuristic> heuristic, cudaStream_t stream);

/// As launchMarch, for rays of which the greatest value alone is seen. Its depth is every heuristic's: only whether there is one matters.
template <class Voxel, bool kHasHoles, bool kByCells>
void launchMip(const MarchJob<Voxel>& job, const MipSetup& setup, std::optional<Heuristic> heuristic, cudaStream_t stream);

/// As launchMarch, for rays that see surfaces.
template <class Voxel, bool kHasHoles, bool kByCells>
void launchIsosurfaces(const MarchJob<Voxel>& job, const IsosurfaceSetup& setup, const ShadingSetup& shading, std::optional<Heuristic> heuristic,
                       cudaStream_t stream);
/// As launchMarch, for steps that are classified by the values at their ends.
template <class Voxel, bool kByCells>
void launchSegments(const MarchJob<Voxel>& job, const SegmentLookup& segments, const ShadingSetup& shading, const LightVolume& lightVolume,
                    std::optional<Heuristic> heuristic, cudaStream_t stream);

/// Finds out places [first, end) of a light volume, whose values these are in device memory.
template <class Voxel, bool kHasHoles, bool kByCells>
void launchLightVolume(const LightVolumeJob& job, const VolumeView<Voxel>& view, size_t first, size_t end, uint16_t* values, cudaStream_t stream);

}  // namespace warpscope
