// All values of a layer, each from its neighbours: in runs (neighbor_runs.h), and rows without gaps side by side (neighbor_rows.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "render/codec/color_differences.h"
#include "render/codec/neighbor_rows.h"
#include "render/codec/neighbor_runs.h"
#include "render/codec/place_differences.h"
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

/// Of the same differences (place_differences.h, color_differences.h).
inline auto makingTilePlaces(const FineScale& scale, const uint32_t* differences, int32_t* slots, int32_t* places) {
  return TileMaking{makingPlaces(scale, [differences](size_t k) { return differences[k]; }, slots, places),
                    RowMaking(PlacesInRows{scale, differences, slots, places})};
}
inline auto makingTileNumbers(const uint32_t* differences, int32_t* slots) {
  return TileMaking{makingNumbers(differences, slots), RowMaking(NumbersInRows{{differences, slots}})};
}
/// The differences are not where colours go.
inline auto makingTileColors(const Rgba8* differences, Rgba8* slots) {
  return TileMaking{makingColors(differences, slots), RowMaking(ColorsInRows{{differences, slots}})};
}

/// Each making waits for what it made before, and none for another.
template <class... Makings>
void makeFromNeighbors(const TileLayer& layer, const Makings&... makings) {
  layer.forEachPart([&](std::span<const NeighborRun> runs) { makeFromNeighbors(runs, makings.inRuns...); }, [&](const NeighborRows& rows) { makeRows(rows, makings.inRows...); });
}

}  // namespace warpscope
