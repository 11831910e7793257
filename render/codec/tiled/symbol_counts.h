// How often each symbol of a plane occurs: what models are made of (ans_model.h).
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "render/codec/tiled/ans.h"

namespace warpscope {

class SymbolCounts {
 public:
  void add(std::span<const uint8_t> symbols);
  void addTo(std::array<uint32_t, kAnsSymbols>& counts) const;

 private:
  void addAll(const uint8_t* symbols, size_t count);

  /// In turns: what comes next is often what came last, and need not wait until that has been counted.
  std::array<std::array<uint32_t, kAnsSymbols>, 4> counts_{};
};

}  // namespace warpscope
