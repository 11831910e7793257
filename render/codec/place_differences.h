// Places along rays as differences from what their neighbours make likely, and back: the loops that samples and segments, in bands and in tiles, share.
// Prediction: band_layout.h. Slots are fine units (pixel_path.h), one place on: the first stands for none and is 0. Loops read and write through locals only: what they
// write cannot be what they read then.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "render/codec/neighbor_rows.h"
#include "render/codec/neighbor_runs.h"
#include "render/codec/pixel_path.h"
#include "render/codec/tokens.h"
#include "render/core/transfer_vector.h"

namespace warpscope {

inline int32_t wrappedSum(int32_t a, int32_t b) { return static_cast<int32_t>(static_cast<uint32_t>(a) + static_cast<uint32_t>(b)); }
inline int32_t wrappedDifference(int32_t a, int32_t b) { return static_cast<int32_t>(static_cast<uint32_t>(a) - static_cast<uint32_t>(b)); }

inline int32_t predictedSlot(const int32_t* slots, const Neighbors& from) { return predicted(slots[from.west], slots[from.north], slots[from.northWest]); }

/// Folded differences (zigzag); fills the slots behind the first.
inline void putPlaces(const FineScale& scale, std::span<const NeighborRun> runs, std::span<const int32_t> places, int32_t* slots, uint32_t* __restrict__ differences) {
  const int32_t* const place = places.data();
  for (size_t k = 0; k < places.size(); ++k) slots[k + 1] = scale.fineOf(k, place[k]);
  for (const NeighborRun& run : runs) {
    const RunSlots from(slots, run);
    for (size_t i = 0; i < run.size; ++i) {
      const size_t k = run.begin + i;
      differences[k] = zigzag(wrappedDifference(place[k], scale.placeOf(k, predicted(from.west[i], from.north[i], from.northWest[i]))));
    }
  }
}

/// Back (neighbor_runs.h); `differenceAt(k)` gives them one after the other.
template <class DifferenceAt>
auto makingPlaces(const FineScale& scale, DifferenceAt differenceAt, int32_t* slots, int32_t* places) {
  return making(slots, [scale, differenceAt, places](size_t k, int32_t west, int32_t north, int32_t northWest) {
    places[k] = wrappedSum(scale.placeOf(k, predicted(west, north, northWest)), unzigzag(differenceAt(k)));
    return scale.fineOf(k, places[k]);
  });
}

/// The same for rows (neighbor_rows.h): FineScale's formulas, lane by lane.
struct PlacesInRows {
  static constexpr size_t kInputs = 2;

  FineScale scale;
  const uint32_t* differences;
  int32_t* fine;  ///< slots
  int32_t* places;

  const uint32_t* input(size_t i) const { return i == 0 ? reinterpret_cast<const uint32_t*>(scale.origins) : differences; }
  const int32_t* slots() const { return fine; }
  int32_t* out() const { return places; }
  RowLanes make(const RowLanes& west, const RowLanes& north, const RowLanes& northWest, const std::array<RowLanes, kInputs>& inputs, RowLanes& place) const {
    const RowLanes &origin = inputs[0], &difference = inputs[1];
    const RowLanes likely = predictedLanes<SignedRowLanes>(west, north, northWest) + (half() - origin);
    place = reinterpret_cast<RowLanes>(reinterpret_cast<SignedRowLanes>(likely) >> scale.bits) + unzigzagLanes(difference);
    return (place << scale.bits) + origin;
  }
  void finish(size_t first, size_t count) const {
    for (size_t k = first; k < first + count; ++k) fine[k + 1] = scale.fineOf(k, places[k]);
  }
  uint32_t half() const { return scale.bits > 0 ? 1u << (scale.bits - 1) : 0u; }  ///< of a place, in fine units
};

/// Folded differences of numbers that are predicted as they are. Slots are filled.
inline void putNumbers(std::span<const NeighborRun> runs, const int32_t* slots, uint32_t* __restrict__ differences) {
  for (const NeighborRun& run : runs) {
    const RunSlots from(slots, run);
    for (size_t i = 0; i < run.size; ++i) {
      const size_t k = run.begin + i;
      differences[k] = zigzag(wrappedDifference(slots[k + 1], predicted(from.west[i], from.north[i], from.northWest[i])));
    }
  }
}
/// Back.
inline auto makingNumbers(const uint32_t* differences, int32_t* slots) {
  return making(slots, [differences](size_t k, int32_t west, int32_t north, int32_t northWest) { return wrappedSum(predicted(west, north, northWest), unzigzag(differences[k])); });
}
/// The same for rows.
struct NumbersInRows : ValuesInRows<int32_t> {
  RowLanes make(const RowLanes& west, const RowLanes& north, const RowLanes& northWest, const std::array<RowLanes, kInputs>& inputs, RowLanes& number) const {
    return number = predictedLanes<SignedRowLanes>(west, north, northWest) + unzigzagLanes(inputs[0]);
  }
};

/// Where the segments of a layer begin and end, in places of borders.
struct BorderPlaces {
  std::span<int32_t> begins, ends;
};

/// f(k, what is likely, place, whether it is an end), which sets the place or reads it: for where all segments of a layer begin, then for where they end. In front a
/// beginning is predicted from those beside it, behind it the gap from the end in front; an end from those beside it. `endInFront(k)`: a reference to where the segment
/// in front of it ends, which becomes its own end.
template <class EndInFront, class F>
void forEachBorder(const FineScale& scale, std::span<const NeighborRun> runs, bool isFront, const BorderPlaces& places, int32_t* slots, const EndInFront& endInFront, const F& f) {
  makeFromNeighbors(runs, making(slots, [&](size_t k, int32_t west, int32_t north, int32_t northWest) {
    const int32_t likely = predicted(west, north, northWest);
    f(k, isFront ? scale.placeOf(k, likely) : wrappedSum(endInFront(k), likely), places.begins[k], false);
    return isFront ? scale.fineOf(k, places.begins[k]) : wrappedDifference(places.begins[k], endInFront(k));
  }));
  makeFromNeighbors(runs, making(slots, [&](size_t k, int32_t west, int32_t north, int32_t northWest) {
    f(k, scale.placeOf(k, predicted(west, north, northWest)), places.ends[k], true);
    endInFront(k) = places.ends[k];
    return scale.fineOf(k, places.ends[k]);
  }));
}

}  // namespace warpscope
