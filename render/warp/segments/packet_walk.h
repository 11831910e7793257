// As many rays of a new camera at once through the segments of a frame as a vector has lanes. Host only.
// Packets of rays: Wald, Slusallek, Benthin, Wagner 2001. Each lane goes the way of segment_walk.h, by the same operations in the same order (of what is not blended, by those of nearest_walk.h where a segment is met), so that a ray is the
// same bits here as there. As on a device all lanes leap until each stands at a cell with something in it, then all walk through their cells.
#pragma once

#include <bit>

#include "render/core/opacity_batch.h"
#include "render/core/simd_lanes.h"
#include "render/warp/segments/packet_lines.h"
#include "render/warp/segments/segment_walk.h"

namespace warpscope {

/// What rays side by side have met so far.
struct alignas(64) WalkedPacket {
  float red[kBatchLanes], green[kBatchLanes], blue[kBatchLanes], through[kBatchLanes], guessed[kBatchLanes];

  WalkedRay ray(int lane) const { return {{red[lane], green[lane], blue[lane]}, through[lane], guessed[lane]}; }
  void set(int lane, const WalkedRay& walked) {
    red[lane] = walked.color.x, green[lane] = walked.color.y, blue[lane] = walked.color.z;
    through[lane] = walked.through, guessed[lane] = walked.guessed;
  }
};

/// Walks lines that all rise or all fall to their ends.
template <Between kBetween, bool kIsRising, class Fill>
class PacketWalk {
 public:
  /// `isWalked`: 1 for lines that are, else 0. `fill(lane, begin, end, reason)`: passes to that lane of `walked` a part of its line, as walkRest()'s does; s. nullptr:
  /// there is nothing where nothing is known.
  PacketWalk(const SegmentField& field, const PacketLines& lines, const float (&isWalked)[kBatchLanes], float stopBelow, WalkedPacket& walked, const Fill& fill)
      : field_(field), stopBelow_(stopBelow), fill_(fill), walked_(walked) {
    x0_ = loaded(lines.x0), y0_ = loaded(lines.y0), dx_ = loaded(lines.dx), dy_ = loaded(lines.dy);
    depth0_ = loaded(lines.depth0), depths_ = loaded(lines.depths), ratio_ = loaded(lines.ratio), spaceBy_ = loaded(lines.spaceBy);
    s_ = loaded(lines.s), depth_ = loaded(lines.depth), end_ = loaded(lines.end);
    x_ = IntBatch::load_aligned(lines.x), y_ = IntBatch::load_aligned(lines.y);
    active_ = loaded(isWalked) > F(0.0f);
    stepsX_ = absOf(dx_) > F(kLeastWayAlongAxis), stepsY_ = absOf(dy_) > F(kLeastWayAlongAxis);
    perX_ = selected(stepsX_, F(1.0f) / dx_, F(0.0f)), perY_ = selected(stepsY_, F(1.0f) / dy_, F(0.0f));
    perDepth_ = F(1.0f) / depths_;
    leadX_ = chosen(dx_ > F(0.0f), I(1), I(0)), leadY_ = chosen(dy_ > F(0.0f), I(1), I(0));
    columns_ = field.width + (kIsLinear ? 1 : 0), rows_ = field.height + (kIsLinear ? 1 : 0);
    lastSegment_ = static_cast<int>(field.first[static_cast<size_t>(field.width) * static_cast<size_t>(field.height)] & ~SegmentField::kEndedBit) - 1;
    for (int level = 0; level < kFieldLevels; ++level) tilesFrom_[level] = static_cast<int>(field.tiles[level] - field.tiles[0]);
    load();
  }
  PacketWalk(const PacketWalk&) = delete;
  PacketWalk& operator=(const PacketWalk&) = delete;

  void run() {
    while (true) {
      leap();
      if (!xsimd::any(active_)) break;
      enterCells();
      walkCells();
    }
    if constexpr (kFills) {
      const M isUnknown = unknownFrom_ < F(kNowhereOnLine);
      if (xsimd::any(isUnknown)) fillUnknown(isUnknown, end_);
    }
    store();
  }

