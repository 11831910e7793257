// Pre-integrated classification: opacity and colour of a step along which the value goes straight from one to another, from a table of two dimensions.
// Max, Hanrahan, Crawfis 1990; Engel, Kraus, Ertl 2001 (sections 3 and 4). Here a step is composited of pieces, so that its front hides its back.
#pragma once

#include <cstdint>
#include <vector>

#include "render/core/transfer_table.h"

namespace warpscope {

/// A table's memory, for host and device: nodes x nodes entries, that of a step from node f to node b at f * nodes + b. Between nodes they are blended.
/// Nodes are values, the least first; between them the function may do what it likes, and what it does there is in every entry of a step across it.
struct SegmentLookup {
  /// Three stretches of nodes of equal distances: below what changes, there, and above.
  struct Stretch {
    float begin = 0.0f;  ///< value of its first node
    float scale = 0.0f;  ///< nodes for a unit of value
    float count = 0.0f;  ///< of steps between its nodes; a stretch may have none
  };
  static constexpr int kStretches = 3;

  const glm::vec4* entries = nullptr;  ///< linear colour premultiplied by the opacity of a step, and that opacity
  const float* alphas = nullptr;       ///< the entries' opacities alone
  const float* unitAlphas = nullptr;   ///< opacity of a step of one unit
  Stretch stretches[kStretches];
  int32_t nodes = 2;  ///< at least 2

  /// Where a value is among the nodes, 0..nodes-1. Float is float or a vector of floats.
  template <class Float>
  WARPSCOPE_HD Float placeOf(const Float& value) const {
    Float place(0.0f);
    for (const Stretch& stretch : stretches)
      place = place + minOf(maxOf((value - Float(stretch.begin)) * Float(stretch.scale), Float(0.0f)), Float(stretch.count));
    return place;
  }
};

/// Between four numbers, `front` and `back` of the way.
template <class Float>
WARPSCOPE_HD inline Float blended(const Float (&corners)[4], const Float& front, const Float& back) {
  const Float near = mulAdd(back, corners[1] - corners[0], corners[0]);
  const Float far = mulAdd(back, corners[3] - corners[2], corners[2]);
  return mulAdd(front, far - near, near);
}

/// A step from one value to another, found among the nodes.
struct SegmentPlace {
  int32_t first = 0;   ///< the entry of both lower nodes
  float front = 0.0f;  ///< of the way to the next, 0..1
  float back = 0.0f;
};

WARPSCOPE_HD inline SegmentPlace segmentPlace(const SegmentLookup& table, float frontPlace, float backPlace) {
  const int front = truncatedWithin(frontPlace, table.nodes - 2), back = truncatedWithin(backPlace, table.nodes - 2);
  return {front * table.nodes + back, frontPlace - static_cast<float>(front), backPlace - static_cast<float>(back)};
}

/// Of `alphas` or `unitAlphas`: 0 exactly where all four are.
WARPSCOPE_HD inline float alphaOf(const SegmentLookup& table, const float* alphas, const SegmentPlace& place) {
  const float* const first = alphas + place.first;
  const float corners[4] = {first[0], first[1], first[table.nodes], first[table.nodes + 1]};
  return minOf(blended(corners, place.front, place.back), 1.0f);
}
WARPSCOPE_HD inline glm::vec3 colorOf(const SegmentLookup& table, const SegmentPlace& place) {
  const glm::vec4* const first = table.entries + place.first;
#if defined(__CUDA_ARCH__)
  const auto entry = [&](int i) {
    const float4 wide = reinterpret_cast<const float4*>(first)[i];  // one load; device memory is aligned
    return glm::vec3(wide.x, wide.y, wide.z);
  };
#else
  const auto entry = [&](int i) { return glm::vec3(first[i]); };
#endif
  const glm::vec3 all[4] = {entry(0), entry(1), entry(table.nodes), entry(table.nodes + 1)};
  glm::vec3 color;
  for (int channel = 0; channel < 3; ++channel) {
    const float corners[4] = {all[0][channel], all[1][channel], all[2][channel], all[3][channel]};
    color[channel] = blended(corners, place.front, place.back);
  }
  return color;
}

/// The host's memory behind a SegmentLookup.
struct SegmentTable {
  static constexpr int kInner = 255;  ///< steps between nodes where the function changes, or fewer where numbers are whole
  static constexpr int kOuter = 16;   ///< and on each side of that, where it is constant
  static constexpr int kPieces = 16;  ///< of which a step is composited, at most

  std::vector<glm::vec4> entries;
  std::vector<float> alphas, unitAlphas;
  SegmentLookup::Stretch stretches[SegmentLookup::kStretches];
  int32_t nodes = 0;  ///< 0: there is no table
  float mostOpacity = 0.0f;

  /// Points into this table, which must stay.
  SegmentLookup lookup() const;
};

/// Bakes `function` over the domain, for steps of `step` volume units.
SegmentTable bakeSegmentTable(const TransferFunction& function, const TransferDomain& domain, float step);

/// What shows anything by `segments`, as a table of bins that has opacity 1 there and 0 elsewhere: for those who leap over what is empty. A range of values
/// that shows nothing by it holds no step that has any opacity.
TransferTable visibleBySegments(const SegmentTable& segments);

}  // namespace warpscope
