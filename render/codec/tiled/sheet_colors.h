// Where a layer of a tile has the differences of its colours, of samples and of segments.
#pragma once

#include "render/codec/color_differences.h"
#include "render/codec/tiled/tiled_sheet.h"

namespace warpscope {

/// `Bytes`: the planes of bytes that such layers have.
template <class Bytes>
ColorDifferences differencesIn(SheetLayer& planes) {
  const auto plane = [&](Bytes bytes) { return planes.byte(static_cast<size_t>(bytes)).data(); };
  return {plane(Bytes::alpha), plane(Bytes::green), plane(Bytes::red), plane(Bytes::blue)};
}

}  // namespace warpscope
