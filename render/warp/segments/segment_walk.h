// A ray of a new camera through the segments of a frame, front to back. For host and device.
// Volumetric depth images: Frey, Sadlo, Ertl 2013; their ray casting through the old camera's pixels: Gupta et al. 2023. A line in space is a line in the old
// picture, on which 1 / depth is linear (Heckbert, Moreton 1991): the ray is clipped to the old frustum, its ends are projected, and the picture's line is
// stepped along. Deviations: the place along the ray comes from the place along the line in a form without differences that vanish (where both eyes nearly
// coincide the line is hardly a point); between the centres of four pixels their extinction and emission are blended; frusta are leapt over by tiles.
#pragma once

#include "render/core/box.h"
#include "render/core/opacity.h"
#include "render/core/ray.h"
#include "render/warp/warp.h"
#include "render/warp/segments/segment_field.h"

namespace warpscope {

/// What a ray has met so far.
struct WalkedRay {
  glm::vec3 color{0.0f};  ///< linear, premultiplied
  float through = 1.0f;   ///< what is left of light from behind
  float guessed = 0.0f;   ///< the part of the opacity that what is not known was given

  WARPSCOPE_HD void pass(const glm::vec3& itsColor, float itsOpacity) {
    for (int channel = 0; channel < 3; ++channel) color[channel] = mulAdd(through, itsColor[channel], color[channel]);
    through *= 1.0f - itsOpacity;
  }
  /// As pass, for light that no frame says anything about.
  WARPSCOPE_HD void guess(const glm::vec3& itsColor, float itsOpacity) {
    guessed = mulAdd(through, itsOpacity, guessed);
    pass(itsColor, itsOpacity);
  }

  WARPSCOPE_HD glm::vec4 seen() const { return {color, 1.0f - through}; }
  /// What its pixel is: a guess where that can be seen.
  WARPSCOPE_HD uint32_t id() const { return !(through < 1.0f) ? kNoSample : guessed >= kSeenGuess ? kFilled : kNotASample; }
  static constexpr float kSeenGuess = 1.0f / 32;
};

/// A ray's way through the old frustum.
struct FieldLine {
  float t0 = 0.0f, t1 = 0.0f;   ///< where the ray comes in and goes out; t1 <= t0 where it does not
  float x0 = 0.0f, y0 = 0.0f;   ///< in the old picture, cells
  float dx = 0.0f, dy = 0.0f;   ///< from there to where it goes out
  float depth0 = 0.0f, depths = 0.0f;  ///< behind the near plane where it comes in, and how much that grows
  float ratio = 1.0f;           ///< of the depths from the eye where it comes in and goes out