 private:
  using F = FloatBatch;
  using I = IntBatch;
  using M = xsimd::batch_bool<float>;
  static constexpr bool kFills = !std::is_same_v<Fill, std::nullptr_t>;
  static constexpr bool kIsLinear = blends(kBetween), kChecks = kBetween == Between::refined && kFills;
  static constexpr int kPixels = kIsLinear ? 4 : 1;
  static constexpr float kInfinity = std::numeric_limits<float>::infinity();
  static constexpr int kTopShift = fieldShift(kFieldLevels - 1);

  /// PixelState, with its colour.
  struct State {
    F extinction = F(0.0f), known = F(1.0f), until = F(0.0f), red = F(0.0f), green = F(0.0f), blue = F(0.0f);

    void take(const M& which, const State& other) {
      extinction = selected(which, other.extinction, extinction);
      known = selected(which, other.known, known);
      until = selected(which, other.until, until);
      red = selected(which, other.red, red);
      green = selected(which, other.green, green);
      blue = selected(which, other.blue, blue);
    }
  };

  /// Of a cell of which something has been known all along, as in walkBlended(): where and as what it began.
  struct Stretch {
    M isAny = M(false);
    F s = F(0.0f), red = F(0.0f), green = F(0.0f), blue = F(0.0f), through = F(0.0f);
    PixelViews<F> views;

    Stretch() { views.clear(); }
  };

  static F loaded(const float (&numbers)[kBatchLanes]) { return F::load_aligned(numbers); }
  static I chosen(const M& which, const I& ifTrue, const I& ifFalse) { return xsimd::select(xsimd::bool_cast(which), ifTrue, ifFalse); }
  static M isLess(const I& a, const I& b) { return xsimd::bool_cast(a < b); }
  static I within(const I& a, const I& least, const I& most) { return xsimd::min(xsimd::max(a, least), most); }
  /// On the way: true where `a` comes before `b`.
  static M isBefore(const F& a, const F& b) {
    if constexpr (kIsRising)
      return a < b;
    else
      return a > b;
  }
  static F firstOf(const F& a, const F& b) { return kIsRising ? minOf(a, b) : maxOf(a, b); }

  F depthAt(const F& s) const { return mulAdd(s, depths_, depth0_); }
  F divisorAt(const F& s) const { return mulAdd(absOf(s), ratio_ - F(1.0f), F(1.0f)); }
  I byLevel(const int (&values)[kFieldLevels]) const {
    I value(values[0]);
    for (int level = 1; level < kFieldLevels; ++level) value = chosen(isLess(I(fieldShift(level) - 1), shift_), I(values[level]), value);
    return value;
  }

  void load() { red_ = loaded(walked_.red), green_ = loaded(walked_.green), blue_ = loaded(walked_.blue), through_ = loaded(walked_.through); }
  void store() {
    red_.store_aligned(walked_.red), green_.store_aligned(walked_.green), blue_.store_aligned(walked_.blue), through_.store_aligned(walked_.through);
  }

  /// The walks of `which` go on from where they are as they began, having passed what is between.
  void fillBetween(const M& which, const F& begin, const F& end, FillReason reason) {
    if constexpr (kFills) {
      alignas(64) float from[kBatchLanes], to[kBatchLanes];
      begin.store_aligned(from), end.store_aligned(to);
      store();
      for (uint32_t bits = bitsOf(which); bits != 0; bits &= bits - 1) {
        const int lane = std::countr_zero(bits);
        if (from[lane] < to[lane]) fill_(lane, from[lane], to[lane], reason);
      }
      load();
    }
  }
  void fillUnknown(const M& which, const F& end) {
    fillBetween(which, unknownFrom_, end, FillReason::unknown);
    unknownFrom_ = selected(which, F(kNowhereOnLine), unknownFrom_);
  }
  void interrupt(const M& which) {
    fillUnknown(which, s_);
    goOnAnew(which);
  }
  void goOnAnew(const M& which) {
    active_ = active_ & !(which & (through_ < F(stopBelow_)));
    shift_ = chosen(which, I(kTopShift), shift_);
    keptX_ = keptX_ & !which, keptY_ = keptY_ & !which;
  }
  void beginUnknown(const M& which) {
    if constexpr (kFills) unknownFrom_ = selected(which & (unknownFrom_ >= F(kNowhereOnLine)), s_, unknownFrom_);
  }

