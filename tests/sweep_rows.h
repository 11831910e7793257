// Rows of sweeps as tests make them up.
#pragma once

#include <string_view>

#include "app/experiment/sweep_result.h"

namespace warpscope {

/// What a technique showed at an angle, in pictures that wide, of a server that marches so.
inline SweepRow sweepRow(std::string_view technique, double angleDeg, double flip, double drawMs, const MarchSettings& march = {}, uint32_t side = 512) {
  SweepRow row;
  row.configuration.technique = &findWarp(technique);
  row.configuration.march = march;
  row.configuration.serverSidePx = side;
  row.configuration = normalized(row.configuration);
  row.angleDeg = angleDeg;
  row.errors.flip = flip;
  row.draw.medianMs = drawMs;
  return row;
}

}  // namespace warpscope
