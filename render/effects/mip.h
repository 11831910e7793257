// The greatest value along a ray (maximum intensity projection), and what is seen of it. For host and device.
// Wallis, Miller, Lerner, Kleerup 1989; cells of which no value can be the greatest are leapt over, after Mroz, Hauser, Groeller 2000.
#pragma once

#include "render/core/counters.h"
#include "render/core/visible_bins.h"
#include "render/march/march.h"
#include "render/march/value_reader.h"

namespace warpscope {

struct GreatestValue {
  bool any = false;
  float value = 0.0f;
  int i = 0;       ///< sample of the ray's lattice: the nearest of those that have the value
  float t = 0.0f;  ///< where it lies
};

/// What is the same for all rays of a picture. The memory is another's.
struct MipSetup {
  const float* highest = nullptr;  ///< Macrocells::highest(), or null: nothing is leapt over
  const float* lowest = nullptr;   ///< and Macrocells::lowest()
  float leastShown = -INFINITY;    ///< no value below it is shown: rays need not find out which of those is the greatest
  bool hidesBelow = false;         ///< nor is any shown that is in a cell which shows nothing: all that is hidden lies below all that is shown

  /// Cells around one that need not be looked into, as EmptyCells::distance(): 0 if the cell itself may have the greatest value.
  WARPSCOPE_HD int leapable(const EmptyCells& cells, const glm::ivec3& cell, const GreatestValue& greatest) const;
};

/// A value below which `table` shows none: a bin less than the least shown, and what bins' borders are off by.
WARPSCOPE_HD inline float leastShownValue(const TransferLookup& table, int firstVisibleBin) {
  if (firstVisibleBin <= 0 || !(table.scale > 0.0f)) return -INFINITY;
  return (static_cast<float>(firstVisibleBin - 1) - 0x1p-20f * absOf(table.offset) - table.offset) / table.scale;
}

/// Whether no value in a macrocell is greater than what a ray has met, or it makes no difference which is.
WARPSCOPE_HD inline bool isBeaten(const MipSetup& setup, const EmptyCells& cells, const glm::ivec3& cell, const GreatestValue& greatest) {
  const uint32_t row = static_cast<uint32_t>(cell.z) * static_cast<uint32_t>(cells.dims.y) + static_cast<uint32_t>(cell.y);
  const uint32_t place = row * static_cast<uint32_t>(cells.dims.x) + static_cast<uint32_t>(cell.x);
  const float low = setup.lowest[place], high = setup.highest[place];
  if (low > high) return true;  // it has no value
  // As anyVisibleBetween() has it.
  const float most = low < high ? high + kRangeSlack * maxOf(absOf(low), absOf(high)) : high;
  return (greatest.any && most <= greatest.value) || most < setup.leastShown;
}

WARPSCOPE_HD inline int MipSetup::leapable(const EmptyCells& cells, const glm::ivec3& cell, const GreatestValue& greatest) const {
  const int distance = hidesBelow ? cells.distance(cell) : 0;
  return distance > 0 ? distance : isBeaten(*this, cells, cell, greatest) ? 1 : 0;
}

/// A source for marchRay() below.
template <class Voxel, bool kHasHoles, bool kByCells>
class MipSource {
 public:
  using March = StableMarch;
  using Setup = MipSetup;
  static constexpr bool kLoadsCells = kByCells;
  static constexpr bool kLeavesOutHoles = kHasHoles;
  /// What is hidden takes part as well: a ray must not be cut to what is visible.
  static constexpr bool kTakesWholeRays = true;

  WARPSCOPE_HD MipSource(const ModeView<Voxel, MipSetup>& view, const Ray& ray, const RayLattice& lattice)
      : reader_(view.volume, ray), lattice_(lattice), setup_(view.setup), emptySpace_(view.volume.cells, reader_.origin(), reader_.direction(), lattice) {}

  /// Among samples [begin, end) of the lattice. With cells to leap over, one below setup.leastShown may be missed for another. `greatest`: of those in front.
  WARPSCOPE_HD GreatestValue find(int begin, int end, GreatestValue greatest = {}) const {
    for (int i = begin; i < end;) {
      const float t = lattice_.t(i);
      int index[3];
      const float value = reader_.at(t, index);
      if ((!kHasHoles || isFiniteVoxel(value)) && (!greatest.any || value > greatest.value)) {
        greatest = {true, value, i, t};
        ++i;
        continue;  // the next one is likely to be greater
      }
      i = setup_.highest != nullptr ? next(i, index, greatest) : i + 1;
    }
    return greatest;
  }

  WARPSCOPE_HD const VolumeView<Voxel>& view() const { return reader_.view(); }

 private:
  /// The first sample behind the i-th that may have a greater value.
  WARPSCOPE_HD int next(int i, const int (&index)[3], const GreatestValue& greatest) const {
    const EmptyCells& cells = view().cells;
    const glm::ivec3 cell(index[0] >> cells.edgeBits, index[1] >> cells.edgeBits, index[2] >> cells.edgeBits);
    const int distance = setup_.leapable(cells, cell, greatest);
    return distance > 0 ? emptySpace_.leap(i, cell, distance, lattice_) : i + 1;
  }

  ValueReader<Voxel, kHasHoles, kByCells> reader_;
  const RayLattice& lattice_;
  const MipSetup& setup_;
  EmptySpace emptySpace_;
};

/// What is seen of a ray's greatest value: one sample, without light. It is no length of matter: its opacity is the function's over one unit, whatever the
/// step, as in VTK, which leaves out its correction in this mode.
template <class Gathered, class Sink>
WARPSCOPE_HD inline void passGreatest(const GreatestValue& found, const TransferLookup& transfer, const RayLimits& limits, Gathered& ray, Sink&& sink) {
  if (!found.any) return;
  WARPSCOPE_COUNT(maxima, 1);
  const int entry = transfer.entryOf(found.value);
  const float ofStep = transfer.alphas[entry], alpha = transfer.unitAlphas[entry];
  if (!(ofStep > 0.0f)) return;
  const float through = ray.transmittance.value();
  if (through * alpha >= limits.contribution && !sink(CountingSample::behind(ray.transmittance.exact(), through, found.t, 0.0f, alpha))) return;
  if constexpr (Gathered::kWantsColor) ray.add(PointSample{{found.i, found.t, 0.0f, alpha}}, glm::vec3(transfer.entries[entry]) * (alpha / ofStep), through);
  ray.transmittance.pass(alpha);
}

/// march.h's, for rays of which the greatest value alone is seen.
template <class Voxel, bool kHasHoles, bool kByCells, class Light, class Gathered, class Sink>
WARPSCOPE_HD inline void marchRay(const RayPath&, int begin, int end, MipSource<Voxel, kHasHoles, kByCells>& source, const Light&, const RayLimits& limits,
                                  Gathered& ray, Sink&& sink) {
  passGreatest(source.find(begin, end), source.view().transfer, limits, ray, sink);
}

}  // namespace warpscope