  /// Share of the way in space at a share of the way in the picture, both 0..1; and back. Exact at both ends.
  WARPSCOPE_HD float inSpace(float s) const { return s * ratio / mulAdd(s, ratio - 1.0f, 1.0f); }
  WARPSCOPE_HD float inPicture(float f) const { return f / mulAdd(f, 1.0f - ratio, ratio); }
  WARPSCOPE_HD float depthAt(float f) const { return mulAdd(f, depths, depth0); }
  WARPSCOPE_HD float tAt(float f) const { return mulAdd(f, t1 - t0, t0); }
};

/// The part of [tNear, tFar] of a ray in front of which the frame's camera was. `shift`: 0.5 for cells between centres, 0 for those about them.
WARPSCOPE_HD inline FieldLine makeFieldLine(const SegmentField& field, const Ray& ray, float tNear, float tFar, float shift) {
  const PixelGrid& grid = field.pixels;
  const glm::vec3 offset = ray.origin - grid.anchor;
  const glm::vec3 o(glm::dot(offset, grid.right), glm::dot(offset, grid.up), glm::dot(offset, grid.forward));
  const glm::vec3 d(glm::dot(ray.direction, grid.right), glm::dot(ray.direction, grid.up), glm::dot(ray.direction, grid.forward));
  // In front of the near plane there is nothing to be seen, and behind an eye that is inside the volume nothing was.
  const float leastDepth = grid.nearDepth > 0.0f ? -grid.nearDepth * 0.5f : 1e-4f;
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
  const auto projected = [&](float t, float& x, float& y, float& behind) {
    behind = mulAdd(t, d.z, o.z);
    const float scale = 1.0f / (grid.edge * (grid.nearDepth + behind));
    x = mulAdd(mulAdd(t, d.x, o.x), scale, grid.halfWidth);
    y = mulAdd(mulAdd(t, d.y, o.y), -scale, grid.halfHeight);
    x = minOf(maxOf(x, 0.0f), static_cast<float>(field.width)) + shift;
    y = minOf(maxOf(y, 0.0f), static_cast<float>(field.height)) + shift;
    return grid.nearDepth + behind;
  };
  float x1, y1, behind1;
  const float z0 = projected(line.t0, line.x0, line.y0, line.depth0), z1 = projected(line.t1, x1, y1, behind1);
  line.dx = x1 - line.x0;
  line.dy = y1 - line.y0;
  line.depths = behind1 - line.depth0;
  line.ratio = z0 / z1;
  return line;
}

/// What a pixel has at a depth on a line, and up to which depth that holds.
struct PixelState {
  static constexpr uint32_t kNone = 0xffffffffu;

  uint32_t active = kNone;  ///< number of the segment that it is in
  float extinction = 0.0f;  ///< of that
  bool isKnown = true;
  float until = 0.0f;
};

/// From `depth` on, towards greater depths or (`isRising` false) less.
WARPSCOPE_HD inline PixelState stateOf(const SegmentField& field, int pixel, float depth, bool isRising) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const uint32_t begin = field.first[pixel] & ~SegmentField::kEndedBit, next = field.first[pixel + 1];
  const uint32_t end = next & ~SegmentField::kEndedBit;
  const bool isEnded = (next & SegmentField::kEndedBit) != 0;
  PixelState state;
  if (isRising) {
    state.until = kInfinity;
    state.isKnown = !isEnded;
    for (uint32_t i = begin; i < end; ++i) {
      const FieldSegment segment = field.segments[i];
      if (!(depth < segment.end)) continue;
      state.isKnown = true;
      const bool isInside = segment.begin <= depth;
      if (isInside) state.active = i, state.extinction = segment.extinction;
      state.until = isInside ? segment.end : segment.begin;
      break;
    }
  } else {
    state.until = -kInfinity;
    state.isKnown = begin < end || !isEnded;
    for (uint32_t i = end; i > begin; --i) {
      const FieldSegment segment = field.segments[i - 1];
      if (!(segment.begin < depth)) continue;
      const bool isInside = depth <= segment.end;
      if (isInside) state.active = i - 1, state.extinction = segment.extinction;
      state.until = isInside ? segment.begin : segment.end;
      state.isKnown = isInside || !(isEnded && i == end);
      break;
    }
  }
  return state;
}

/// Pixels that know what is at a place, but have less weight there, are not asked: what a frame shows would depend on where its rays end otherwise.
inline constexpr float kLeastKnown = 1.0f / 64;

