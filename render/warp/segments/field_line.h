// A ray of a new camera as a line in the picture of an old one, and how far a walk along it has got. For host and device.
// A line in space is a line in the old picture, on which 1 / depth is linear (Heckbert, Moreton 1991): the ray is clipped to the old frustum, its ends are projected,
// and the picture's line is stepped along. Deviations: all that is looked for (borders of pixels, ends of segments) is found on the picture's line, where it goes
// straight, so that places in space are asked for where there is matter alone, and no difference of two vanishes where both eyes nearly coincide and the line is
// hardly a point.
#pragma once

#include <bit>

#include "render/core/box.h"
#include "render/core/ray.h"
#include "render/warp/segments/fill_reason.h"
#include "render/warp/segments/segment_field.h"

namespace warpscope {

/// The part of a ray inside of what segments are of.
WARPSCOPE_HD inline RayInterval partInside(const Box& bounds, const Ray& ray) {
  return intersectBox(reciprocalOf(ray.origin, ray.direction), bounds, 0.0f, std::numeric_limits<float>::infinity());
}

/// The part of a ray that is in the old frustum, as a line in the old picture: places are told by `s`, which goes straight along that line and is 0 where the line
/// is farthest from the old eye, so that single precision tells places apart there, where most of space is.
struct FieldLine {
  float t0 = 0.0f, t1 = 0.0f;           ///< where the ray comes in and goes out; t1 <= t0 where it does not
  float begin = 0.0f, end = 0.0f;       ///< s there: -1 and 0 where depths grow along the ray, 0 and 1 where they shrink
  float x0 = 0.0f, y0 = 0.0f;           ///< in the old picture, cells, at s = 0
  float dx = 0.0f, dy = 0.0f;           ///< by s
  float depth0 = 0.0f, depths = 0.0f;   ///< picture depth at s = 0, and by s
  float ratio = 1.0f;                   ///< of the greatest and least forward depth; at least 1

