// A ray's samples, near to far: one, or one for each of several parts of equal opacity. For host and device.
// Parts end at the marks k/N of accumulated opacity; over one another they are the ray (Porter, Duff 1984).
#pragma once

#include "render/march/ray_state.h"

namespace warpscope {

/// The most that settings may ask for.
inline constexpr int kMaxRaySamples = static_cast<int>(kSamplesPerRayRange.highest);

/// A part of a ray and what stands for it.
struct RaySample {
  DepthResult depth;
  glm::vec4 color;  ///< linear, premultiplied: what the part alone emits and holds back
};

/// 0..kMaxRaySamples of them, near to far.
class RaySamples {
 public:
  WARPSCOPE_HD int size() const { return size_; }
  WARPSCOPE_HD RaySample& operator[](int i) { return samples_[i]; }
  WARPSCOPE_HD const RaySample& operator[](int i) const { return samples_[i]; }
  WARPSCOPE_HD void clear() { size_ = 0; }
  /// There is room for as many as there are parts.
  WARPSCOPE_HD void add(const RaySample& sample) { samples_[size_++] = sample; }

 private:
  int size_ = 0;
  RaySample samples_[kMaxRaySamples];
};

/// Where a ray is cut into parts.
struct RayParts {
  float accumulatedEnd = 1.0f;  ///< opacity after the ray's last sample that counts
  int count = 1;

  /// The part in which a sample begins, `before` being the opacity in front of it; never one before `part`, where the
  /// last sample that counted began.
  WARPSCOPE_HD int partOf(float before, int part) const {
    while (part + 1 < count && before >= accumulatedEnd * (static_cast<float>(part + 1) / static_cast<float>(count)))
      ++part;
    return part;
  }
};

/// A ray that is marched part by part, so far. `Piece` gathers a part: a RayPiece, or a PieceOpacity where depths alone are wanted.
template <class Piece>
struct RayPart {
  Piece piece;       ///< of the part under way
  int part = 0;      ///< which that is
  bool any = false;  ///< a sample has counted
};

/// Marches samples [begin, end) of the path. A part begins with a sample that counts, and has what follows up to the next part's first;
/// the first part has what lies in front as well. Parts without a sample that counts do not come up. `onSample` gets every sample
/// that counts, its transmittance from the part's beginning on; `onPart` the piece, where another part begins. The other parameters are
/// marchRay's.
template <class Piece, class Source, class Light, class OnSample, class OnPart>
WARPSCOPE_HD inline void marchParts(const RayPath& path, int begin, int end, Source& source, const Light& light, const RayLimits& limits,
                                    const RayParts& parts, RayPart<Piece>& ray, const OnSample& onSample, const OnPart& onPart) {
  marchRay(path, begin, end, source, light, limits, ray.piece, [&](const CountingSample& sample) {
    const int next = parts.partOf(sample.accumulatedBefore(), ray.part);
    if (ray.any && next != ray.part) {
      onPart(ray.piece);
      ray.piece.restart();
    }
    ray.part = next;
    ray.any = true;
    onSample(CountingSample::behind(ray.piece.transmittance.alone().exact(), sample.t, sample.ds, sample.alpha));
    return true;
  });
}
/// As that, of the whole path: `onPart` gets the last part as well.
template <class Piece, class Source, class Light, class OnSample, class OnPart>
WARPSCOPE_HD inline void marchParts(const RayPath& path, Source& source, const Light& light, const RayLimits& limits,
                                    const RayParts& parts, const OnSample& onSample, const OnPart& onPart) {
  RayPart<Piece> ray;
  marchParts(path, 0, path.lattice.count, source, light, limits, parts, ray, onSample, onPart);
  if (ray.any) onPart(ray.piece);
}

/// Makes `found` the path's samples by the heuristic `depth`, one for each of up to `count` parts. `makeSource()` gives a
/// source at the path's beginning: the path is marched twice, three times for a two-pass heuristic, and nothing is kept
/// but the parts.
template <class Depth, class MakeSource, class Light>
WARPSCOPE_HD inline void findSamples(const Depth& depth, const RayPath& path, const MakeSource& makeSource, const Light& light,
                                     const RayLimits& limits, float threshold, int count, RaySamples& found) {
  found.clear();
  ProfileFold whole;
  {
    RayOpacity opacity;
    auto source = makeSource();
    marchRay(path, 0, path.lattice.count, source, light, limits, opacity, [&](const CountingSample& sample) {
      whole.add(sample);
      return true;
    });
  }
  if (!whole.any) return;
  const RayParts parts{whole.accumulatedEnd, count};
  ProfileFold profiles[Depth::kTwoPass ? kMaxRaySamples : 1];
  auto fold = depth.start(threshold, ProfileFold{});
  {
    auto source = makeSource();
    marchParts<RayPiece>(
        path, source, light, limits, parts,
        [&](const CountingSample& sample) {
          if constexpr (Depth::kTwoPass)
            profiles[found.size()].add(sample);
          else
            fold.add(sample);
        },
        [&](const RayPiece& piece) {
          found.add({depth.result(fold), piece.premultiplied()});
          fold = depth.start(threshold, ProfileFold{});
        });
  }
  if constexpr (Depth::kTwoPass) {
    int part = 0;
    fold = depth.start(threshold, profiles[0]);
    auto source = makeSource();
    marchParts<PieceOpacity>(
        path, source, light, limits, parts, [&](const CountingSample& sample) { fold.add(sample); },
        [&](const PieceOpacity&) {
          found[part].depth = depth.result(fold);
          if (++part < found.size()) fold = depth.start(threshold, profiles[part]);
        });
  }
}

}  // namespace warpscope
