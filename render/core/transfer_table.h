// The table that marching reads a transfer function from: bins of equal width, corrected for one step length, and pieces where a bin is too coarse.
// Steps stay where they were written, to the last bit of the number that is looked up, and so does what is visible at all.
#pragma once

#include <cstdint>
#include <vector>

#include "render/core/transfer_function.h"

namespace warpscope {

/// Where a bin is told apart further: its pieces.
struct TransferRefinement {
  int32_t first = 0;
  int32_t count = 0;  ///< at least 1
};

/// A table's memory, for host and device. Entries are those of the bins, then those of the pieces.
///
/// What is read at x, in the units of the table's function:
///  - At every whole number of a table of whole numbers (TransferDomain::isWhole), the function at x; colour and opacity are its floats, corrected.
///  - Elsewhere the function at some x' in the same bin or piece, where no channel of what is read, and no opacity, is farther than kMostVariation from
///    what is at x, and where something is visible if and only if it is at x. But for feet of ramps: where the function rises out of nothing, what
///    is below TransferTable::kLeastShown may be left out, up to the end of the bin.
///  - Bins' borders are those of x * scale + offset in one rounding: exact for whole numbers, else off by 2^-22 bins at most for each bin, or each unit of
///    the offset. Bins that a step is nearer to than that are refined.
struct TransferLookup {
  const glm::vec4* entries = nullptr;  ///< linear colour premultiplied by the opacity of a step, and that opacity
  const float* alphas = nullptr;       ///< the entries' opacities alone; of a bin that is refined, minus one and the refinement's index: < 0
  const float* unitAlphas = nullptr;   ///< opacity over one unit of volume space
  const TransferRefinement* refinements = nullptr;
  const float* begins = nullptr;       ///< of each piece: the least x in it; ascending within a bin
  float scale = 0.0f;                  ///< bins for a unit of x
  float offset = 0.0f;                 ///< bins between that of 0 and the first
  bool isRefined = false;              ///< any bin is: refinements are not empty
  int32_t bins = 1;                    ///< the first holds all below the second, the last all above the one before it

  /// The bin of x; NaN's is the first. Float is float or a vector of floats.
  template <class Float>
  WARPSCOPE_HD auto binOf(const Float& x) const {
    return truncatedWithin(mulAdd(x, Float(scale), Float(offset)), bins - 1);
  }
  /// The entry of x where its bin's alpha is negative. Seldom: kept apart, so that it takes no registers from loops.
  WARPSCOPE_NOINLINE WARPSCOPE_HD int refined(float alpha, float x) const {
    const TransferRefinement& pieces = refinements[static_cast<int>(-alpha) - 1];
    int low = pieces.first, high = pieces.first + pieces.count;  // the one that is looked for is in [low, high)
    while (high - low > 1) {
      const int middle = (low + high) / 2;
      if (begins[middle] <= x)
        low = middle;
      else
        high = middle;
    }
    return bins + low;
  }
  /// The entry of x.
  WARPSCOPE_HD int entryOf(float x) const {
    const int bin = binOf(x);
    return alphas[bin] < 0.0f ? refined(alphas[bin], x) : bin;
  }
};

/// What numbers are looked up.
struct TransferDomain {
  float lower = 0.0f;  ///< the least
  float upper = 1.0f;  ///< the greatest
  bool isWhole = false;  ///< whole numbers of at most 16 bits, and blends of them
};

/// The host's memory behind a TransferLookup.
struct TransferTable {
  static constexpr int kBins = 4096;  ///< about as many; of whole numbers one for each, if these are more
  /// By how much what is read may differ within a bin or piece: premultiplied channels and opacity of a step, and opacity of a unit.
  static constexpr float kMostVariation = 1.0f / 128;
  /// Opacity of a unit at the feet of ramps that may be left out: what lets no sample count by itself. A bin that has a foot would have to be
  /// refined, and nearly every function has one; on devices, marches that find refined bins take 3 to 6 % longer.
  static constexpr float kLeastShown = 1.0f / 1024;

  std::vector<glm::vec4> entries;
  std::vector<float> alphas;
  std::vector<float> unitAlphas;
  std::vector<TransferRefinement> refinements;
  std::vector<float> begins;
  std::vector<int32_t> visibleBefore;  ///< bins + 1: how many of the first i bins show anything
  float scale = 0.0f, offset = 0.0f;
  int32_t bins = 1;
  float step = 1.0f;  ///< volume units that the opacities are corrected for

  /// Points into this table, which must stay.
  TransferLookup lookup() const;
  /// True if any x in [lowest, highest] may have opacity; false only if none has.
  bool anyVisible(float lowest, float highest) const;
  /// Makes visibleBefore from `alphas`, of a table without refinements.
  void countVisible();
};

/// Bakes `function` over the domain, for steps of `step` volume units. Its corners are taken as the least floats that are not below them.
TransferTable bakeTransferTable(const TransferFunction& function, const TransferDomain& domain, float step);

}  // namespace warpscope
