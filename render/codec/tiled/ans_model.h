// How frequent each symbol of a plane is: what writer and reader of its symbols share (ans.h).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "render/codec/bytes.h"
#include "render/codec/tiled/ans.h"

namespace warpscope {

/// Of nothing: no symbol occurs.
class AnsModel {
 public:
  static constexpr size_t kMostBytes = 1 + 2 * kAnsSymbols;

  AnsModel() = default;
  static AnsModel ofCounts(std::span<const uint32_t, kAnsSymbols> counts);
  /// Of kAnsScale in all, or 0.
  static AnsModel ofFrequencies(std::span<const uint16_t, kAnsSymbols> frequencies);

  /// The highest symbol, then each one's frequency: below 128 in one byte, else in two.
  void append(ByteVector& out) const;
  /// False if what is there is not a model.
  bool take(ByteReader& reader);

  bool isEmpty() const { return isEmpty_; }
  /// Whether there is but one symbol: it takes no bits.
  bool isConstant() const { return !isEmpty_ && frequencies_[constant_] == kAnsScale; }
  uint8_t constant() const { return constant_; }

  AnsShare share(uint32_t symbol) const { return {starts_[symbol], frequencies_[symbol]}; }
  std::span<const uint16_t, kAnsSymbols> frequencies() const { return frequencies_; }
  /// What a reader finds at each slot; empty where isConstant() or isEmpty().
  std::vector<uint32_t> slots() const;

 private:
  void cumulate();

  std::array<uint16_t, kAnsSymbols> frequencies_{}, starts_{};
  uint8_t constant_ = 0;
  bool isEmpty_ = true;
};

}  // namespace warpscope
