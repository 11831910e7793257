// A ray of a new camera through the segments of a frame, front to back. For host and device.
// Volumetric depth images: Frey, Sadlo, Ertl 2013; their ray casting through the old camera's pixels: Gupta et al. 2023; how the lines go: field_line.h. Deviations:
// between the centres of four pixels what these show is blended; frusta are leapt over by tiles (Amanatides, Woo 1987, on a pyramid).
//
// Blended is light, not extinction: a ray between four pixels is taken to be one of theirs, each as likely as it has weight, and what is seen is the mean. So an outline between a pixel
// that is in something dense and one that is not is as wide on the one side as on the other, where means of extinction move it outwards; and a ray that keeps its place between the four sees
// their colours interpolated. As it goes on within a cell, of those that would have been stopped by now less is left, and each weighs by that (Bayes), until the cell or what is known ends. That is
// right as far as a ray keeps its place between pixels, which it does at small angles; at others it is an approximation that measures better than blended extinction (tests/bench).
//
// What the four show of a stretch of a cell may be so different that their mean is none of what a ray can meet: there is an outline between them. Where a copy of the volume with all of its voxels came
// with the frame, such stretches are taken from it (Between::refined): of the frame is what it sampled well enough.
#pragma once

#include "render/core/opacity.h"
#include "render/warp/segments/between.h"
#include "render/warp/segments/field_line.h"
#include "render/warp/segments/nearest_walk.h"
#include "render/warp/segments/pixel_views.h"
#include "render/warp/segments/walked_ray.h"

namespace warpscope {

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
      const FieldSpan span = field.spans[i];
      if (!(depth < span.end)) continue;
      state.known = 1.0f;
      const bool isInside = span.begin <= depth;
      if (isInside) state.active = i, state.extinction = field.matter[i].extinction;
      state.until = isInside ? span.end : span.begin;
      break;
    }
  } else {
    state.until = -kInfinity;
    state.known = begin < end || !isEnded ? 1.0f : 0.0f;
    for (uint32_t i = end; i > begin; --i) {
      const FieldSpan span = field.spans[i - 1];
      if (!(span.begin < depth)) continue;
      const bool isInside = depth <= span.end;
      if (isInside) state.active = i - 1, state.extinction = field.matter[i - 1].extinction;
      state.until = isInside ? span.begin : span.end;
      state.known = isInside || !(isEnded && i == end) ? 1.0f : 0.0f;
      break;
    }
  }
  return state;
}

/// Least transmittance by which a pixel is weighed, so that the sum of weights is more than 0: where all four have so little nothing is seen any more.
inline constexpr float kLeastLeft = 1e-6f;

/// Pixels that know what is at a place, but have less weight there, are not asked: what a frame shows would depend on where its rays end otherwise.
inline constexpr float kLeastKnown = 1.0f / 64;

