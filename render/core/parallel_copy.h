// Bytes copied on all cores: one takes longer than a link to a device.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "render/core/parallel.h"

namespace warpscope {

inline void parallelCopy(std::byte* to, const std::byte* from, size_t bytes) {
  constexpr size_t kPiece = size_t{1} << 18;
  parallelForRanges((bytes + kPiece - 1) / kPiece, 1, [=](size_t begin, size_t end) {
    std::memcpy(to + begin * kPiece, from + begin * kPiece, std::min(end * kPiece, bytes) - begin * kPiece);
  });
}

}  // namespace warpscope