  WARPSCOPE_HD bool isRising() const { return begin < 0.0f; }
  WARPSCOPE_HD float depthAt(float s) const { return mulAdd(s, depths, depth0); }
  WARPSCOPE_HD float divisorAt(float s) const { return mulAdd(absOf(s), ratio - 1.0f, 1.0f); }
  /// Distance along the ray.
  WARPSCOPE_HD float tAt(float s) const {
    const float way = s * ratio / divisorAt(s);
    return mulAdd(way, t1 - t0, isRising() ? t1 : t0);
  }
};

/// The part of [tNear, tFar] of a ray in front of which the frame's camera was. `shift`: 0.5 for cells between centres, 0 for those about them.
[[gnu::flatten]] WARPSCOPE_HD inline FieldLine makeFieldLine(const SegmentField& field, const Ray& ray, float tNear, float tFar, float shift) {
  const PixelGrid& grid = field.pixels;
  const glm::vec3 offset = ray.origin - grid.anchor;
  const glm::vec3 o(glm::dot(offset, grid.right), glm::dot(offset, grid.up), glm::dot(offset, grid.forward));
  const glm::vec3 d(glm::dot(ray.direction, grid.right), glm::dot(ray.direction, grid.up), glm::dot(ray.direction, grid.forward));
  // In front of the near plane there is nothing to be seen, and behind an eye that is inside the volume nothing was. Not so near to the eye that rounding of where the
  // ray begins could put it behind.
  const float leastFromEye = maxOf(field.depths.leastFromEye(), absOf(o.z) * 0x1p-20f), leastDepth = leastFromEye - grid.nearDepth;
  FieldLine line;
  line.t0 = tNear;
  line.t1 = tFar;
  const auto keep = [&](float at0, float growth) {  // where at0 + t * growth >= 0
    const float crossing = -at0 / growth;
    if (growth > 0.0f)
      line.t0 = maxOf(crossing, line.t0);
    else if (growth < 0.0f)
      line.t1 = minOf(crossing, line.t1);
    else if (at0 < 0.0f)
      line.t1 = line.t0;
  };
  keep(o.z - leastDepth, d.z);
  const float depth = grid.nearDepth + o.z;
  const float tanX = grid.halfWidth * grid.edge, tanY = grid.halfHeight * grid.edge;
  keep(mulAdd(tanX, depth, -o.x), mulAdd(tanX, d.z, -d.x));
  keep(mulAdd(tanX, depth, o.x), mulAdd(tanX, d.z, d.x));
  keep(mulAdd(tanY, depth, -o.y), mulAdd(tanY, d.z, -d.y));
  keep(mulAdd(tanY, depth, o.y), mulAdd(tanY, d.z, d.y));
  if (!(line.t0 < line.t1)) {
    line.t1 = line.t0;
    return line;
  }
  struct Place {
    float x, y, depth, fromEye;
  };
  const auto projected = [&](float t) {
    const float behind = mulAdd(t, d.z, o.z), fromEye = grid.nearDepth + behind, scale = 1.0f / (grid.edge * fromEye);
    const float x = mulAdd(mulAdd(t, d.x, o.x), scale, grid.halfWidth), y = mulAdd(mulAdd(t, d.y, o.y), -scale, grid.halfHeight);
    return Place{minOf(maxOf(x, 0.0f), static_cast<float>(field.width)) + shift, minOf(maxOf(y, 0.0f), static_cast<float>(field.height)) + shift,
                 field.depths.of(behind), fromEye};
  };
  const bool isRising = d.z > 0.0f;
  const Place far = projected(isRising ? line.t1 : line.t0), near = projected(isRising ? line.t0 : line.t1);
  line.begin = isRising ? -1.0f : 0.0f;
  line.end = isRising ? 0.0f : 1.0f;
  line.x0 = far.x;
  line.y0 = far.y;
  line.dx = isRising ? far.x - near.x : near.x - far.x;
  line.dy = isRising ? far.y - near.y : near.y - far.y;
  line.depth0 = far.depth;
  line.depths = isRising ? far.depth - near.depth : near.depth - far.depth;
  line.ratio = far.fromEye / near.fromEye;
  return line;
}

/// Of lines that go along an axis of the picture by less than that nothing on it is crossed.
inline constexpr float kLeastWayAlongAxis = 1e-20f;
/// An s that no place on a line has.
inline constexpr float kNowhereOnLine = 2.0f;

/// The coarsest level on which a step that changes those bits of a cell's place leaves its tile.
WARPSCOPE_HD inline int levelLeft(int changed) {
#if defined(__CUDA_ARCH__)
  const int zeros = __clz(changed);
#else
  const int zeros = std::countl_zero(static_cast<uint32_t>(changed));
#endif
  return minOf((31 - zeros) / kFieldLevelShift, kFieldLevels - 1);
}

/// From the cell (x, y) to the one behind its tile, which a line leaves at `s`: exactly on the axis on which the tile ends (`isOnX`), and within the tile and the picture,
/// which has so many columns and rows of cells, on the other. `shift`: of the tile's level; `leadX`, `leadY`: 1 where borders that are crossed lie behind a cell, else 0.
WARPSCOPE_HD inline void leaveTile(const FieldLine& line, float s, bool isOnX, int shift, int leadX, int leadY, int columns, int rows, int& x, int& y) {
  const int tx = x >> shift, ty = y >> shift, low = (1 << shift) - 1;
  if (isOnX) {
    x = ((tx + leadX) << shift) - 1 + leadX;
    y = minOf(maxOf(static_cast<int>(mulAdd(s, line.dy, line.y0)), ty << shift), minOf((ty << shift) + low, rows - 1));
  } else {
    y = ((ty + leadY) << shift) - 1 + leadY;
    x = minOf(maxOf(static_cast<int>(mulAdd(s, line.dx, line.x0)), tx << shift), minOf((tx << shift) + low, columns - 1));
  }
}

/// How far a walk along a line has got.
struct WalkPlace {
  float s = 0.0f, depth = 0.0f;  ///< place on the line, and its picture depth
  int x = 0, y = 0;              ///< cell
};
template <bool kIsLinear>
WARPSCOPE_HD inline WalkPlace beginOfWalk(const SegmentField& field, const FieldLine& line) {
  const int lastColumn = field.width - (kIsLinear ? 0 : 1), lastRow = field.height - (kIsLinear ? 0 : 1);
  return {line.begin, line.depthAt(line.begin), minOf(maxOf(static_cast<int>(mulAdd(line.begin, line.dx, line.x0)), 0), lastColumn),
          minOf(maxOf(static_cast<int>(mulAdd(line.begin, line.dy, line.y0)), 0), lastRow)};
}

/// A part of a line that is to be filled, of what is unknown as long as there are; s.
struct PieceToFill {
  float begin = 0.0f, end = 0.0f;
  FillReason reason = FillReason::unknown;

  WARPSCOPE_HD bool isAny() const { return begin < end; }
};

/// What walks do where nothing is known, or pixels are doubted.
enum class AtUnknown { stop, stopBehind, goOn };

}  // namespace warpscope
