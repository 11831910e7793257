// Values that are made one after the other from their neighbours (neighbor_runs.h), where rows have no gaps: several rows
// at once, each a value behind the one above it, as lanes of vectors. What is north of a value has been made a step
// before, in the lane beside it (a wavefront; cf. Lamport 1974, "The parallel execution of DO loops").
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "render/codec/neighbor_runs.h"

namespace warpscope {

static_assert(kRowsAtOnce == 4, "what follows is written for four");

/// A value of each row. Operators are the compilers' own, lane by lane.
using RowLanes [[gnu::vector_size(kRowsAtOnce * sizeof(uint32_t))]] = uint32_t;
using SignedRowLanes [[gnu::vector_size(kRowsAtOnce * sizeof(int32_t))]] = int32_t;
using ByteRowLanes [[gnu::vector_size(kRowsAtOnce * sizeof(uint32_t))]] = uint8_t;

template <class Lanes>
Lanes lesserLanes(const Lanes& a, const Lanes& b) {
  return a < b ? a : b;
}
template <class Lanes>
Lanes greaterLanes(const Lanes& a, const Lanes& b) {
  return a < b ? b : a;
}
/// predicted() of each (band_layout.h); sums of signed ones do not overflow in what they are made of.
template <class Lanes>
RowLanes predictedLanes(const RowLanes& west, const RowLanes& north, const RowLanes& northWest) {
  using Sums = std::conditional_t<std::is_same_v<Lanes, SignedRowLanes>, RowLanes, Lanes>;
  const auto w = reinterpret_cast<Lanes>(west), n = reinterpret_cast<Lanes>(north);
  const Lanes within = lesserLanes(greaterLanes(reinterpret_cast<Lanes>(northWest), lesserLanes(w, n)), greaterLanes(w, n));
  return reinterpret_cast<RowLanes>(reinterpret_cast<Sums>(west) + reinterpret_cast<Sums>(north) - reinterpret_cast<Sums>(within));
}

inline RowLanes unzigzagLanes(const RowLanes& codes) { return codes >> 1 ^ (0u - (codes & 1)); }

/// What `Formula` says of a value:
///   kInputs, input(i): what comes of each value, by its number;
///   slots(): what values are predicted from, one place on;
///   out(): what is made, by its number;
///   make(west, north, north-west, inputs, made): what is predicted from, and, in the lanes `made`, what goes out;
///   finish(first number, how many): after so many have been made, sets their slots if they are not what goes out.
template <class Formula>
class RowMaking {
 public:
  explicit RowMaking(Formula formula) : formula_(formula) {}

  /// The first values of kRowsAtOnce rows, of which the first begins with value number `begin`.
  void begin(size_t begin, size_t width) {
    begin_ = begin;
    width_ = width;
    last_ = northWest_ = RowLanes{};
    store<true>(0);
  }
  /// The next kRowsAtOnce values of each row; each row's are one in front of those of the row above it. `at`: of the first row.
  void goOn(size_t at) { store<false>(at); }
  /// The values that are left. The first row has none: what its lane reads and makes here counts for nothing.
  void end() {
    Block inputs[Formula::kInputs]{};
    for (size_t i = 0; i < Formula::kInputs; ++i) forEachEnd([&]<size_t row>() { std::memcpy(&inputs[i][row], formula_.input(i) + placeOf(row, width_), row * sizeof(uint32_t)); });
    const Block made = make<false>(inputs, width_);
    forEachEnd([&]<size_t row>() { std::memcpy(formula_.out() + placeOf(row, width_), &made[row], row * sizeof(uint32_t)); });
    formula_.finish(begin_, kRowsAtOnce * width_);
  }

 private:
  using Block = std::array<RowLanes, kRowsAtOnce>;

  /// f<row>() of the rows that end behind the first: as many values as that are left of each.
  template <class F>
  static void forEachEnd(const F& f) {
    f.template operator()<1>();
    f.template operator()<2>();
    f.template operator()<3>();
  }

