// See payload_hash.h.
#include "render/codec/payload_hash.h"

#include "render/codec/bytes.h"
#include "render/codec/codec.h"
#include "render/codec/summed_hash.h"
#include "render/core/placed_hash.h"

namespace warpscope {
namespace {

/// Of words, the last one filled up with zeros, and of the number of bytes.
uint64_t summedHashOf(std::span<const std::byte> bytes, uint64_t seed, std::span<const SummedWords> summed) {
  const size_t words = bytes.size() / kHashedWordBytes;
  uint64_t sum = 0;
  const auto add = [&](size_t begin, size_t end) {
    const std::byte* const first = bytes.data() + kHashedWordBytes * begin;
    sum += summedHash(end - begin, begin, [first](size_t i) { return loadLittle<uint64_t>(first + kHashedWordBytes * i); });
  };
  size_t at = 0;
  for (const SummedWords& part : summed) {
    if (part.count() == 0) continue;
    add(at, part.begin);
    sum += part.sum;
    at = part.end;
  }
  add(at, words);
  uint64_t last = 0;
  for (size_t i = kHashedWordBytes * words; i < bytes.size(); ++i) last = last << 8 | std::to_integer<uint64_t>(bytes[i]);
  return sum + placedHash(last, words) + placedHash(seed ^ bytes.size() << 8, words + 1);
}

}  // namespace

uint64_t payloadHash(std::span<const std::byte> payload, std::span<const SummedWords> summed) {
  const auto format = std::to_integer<uint64_t>(payload[0]);
  const std::span<const std::byte> hashed = payload.subspan(kPayloadHeadBytes);
  return format == static_cast<uint64_t>(PayloadFormat::tiled) ? summedHashOf(hashed, format, summed) : hashBytes(hashed, format);
}

void sealPayload(std::span<std::byte> payload, std::span<const SummedWords> summed) {
  if (payload.size() >= kPayloadHeadBytes) storeLittle(payload.data() + 1, payloadHash(payload, summed));
}

}  // namespace warpscope
