// The greatest value along a ray on the CPU: values of a batch of samples are interpolated at once.
// The formulas of mip.h and of volume_source.h, in the same order: the same bits as one sample at a time.
#pragma once

#include <algorithm>
#include <bit>

#include "render/effects/mip.h"
#include "render/march/volume_source.h"

namespace warpscope {

/// As MipSource.
template <class Voxel, bool kHasHoles>
class MipBatchSource {
 public:
  using March = StableMarch;
  using Setup = MipSetup;
  static constexpr int kBatch = kBatchLanes;
  static constexpr bool kLoadsCells = false;
  static constexpr bool kLeavesOutHoles = kHasHoles;
  static constexpr bool kTakesWholeRays = true;

  MipBatchSource(const ModeView<Voxel, MipSetup>& view, const Ray& ray, const RayLattice& lattice)
      : source_(view.volume, ray, lattice),
        lattice_(lattice),
        setup_(view.setup),
        emptySpace_(view.volume.cells, view.volume.voxelOrigin(ray), view.volume.voxelDirection(ray), lattice) {}

  /// Among samples [begin, end) of the lattice, as MipSource::find. `greatest`: of those in front.
  GreatestValue find(int begin, int end, GreatestValue greatest = {}) {
    const int last = lattice_.count - 1, wholeEnd = std::min(end, last);
    int i = skip(begin, greatest);
    while (i < wholeEnd) {
      const int n = std::min(wholeEnd - i, kBatch);
      const FloatBatch values = source_.values(i);
      alignas(64) float value[kBatch];
      values.store_aligned(value);
      if constexpr (kHasHoles) {
        for (int k = 0; k < n; ++k) take(value[k], i + k, greatest);
      } else {
        uint32_t candidates = (uint32_t{2} << (n - 1)) - 1;
        if (greatest.any) candidates &= bitsOf(values > FloatBatch(greatest.value));
        for (; candidates != 0; candidates &= candidates - 1) {
          const int k = std::countr_zero(candidates);
          take(value[k], i + k, greatest);
        }
      }
      i = skip(i + n, greatest);
    }
    if (i == last && end == lattice_.count) take(source_.valueOfLast(), last, greatest);
    if (greatest.any) greatest.t = lattice_.t(greatest.i);
    return greatest;
  }

  const VolumeView<Voxel>& view() const { return source_.view(); }

 private:
  void take(float value, int i, GreatestValue& greatest) const {
    if (kHasHoles && !isFiniteVoxel(value)) return;
    if (!greatest.any || value > greatest.value) greatest = {true, value, i};
  }

  /// The first sample from the i-th on that may have a greater value; the lattice's count if there is none.
  int skip(int i, const GreatestValue& greatest) const {
    if (setup_.highest == nullptr) return i;
    while (i < lattice_.count) {
      const glm::ivec3 cell = emptySpace_.cellAt(lattice_.t(i));
      const int distance = setup_.leapable(view().cells, cell, greatest);
      if (distance == 0) return i;
      i = emptySpace_.leap(i, cell, distance, lattice_);
    }
    return i;
  }

  VolumeSource<Voxel, kHasHoles> source_;
  const RayLattice& lattice_;
  const MipSetup& setup_;
  EmptySpace emptySpace_;
};

/// As for MipSource.
template <class Voxel, bool kHasHoles, class Light, class Gathered, class Sink>
inline void marchRay(const RayPath&, int begin, int end, MipBatchSource<Voxel, kHasHoles>& source, const Light&, const RayLimits& limits, Gathered& ray,
                     Sink&& sink) {
  passGreatest(source.find(begin, end), source.view().transfer, limits, ray, sink);
}

}  // namespace warpscope
