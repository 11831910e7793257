// The k nearest hits along a ray, nearest first, collected one by one in any order. For host and device.
// A bounded list kept sorted by insertion, after Gribble, Naveros, Kerzner 2014 ("Multi-Hit Ray Traversal", JCGT 3(1)); ours decides ties by
// id, so that the order of arrival does not matter.
#pragma once

#include "render/core/host_device.h"

#include <cstdint>

#include "render/core/ray_sphere.h"
#include "render/core/sample.h"

namespace warpscope {

/// The most hits a ray that anyone may ask for.
inline constexpr int kMaxHits = 16;

/// Holds at most `Capacity` hits. All loops are over constant bounds, so that a device can keep the list in registers.
template <int Capacity>
class NearestHits {
  static_assert(Capacity >= 1 && Capacity <= kMaxHits);

 public:
  WARPSCOPE_HD NearestHits() {
    for (int i = 0; i < Capacity; ++i) {
      t_[i] = kNoHit;
      id_[i] = kNoSample;
    }
  }

  /// Takes the hit unless it is kNoHit or comes after as many as fit. Hits are ordered by (t, id); each id may come once only.
  WARPSCOPE_HD void insert(float t, uint32_t id) {
    if (!(t < kNoHit) || !isBefore(t, id, t_[Capacity - 1], id_[Capacity - 1])) return;
    // From the far end: whatever comes after the new hit moves on by one, and the last one drops out.
    for (int i = Capacity - 1; i > 0; --i) {
      if (isBefore(t, id, t_[i - 1], id_[i - 1])) {
        t_[i] = t_[i - 1];
        id_[i] = id_[i - 1];
      } else if (isBefore(t, id, t_[i], id_[i])) {
        t_[i] = t;
        id_[i] = id;
      }
    }
    if (isBefore(t, id, t_[0], id_[0])) {
      t_[0] = t;
      id_[0] = id;
    }
  }

  /// Hits beyond this distance would not be taken; kNoHit as long as there is room.
  WARPSCOPE_HD const float& farthest() const { return t_[Capacity - 1]; }

  /// Of the i-th hit, kNoHit and kNoSample beyond the last one.
  WARPSCOPE_HD float t(int i) const { return t_[i]; }
  WARPSCOPE_HD uint32_t id(int i) const { return id_[i]; }

 private:
  WARPSCOPE_HD static bool isBefore(float t, uint32_t id, float otherT, uint32_t otherId) {
    return t < otherT || (t == otherT && id < otherId);
  }

  float t_[Capacity];
  uint32_t id_[Capacity];
};

}  // namespace warpscope
