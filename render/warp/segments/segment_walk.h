// A ray of a new camera through the segments of a frame, front to back. For host and device.
// Volumetric depth images: Frey, Sadlo, Ertl 2013; their ray casting through the old camera's pixels: Gupta et al. 2023. A line in space is a line in the old
// picture, on which 1 / depth is linear (Heckbert, Moreton 1991): the ray is clipped to the old frustum, its ends are projected, and the picture's line is
// stepped along. Deviations: all that is looked for (borders of pixels, ends of segments) is found on the picture's line, where it goes straight, so that places in
// space are asked for where there is matter alone, and no difference of two vanishes where both eyes nearly coincide and the line is hardly a point; between the
// centres of four pixels their extinction and emission are blended; frusta are leapt over by tiles (Amanatides, Woo 1987, on a pyramid).
#pragma once

#include <bit>

#include "render/core/box.h"
#include "render/core/opacity.h"
#include "render/core/ray.h"
#include "render/march/ray_state.h"
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

  WARPSCOPE_HD void guess(const RayLight& light) { guess(glm::vec3(light.color), static_cast<float>(1.0 - light.transmittance)); }

  WARPSCOPE_HD glm::vec4 seen() const { return {color, 1.0f - through}; }
  /// What its pixel is: a guess where that can be seen.
  WARPSCOPE_HD uint32_t id() const { return !(through < 1.0f) ? kNoSample : guessed >= kSeenGuess ? kFilled : kNotASample; }
  static constexpr float kSeenGuess = 1.0f / 32;
};

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
  const float leastFromEye = maxOf(grid.nearDepth > 0.0f ? grid.nearDepth * 0.5f : 1e-4f, absOf(o.z) * 0x1p-20f), leastDepth = leastFromEye - grid.nearDepth;
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

/// What a pixel has at a depth on a line, and up to which depth that holds.
struct PixelState {
  uint32_t active = 0;      ///< number of the segment that it is in; 0 as well where it is in none
  float extinction = 0.0f;  ///< of that; 0 where it is in none
  float known = 1.0f;       ///< 0: nothing is known
  float until = 0.0f;       ///< picture depth
};

/// From the picture depth `depth` on, towards greater depths or (`isRising` false) less.
WARPSCOPE_HD inline PixelState stateOf(const SegmentField& field, int pixel, float depth, bool isRising) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const uint32_t begin = field.first[pixel] & ~SegmentField::kEndedBit, next = field.first[pixel + 1];
  const uint32_t end = next & ~SegmentField::kEndedBit;
  const bool isEnded = (next & SegmentField::kEndedBit) != 0;
  PixelState state;
  if (isRising) {
    state.until = kInfinity;
    state.known = isEnded ? 0.0f : 1.0f;
    for (uint32_t i = begin; i < end; ++i) {
      const FieldSegment segment = field.segments[i];
      if (!(depth < segment.end)) continue;
      state.known = 1.0f;
      const bool isInside = segment.begin <= depth;
      if (isInside) state.active = i, state.extinction = segment.extinction;
      state.until = isInside ? segment.end : segment.begin;
      break;
    }
  } else {
    state.until = -kInfinity;
    state.known = begin < end || !isEnded ? 1.0f : 0.0f;
    for (uint32_t i = end; i > begin; --i) {
      const FieldSegment segment = field.segments[i - 1];
      if (!(segment.begin < depth)) continue;
      const bool isInside = depth <= segment.end;
      if (isInside) state.active = i - 1, state.extinction = segment.extinction;
      state.until = isInside ? segment.begin : segment.end;
      state.known = isInside || !(isEnded && i == end) ? 1.0f : 0.0f;
      break;
    }
  }
  return state;
}

/// Pixels that know what is at a place, but have less weight there, are not asked: what a frame shows would depend on where its rays end otherwise.
inline constexpr float kLeastKnown = 1.0f / 64;