  /// To cells that have something, or to the end.
  void leap() {
    active_ = active_ & (s_ < end_);
    M leaping = active_;
    const float* const tiles = &field_.tiles[0]->nearestBegin;
    while (xsimd::any(leaping)) {
      const I tx = shiftedRight(x_, shift_), ty = shiftedRight(y_, shift_);
      const I borderX = shiftedLeft(tx + leadX_, shift_), borderY = shiftedLeft(ty + leadY_, shift_);
      const F sx = selected(stepsX_, (converted(borderX) - x0_) * perX_, F(kInfinity)), sy = selected(stepsY_, (converted(borderY) - y0_) * perY_, F(kInfinity));
      const F out = minOf(maxOf(minOf(sx, sy), s_), end_), depthOut = depthAt(out);
      const F least = minOf(depth_, depthOut), most = maxOf(depth_, depthOut);
      const auto [nearestBegin, farthestEnd, nearestUnknown, farthestUnknown] =
          gatheredQuads(tiles, chosen(leaping, byLevel(tilesFrom_) + ty * byLevel(field_.tileColumns) + tx, I(0))).of;
      M overEmpty = (nearestBegin > most) | (farthestEnd < least), overUnknown(false);
      if constexpr (kFills) {
        overEmpty = overEmpty & (nearestUnknown > most);
        overUnknown = !overEmpty & (farthestUnknown < least);
      }
      M moving = leaping & (overEmpty | overUnknown);
      const M descending = leaping & !moving, isAtCell = descending & isLess(shift_, I(1));
      sx_ = selected(isAtCell, sx, sx_), sy_ = selected(isAtCell, sy, sy_), out_ = selected(isAtCell, out, out_), depthOut_ = selected(isAtCell, depthOut, depthOut_);
      leaping = leaping & !isAtCell;
      shift_ = chosen(descending & !isAtCell, shift_ - I(kFieldLevelShift), shift_);
      if constexpr (kFills) {
        const M interrupted = moving & overEmpty & (unknownFrom_ < F(kNowhereOnLine));
        if (xsimd::any(interrupted)) {
          moving = moving & !interrupted;
          interrupt(interrupted);
          leaping = leaping & active_;
        }
        beginUnknown(moving & overUnknown);
      }
      if (!xsimd::any(moving)) continue;

      const I low = shiftedLeft(I(1), shift_) - I(1), tileX = shiftedLeft(tx, shift_), tileY = shiftedLeft(ty, shift_);
      const M isOnX = sx <= sy;
      const I newX = chosen(isOnX, borderX - I(1) + leadX_, within(truncated(mulAdd(out, dx_, x0_)), tileX, xsimd::min(tileX + low, I(columns_ - 1))));
      const I newY = chosen(isOnX, within(truncated(mulAdd(out, dy_, y0_)), tileY, xsimd::min(tileY + low, I(rows_ - 1))), borderY - I(1) + leadY_);
      leaping = leaping & !moveTo(moving, newX, newY, out, depthOut);
      keptX_ = keptX_ & !moving, keptY_ = keptY_ & !moving;
    }
  }

