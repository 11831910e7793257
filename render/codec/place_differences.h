// Places along rays as differences from what their neighbours make likely, and back: the loops that samples and segments, in bands and in tiles, share.
// Prediction: band_layout.h. Slots are fine units (pixel_path.h), one place on: the first stands for none and is 0. Loops read and write through locals only: what they
// write cannot be what they read then.
#pragma once

#include <cstdint>
#include <span>

#include "render/codec/band_layout.h"
#include "render/codec/pixel_path.h"
#include "render/codec/tokens.h"
#include "render/core/transfer_vector.h"

namespace warpscope {

inline int32_t wrappedSum(int32_t a, int32_t b) { return static_cast<int32_t>(static_cast<uint32_t>(a) + static_cast<uint32_t>(b)); }
inline int32_t wrappedDifference(int32_t a, int32_t b) { return static_cast<int32_t>(static_cast<uint32_t>(a) - static_cast<uint32_t>(b)); }

inline int32_t predictedSlot(const int32_t* slots, const Neighbors& from) { return predicted(slots[from.west], slots[from.north], slots[from.northWest]); }

/// Folded differences (zigzag); fills the slots behind the first.
inline void putPlaces(const FineScale& scale, const Neighbors* neighbors, std::span<const int32_t> places, int32_t* slots, uint32_t* differences) {
  const int32_t* const place = places.data();
  for (size_t k = 0; k < places.size(); ++k) slots[k + 1] = scale.fineOf(k, place[k]);
  for (size_t k = 0; k < places.size(); ++k) differences[k] = zigzag(wrappedDifference(place[k], scale.placeOf(k, predictedSlot(slots, neighbors[k]))));
}

/// Back; `differenceAt(k)` gives them one after the other.
template <class DifferenceAt>
void takePlaces(const FineScale& scale, const Neighbors* neighbors, DifferenceAt differenceAt, int32_t* slots, std::span<int32_t> places) {
  int32_t* const place = places.data();
  int32_t last = 0;  // what slots[k] became, nearly always the western neighbour's: it need not come back from memory
  for (size_t k = 0; k < places.size(); ++k) {
    const Neighbors from = neighbors[k];
    const int32_t west = from.west == k ? last : slots[from.west];
    const int32_t likely = scale.placeOf(k, predicted(west, slots[from.north], slots[from.northWest]));
    place[k] = wrappedSum(likely, unzigzag(differenceAt(k)));
    last = scale.fineOf(k, place[k]);
    slots[k + 1] = last;
  }
}

/// Where the segments of a layer begin and end, in places of borders.
struct BorderPlaces {
  std::span<int32_t> begins, ends;
};

/// f(k, what is likely, place, whether it is an end), which sets the place or reads it: for where all segments of a layer begin, then for where they end. In front a
/// beginning is predicted from those beside it, behind it the gap from the end in front; an end from those beside it. `endInFront(k)`: a reference to where the segment
/// in front of it ends, which becomes its own end.
template <class EndInFront, class F>
void forEachBorder(const FineScale& scale, const Neighbors* neighbors, bool isFront, const BorderPlaces& places, int32_t* slots, const EndInFront& endInFront, const F& f) {
  for (size_t k = 0; k < places.begins.size(); ++k) {
    const int32_t likely = predictedSlot(slots, neighbors[k]);
    if (isFront) {
      f(k, scale.placeOf(k, likely), places.begins[k], false);
      slots[k + 1] = scale.fineOf(k, places.begins[k]);
    } else {
      f(k, wrappedSum(endInFront(k), likely), places.begins[k], false);
      slots[k + 1] = wrappedDifference(places.begins[k], endInFront(k));
    }
  }
  for (size_t k = 0; k < places.ends.size(); ++k) {
    f(k, scale.placeOf(k, predictedSlot(slots, neighbors[k])), places.ends[k], true);
    slots[k + 1] = scale.fineOf(k, places.ends[k]);
    endInFront(k) = places.ends[k];
  }
}

}  // namespace warpscope
