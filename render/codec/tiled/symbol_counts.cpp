// Most symbols are small differences, around 0: these are counted a block at a time, the others one by one.
// See symbol_counts.h.
#include "render/codec/tiled/symbol_counts.h"

#include <bit>

#include "render/codec/tiled/byte_block.h"

namespace warpscope {

void SymbolCounts::add(std::span<const uint8_t> symbols) {
  const uint8_t* const all = symbols.data();
  size_t done = 0;
#if defined(WARPSCOPE_HAS_BYTE_BLOCKS) && defined(__POPCNT__)
  constexpr int kSmall = 4;  // symbols from -kSmall to kSmall - 1, which wrap around
  std::array<uint32_t, 2 * kSmall> small{};
  for (; done + ByteBlock::kSize <= symbols.size(); done += ByteBlock::kSize) {
    const ByteBlock block(all + done);
    uint64_t found = 0;
    for (int s = 0; s < 2 * kSmall; ++s) {
      const uint64_t own = block.equalTo(static_cast<uint8_t>(s - kSmall));
      small[static_cast<size_t>(s)] += static_cast<uint32_t>(std::popcount(own));
      found |= own;
    }
    uint64_t others = ~found;
    for (size_t turn = 0; others != 0; others &= others - 1) ++counts_[turn++ % counts_.size()][all[done + static_cast<size_t>(std::countr_zero(others))]];
  }
  for (int s = 0; s < 2 * kSmall; ++s) counts_[0][static_cast<uint8_t>(s - kSmall)] += small[static_cast<size_t>(s)];
#endif
  addAll(all + done, symbols.size() - done);
}

void SymbolCounts::addAll(const uint8_t* symbols, size_t count) {
  for (size_t i = 0; i < count; ++i) ++counts_[i % counts_.size()][symbols[i]];
}

void SymbolCounts::addTo(std::array<uint32_t, kAnsSymbols>& counts) const {
  for (const auto& own : counts_)
    for (size_t s = 0; s < kAnsSymbols; ++s) counts[s] += own[s];
}

}  // namespace warpscope
