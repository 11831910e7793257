// As many rays of a new camera at once as lines in the picture of an old one as a vector has lanes. Host only.
// Each lane goes the way of makeFieldLine() and beginOfWalk(), by the same operations in the same order, so that a line is the same bits here as there.
#pragma once

#include "render/core/simd_lanes.h"
#include "render/warp/segments/field_line.h"
#include "render/warp/segments/ray_packet.h"

namespace warpscope {

/// Lines of rays side by side: FieldLine's members, and where walks along them begin. Of lanes without a line all is 0, and the ratio 1.
struct alignas(64) PacketLines {
  float t0[kBatchLanes], t1[kBatchLanes];  ///< t1 <= t0 where a ray has no line
  float x0[kBatchLanes], y0[kBatchLanes], dx[kBatchLanes], dy[kBatchLanes], depth0[kBatchLanes], depths[kBatchLanes], ratio[kBatchLanes], spaceBy[kBatchLanes];
  float s[kBatchLanes], depth[kBatchLanes], end[kBatchLanes];
  int32_t x[kBatchLanes], y[kBatchLanes];

  bool isLine(int lane) const { return t0[lane] < t1[lane]; }
  bool isRising(int lane) const { return !(end[lane] > 0.0f); }
  /// FieldLine::tAt().
  float tAt(int lane, float place) const {
    FieldLine line;
    line.t0 = t0[lane], line.t1 = t1[lane], line.ratio = ratio[lane];
    line.begin = isRising(lane) ? -1.0f : 0.0f;
    return line.tAt(place);
  }
};

/// Of each ray its part; of none where that is a miss, or a point.
template <bool kIsLinear>
void makePacketLines(const SegmentField& field, const RayPacket& rays, PacketLines& lines) {
  using F = FloatBatch;
  using M = xsimd::batch_bool<float>;
  const auto loaded = [](const float (&numbers)[kBatchLanes]) { return F::load_aligned(numbers); };
  const PixelGrid& grid = field.pixels;
  const F zero(0.0f), nearDepth(grid.nearDepth), directionX = loaded(rays.directionX), directionY = loaded(rays.directionY), directionZ = loaded(rays.directionZ);
  const F offsetX = loaded(rays.originX) - F(grid.anchor.x), offsetY = loaded(rays.originY) - F(grid.anchor.y), offsetZ = loaded(rays.originZ) - F(grid.anchor.z);
  const auto along = [](const F& x, const F& y, const F& z, const glm::vec3& axis) { return x * F(axis.x) + y * F(axis.y) + z * F(axis.z); };
  const F ox = along(offsetX, offsetY, offsetZ, grid.right), oy = along(offsetX, offsetY, offsetZ, grid.up), oz = along(offsetX, offsetY, offsetZ, grid.forward);
  const F dx = along(directionX, directionY, directionZ, grid.right), dy = along(directionX, directionY, directionZ, grid.up), dz = along(directionX, directionY, directionZ, grid.forward);
  const F leastFromEye = maxOf(F(field.depths.leastFromEye()), absOf(oz) * F(0x1p-20f)), leastDepth = leastFromEye - nearDepth;
  F t0 = loaded(rays.tNear), t1 = loaded(rays.tFar);
  const M hasPart = t0 < t1;
  const auto keep = [&](const F& at0, const F& growth) {
    const F crossing = -at0 / growth;
    const M grows = growth > zero, shrinks = growth < zero;
    t0 = selected(grows, maxOf(crossing, t0), t0);
    t1 = selected(shrinks, minOf(crossing, t1), selected(!(grows | shrinks) & (at0 < zero), t0, t1));
  };
  keep(oz - leastDepth, dz);
  const F depth = nearDepth + oz, tanX(grid.halfWidth * grid.edge), tanY(grid.halfHeight * grid.edge);
  keep(mulAdd(tanX, depth, -ox), mulAdd(tanX, dz, -dx));
  keep(mulAdd(tanX, depth, ox), mulAdd(tanX, dz, dx));
  keep(mulAdd(tanY, depth, -oy), mulAdd(tanY, dz, -dy));
  keep(mulAdd(tanY, depth, oy), mulAdd(tanY, dz, dy));
  const M isLine = hasPart & (t0 < t1), isRising = dz > zero;
  constexpr float kShift = kIsLinear ? 0.5f : 0.0f;
  struct Place {
    F x, y, depth, fromEye;
  };
  const auto projected = [&](const F& t) {
    const F behind = mulAdd(t, dz, oz), fromEye = nearDepth + behind, scale = F(1.0f) / (F(grid.edge) * fromEye);
    const F x = mulAdd(mulAdd(t, dx, ox), scale, F(grid.halfWidth)), y = mulAdd(mulAdd(t, dy, oy), -scale, F(grid.halfHeight));
    const PictureDepths& depths = field.depths;
    return Place{minOf(maxOf(x, zero), F(static_cast<float>(field.width))) + F(kShift), minOf(maxOf(y, zero), F(static_cast<float>(field.height))) + F(kShift),
                 F(depths.reference) * (behind + F(depths.nearDepth - depths.reference)) / (F(depths.nearDepth) + behind), fromEye};
  };
  const Place far = projected(selected(isRising, t1, t0)), near = projected(selected(isRising, t0, t1));
  const auto by = [&](const F& atFar, const F& atNear) { return selected(isRising, atFar - atNear, atNear - atFar); };
  const F begin = selected(isRising, F(-1.0f), zero), ratio = far.fromEye / near.fromEye, perX = by(far.x, near.x), perY = by(far.y, near.y), perS = by(far.depth, near.depth);
  const auto store = [&](const F& value, float (&to)[kBatchLanes]) { selected(isLine, value, zero).store_aligned(to); };
  store(t0, lines.t0);
  store(t1, lines.t1);
  store(far.x, lines.x0);
  store(far.y, lines.y0);
  store(perX, lines.dx);
  store(perY, lines.dy);
  store(far.depth, lines.depth0);
  store(perS, lines.depths);
  selected(isLine, ratio, F(1.0f)).store_aligned(lines.ratio);
  store((t1 - t0) * ratio, lines.spaceBy);
  store(begin, lines.s);
  store(mulAdd(begin, perS, far.depth), lines.depth);
  store(selected(isRising, zero, F(1.0f)), lines.end);
  // Of what is no line not even whole numbers are made.
  const IntBatch lastColumn(field.width - (kIsLinear ? 0 : 1)), lastRow(field.height - (kIsLinear ? 0 : 1));
  const auto cell = [&](const F& place, const IntBatch& last) { return xsimd::min(xsimd::max(truncated(selected(isLine, place, zero)), IntBatch(0)), last); };
  cell(mulAdd(begin, perX, far.x), lastColumn).store_aligned(lines.x);
  cell(mulAdd(begin, perY, far.y), lastRow).store_aligned(lines.y);
}

}  // namespace warpscope