  /// Which of `which` are at their ends then.
  M moveTo(const M& which, const I& x, const I& y, const F& s, const F& depth) {
    s_ = selected(which, s, s_), depth_ = selected(which, depth, depth_);
    const M isOut = !(s_ < end_) | isLess(x, I(0)) | isLess(y, I(0)) | isLess(I(columns_ - 1), x) | isLess(I(rows_ - 1), y);
    const M ended = which & isOut, going = which & !isOut;
    active_ = active_ & !ended;
    const I changed = (x ^ x_) | (y ^ y_);  // levelLeft()
    I left(0);
    for (int level = 1; level < kFieldLevels; ++level) left = chosen(isLess(I((1 << fieldShift(level)) - 1), changed), I(fieldShift(level)), left);
    shift_ = chosen(going, left, shift_);
    x_ = chosen(going, x, x_), y_ = chosen(going, y, y_);
    return ended;
  }

  void enterCells() {
    if constexpr (kIsLinear) {
      const I zero(0), lastColumn(field_.width - 1), lastRow(field_.height - 1), width(field_.width);
      const I leading = within(x_ - I(1) + leadX_, zero, lastColumn), trailing = within(x_ - leadX_, zero, lastColumn);
      const I leadingRow = within(y_ - I(1) + leadY_, zero, lastRow) * width, trailingRow = within(y_ - leadY_, zero, lastRow) * width;
      pixel_[0] = trailingRow + trailing, pixel_[1] = trailingRow + leading, pixel_[2] = leadingRow + trailing, pixel_[3] = leadingRow + leading;
      states_[0].take(keptX_, states_[1]), states_[2].take(keptX_, states_[3]);
      states_[0].take(keptY_, states_[2]), states_[1].take(keptY_, states_[3]);
    } else {
      pixel_[0] = y_ * I(field_.width) + x_;
    }
    const F expired(kIsRising ? -kInfinity : kInfinity);
    if constexpr (kIsLinear) {
      states_[0].until = selected(keptX_ | keptY_, states_[0].until, expired);
      states_[1].until = selected(keptY_, states_[1].until, expired);
      states_[2].until = selected(keptX_, states_[2].until, expired);
      states_[3].until = expired;
    } else {
      states_[0].until = expired;
    }
  }

  /// Of `piecing`, the states that do not hold any more where they are: stateOf(). One of each lane at a time, whichever of its pixels that is of.
  [[gnu::always_inline]] void findStates(const M& piecing) {
    M stale[kPixels], any = M(false);
    for (int i = 0; i < kPixels; ++i) {
      stale[i] = piecing & !isBefore(depth_, states_[i].until);
      any = any | stale[i];
    }
    while (xsimd::any(any)) {
      I pixel(0);
      M left = any, rest = M(false), now[kPixels];
      for (int i = 0; i < kPixels; ++i) {
        now[i] = stale[i] & left;
        left = left & !now[i];
        stale[i] = stale[i] & !now[i];
        rest = rest | stale[i];
        pixel = chosen(now[i], pixel_[i], pixel);
      }
      const State found = find(pixel, any);
      for (int i = 0; i < kPixels; ++i) states_[i].take(now[i], found);
      any = rest;
    }
  }

