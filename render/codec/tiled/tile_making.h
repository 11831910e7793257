// All values of a layer, each from its neighbours: in runs (neighbor_runs.h), and rows without gaps side by side (neighbor_rows.h).
#pragma once

#include <span>

#include "render/codec/neighbor_rows.h"
#include "render/codec/neighbor_runs.h"
#include "render/codec/tiled/tile_layer.h"

namespace warpscope {

/// How values are made in either; both make the same.
template <class InRuns, class InRows>
struct TileMaking {
  InRuns inRuns;
  InRows inRows;
};
template <class InRuns, class InRows>
TileMaking(InRuns, InRows) -> TileMaking<InRuns, InRows>;

/// Each making waits for what it made before, and none for another.
template <class... Makings>
void makeFromNeighbors(const TileLayer& layer, const Makings&... makings) {
  layer.forEachPart([&](std::span<const NeighborRun> runs) { makeFromNeighbors(runs, makings.inRuns...); }, [&](const NeighborRows& rows) { makeRows(rows, makings.inRows...); });
}

}  // namespace warpscope