/// walkOn() where pixels are blended. `kIsRefined`: where those about a cell disagree by more than kMostDisagreement of what a stretch of it shows, that is filled as what is not known is.
template <bool kIsRefined, AtUnknown kAtUnknown>
[[gnu::flatten]] WARPSCOPE_HD inline bool walkBlended(const SegmentField& field, const FieldLine& line, float stopBelow, WalkPlace& place, WalkedRay& walked, PieceToFill& piece) {
  float unknownFrom = kNowhereOnLine;  // s; kNowhereOnLine: what came last was known

  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const bool isRising = line.isRising(), stepsX = absOf(line.dx) > kLeastWayAlongAxis, stepsY = absOf(line.dy) > kLeastWayAlongAxis;
  const float perX = stepsX ? 1.0f / line.dx : 0.0f, perY = stepsY ? 1.0f / line.dy : 0.0f;
  const float perDepth = 1.0f / line.depths;  // used where depths change alone
  const float spaceBy = (line.t1 - line.t0) * line.ratio;
  const int columns = field.width + 1, rows = field.height + 1;
  // Where borders are that are crossed: before a cell or tile, or behind it.
  const int leadX = line.dx > 0.0f ? 1 : 0, leadY = line.dy > 0.0f ? 1 : 0;
  float s = place.s, depth = place.depth;
  int x = place.x, y = place.y;
  // True where the walk is interrupted.
  const auto endsUnknown = [&] {
    if (kAtUnknown != AtUnknown::stopBehind || !(unknownFrom < kNowhereOnLine)) return false;
    piece = {unknownFrom, s};
    place = {s, depth, x, y};
    return true;
  };
  const auto beginsUnknown = [&] {
    if (kAtUnknown == AtUnknown::stop) place = {s, depth, x, y};
    if (kAtUnknown == AtUnknown::stopBehind && !(unknownFrom < kNowhereOnLine)) unknownFrom = s;
    return kAtUnknown == AtUnknown::stop;
  };

  // The stretch of a cell of which something has been known all along: where and as what it began.
  constexpr bool kChecks = kIsRefined && kAtUnknown != AtUnknown::goOn;
  WalkPlace stretch{.x = -1};  // x < 0: there is none
  WalkedRay before;
  PixelViews<float> views;
  float left[4];  // within the stretch, of light that goes along what each pixel has
  // True where it, which ends there, is to be filled, and the walk interrupted, which goes on at its end.
  const auto isDoubted = [&](float end, float depthAtEnd) {
    if (!kChecks || stretch.x < 0 || !(views.disagreement(left) * before.through > kMostDisagreement)) return false;
    walked = before;
    piece = {stretch.s, end, FillReason::doubted};
    place = kAtUnknown == AtUnknown::stop ? stretch : WalkPlace{end, depthAtEnd, x, y};
    return true;
  };

  // The pixels about a cell in the order in which the line leaves them behind: trailing on both axes, leading on x, leading on y, leading on both.
  constexpr int kPixels = 4;
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
      if (isEmpty && (kAtUnknown == AtUnknown::goOn || tile.nearestUnknown > most)) {
        if (endsUnknown()) return false;
      } else if (kAtUnknown != AtUnknown::goOn && tile.farthestUnknown < least) {
        if (beginsUnknown()) return false;
      } else {
        if (level == 0) break;
        --level;
        continue;
      }
      const int oldX = x, oldY = y;
      leaveTile(line, out, sx <= sy, shift, leadX, leadY, columns, rows, x, y);
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
    const int leading = minOf(maxOf(x - 1 + leadX, 0), field.width - 1), trailing = minOf(maxOf(x - leadX, 0), field.width - 1);
    const int leadingRow = minOf(maxOf(y - 1 + leadY, 0), field.height - 1) * field.width, trailingRow = minOf(maxOf(y - leadY, 0), field.height - 1) * field.width;
    const int pixel[kPixels] = {trailingRow + trailing, trailingRow + leading, leadingRow + trailing, leadingRow + leading};
    if (kept == Kept::alongX)
      states[0] = states[1], states[2] = states[3];
    else if (kept == Kept::alongY)
      states[0] = states[2], states[1] = states[3];
    const float expired = isRising ? -kInfinity : kInfinity;
    if (kept == Kept::none) states[0].until = expired;
    if (kept != Kept::alongY) states[1].until = expired;
    if (kept != Kept::alongX) states[2].until = expired;
    states[3].until = expired;
    for (float& one : left) one = 1.0f;
    stretch.x = -1;
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
      // Means over the piece: of a product of two that go straight, the product of their means and a twelfth of that of their growths.
      float weights[kPixels];
      const float middle = 0.5f * (s + to), way = to - s;
      const float u = saturated(absOf(mulAdd(middle, line.dx, line.x0) - static_cast<float>(x + 1 - leadX)));
      const float v = saturated(absOf(mulAdd(middle, line.dy, line.y0) - static_cast<float>(y + 1 - leadY)));
      weights[3] = mulAdd(u, v, absOf((line.dx * way) * (line.dy * way)) * (1.0f / 12));
      weights[1] = maxOf(u - weights[3], 0.0f);
      weights[2] = maxOf(v - weights[3], 0.0f);
      weights[0] = maxOf(1.0f - u - weights[2], 0.0f);
      float known = 0.0f;
      for (int i = 0; i < kPixels; ++i) {
        weights[i] *= states[i].known;
        known += weights[i];
      }
      if (known < kLeastKnown) {
        if (isDoubted(s, depth) || beginsUnknown()) return false;
        for (float& one : left) one = 1.0f;  // as of a walk that goes on behind it
        stretch.x = -1;
      } else {
        if (endsUnknown()) return false;
        if (kChecks && stretch.x < 0) {
          stretch = {s, depth, x, y};
          before = walked;
          views.clear();
        }
        const float length = spaceBy * share / (line.divisorAt(s) * line.divisorAt(to));
        float all = 0.0f, stopped = 0.0f;
        glm::vec3 light(0.0f);
        for (int i = 0; i < kPixels; ++i) {
          // Without branches: of what is in no segment the first one's colour is taken by nothing.
          const float opacity = opacityOf(states[i].extinction * length), weight = weights[i] * left[i], own = weight * opacity;
          all += weight;
          stopped += own;
          const glm::vec3 color = field.matter[states[i].active].color;
          light += own * color;
          if (kChecks) {
            for (int channel = 0; channel < 3; ++channel) views.color[i][channel] = mulAdd(left[i] * opacity, color[channel], views.color[i][channel]);
            views.asked[i] = weights[i] > kLeastKnown ? 1.0f : views.asked[i];
          }
          left[i] = maxOf(left[i] * (1.0f - opacity), kLeastLeft);
        }
        if (stopped > 0.0f) {
          const float perWeight = 1.0f / all;
          walked.pass(light, perWeight, stopped * perWeight);
        }
      }
      s = to;
      const bool isStopped = walked.through < stopBelow;
      // Behind where it is stopped it may not be: up to the end of the cell.
      if ((isStopped || isLast) && isDoubted(out, depthOut)) return false;
      if (isStopped) return true;
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
  if (kAtUnknown == AtUnknown::stopBehind && unknownFrom < kNowhereOnLine) piece = {unknownFrom, line.end};
  return true;
}

