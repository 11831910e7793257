// Frequencies as bytes and tables.
// See ans_model.h.
#include "render/codec/tiled/ans_model.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace warpscope {
namespace {

constexpr uint16_t kTwoBytes = 128;

}  // namespace

AnsModel AnsModel::ofCounts(std::span<const uint32_t, kAnsSymbols> counts) {
  AnsModel model;
  const uint64_t total = std::accumulate(counts.begin(), counts.end(), uint64_t{0});
  if (total == 0) return model;
  for (uint32_t s = 0; s < kAnsSymbols; ++s) model.frequencies_[s] = ansRounded(counts[s], total);
  ansEven(model.frequencies_.data());
  model.cumulate();
  return model;
}

AnsModel AnsModel::ofFrequencies(std::span<const uint16_t, kAnsSymbols> frequencies) {
  AnsModel model;
  std::ranges::copy(frequencies, model.frequencies_.begin());
  model.cumulate();
  return model;
}

void AnsModel::cumulate() {
  uint32_t start = 0;
  isEmpty_ = true;
  for (uint32_t s = 0; s < kAnsSymbols; ++s) {
    starts_[s] = static_cast<uint16_t>(start);
    start += frequencies_[s];
    if (frequencies_[s] == 0) continue;
    isEmpty_ = false;
    constant_ = static_cast<uint8_t>(s);
  }
}

void AnsModel::append(ByteVector& out) const {
  std::array<std::byte, 1 + 2 * kAnsSymbols> bytes;
  size_t count = 0;
  bytes[count++] = std::byte{constant_};  // the highest one
  for (uint32_t s = 0; s <= constant_; ++s) {
    const uint16_t frequency = frequencies_[s];
    if (frequency >= kTwoBytes) bytes[count++] = static_cast<std::byte>(kTwoBytes | frequency >> 8);
    bytes[count++] = static_cast<std::byte>(frequency);
  }
  out.insert(out.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(count));
}

bool AnsModel::take(ByteReader& reader) {
  frequencies_.fill(0);
  const auto highest = reader.take<uint8_t>();
  uint32_t sum = 0;
  for (uint32_t s = 0; s <= highest; ++s) {
    uint32_t frequency = reader.take<uint8_t>();
    if (frequency >= kTwoBytes) frequency = (frequency - kTwoBytes) << 8 | reader.take<uint8_t>();
    if (frequency > kAnsScale) return false;
    frequencies_[s] = static_cast<uint16_t>(frequency);
    sum += frequency;
  }
  cumulate();
  return !reader.ranOut() && (sum == kAnsScale || (sum == 0 && highest == 0));
}

std::vector<uint32_t> AnsModel::slots() const {
  std::vector<uint32_t> slots;
  if (isEmpty_ || isConstant()) return slots;
  slots.reserve(kAnsScale);
  for (uint32_t s = 0; s < kAnsSymbols; ++s)
    for (uint32_t behind = 0; behind < frequencies_[s]; ++behind) slots.push_back(ansSlot(s, frequencies_[s], behind));
  return slots;
}

}  // namespace warpscope
