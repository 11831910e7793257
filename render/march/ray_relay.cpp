// Tiles of a picture, what becomes of their rays between two ways and at their end, and what cannot be marched so.
// See ray_relay.h.
#include "render/march/ray_relay.h"

#include <algorithm>
#include <cmath>

namespace warpscope {

namespace {

uint32_t columnsOf(const Camera& camera) { return (camera.width + kRelayedSide - 1) / kRelayedSide; }

}  // namespace

uint32_t tilesOf(const Camera& camera) { return columnsOf(camera) * ((camera.height + kRelayedSide - 1) / kRelayedSide); }

PixelArea areaOfTile(const Camera& camera, uint32_t tile) {
  PixelArea area;
  area.x = tile % columnsOf(camera) * kRelayedSide;
  area.y = tile / columnsOf(camera) * kRelayedSide;
  area.width = std::min(kRelayedSide, camera.width - area.x);
  area.height = std::min(kRelayedSide, camera.height - area.y);
  return area;
}

void RelayedTile::keep(const FinishedRay& ray, const SampleSettings* sample, bool hasNormals, const SampleRule& rule, const PixelGrid& pixels) {
  const bool isEmpty = sample == nullptr ? ray.premultiplied == glm::vec4(0.0f)
                                         : (ray.samples == nullptr || ray.samples->size() == 0) && !ray.hasSegments();
  if (isEmpty) return;
  finished.push_back((ray.y - area.y) * area.width + (ray.x - area.x));
  if (sample == nullptr) return colors.push_back(ray.premultiplied);
  found.resize(finished.size(), *sample, hasNormals);
  found.put(finished.size() - 1, ray, rule, pixels);
}

bool RelayedTile::beginAgain() {
  isAgain = true;
  again.resize(rays.size());
  bool any = false;
  for (size_t place = 0; place < rays.size(); ++place) {
    RelayedRay& ray = rays[place];
    ray.isDone = !ray.hasMet();
    ray.state.next = 0;
    any = any || !ray.isDone;
    if (!isDivided || ray.counting.size() < 2) continue;
    again[place].isDivided = true;
    again[place].accumulatedEnd = ray.counting.back().accumulatedAfter();
    ray.counting.clear();
  }
  return any;
}

int marginOf(const RenderSettings& settings, const VolumeGeometry& geometry, int axis) {
  return 2 + static_cast<int>(std::min(std::ceil(settings.step / geometry.voxelEdges()[axis]), 1e6f));
}

VoxelRows rowsOf(const CellBlock& block, const RenderSettings& settings, const VolumeGeometry& geometry) {
  VoxelRows rows;
  for (int axis = 1; axis < 3; ++axis) {
    const int64_t margin = marginOf(settings, geometry, axis), voxels = geometry.dims[axis];
    rows.lower[axis - 1] = static_cast<uint32_t>(std::clamp<int64_t>(block.lower[axis] - margin, 0, voxels));
    rows.upper[axis - 1] = static_cast<uint32_t>(std::clamp<int64_t>(block.upper[axis] + 1 + margin, 0, voxels));
  }
  return rows;
}

std::string whyNotInPieces(const RenderSettings& settings) {
  return settings.arithmetic != Arithmetic::stable ? "textbook arithmetic cannot be marched in pieces" : "";
}

bool needsLightCopy(const RenderSettings& settings) {
  const Effects& effects = settings.effects;
  return effects.shading.strength > 0.0f && (effects.shadows.strength > 0.0f || effects.shadows.occlusion > 0.0f);
}

}  // namespace warpscope