  /// Of a row's value that is made together with number `at` of the first row.
  size_t placeOf(size_t row, size_t at) const { return begin_ + row * width_ + at - row; }

  /// What is written in front of a row's first value, where rows begin, is written over by the row above it: now, or later on.
  template <bool isFirst>
  void store(size_t at) {
    Block inputs[Formula::kInputs];
    for (size_t i = 0; i < Formula::kInputs; ++i)
      for (size_t row = 0; row < kRowsAtOnce; ++row) std::memcpy(&inputs[i][row], formula_.input(i) + placeOf(row, at), sizeof(RowLanes));
    const Block made = make<isFirst>(inputs, at);
    for (size_t row = kRowsAtOnce; row-- > 0;) std::memcpy(formula_.out() + placeOf(row, at), &made[row], sizeof(RowLanes));
  }

  template <bool isFirst>
  Block make(Block (&inputs)[Formula::kInputs], size_t at) {
    for (Block& input : inputs) transpose(input);
    RowLanes above;
    std::memcpy(&above, formula_.slots() + (begin_ - width_ + 1) + at, sizeof above);
    Block made;
    step<0, isFirst>(inputs, above, made);
    step<1, isFirst>(inputs, above, made);
    step<2, isFirst>(inputs, above, made);
    step<3, isFirst>(inputs, above, made);
    transpose(made);
    return made;
  }

  template <int number, bool isFirst>
  void step(const Block (&inputs)[Formula::kInputs], const RowLanes& above, Block& made) {
    const RowLanes north = __builtin_shufflevector(last_, above, 4 + number, 0, 1, 2);
    if constexpr (isFirst) last_[number] = north[number];
    std::array<RowLanes, Formula::kInputs> own;
    for (size_t i = 0; i < Formula::kInputs; ++i) own[i] = inputs[i][number];
    last_ = formula_.make(last_, north, northWest_, own, made[number]);
    northWest_ = north;
  }

  static void transpose(Block& block) {
    const RowLanes lower01 = __builtin_shufflevector(block[0], block[1], 0, 4, 1, 5), upper01 = __builtin_shufflevector(block[0], block[1], 2, 6, 3, 7);
    const RowLanes lower23 = __builtin_shufflevector(block[2], block[3], 0, 4, 1, 5), upper23 = __builtin_shufflevector(block[2], block[3], 2, 6, 3, 7);
    block[0] = __builtin_shufflevector(lower01, lower23, 0, 1, 4, 5);
    block[1] = __builtin_shufflevector(lower01, lower23, 2, 3, 6, 7);
    block[2] = __builtin_shufflevector(upper01, upper23, 0, 1, 4, 5);
    block[3] = __builtin_shufflevector(upper01, upper23, 2, 3, 6, 7);
  }

  Formula formula_;
  size_t begin_ = 0, width_ = 0;
  RowLanes last_{}, northWest_{};
};

/// What formulas share whose values are made of one difference each and are what goes out.
template <class T>
struct ValuesInRows {
  static constexpr size_t kInputs = 1;

  const uint32_t* differences;
  T* values;  ///< slots; not where the differences are

  const uint32_t* input(size_t) const { return differences; }
  const T* slots() const { return values; }
  T* out() const { return values + 1; }
  void finish(size_t, size_t) const {}
};

/// Each waits for what it made before, and none for another.
template <class... Makings>
void makeRows(const NeighborRows& rows, Makings... makings) {
  for (size_t row = 0; row < rows.count; row += kRowsAtOnce) {
    (makings.begin(rows.begin + row * rows.width, rows.width), ...);
    for (size_t at = kRowsAtOnce; at < rows.width; at += kRowsAtOnce) (makings.goOn(at), ...);
    (makings.end(), ...);
  }
}

}  // namespace warpscope