/// Walks the part [tNear, tFar] of a ray. `kIsLinear`: between the centres of pixels what they have is blended, of those that know; else each pixel's is the
/// same all over its frustum. `fill(walked, tNear, tFar)` passes what is not known. Ends where less than `stopBelow` is left.
template <bool kIsLinear, class Fill>
WARPSCOPE_HD inline WalkedRay walkSegments(const SegmentField& field, const Ray& ray, float tNear, float tFar, float stopBelow, Fill&& fill) {
  WalkedRay walked;
  if (!(tNear < tFar)) return walked;
  const FieldLine line = makeFieldLine(field, ray, tNear, tFar, kIsLinear ? 0.5f : 0.0f);
  if (!(line.t0 < line.t1)) {
    fill(walked, tNear, tFar);
    return walked;
  }
  if (line.t0 > tNear) fill(walked, tNear, line.t0);

  // What is not known is passed in as long pieces as there are.
  float unknownFrom = -1.0f;  // share of the way; less than 0: what came last was known
  const auto passUnknownUntil = [&](float f) {
    if (unknownFrom >= 0.0f) fill(walked, line.tAt(unknownFrom), line.tAt(f));
    unknownFrom = -1.0f;
  };

  const float length = line.t1 - line.t0;
  const bool isRising = line.depths > 0.0f;
  const int columns = field.width + (kIsLinear ? 1 : 0), rows = field.height + (kIsLinear ? 1 : 0);
  const float perDepth = 1.0f / line.depths;  // used where depths change alone
  const float perX = 1.0f / line.dx, perY = 1.0f / line.dy;  // infinite where there is no way
  int x = minOf(maxOf(static_cast<int>(line.x0), 0), columns - 1), y = minOf(maxOf(static_cast<int>(line.y0), 0), rows - 1);
  int tileX = -1, tileY = -1;  // that was looked at last
  float s = 0.0f, f = 0.0f;
  const auto crossing = [](float border, float from, float delta, float per) {
    return delta > 0.0f || delta < 0.0f ? (border - from) * per : std::numeric_limits<float>::infinity();
  };

  while (s < 1.0f) {
    // Tiles that nothing is in, or nothing known. All of them before the next cell: on a device rays that leap do not wait for those that do not (Aila, Laine
    // 2009).
    while ((x >> fieldShift(0)) != tileX || (y >> fieldShift(0)) != tileY) {
      bool hasLeapt = false;
      for (int level = kFieldLevels - 1; level >= 0; --level) {
        const int shift = fieldShift(level), tx = x >> shift, ty = y >> shift;
        const float borderX = static_cast<float>((line.dx > 0.0f ? tx + 1 : tx) << shift), borderY = static_cast<float>((line.dy > 0.0f ? ty + 1 : ty) << shift);
        const float sx = crossing(borderX, line.x0, line.dx, perX), sy = crossing(borderY, line.y0, line.dy, perY);
        const float out = minOf(maxOf(minOf(sx, sy), s), 1.0f);
        const float fOut = line.inSpace(out);
        const float depthIn = line.depthAt(f), depthOut = line.depthAt(fOut);
        const float least = minOf(depthIn, depthOut), most = maxOf(depthIn, depthOut);
        const FieldTile& tile = field.tiles[level][ty * field.tileColumns[level] + tx];
        const bool isEmpty = tile.nearestBegin > most || tile.farthestEnd < least;
        if (isEmpty && tile.nearestUnknown > most) {
          passUnknownUntil(f);
        } else if (tile.farthestUnknown < least) {
          if (unknownFrom < 0.0f) unknownFrom = f;
        } else {
          continue;
        }
        hasLeapt = true;
        // On beyond the tile: exactly on the axis on which it ends, and within the tile on the other.
        const int low = (1 << shift) - 1;
        if (sx <= sy) {
          x = line.dx > 0.0f ? (tx + 1) << shift : (tx << shift) - 1;
          const int at = static_cast<int>(mulAdd(out, line.dy, line.y0));
          y = minOf(maxOf(at, ty << shift), (ty << shift) + low);
        } else {
          y = line.dy > 0.0f ? (ty + 1) << shift : (ty << shift) - 1;
          const int at = static_cast<int>(mulAdd(out, line.dx, line.x0));
          x = minOf(maxOf(at, tx << shift), (tx << shift) + low);
        }
        s = out;
        f = fOut;
        break;
      }
      if (hasLeapt) {
        if (!(s < 1.0f) || x < 0 || y < 0 || x >= columns || y >= rows) {
          s = 1.0f;
          break;
        }
        tileX = tileY = -1;
      } else {
        tileX = x >> fieldShift(0);
        tileY = y >> fieldShift(0);
      }
    }
    if (!(s < 1.0f)) break;

    const float sx = crossing(static_cast<float>(line.dx > 0.0f ? x + 1 : x), line.x0, line.dx, perX);
    const float sy = crossing(static_cast<float>(line.dy > 0.0f ? y + 1 : y), line.y0, line.dy, perY);
    const float sOut = minOf(maxOf(minOf(sx, sy), s), 1.0f);
    const float fOut = line.inSpace(sOut);
    const float depthOut = line.depthAt(fOut);
    float depth = line.depthAt(f), from = s;
    // Pieces of the cell in which nothing changes.
    int pixel[4];
    if constexpr (kIsLinear) {
      const int left = maxOf(x - 1, 0), right = minOf(x, field.width - 1), upper = maxOf(y - 1, 0) * field.width, lower = minOf(y, field.height - 1) * field.width;
      pixel[0] = upper + left, pixel[1] = upper + right, pixel[2] = lower + left, pixel[3] = lower + right;
    } else {
      pixel[0] = y * field.width + x;
    }
    constexpr int kPixels = kIsLinear ? 4 : 1;
    for (;;) {
      PixelState states[kPixels];
      float until = depthOut;
      for (int i = 0; i < kPixels; ++i) {
        states[i] = stateOf(field, pixel[i], depth, isRising);
        until = isRising ? minOf(states[i].until, until) : maxOf(states[i].until, until);
      }
      const bool isLast = isRising ? !(until < depthOut) : !(until > depthOut);
      float fNext = fOut;
      if (!isLast) fNext = minOf(maxOf((until - line.depth0) * perDepth, f), fOut);
      float weights[kPixels];
      if constexpr (kIsLinear) {
        // Means over the piece: of a product of two that go straight, the product of their means and a twelfth of that of their growths.
        const float to = isLast ? sOut : line.inPicture(fNext), middle = 0.5f * (from + to), way = to - from;
        const float u = saturated(mulAdd(middle, line.dx, line.x0) - static_cast<float>(x)), v = saturated(mulAdd(middle, line.dy, line.y0) - static_cast<float>(y));
        weights[3] = mulAdd(u, v, (line.dx * way) * (line.dy * way) * (1.0f / 12));
        weights[1] = maxOf(u - weights[3], 0.0f);
        weights[2] = maxOf(v - weights[3], 0.0f);
        weights[0] = maxOf(1.0f - u - weights[2], 0.0f);
        from = to;
      } else {
        weights[0] = 1.0f;
      }
      float known = 0.0f, extinction = 0.0f;
      glm::vec3 emission(0.0f);
      for (int i = 0; i < kPixels; ++i) {
        if (!states[i].isKnown) continue;
        known += weights[i];
        if (states[i].active == PixelState::kNone) continue;
        const float own = weights[i] * states[i].extinction;
        extinction += own;
        emission += own * field.colors[states[i].active];
      }
      if (known < kLeastKnown) {
        if (unknownFrom < 0.0f) unknownFrom = f;
      } else {
        passUnknownUntil(f);
        if (extinction > 0.0f) {
          const float opacity = opacityOf(extinction / known * (length * (fNext - f)));
          walked.pass(emission * (opacity / extinction), opacity);
        }
      }
      f = fNext;
      if (walked.through < stopBelow) return walked;
      if (isLast) break;
      depth = until;
    }
    s = sOut;
    f = fOut;
    if (!(s < 1.0f)) break;
    if (sx <= sy)
      x += line.dx > 0.0f ? 1 : -1;
    else
      y += line.dy > 0.0f ? 1 : -1;
    if (x < 0 || y < 0 || x >= columns || y >= rows) break;
  }
  passUnknownUntil(1.0f);
  if (line.t1 < tFar) fill(walked, line.t1, tFar);
  return walked;
}

}  // namespace warpscope