  /// stateOf() of `which` of the pixels.
  State find(const I& pixel, const M& which) const {
    const float* const spans = &field_.spans[0].begin;
    const I kMask(std::numeric_limits<int32_t>::max());
    const auto [own, next] = gatheredPairs(field_.first, pixel);
    const I begin = own & kMask, end = next & kMask;
    const M isEnded = isLess(next, I(0));
    State found;
    found.until = F(kIsRising ? kInfinity : -kInfinity);
    found.known = selected(kIsRising ? isEnded : isEnded & !isLess(begin, end), F(0.0f), F(1.0f));
    I at = kIsRising ? begin : end - I(1), active(0);
    M searching = which & isLess(begin, end), isInside = M(false);
    while (xsimd::any(searching)) {
      const auto [itsBegin, itsEnd] = gatheredFloatPairs(spans, within(at, I(0), I(lastSegment_)));
      const M isIt = searching & (kIsRising ? depth_ < itsEnd : itsBegin < depth_);
      const M inside = isIt & (kIsRising ? itsBegin <= depth_ : depth_ <= itsEnd);
      found.until = selected(isIt, kIsRising ? selected(inside, itsEnd, itsBegin) : selected(inside, itsBegin, itsEnd), found.until);
      if constexpr (kIsRising) {
        found.known = selected(isIt, F(1.0f), found.known);
      } else {
        const M isLast = xsimd::bool_cast(at == end - I(1));
        found.known = selected(isIt, selected(!inside & isEnded & isLast, F(0.0f), F(1.0f)), found.known);
      }
      active = chosen(inside, at, active);
      isInside = isInside | inside;
      at = kIsRising ? at + I(1) : at - I(1);
      searching = searching & !isIt & (kIsRising ? isLess(at, end) : !isLess(at, begin));
    }
    if (xsimd::any(isInside)) {
      const auto [red, green, blue, extinction] = gatheredQuads(&field_.matter[0].color.x, active).of;
      found.red = selected(isInside, red, F(0.0f)), found.green = selected(isInside, green, F(0.0f)), found.blue = selected(isInside, blue, F(0.0f));
      found.extinction = selected(isInside, extinction, F(0.0f));
    }
    return found;
  }

  /// A piece that is so long, over the divisors, by what the pixels about it have.
  [[gnu::always_inline]] void pass(const M& which, const F (&weights)[kPixels], const F& way, const F& divisors, F (&left)[kPixels], Stretch& stretch) {
    F opacity, share, red(0.0f), green(0.0f), blue(0.0f);
    if constexpr (kIsLinear) {
      const F length = way / divisors;
      F all(0.0f), stopped(0.0f);
      for (int i = 0; i < kPixels; ++i) {
        const State& state = states_[i];
        const F its = opacityOf(state.extinction * length), weight = weights[i] * left[i], own = weight * its;
        all = all + weight;
        stopped = stopped + own;
        red = red + own * state.red, green = green + own * state.green, blue = blue + own * state.blue;
        if constexpr (kChecks) {
          const F light = selected(which, left[i] * its, F(0.0f));
          F(&color)[3] = stretch.views.color[i];
          color[0] = mulAdd(light, state.red, color[0]), color[1] = mulAdd(light, state.green, color[1]), color[2] = mulAdd(light, state.blue, color[2]);
          stretch.views.asked[i] = selected(which & (weights[i] > F(kLeastKnown)), F(1.0f), stretch.views.asked[i]);
        }
        left[i] = selected(which, maxOf(left[i] * (F(1.0f) - its), F(kLeastLeft)), left[i]);
      }
      const F perWeight = F(1.0f) / all;
      opacity = stopped * perWeight, share = through_ * perWeight;
    } else {
      opacity = opacityOf(states_[0].extinction * way / divisors), share = through_ * opacity;
      red = states_[0].red, green = states_[0].green, blue = states_[0].blue;
    }
    const M isAny = which & (opacity > F(0.0f));
    red_ = selected(isAny, mulAdd(share, red, red_), red_);
    green_ = selected(isAny, mulAdd(share, green, green_), green_);
    blue_ = selected(isAny, mulAdd(share, blue, blue_), blue_);
    through_ = selected(isAny, through_ * (F(1.0f) - opacity), through_);
  }

  void beginStretch(const M& which, Stretch& stretch) const {
    stretch.s = selected(which, s_, stretch.s);
    stretch.red = selected(which, red_, stretch.red), stretch.green = selected(which, green_, stretch.green), stretch.blue = selected(which, blue_, stretch.blue);
    stretch.through = selected(which, through_, stretch.through);
    for (int i = 0; i < kPixels; ++i) {
      stretch.views.asked[i] = selected(which, F(0.0f), stretch.views.asked[i]);
      for (F& channel : stretch.views.color[i]) channel = selected(which, F(0.0f), channel);
    }
    stretch.isAny = stretch.isAny | which;
  }
  /// Those of `which` whose stretches, which end there, are doubted and have been filled. Their walks go on from there as they began.
  M fillDoubted(const M& which, const F& end, const F (&left)[kPixels], const Stretch& stretch) {
    if (!xsimd::any(which)) return which;
    const M doubted = which & (stretch.views.disagreement(left) * stretch.through > F(kMostDisagreement));
    if (!xsimd::any(doubted)) return doubted;
    red_ = selected(doubted, stretch.red, red_), green_ = selected(doubted, stretch.green, green_), blue_ = selected(doubted, stretch.blue, blue_);
    through_ = selected(doubted, stretch.through, through_);
    fillBetween(doubted, stretch.s, end, FillReason::doubted);
    goOnAnew(doubted);
    return doubted;
  }

