// Where the segments of some rays begin among all, found on all cores.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "render/core/parallel.h"
#include "render/march/frame_segments.h"

namespace warpscope {

inline constexpr uint8_t kUnusedRayBits = 0x60;  ///< of RaySegmentCount: none may be set

inline size_t countOf(std::span<const RaySegmentCount> rays) {
  size_t count = 0;
  for (const RaySegmentCount ray : rays) count += static_cast<size_t>(ray.count());
  return count;
}

/// Of each piece of so many rays, and how many segments there are in all.
inline std::vector<size_t> segmentStarts(std::span<const RaySegmentCount> rays, size_t piece) {
  const size_t pieces = (rays.size() + piece - 1) / piece;
  std::vector<size_t> starts(pieces + 1, 0);
  parallelForRanges(pieces, 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) starts[i + 1] = countOf(rays.subspan(i * piece, std::min(piece, rays.size() - i * piece)));
  });
  for (size_t i = 0; i < pieces; ++i) starts[i + 1] += starts[i];
  return starts;
}

}  // namespace warpscope
