// See frame_places.h.
#include "render/march/frame_places.h"

#include <cmath>

#include "render/march/ray_pieces.h"

namespace warpscope {

bool hasLattice(const SampleFrame& frame) {
  return isUsable(frame.camera) && frame.settings.render.step > 0.0f && std::isfinite(frame.settings.render.step);
}

PathGrid pathGridOf(const SampleFrame& frame, Placement placement) {
  return {makePixelGrid(frame.camera, frame.quantization.nearDepth), frame.quantization.bounds, jitterFor(frame.settings.render), frame.settings.render.step,
          frame.quantization.depthStep, placement};
}

Placement placementOf(const SampleFrame& frame) {
  if (!hasLattice(frame)) return Placement::depth;
  if (frame.isAway) return frame.device->placements().samples;
  const PathGrid paths = pathGridOf(frame, Placement::steps);
  SampleVotes votes;
  for (size_t i = 0; i < frame.size(); i += probeStride(frame.size())) {
    const PackedSample sample = frame.samples[i];
    const PixelPath path = paths.path(columnOf(sample), rowOf(sample));
    const auto isOn = [&](bool isHalf) { return isOnLattice(path, depthCode(sample), paths.step, paths.depthStep, isHalf); };
    ++votes.looked;
    if (isOn(false)) ++votes.onSteps;
    if (isOn(true)) ++votes.onHalfSteps;
  }
  return votes.placement();
}

Placement borderPlacementOf(const SampleFrame& frame) {
  if (!hasLattice(frame)) return Placement::depth;
  if (frame.isAway) return frame.device->placements().borders;
  const FrameSegments& segments = frame.segments;
  if (segments.size() == 0) return Placement::depth;
  const PathGrid paths = pathGridOf(frame, kBorders);
  const size_t stride = probeStride(segments.rays.size());
  const std::vector<size_t> starts = segmentStarts(segments.rays, stride);
  BorderVotes votes;
  for (size_t probe = 0; probe + 1 < starts.size(); ++probe) {
    if (segments.rays[probe * stride].count() == 0) continue;
    const auto pixel = static_cast<uint32_t>(probe * stride);
    const PixelPath path = paths.path(pixel % frame.camera.width, pixel / frame.camera.width);
    ++votes.looked;
    if (isNearBorder(path, segments.depths[starts[probe]].begin, paths.step, paths.depthStep)) ++votes.nearBorders;
  }
  return votes.placement();
}

}  // namespace warpscope