  /// Through the cells in which all are that are still under way, in pieces in which nothing changes, and to the next ones.
  void walkCells() {
    M piecing = active_, leaving = M(false);
    F left[kPixels];  // as walkBlended() says
    for (F& one : left) one = F(1.0f);
    Stretch stretch;
    while (xsimd::any(piecing)) {
      findStates(piecing);
      F until = depthOut_;
      for (int i = 0; i < kPixels; ++i) until = firstOf(states_[i].until, until);
      const M isLast = !isBefore(until, depthOut_);
      const F to = selected(isLast, out_, minOf(maxOf((until - depth0_) * perDepth_, s_), out_));
      const F share = selected(isLast, out_ - s_, (until - depth_) * perDepth_);
      F weights[kPixels];
      if constexpr (kIsLinear) {
        const F middle = F(0.5f) * (s_ + to), way = to - s_;
        const F u = saturated(absOf(mulAdd(middle, dx_, x0_) - converted(x_ + I(1) - leadX_)));
        const F v = saturated(absOf(mulAdd(middle, dy_, y0_) - converted(y_ + I(1) - leadY_)));
        weights[3] = mulAdd(u, v, absOf((dx_ * way) * (dy_ * way)) * F(1.0f / 12));
        weights[1] = maxOf(u - weights[3], F(0.0f));
        weights[2] = maxOf(v - weights[3], F(0.0f));
        weights[0] = maxOf(F(1.0f) - u - weights[2], F(0.0f));
      } else {
        weights[0] = F(1.0f);
      }
      F known(0.0f);
      for (int i = 0; i < kPixels; ++i) {
        weights[i] = weights[i] * states_[i].known;
        known = known + weights[i];
      }
      const M isUnknown = known < F(kLeastKnown);
      if constexpr (kChecks) {
        piecing = piecing & !fillDoubted(piecing & isUnknown & stretch.isAny, s_, left, stretch);
        stretch.isAny = stretch.isAny & !isUnknown;
      }
      if constexpr (kFills) {
        beginUnknown(piecing & isUnknown);
        const M interrupted = piecing & !isUnknown & (unknownFrom_ < F(kNowhereOnLine));
        if (xsimd::any(interrupted)) {
          interrupt(interrupted);
          piecing = piecing & !interrupted;
        }
      }
      for (F& one : left) one = selected(isUnknown, F(1.0f), one);
      if (const M passing = piecing & !isUnknown; xsimd::any(passing)) {
        if constexpr (kChecks) beginStretch(passing & !stretch.isAny, stretch);
        pass(passing, weights, spaceBy_ * share, divisorAt(s_) * divisorAt(to), left, stretch);
      }
      s_ = selected(piecing, to, s_);
      if constexpr (kChecks) {
        const M doubted = fillDoubted(piecing & ((through_ < F(stopBelow_)) | isLast) & stretch.isAny, out_, left, stretch);
        s_ = selected(doubted, out_, s_), depth_ = selected(doubted, depthOut_, depth_);
        piecing = piecing & !doubted;
      }
      const M stopped = piecing & (through_ < F(stopBelow_));
      active_ = active_ & !stopped;
      piecing = piecing & !stopped;
      leaving = leaving | (piecing & isLast);
      piecing = piecing & !isLast;
      depth_ = selected(piecing, until, depth_);
    }
    const M isOnX = sx_ <= sy_;
    keptX_ = leaving & isOnX, keptY_ = leaving & !isOnX;
    const I step(2), one(1);
    moveTo(leaving, chosen(isOnX, x_ + step * leadX_ - one, x_), chosen(isOnX, y_, y_ + step * leadY_ - one), out_, depthOut_);
  }