/// Walks on from `place` to the line's end, or to where less than `stopBelow` is left: true. Else false, and `place` is where the walk was interrupted: at the first
/// place of which nothing is known or that is doubted, `walked` being what was met in front of it (AtUnknown::stop), or where that ends (stopBehind). `piece`: what of the line ends there and is not
/// known or doubted, for stopBehind. Another walk from `place` gives the same bits as one that goes on: rays of a device leave their walks to fill such pieces, all together, rather than each in the midst of its own.
/// `kBetween`: blended is of those pixels that know; nearest, each pixel's is the same all over its frustum. Refined, what pixels disagree about is doubted, but for goOn.
/// `Walked`: a WalkedRay, or one that besides is told by meet(segment, distance along the ray, opacity) which segments it meets, where what is between is not blended.
template <Between kBetween, AtUnknown kAtUnknown, class Walked>
WARPSCOPE_HD inline bool walkOn(const SegmentField& field, const FieldLine& line, float stopBelow, WalkPlace& place, Walked& walked, PieceToFill& piece) {
  if constexpr (blends(kBetween))
    return walkBlended<kBetween == Between::refined, kAtUnknown>(field, line, stopBelow, place, walked, piece);
  else
    return walkNearest<kAtUnknown>(field, line, stopBelow, place, walked, piece);
}

/// A walk of a ray in two parts: what the frame knows without an interruption, and the rest. For devices, where few rays need the rest (refined, up to most)
/// and registers for it would slow down all.
struct InterruptedWalk {
  WalkPlace place{.x = -1};  ///< x < 0: nothing has been walked
  WalkedRay walked;
};