/// The coarsest level on which a step that changes those bits of a cell's place leaves its tile.
WARPSCOPE_HD inline int levelLeft(int changed) {
#if defined(__CUDA_ARCH__)
  const int zeros = __clz(changed);
#else
  const int zeros = std::countl_zero(static_cast<uint32_t>(changed));
#endif
  return minOf((31 - zeros) / kFieldLevelShift, kFieldLevels - 1);
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

/// A part of a line of which nothing is known, as long as there are; s.
struct UnknownPiece {
  float begin = 0.0f, end = 0.0f;

  WARPSCOPE_HD bool isAny() const { return begin < end; }
};

/// What walks do where nothing is known.
enum class AtUnknown { stop, stopBehind, goOn };

/// Walks on from `place` to the line's end, or to where less than `stopBelow` is left: true. Else false, and `place` is where the walk was interrupted: at the first
/// place of which nothing is known (AtUnknown::stop), or where that ends (stopBehind). `piece`: what of the line ends there and is not known, for stopBehind. Another
/// walk from `place` gives the same bits as one that goes on: rays of a device leave their walks to fill such pieces, all together, rather than each in the midst of its own.
/// `kIsLinear`: between the centres of pixels what they have is blended, of those that know; else each pixel's is the same all over its frustum.
/// `Walked`: a WalkedRay, or one that besides is told by meet(segment, distance along the ray, opacity) which segments it meets, where what is between is not blended.
template <bool kIsLinear, AtUnknown kAtUnknown, class Walked>
[[gnu::flatten]] WARPSCOPE_HD inline bool walkOn(const SegmentField& field, const FieldLine& line, float stopBelow, WalkPlace& place, Walked& walked, UnknownPiece& piece) {
  constexpr float kNowhere = 2.0f;
  float unknownFrom = kNowhere;  // s; kNowhere: what came last was known

  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  // Of lines that go along an axis by less than that nothing on it is crossed.
  constexpr float kLeastWay = 1e-20f;
  const bool isRising = line.isRising(), stepsX = absOf(line.dx) > kLeastWay, stepsY = absOf(line.dy) > kLeastWay;
  const float perX = stepsX ? 1.0f / line.dx : 0.0f, perY = stepsY ? 1.0f / line.dy : 0.0f;
  const float perDepth = 1.0f / line.depths;  // used where depths change alone
  const float spaceBy = (line.t1 - line.t0) * line.ratio;
  const int columns = field.width + (kIsLinear ? 1 : 0), rows = field.height + (kIsLinear ? 1 : 0);
  // Where borders are that are crossed: before a cell or tile, or behind it.
  const int leadX = line.dx > 0.0f ? 1 : 0, leadY = line.dy > 0.0f ? 1 : 0;
  float s = place.s, depth = place.depth;
  int x = place.x, y = place.y;
  // True where the walk is interrupted.
  const auto endsUnknown = [&] {
    if (kAtUnknown != AtUnknown::stopBehind || !(unknownFrom < kNowhere)) return false;
    piece = {unknownFrom, s};
    place = {s, depth, x, y};
    return true;
  };
  const auto beginsUnknown = [&] {
    if (kAtUnknown == AtUnknown::stop) place = {s, depth, x, y};
    if (kAtUnknown == AtUnknown::stopBehind && !(unknownFrom < kNowhere)) unknownFrom = s;
    return kAtUnknown == AtUnknown::stop;
  };

  // The pixels about a cell in the order in which the line leaves them behind: trailing on both axes, leading on x, leading on y, leading on both.
  constexpr int kPixels = kIsLinear ? 4 : 1;
  PixelState states[kPixels];
  enum class Kept { none, alongX, alongY };
  Kept kept = Kept::none;
  int level = kFieldLevels - 1;

  while (s < line.end) {
    // Over tiles that nothing is in, or nothing known, down to a cell that is neither. All of them before the next cell: on a device rays that leap do not wait for
    // those that do not (Aila, Laine 2009).
    float sx, sy, out, depthOut;
    for (;;) {
      const int shift = fieldShift(level), tx = x >> shift, ty = y >> shift;
      sx = stepsX ? (static_cast<float>((tx + leadX) << shift) - line.x0) * perX : kInfinity;
      sy = stepsY ? (static_cast<float>((ty + leadY) << shift) - line.y0) * perY : kInfinity;
      out = minOf(maxOf(minOf(sx, sy), s), line.end);
      depthOut = line.depthAt(out);
      const float least = minOf(depth, depthOut), most = maxOf(depth, depthOut);
      const FieldTile& tile = field.tiles[level][ty * field.tileColumns[level] + tx];
      const bool isEmpty = tile.nearestBegin > most || tile.farthestEnd < least;
      if (isEmpty && tile.nearestUnknown > most) {
        if (endsUnknown()) return false;
      } else if (tile.farthestUnknown < least) {
        if (beginsUnknown()) return false;
      } else {
        if (level == 0) break;
        --level;
        continue;
      }
      // On beyond the tile: exactly on the axis on which it ends, and within the tile on the other.
      const int oldX = x, oldY = y, low = (1 << shift) - 1;
      if (sx <= sy) {
        x = ((tx + leadX) << shift) - 1 + leadX;
        y = minOf(maxOf(static_cast<int>(mulAdd(out, line.dy, line.y0)), ty << shift), (ty << shift) + low);
      } else {
        y = ((ty + leadY) << shift) - 1 + leadY;
        x = minOf(maxOf(static_cast<int>(mulAdd(out, line.dx, line.x0)), tx << shift), (tx << shift) + low);
      }
      s = out;
      depth = depthOut;
      kept = Kept::none;
      if (!(s < line.end) || x < 0 || y < 0 || x >= columns || y >= rows) {
        s = line.end;
        break;
      }
      level = levelLeft((x ^ oldX) | (y ^ oldY));
    }
    if (!(s < line.end)) break;

    // The cell, in pieces in which nothing changes.
    int pixel[kPixels];
    if constexpr (kIsLinear) {
      const int leading = minOf(maxOf(x - 1 + leadX, 0), field.width - 1), trailing = minOf(maxOf(x - leadX, 0), field.width - 1);
      const int leadingRow = minOf(maxOf(y - 1 + leadY, 0), field.height - 1) * field.width, trailingRow = minOf(maxOf(y - leadY, 0), field.height - 1) * field.width;
      pixel[0] = trailingRow + trailing, pixel[1] = trailingRow + leading, pixel[2] = leadingRow + trailing, pixel[3] = leadingRow + leading;
      if (kept == Kept::alongX)
        states[0] = states[1], states[2] = states[3];
      else if (kept == Kept::alongY)
        states[0] = states[2], states[1] = states[3];
    } else {
      pixel[0] = y * field.width + x;
    }
    const float expired = isRising ? -kInfinity : kInfinity;
    if (!kIsLinear || kept == Kept::none) states[0].until = expired;
    if constexpr (kIsLinear) {
      if (kept != Kept::alongY) states[1].until = expired;
      if (kept != Kept::alongX) states[2].until = expired;
      states[3].until = expired;
    }
    for (;;) {
      float until = depthOut;
      for (int i = 0; i < kPixels; ++i) {
        if (isRising ? !(depth < states[i].until) : !(depth > states[i].until)) states[i] = stateOf(field, pixel[i], depth, isRising);
        until = isRising ? minOf(states[i].until, until) : maxOf(states[i].until, until);
      }
      const bool isLast = isRising ? !(until < depthOut) : !(until > depthOut);
      const float to = isLast ? out : minOf(maxOf((until - line.depth0) * perDepth, s), out);
      // Of what is thin the difference of depths is exact, that of places on the line is not.
      const float share = isLast ? out - s : (until - depth) * perDepth;
      float weights[kPixels];
      if constexpr (kIsLinear) {
        // Means over the piece: of a product of two that go straight, the product of their means and a twelfth of that of their growths.
        const float middle = 0.5f * (s + to), way = to - s;
        const float u = saturated(absOf(mulAdd(middle, line.dx, line.x0) - static_cast<float>(x + 1 - leadX)));
        const float v = saturated(absOf(mulAdd(middle, line.dy, line.y0) - static_cast<float>(y + 1 - leadY)));
        weights[3] = mulAdd(u, v, absOf((line.dx * way) * (line.dy * way)) * (1.0f / 12));
        weights[1] = maxOf(u - weights[3], 0.0f);
        weights[2] = maxOf(v - weights[3], 0.0f);
        weights[0] = maxOf(1.0f - u - weights[2], 0.0f);
      } else {
        weights[0] = 1.0f;
      }
      float known = 0.0f, extinction = 0.0f;
      glm::vec3 emission(0.0f);
      for (int i = 0; i < kPixels; ++i) {
        // Without branches: of what is in no segment the first one's colour is taken by nothing.
        known += weights[i] * states[i].known;
        const float own = weights[i] * states[i].extinction;
        extinction += own;
        emission += own * field.colors[states[i].active].linear;
      }
      if (known < kLeastKnown) {
        if (beginsUnknown()) return false;
      } else {
        if (endsUnknown()) return false;
        if (extinction > 0.0f) {
          const float opacity = opacityOf(extinction * (spaceBy * share) / (known * (line.divisorAt(s) * line.divisorAt(to))));
          if constexpr (requires { walked.meet(0u, 0.0f, 0.0f); }) walked.meet(states[0].active, 0.5f * (line.tAt(s) + line.tAt(to)), opacity);
          walked.pass(emission * (opacity / extinction), opacity);
        }
      }
      s = to;
      if (walked.through < stopBelow) return true;
      if (isLast) break;
      depth = until;
    }
    s = out;
    depth = depthOut;
    const int oldX = x, oldY = y;
    if (sx <= sy) {
      x += 2 * leadX - 1;
      kept = Kept::alongX;
    } else {
      y += 2 * leadY - 1;
      kept = Kept::alongY;
    }
    if (x < 0 || y < 0 || x >= columns || y >= rows) break;
    level = levelLeft((x ^ oldX) | (y ^ oldY));
  }
  if (kAtUnknown == AtUnknown::stopBehind && unknownFrom < kNowhere) piece = {unknownFrom, line.end};
  return true;
}

/// A walk of a ray in two parts: what the frame knows without an interruption, and the rest. For devices, where few rays need the rest and registers for it would
/// slow down all.
struct InterruptedWalk {
  WalkPlace place{.x = -1};  ///< x < 0: nothing has been walked
  WalkedRay walked;
};

/// The first part of walkSegments(): true if that is all. `walk` as it begins; what walkRest() takes if it is not all.
template <bool kIsLinear>
WARPSCOPE_HD inline bool walkKnown(const SegmentField& field, const Ray& ray, float tNear, float tFar, float stopBelow, InterruptedWalk& walk) {
  if (!(tNear < tFar)) return true;
  const FieldLine line = makeFieldLine(field, ray, tNear, tFar, kIsLinear ? 0.5f : 0.0f);
  const bool isLine = line.t0 < line.t1;
  if (!isLine || line.t0 > tNear) return false;
  walk.place = beginOfWalk<kIsLinear>(field, line);
  UnknownPiece none;
  const bool isWalked = walkOn<kIsLinear, AtUnknown::stop>(field, line, stopBelow, walk.place, walk.walked, none);
  if (isWalked) walk.place.s = line.end;
  return isWalked && (!(line.t1 < tFar) || walk.walked.through < stopBelow);
}

/// The second part, of the same ray with the same arguments. `fill(walked, tNear, tFar)` passes what is not known.
template <bool kIsLinear, class Fill>
WARPSCOPE_HD inline WalkedRay walkRest(const SegmentField& field, const Ray& ray, float tNear, float tFar, float stopBelow, const InterruptedWalk& walk, Fill&& fill) {
  WalkedRay walked = walk.walked;
  const FieldLine line = makeFieldLine(field, ray, tNear, tFar, kIsLinear ? 0.5f : 0.0f);
  if (!(line.t0 < line.t1)) {
    fill(walked, tNear, tFar);
    return walked;
  }
  WalkPlace place = walk.place;
  if (place.x < 0) {
    if (line.t0 > tNear) fill(walked, tNear, line.t0);
    place = beginOfWalk<kIsLinear>(field, line);
  }
  for (bool isDone = false; !isDone && !(walked.through < stopBelow);) {
    UnknownPiece piece;
    isDone = walkOn<kIsLinear, AtUnknown::stopBehind>(field, line, stopBelow, place, walked, piece);
    if (piece.isAny()) fill(walked, line.tAt(piece.begin), line.tAt(piece.end));
  }
  if (line.t1 < tFar && !(walked.through < stopBelow)) fill(walked, line.t1, tFar);
  return walked;
}

/// Walks the part [tNear, tFar] of a ray, as walkOn() does. `fill`: as walkRest().
template <bool kIsLinear, class Fill>
WARPSCOPE_HD inline WalkedRay walkSegments(const SegmentField& field, const Ray& ray, float tNear, float tFar, float stopBelow, Fill&& fill) {
  return tNear < tFar ? walkRest<kIsLinear>(field, ray, tNear, tFar, stopBelow, {}, fill) : WalkedRay{};
}
/// As if there were nothing where nothing is known; `walked` as it begins.
template <bool kIsLinear, class Walked>
WARPSCOPE_HD inline void walkThrough(const SegmentField& field, const Ray& ray, float tNear, float tFar, float stopBelow, Walked& walked) {
  if (!(tNear < tFar)) return;
  const FieldLine line = makeFieldLine(field, ray, tNear, tFar, kIsLinear ? 0.5f : 0.0f);
  WalkPlace place = beginOfWalk<kIsLinear>(field, line);
  UnknownPiece none;
  if (line.t0 < line.t1) walkOn<kIsLinear, AtUnknown::goOn>(field, line, stopBelow, place, walked, none);
}
template <bool kIsLinear>
WARPSCOPE_HD inline WalkedRay walkSegments(const SegmentField& field, const Ray& ray, float tNear, float tFar, float stopBelow) {
  WalkedRay walked;
  walkThrough<kIsLinear>(field, ray, tNear, tFar, stopBelow, walked);
  return walked;
}

}  // namespace warpscope
