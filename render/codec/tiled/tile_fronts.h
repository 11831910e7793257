// Differences of values from what neighbours make likely, for all tiles of a picture on a device, and back. For .cu files and what they include.
// Who decodes goes through a tile with a warp, a row for each thread, each two columns behind the one above: what a pixel is predicted from is known when its turn
// comes (a wavefront; cf. Lamport 1974, "The parallel execution of DO loops"). Neighbours are those of tile_layer.h.
#pragma once

#include <cuda_runtime.h>

#include <cstdint>

#include "render/codec/tiled/device_sheet.h"

namespace warpscope {

/// What is predicted of values.
enum class FrontKind : uint32_t {
  place,     ///< numbers, in fine units of rays whose origins differ
  gap,       ///< in the front layer as `place`, behind it numbers as they are
  radius,    ///< radius codes
  color,     ///< 4 channels, green taken off red and blue: planes of opacity, green, red, blue
  channels,  ///< the 2 lower channels
};

/// Values of one kind and where their differences are.
struct FrontJob {
  FrontKind kind = FrontKind::place;
  uint32_t plane = 0;  ///< the first of the sheet's planes of numbers (place, gap, radius) or bytes
  uint32_t* values = nullptr;  ///< in the order of streams

  WARPSCOPE_HD bool isNumber() const { return kind == FrontKind::place || kind == FrontKind::gap || kind == FrontKind::radius; }
  /// Of the sheet, one after the other.
  WARPSCOPE_HD uint32_t planes() const { return kind == FrontKind::color ? 4 : kind == FrontKind::channels ? 2 : 1; }
  /// Whether values are places on rays that begin at origins.
  WARPSCOPE_HD bool hasOrigins(uint32_t layer) const { return kind == FrontKind::place || (kind == FrontKind::gap && layer == 0); }
};

struct FrontJobs {
  static constexpr uint32_t kMost = 4;

  FrontJob jobs[kMost];
  uint32_t count = 0;
  const int32_t* origins = nullptr;  ///< of each value's ray
  int bits = 0;                      ///< fineBitsOf()

  /// At most 8 planes in all.
  void add(FrontKind kind, uint32_t plane, uint32_t* values) { jobs[count++] = {kind, plane, values}; }
  /// The sheet's planes that come of them: a bit each, numbers first.
  uint32_t planes(const SheetForm& form) const {
    uint32_t planes = 0;
    for (uint32_t i = 0; i < count; ++i) planes |= ((1u << jobs[i].planes()) - 1) << (jobs[i].isNumber() ? jobs[i].plane : form.numbers + jobs[i].plane);
    return planes;
  }
};

/// Planes from values; counts their symbols in the view's histograms.
void putFronts(const SheetView& view, const FrontJobs& jobs, cudaStream_t stream);
/// Values from planes. Nothing where the sheet is damaged or not full.
void takeFronts(const SheetView& view, const FrontJobs& jobs, cudaStream_t stream);

}  // namespace warpscope