/// The first part of walkSegments(): true if that is all. `walk` as it begins; what walkRest() takes if it is not all.
template <Between kBetween>
WARPSCOPE_HD inline bool walkKnown(const SegmentField& field, const Ray& ray, float tNear, float tFar, float stopBelow, InterruptedWalk& walk) {
  if (!(tNear < tFar)) return true;
  const FieldLine line = makeFieldLine(field, ray, tNear, tFar, blends(kBetween) ? 0.5f : 0.0f);
  const bool isLine = line.t0 < line.t1;
  if (!isLine || line.t0 > tNear) return false;
  walk.place = beginOfWalk<blends(kBetween)>(field, line);
  PieceToFill none;
  const bool isWalked = walkOn<kBetween, AtUnknown::stop>(field, line, stopBelow, walk.place, walk.walked, none);
  if (isWalked) walk.place.s = line.end;
  return isWalked && (!(line.t1 < tFar) || walk.walked.through < stopBelow);
}

/// The second part, of the same ray with the same arguments. `fill(walked, tNear, tFar, reason)` passes what is not known or doubted.
template <Between kBetween, class Fill>
WARPSCOPE_HD inline WalkedRay walkRest(const SegmentField& field, const Ray& ray, float tNear, float tFar, float stopBelow, const InterruptedWalk& walk, Fill&& fill) {
  WalkedRay walked = walk.walked;
  const FieldLine line = makeFieldLine(field, ray, tNear, tFar, blends(kBetween) ? 0.5f : 0.0f);
  if (!(line.t0 < line.t1)) {
    fill(walked, tNear, tFar, FillReason::unknown);
    return walked;
  }
  WalkPlace place = walk.place;
  if (place.x < 0) {
    if (line.t0 > tNear) fill(walked, tNear, line.t0, FillReason::unknown);
    place = beginOfWalk<blends(kBetween)>(field, line);
  }
  for (bool isDone = false; !isDone && !(walked.through < stopBelow);) {
    PieceToFill piece;
    isDone = walkOn<kBetween, AtUnknown::stopBehind>(field, line, stopBelow, place, walked, piece);
    if (piece.isAny()) fill(walked, line.tAt(piece.begin), line.tAt(piece.end), piece.reason);
  }
  if (line.t1 < tFar && !(walked.through < stopBelow)) fill(walked, line.t1, tFar, FillReason::unknown);
  return walked;
}

/// Walks the part [tNear, tFar] of a ray, as walkOn() does. `fill`: as walkRest().
template <Between kBetween, class Fill>
WARPSCOPE_HD inline WalkedRay walkSegments(const SegmentField& field, const Ray& ray, float tNear, float tFar, float stopBelow, Fill&& fill) {
  return tNear < tFar ? walkRest<kBetween>(field, ray, tNear, tFar, stopBelow, {}, fill) : WalkedRay{};
}
/// As if there were nothing where nothing is known; `walked` as it begins.
template <Between kBetween, class Walked>
WARPSCOPE_HD inline void walkThrough(const SegmentField& field, const Ray& ray, float tNear, float tFar, float stopBelow, Walked& walked) {
  if (!(tNear < tFar)) return;
  const FieldLine line = makeFieldLine(field, ray, tNear, tFar, blends(kBetween) ? 0.5f : 0.0f);
  WalkPlace place = beginOfWalk<blends(kBetween)>(field, line);
  PieceToFill none;
  if (line.t0 < line.t1) walkOn<kBetween, AtUnknown::goOn>(field, line, stopBelow, place, walked, none);
}
template <Between kBetween>
WARPSCOPE_HD inline WalkedRay walkSegments(const SegmentField& field, const Ray& ray, float tNear, float tFar, float stopBelow) {
  WalkedRay walked;
  walkThrough<kBetween>(field, ray, tNear, tFar, stopBelow, walked);
  return walked;
}

}  // namespace warpscope