  const SegmentField& field_;
  const float stopBelow_;
  const Fill& fill_;
  WalkedPacket& walked_;
  int columns_ = 0, rows_ = 0, lastSegment_ = 0;
  int tilesFrom_[kFieldLevels];
  // Of the lines.
  F x0_, y0_, dx_, dy_, depth0_, depths_, ratio_, spaceBy_, end_, perX_, perY_, perDepth_;
  M stepsX_, stepsY_;
  I leadX_, leadY_;
  // Of the walks.
  M active_;
  F s_, depth_, unknownFrom_ = F(kNowhereOnLine);
  I x_, y_, shift_ = I(kTopShift);
  M keptX_ = M(false), keptY_ = M(false);
  // Of the cells.
  F sx_ = F(0.0f), sy_ = F(0.0f), out_ = F(0.0f), depthOut_ = F(0.0f);
  I pixel_[kPixels];
  State states_[kPixels];
  F red_, green_, blue_, through_;
};

/// walkSegments() of rays side by side, as many as a vector has lanes. Of each its part is walked; none where that is a miss. `fill(lane, walked, tNear,
/// tFar, reason)`, or nullptr. `walked`: as it begins. The field's tiles lie in one array, level after level, as BuiltSegmentField's do.
template <Between kBetween, class Fill>
void walkPacket(const SegmentField& field, const RayPacket& rays, float stopBelow, WalkedRay (&walked)[kBatchLanes], const Fill& fill) {
  constexpr bool kFills = !std::is_same_v<Fill, std::nullptr_t>;
  PacketLines lines;
  makePacketLines<blends(kBetween)>(field, rays, lines);
  WalkedPacket colors;
  alignas(64) float rises[kBatchLanes] = {}, falls[kBatchLanes] = {};
  bool anyRises = false, anyFalls = false;
  const auto fillRay = [&](int lane, float tNear, float tFar) {
    if constexpr (kFills)
      if (tNear < tFar && !(walked[lane].through < stopBelow)) fill(lane, walked[lane], tNear, tFar, FillReason::unknown);
  };
  for (int lane = 0; lane < kBatchLanes; ++lane) {
    const bool isLine = lines.isLine(lane);
    fillRay(lane, rays.tNear[lane], isLine ? lines.t0[lane] : rays.tFar[lane]);
    if (isLine && !(walked[lane].through < stopBelow)) {
      (lines.isRising(lane) ? rises : falls)[lane] = 1.0f;
      (lines.isRising(lane) ? anyRises : anyFalls) = true;
    }
    colors.set(lane, walked[lane]);
  }
  const auto walk = [&](const auto& fillPiece) {
    using FillPiece = std::decay_t<decltype(fillPiece)>;
    if (anyRises) PacketWalk<kBetween, true, FillPiece>(field, lines, rises, stopBelow, colors, fillPiece).run();
    if (anyFalls) PacketWalk<kBetween, false, FillPiece>(field, lines, falls, stopBelow, colors, fillPiece).run();
  };
  if constexpr (kFills) {
    walk([&](int lane, float begin, float end, FillReason reason) {
      WalkedRay ray = colors.ray(lane);
      fill(lane, ray, lines.tAt(lane, begin), lines.tAt(lane, end), reason);
      colors.set(lane, ray);
    });
  } else {
    walk(nullptr);
  }
  for (int lane = 0; lane < kBatchLanes; ++lane) {
    walked[lane] = colors.ray(lane);
    if (rises[lane] + falls[lane] > 0.0f) fillRay(lane, lines.t1[lane], rays.tFar[lane]);
  }
}

}  // namespace warpscope
