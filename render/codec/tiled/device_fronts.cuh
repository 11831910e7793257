// A tile gone through by a warp, a row for each thread, each two columns behind the one above: what a pixel is predicted from is known when its turn comes, also
// to who decodes (a wavefront; cf. Lamport 1974, "The parallel execution of DO loops"). Neighbours are those of tile_layer.h.
#pragma once

#include <cstdint>

#include "render/codec/band_layout.h"
#include "render/codec/tiled/tile_grid.h"
#include "render/cuda/warp_reduce.cuh"

namespace warpscope {

static_assert(kTileHeight == 32, "a row is a thread of a warp");

/// What of a pixel its neighbours are predicted from.
struct FrontValues {
  int32_t place = 0, end = 0;  ///< fine units
  uint32_t color = 0;
  uint32_t other = 0;
};

struct FrontNeighbors {
  FrontValues west, north, northWest;
};

__device__ inline FrontValues valuesAbove(const FrontValues& values) {
  return {__shfl_up_sync(kAllLanes, values.place, 1), __shfl_up_sync(kAllLanes, values.end, 1), __shfl_up_sync(kAllLanes, values.color, 1),
          __shfl_up_sync(kAllLanes, values.other, 1)};
}

/// Calls own = visit(column, row, neighbors) for each pixel of the tile that `covers(column, row)` says, which the calling thread's row has from the left to the
/// right. All threads of a warp must call.
template <class Covers, class Visit>
__device__ void goThroughTile(const TileRect& rect, const Covers& covers, const Visit& visit) {
  const uint32_t row = threadIdx.x % 32;
  FrontValues own, seen;                    // of the column before; what a pixel without neighbours is predicted from
  FrontValues north, northWest, northEast;  // of the row above
  bool isOwn = false, isNorth = false, isNorthWest = false, isNorthEast = false, hasSeen = false;
  const int steps = static_cast<int>(rect.width + 2 * (rect.height - 1));
  for (int step = 0; step < steps; ++step) {
    const int column = step - 2 * static_cast<int>(row);
    northWest = north;
    isNorthWest = isNorth;
    north = northEast;
    isNorth = isNorthEast;
    northEast = valuesAbove(own);
    isNorthEast = __shfl_up_sync(kAllLanes, isOwn, 1) && row > 0;
    FrontValues above = valuesAbove(seen);
    if (row == 0) above = {};
    const bool isInside = column >= 0 && column < static_cast<int>(rect.width) && row < rect.height;
    if (!isInside) {
      isOwn = false;
      continue;
    }
    if (!hasSeen) seen = above;
    const bool isCovered = covers(static_cast<uint32_t>(column), row);
    if (isCovered) {
      FrontNeighbors from;
      from.west = isOwn ? own : isNorth ? north : seen;
      from.north = isNorth ? north : from.west;
      from.northWest = isNorthWest ? northWest : from.north;
      own = seen = visit(static_cast<uint32_t>(column), row, from);
      hasSeen = true;
    }
    isOwn = isCovered;
  }
}

__device__ inline int32_t predictedChannel(const FrontNeighbors& from, uint32_t FrontValues::*values, int shift) {
  const auto channel = [&](const FrontValues& of) { return static_cast<int32_t>(of.*values >> shift & 255); };
  return predicted(channel(from.west), channel(from.north), channel(from.northWest));
}

}  // namespace warpscope
