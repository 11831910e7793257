// Neighbouring voxels of small types read as one word, and taken apart again many words at a time. For the CPU.
// Loads are what a march waits for: a word for two or four voxels saves them. Mirrors pairsOf() of voxel_access.h, which does so on a device.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "render/core/simd.h"

namespace warpscope {

/// Whether two neighbours fit into a word.
template <class Voxel>
inline constexpr bool kHasPairs = sizeof(Voxel) <= 2;
/// Whether four do.
template <class Voxel>
inline constexpr bool kHasQuads = sizeof(Voxel) == 1;

/// The word of the `kCount` voxels from `p` on.
template <int kCount, class Voxel>
uint32_t loadWord(const Voxel* p) {
  using Word = std::conditional_t<kCount * sizeof(Voxel) == 2, uint16_t, uint32_t>;
  static_assert(kCount * sizeof(Voxel) == sizeof(Word));
  Word word;
  std::memcpy(&word, p, sizeof word);
  return word;
}

/// Of words of `kCount` voxels, the `kPlace`-th of each as a number, with its sign.
template <class Voxel, int kCount, int kPlace>
FloatBatch voxelsOf(const UintBatch& words) {
  constexpr int bits = 8 * sizeof(Voxel);
  constexpr int fromLowest = std::endian::native == std::endian::little ? kPlace : kCount - 1 - kPlace;
  const IntBatch top = xsimd::batch_cast<int32_t>(words << (32 - bits * (fromLowest + 1)));
  if constexpr (std::is_signed_v<Voxel>)
    return xsimd::to_float(top >> (32 - bits));
  else
    return xsimd::to_float(xsimd::batch_cast<int32_t>(xsimd::batch_cast<uint32_t>(top) >> (32 - bits)));
}

}  // namespace warpscope
