// Differences of values from what neighbours make likely, for all tiles of a picture on a device, and back. For .cu files and what they include.
// A warp goes through a tile, a row for each thread, each two columns behind the one above: what a pixel is predicted from is known when its turn comes, also to
// who decodes (a wavefront; cf. Lamport 1974, "The parallel execution of DO loops"). Neighbours are those of tile_layer.h.
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
};

struct FrontJobs {
  static constexpr uint32_t kMost = 4;

  FrontJob jobs[kMost];
  uint32_t count = 0;
  const int32_t* origins = nullptr;  ///< of each value's ray
  int bits = 0;                      ///< fineBitsOf()

  void add(FrontKind kind, uint32_t plane, uint32_t* values) { jobs[count++] = {kind, plane, values}; }
};

/// Planes from values.
void putFronts(const SheetView& view, const FrontJobs& jobs, cudaStream_t stream);
/// Values from planes. Nothing where the sheet is damaged or not full.
void takeFronts(const SheetView& view, const FrontJobs& jobs, cudaStream_t stream);

}  // namespace warpscope
