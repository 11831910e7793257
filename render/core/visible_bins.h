// Whether numbers between two of them show anything by a table, asked for each cell of a volume: for host and device.
// Gives TransferTable::anyVisible's answer, by one look-up where no piece of a bin has to be asked for itself.
#pragma once

#include <cstdint>
#include <vector>

#include "render/core/transfer_table.h"

namespace warpscope {

/// For each bin of `table` the least one from it on that shows anything, TransferTable::bins if there is none: twice
/// its index, and one more where it is refined and only some of its pieces show something.
std::vector<int32_t> nextVisibleBins(const TransferTable& table);

/// The memory is another's.
struct VisibleBins {
  TransferLookup table;
  const int32_t* next = nullptr;  ///< nextVisibleBins of the table

  /// True if any x in [lowest, highest] may have opacity; false only if none has.
  WARPSCOPE_HD bool any(float lowest, float highest) const {
    if (!(lowest <= highest)) return false;
    const int first = table.binOf(lowest), last = table.binOf(highest);
    const int code = next[first];
    if ((code >> 1) > last) return false;
    return isCertain(code, first, last) || anyOfPieces(lowest, highest, first, last);
  }
  /// Whether the bin of `code` = next[first], which is not beyond `last`, shows something wherever it is cut.
  WARPSCOPE_HD static bool isCertain(int code, int first, int last) {
    const int bin = code >> 1;
    return (code & 1) == 0 || (bin > first && bin < last);
  }
  /// any(), where `first` and `last` are the bins of its arguments and next[first] is not beyond `last`.
  WARPSCOPE_NOINLINE WARPSCOPE_HD bool anyOfPieces(float lowest, float highest, int first, int last) const {
    for (int bin = next[first] >> 1; bin <= last; bin = next[bin + 1] >> 1) {
      if (isCertain(next[bin], first, last)) return true;
      const TransferRefinement& all = table.refinements[static_cast<int>(-table.alphas[bin]) - 1];
      const int begin = bin == first ? table.refined(table.alphas[bin], lowest) : table.bins + all.first;
      const int end = bin == last ? table.refined(table.alphas[bin], highest) + 1 : table.bins + all.first + all.count;
      for (int entry = begin; entry < end; ++entry)
        if (table.alphas[entry] > 0.0f) return true;
      if (bin == last) return false;
    }
    return false;
  }
};

/// Interpolation may leave a cell's range by its rounding: three blends of two roundings each, and with holes eight
/// products, their sum and a quotient.
inline constexpr float kRangeSlack = 0x1p-20f;

/// Whether what is interpolated between voxels from `lowest` to `highest`, of which there are none if the first is
/// greater, may show anything.
WARPSCOPE_HD inline bool anyVisibleBetween(const VisibleBins& bins, float lowest, float highest) {
  const float slack = lowest < highest ? kRangeSlack * maxOf(absOf(lowest), absOf(highest)) : 0.0f;
  return lowest <= highest && bins.any(lowest - slack, highest + slack);
}

}  // namespace warpscope
