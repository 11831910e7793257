// Surfaces on which a volume has a value: where a ray crosses them, and in what order. For host and device.
// Crossings between samples as Levoy 1988 and Engel et al. 2006 (section 15) have them; roots by the secant, a probe beside it at the tolerance and, where
// these do not halve the interval, bisection (after Dekker 1969): no more than three values for each halving.
#pragma once

#include "render/core/counters.h"
#include "render/effects/mode_settings.h"
#include "render/march/march.h"
#include "render/march/value_reader.h"

namespace warpscope {

/// How far along the ray a crossing may be from where it is reported, in volume units (smallest voxel edges): between two places this far apart the
/// interpolated value, in single precision, is on different sides of the surface's. Beyond 2^13 units from the ray's beginning: a step of float there.
inline constexpr float kSurfaceTolerance = 0x1p-10f;

struct Isosurface {
  float value = 0.0f;     ///< an interpolant
  float opacity = 1.0f;   ///< > 0
  glm::vec3 color{0.0f};  ///< linear, times the opacity
};

/// What is the same for all rays of a picture.
struct IsosurfaceSetup {
  static constexpr int kMost = static_cast<int>(IsoValues::kMost);

  int count = 0;
  Isosurface surfaces[kMost];
};

/// On which side of a surface's value a value is: what is as large lies inside.
WARPSCOPE_HD inline bool isInside(float value, float surface) { return value >= surface; }

/// A place in [a, b] where `valueAt`, a function of the distance, crosses `surface`, within kSurfaceTolerance; `atA` and `atB`, its values there, lie on
/// different sides. False if it has no finite value at a place where it is looked at.
template <class ValueAt>
WARPSCOPE_HD inline bool crossingBetween(const ValueAt& valueAt, float surface, float a, float atA, float b, float atB, float& crossing) {
  const bool isInsideA = isInside(atA, surface);
  // False where there is no value. `t` is between a and b.
  const auto look = [&](float t) {
    const float value = valueAt(t);
    if (!isFiniteVoxel(value)) return false;
    if (isInside(value, surface) == isInsideA)
      a = t, atA = value;
    else
      b = t, atB = value;
    return true;
  };
  const auto secant = [&] {
    const float beforeA = surface - atA, whole = atB - atA;
    return minOf(maxOf(mulAdd(b - a, beforeA / whole, a), a), b);
  };
  while (b - a > kSurfaceTolerance) {
    const float width = b - a, middle = mulAdd(0.5f, width, a);
    if (!(a < middle && middle < b)) break;  // no float is between them
    const float first = minOf(maxOf(secant(), mulAdd(0.25f, kSurfaceTolerance, a)), mulAdd(-0.25f, kSurfaceTolerance, b));
    if (a < first && first < b) {
      if (!look(first)) return false;
      // What is left may be all on one side of it: look at the other end of the tolerance.
      const float probe = a == first ? first + 0.75f * kSurfaceTolerance : first - 0.75f * kSurfaceTolerance;
      if (a < probe && probe < b && !look(probe)) return false;
    }
    if (b - a > 0.5f * width) {
      const float half = mulAdd(0.5f, b - a, a);
      if (a < half && half < b && !look(half)) return false;
    }
  }
  crossing = secant();
  return true;
}

/// A source for marchRay() below.
template <class Voxel, bool kHasHoles, bool kByCells>
class IsosurfaceSource {
 public:
  using March = StableMarch;
  using Setup = IsosurfaceSetup;
  static constexpr bool kLoadsCells = kByCells;
  static constexpr bool kLeavesOutHoles = kHasHoles;

  WARPSCOPE_HD IsosurfaceSource(const ModeView<Voxel, IsosurfaceSetup>& view, const Ray& ray, const RayLattice& lattice)
      : reader_(view.volume, ray), lattice_(lattice), setup_(view.setup), emptySpace_(view.volume.cells, reader_.origin(), reader_.direction(), lattice) {}

