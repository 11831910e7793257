// How much of a volume is kept in memory at a time, where that is limited.
#pragma once

#include <algorithm>

#include "render/base/memory_limit.h"
#include "render/volume/volume.h"

namespace warpscope {

/// All of its slices, but of one that can be read or made again and is too large for the limit. Who shares a volume with others marches a piece of it as it is.
inline uint32_t slicesKept(const Volume& volume) {
  const uint32_t slices = volume.dims().z;
  return isDroppable(volume.voxels()) && !volume.ranks() ? slicesAtATime(volume.sizeBytes() / slices, slices) : slices;
}

/// How slices are looked at: pieces begin at multiples of `edge`, and see `beyond` slices behind their own.
struct SliceGrouping {
  uint32_t edge = 1, beyond = 0;
};

/// Of a volume that no ranks share, calls `body(first, end)` for slices that are in memory meanwhile: all of them, or as many as are kept, one piece after the other.
template <class Body>
void forKeptSlices(const Volume& volume, const SliceGrouping& grouping, const std::stop_token& stop, const Body& body) {
  const uint32_t slices = volume.dims().z, kept = slicesKept(volume);
  const uint32_t step = kept == slices ? slices : std::max((kept - std::min(kept, grouping.beyond)) / grouping.edge, 1u) * grouping.edge;
  for (uint32_t first = 0; first < slices; first += std::min(step, slices - first)) {
    const uint32_t end = first + std::min(step, slices - first);
    const auto held = volume.hold({{0, first}, {volume.dims().y, end + std::min(grouping.beyond, slices - end)}}, stop);
    body(first, end);
  }
}

/// The same of all voxels, `body(first, end)` as they are counted; no slice sees another one.
template <class Body>
void forKeptVoxels(const Volume& volume, const std::stop_token& stop, const Body& body) {
  const size_t slice = size_t{volume.dims().x} * volume.dims().y;
  forKeptSlices(volume, {}, stop, [&](uint32_t first, uint32_t end) { body(first * slice, end * slice); });
}

}  // namespace warpscope
