// A ray of a new camera through the segments of a frame whose pixels each are the same all over their frusta, front to back. For host and device.
// As segment_walk.h where nothing is blended: of a cell there is one pixel, whose segments are compared with the ray's depths four at once, without a load that waits for
// the one before; pixels of a tile that is not empty are gone through one by one, without asking which of them are (Amanatides, Woo 1987).
#pragma once

#include <bit>
#include <cmath>

#include "render/core/opacity.h"
#include "render/warp/segments/field_line.h"

namespace warpscope {

/// The place of the lowest or (`fromLowest` false) the highest of the bits that are set, of which there is one at least.
WARPSCOPE_HD inline uint32_t firstBit(uint32_t bits, bool fromLowest) {
#if defined(__CUDA_ARCH__)
  return static_cast<uint32_t>(fromLowest ? __ffs(static_cast<int>(bits)) - 1 : 31 - __clz(static_cast<int>(bits)));
#else
  return static_cast<uint32_t>(fromLowest ? std::countr_zero(bits) : 31 - std::countl_zero(bits));
#endif
}

/// walkOn() of segment_walk.h without blending.
template <AtUnknown kAtUnknown, class Walked>
[[gnu::flatten]] WARPSCOPE_HD inline bool walkNearest(const SegmentField& field, const FieldLine& line, float stopBelow, WalkPlace& place, Walked& walked, PieceToFill& piece) {
  float unknownFrom = kNowhereOnLine;  // s; kNowhereOnLine: what came last was known

  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const bool isRising = line.isRising(), stepsX = absOf(line.dx) > kLeastWayAlongAxis, stepsY = absOf(line.dy) > kLeastWayAlongAxis;
  // Where nothing is crossed: from a place far in front of all borders, infinitely slowly.
  constexpr float kFarInFront = -1e9f;
  const float x0 = stepsX ? line.x0 : kFarInFront, y0 = stepsY ? line.y0 : kFarInFront;
  const float perX = stepsX ? 1.0f / line.dx : kInfinity, perY = stepsY ? 1.0f / line.dy : kInfinity;
  const float perDepth = 1.0f / line.depths;  // used where depths change alone
  const float spaceBy = (line.t1 - line.t0) * line.ratio;
  const int leadX = line.dx > 0.0f ? 1 : 0, leadY = line.dy > 0.0f ? 1 : 0;
  const float stepX = static_cast<float>(2 * leadX - 1), stepY = static_cast<float>(2 * leadY - 1);
  const int columnStep = 2 * leadX - 1, rowStep = leadY ? field.width : -field.width;
  const auto isOut = [&](int x, int y) { return static_cast<uint32_t>(x) >= static_cast<uint32_t>(field.width) || static_cast<uint32_t>(y) >= static_cast<uint32_t>(field.height); };
  float s = place.s, depth = place.depth;
  int x = place.x, y = place.y;
  // True where the walk is interrupted; it goes on from `s`, `depth` and the pixel.
  const auto endsUnknown = [&](int column, int row) {
    if (kAtUnknown != AtUnknown::stopBehind || !(unknownFrom < kNowhereOnLine)) return false;
    piece = {unknownFrom, s};
    place = {s, depth, column, row};
    return true;
  };
  const auto beginsUnknown = [&](int column, int row) {
    if (kAtUnknown == AtUnknown::stop) place = {s, depth, column, row};
    if (kAtUnknown == AtUnknown::stopBehind && !(unknownFrom < kNowhereOnLine)) unknownFrom = s;
    return kAtUnknown == AtUnknown::stop;
  };
  int level = kFieldLevels - 1;

  while (s < line.end) {
    // Over tiles in which is nothing, or nothing known, down to one that is neither.
    for (;;) {
      const int shift = fieldShift(level), tx = x >> shift, ty = y >> shift;
      const float sx = (static_cast<float>((tx + leadX) << shift) - x0) * perX, sy = (static_cast<float>((ty + leadY) << shift) - y0) * perY;
      const float out = minOf(maxOf(minOf(sx, sy), s), line.end), depthOut = line.depthAt(out);
      const float least = minOf(depth, depthOut), most = maxOf(depth, depthOut);
      const FieldTile& tile = field.tiles[level][ty * field.tileColumns[level] + tx];
      const FieldTileSpan span = tile;
      const bool isEmpty = span.nearestBegin > most || span.farthestEnd < least;
      if (isEmpty && (kAtUnknown == AtUnknown::goOn || tile.nearestUnknown > most)) {
        if (endsUnknown(x, y)) return false;
      } else if (kAtUnknown != AtUnknown::goOn && tile.farthestUnknown < least) {
        if (beginsUnknown(x, y)) return false;
      } else {
        if (level == 1) break;
        --level;
        continue;
      }
      const int oldX = x, oldY = y;
      leaveTile(line, out, sx <= sy, shift, leadX, leadY, field.width, field.height, x, y);
      s = out;
      depth = depthOut;
      if (!(s < line.end) || isOut(x, y)) {
        s = line.end;
        break;
      }
      level = maxOf(levelLeft((x ^ oldX) | (y ^ oldY)), 1);
    }
    if (!(s < line.end)) break;

    // Through the tile's pixels. What is left of them along each axis, to the tile's border or the picture's:
    constexpr int kEdge = 1 << fieldShift(1);
    const int inX = x & (kEdge - 1), inY = y & (kEdge - 1);
    int leftX = leadX ? minOf(kEdge - inX, field.width - x) : inX + 1, leftY = leadY ? minOf(kEdge - inY, field.height - y) : inY + 1;
    float borderX = static_cast<float>(x + leadX), borderY = static_cast<float>(y + leadY);
    int pixel = y * field.width + x;
    do {
      const float sx = (borderX - x0) * perX, sy = (borderY - y0) * perY;
      const uint32_t begin = field.first[pixel] & ~SegmentField::kEndedBit, next = field.first[pixel + 1], end = next & ~SegmentField::kEndedBit;
      const float out = minOf(maxOf(minOf(sx, sy), s), line.end), depthOut = line.depthAt(out);
      float least = minOf(depth, depthOut), most = maxOf(depth, depthOut);
      // On lines along which depth does not change a segment is met that begins there, as is one in which they are.
      if (least == most) (isRising ? most : least) = nextafterf(depth, isRising ? kInfinity : -kInfinity);
      int column = 0, row = 0;  // the pixel's, for those that are interrupted
      if constexpr (kAtUnknown != AtUnknown::goOn) column = static_cast<int>(borderX) - leadX, row = static_cast<int>(borderY) - leadY;
      // To the next one; early, so that less has to be kept while the segments are gone through.
      if (sx <= sy)
        --leftX, borderX += stepX, pixel += columnStep;
      else
        --leftY, borderY += stepY, pixel += rowStep;

      float knownUntil = kInfinity;  // picture depth: behind it nothing is known
      if constexpr (kAtUnknown != AtUnknown::goOn) {
        if ((next & SegmentField::kEndedBit) != 0) knownUntil = begin < end ? field.spans[end - 1].end : -kInfinity;
        if (isRising ? !(depth < knownUntil) : depth > knownUntil) {
          if (beginsUnknown(column, row)) return false;
          if (!isRising && knownUntil > depthOut) {
            s = minOf(maxOf((knownUntil - line.depth0) * perDepth, s), out);
            depth = knownUntil;
            if (endsUnknown(column, row)) return false;
          }
        } else if (endsUnknown(column, row)) {
          return false;
        }
      }
      const float from = depth;
      for (uint32_t left = end - begin; left > 0; left = left > 4 ? left - 4 : 0) {
        const uint32_t group = isRising ? end - left : begin + ((left - 1) & ~3u);
        const FieldSpan* const four = field.spans + group;
        uint32_t met = 0;
        for (uint32_t k = 0; k < 4; ++k) {
          const FieldSpan span = four[k];
          met |= span.begin < most && span.end > least ? 1u << k : 0u;
        }
        met &= 0xfu >> maxOf(4 - static_cast<int>(end - group), 0);
        while (met != 0) {
          const uint32_t k = firstBit(met, isRising);
          met &= ~(1u << k);
          const FieldSpan span = four[k];
          const FieldMatter matter = field.matter[group + k];
          const float first = isRising ? maxOf(span.begin, from) : minOf(span.end, from), last = isRising ? minOf(span.end, depthOut) : maxOf(span.begin, depthOut);
          if (first != from) s = minOf(maxOf((first - line.depth0) * perDepth, s), out);
          const bool isLast = last == depthOut;
          const float to = isLast ? out : minOf(maxOf((last - line.depth0) * perDepth, s), out);
          // Of what is thin the difference of depths is exact, that of places on the line is not.
          const float share = isLast ? out - s : (last - first) * perDepth;
          const float opacity = opacityOf(matter.extinction * (spaceBy * share) / (line.divisorAt(s) * line.divisorAt(to)));
          if constexpr (requires { walked.meet(0u, 0.0f, 0.0f); })
            if (matter.extinction > 0.0f) walked.meet(group + k, 0.5f * (line.tAt(s) + line.tAt(to)), opacity);
          walked.pass(matter.color, opacity, opacity);
          s = to;
          if (walked.through < stopBelow) return true;
        }
      }
      if constexpr (kAtUnknown != AtUnknown::goOn) {
        if (isRising && from < knownUntil && knownUntil < depthOut) {
          s = minOf(maxOf((knownUntil - line.depth0) * perDepth, s), out);
          depth = knownUntil;
          if (beginsUnknown(column, row)) return false;
        }
      }
      s = out;
      depth = depthOut;
    } while (s < line.end && leftX > 0 && leftY > 0);
    const int oldX = x, oldY = y;
    x = static_cast<int>(borderX) - leadX;
    y = static_cast<int>(borderY) - leadY;
    if (isOut(x, y)) break;
    level = maxOf(levelLeft((x ^ oldX) | (y ^ oldY)), 1);
  }
  if (kAtUnknown == AtUnknown::stopBehind && unknownFrom < kNowhereOnLine) piece = {unknownFrom, line.end};
  return true;
}

}  // namespace warpscope