  /// Where the ray is looked at: the lattice's samples, where it enters (-1), where it leaves (the lattice's count).
  WARPSCOPE_HD float placeOf(int i) const {
    if (i < 0) return lattice_.t0;
    return i < lattice_.count ? lattice_.t(i) : lattice_.t0 + lattice_.length;
  }
  WARPSCOPE_HD float at(float t, int (&index)[3]) const { return reader_.at(t, index); }
  WARPSCOPE_HD float at(float t) const { return reader_.at(t); }
  /// The first place behind the i-th, whose voxel is `index`, that a surface may lie in front of; but the one before it has to be looked at.
  WARPSCOPE_HD int next(int i, const int (&index)[3]) const {
    return i < lattice_.count && emptySpace_.isKnown() ? maxOf(i + 1, emptySpace_.leapFromVoxel(i, index, lattice_)) : i + 1;
  }

  WARPSCOPE_HD const IsosurfaceSetup& setup() const { return setup_; }
  WARPSCOPE_HD const VolumeView<Voxel>& view() const { return reader_.view(); }

 private:
  ValueReader<Voxel, kHasHoles, kByCells> reader_;
  const RayLattice& lattice_;
  const IsosurfaceSetup& setup_;
  EmptySpace emptySpace_;
};

/// march.h's, for rays of which surfaces alone are seen: each is a sample without length. Samples [begin, end) stand for the surfaces between each of them
/// and the one before it, the last also for those behind it. Where the view's cells are known, those in front of which it leaps hold no surface: their
/// values are all on one side of each, since cells beside each other share the voxels between them.
template <class Voxel, bool kHasHoles, bool kByCells, class Light, class Gathered, class Sink>
WARPSCOPE_HD inline void marchRay(const RayPath& path, int begin, int end, IsosurfaceSource<Voxel, kHasHoles, kByCells>& source, const Light& light,
                                  const RayLimits& limits, Gathered& ray, Sink&& sink) {
  const IsosurfaceSetup& setup = source.setup();
  const int last = end == path.lattice.count ? end : end - 1;
  if (begin >= end) return;
  float through = ray.transmittance.value();
  float tBefore = source.placeOf(begin - 1), before = source.at(tBefore);
  for (int i = begin; i <= last;) {
    const float t = source.placeOf(i);
    int index[3];
    const float value = source.at(t, index);
    if (!kHasHoles || (isFiniteVoxel(before) && isFiniteVoxel(value))) {
      // Near to far; of surfaces at one place the first of the settings'.
      int order[IsosurfaceSetup::kMost];
      float places[IsosurfaceSetup::kMost];
      int found = 0;
      for (int s = 0; s < setup.count; ++s) {
        const float surface = setup.surfaces[s].value;
        float crossing;
        if (isInside(before, surface) == isInside(value, surface)) continue;
        if (!crossingBetween([&](float place) { return source.at(place); }, surface, tBefore, before, t, value, crossing)) continue;
        int slot = found++;
        for (; slot > 0 && crossing < places[slot - 1]; --slot) {
          places[slot] = places[slot - 1];
          order[slot] = order[slot - 1];
        }
        places[slot] = crossing;
        order[slot] = s;
      }
      for (int s = 0; s < found; ++s) {
        const Isosurface& surface = setup.surfaces[order[s]];
        WARPSCOPE_COUNT(surfaces, 1);
        glm::vec3 color(0.0f);
        if constexpr (Gathered::kWantsColor) color = light.shade({i, places[s], 0.0f, surface.opacity, surface.color}, path.ray, source, 0);
        if (through * surface.opacity >= limits.contribution &&
            !sink(CountingSample::behind(ray.transmittance.exact(), through, places[s], 0.0f, surface.opacity)))
          return;
        ray.add(PointSample{{i, places[s], 0.0f, surface.opacity}}, color, through);
        ray.transmittance.pass(surface.opacity);
        through = ray.transmittance.value();
        if (through < limits.stopBelow || !(through > 0.0f)) return;
      }
    }
    const int next = source.next(i, index);
    if (next == i + 1) {
      tBefore = t, before = value;
    } else {
      if (next > last) return;
      tBefore = source.placeOf(next - 1), before = source.at(tBefore);
    }
    i = next;
  }
}

}  // namespace warpscope
