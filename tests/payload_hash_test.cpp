// Hashes of payloads of whose words some are added up already.
// Mirrors render/codec/payload_hash.h.
#include "render/codec/payload_hash.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "render/codec/bytes.h"
#include "render/codec/codec.h"
#include "render/core/placed_hash.h"

namespace warpscope {
namespace {

std::vector<std::byte> payloadOf(size_t bytes, std::mt19937& random) {
  std::vector<std::byte> payload(bytes);
  for (std::byte& each : payload) each = static_cast<std::byte>(random());
  payload[0] = static_cast<std::byte>(PayloadFormat::tiled);
  return payload;
}

SummedWords summedWithin(const std::vector<std::byte>& payload, size_t at, size_t bytes) {
  SummedWords words = SummedWords::within(at, bytes);
  for (size_t i = 0; i < words.count(); ++i) words.sum += placedHash(loadLittle<uint64_t>(payload.data() + words.firstByte() + kHashedWordBytes * i), words.begin + i);
  return words;
}

TEST(PayloadHash, IsTheSameWhoeverAddsItsWordsUp) {
  std::mt19937 random(7);
  for (int round = 0; round < 2000; ++round) {
    const std::vector<std::byte> payload = payloadOf(kPayloadHeadBytes + random() % 300, random);
    std::vector<SummedWords> summed;
    for (size_t at = random() % 20; at < payload.size();) {
      const size_t bytes = std::min<size_t>(random() % 90, payload.size() - at);
      summed.push_back(summedWithin(payload, at, bytes));
      at += bytes + random() % 30;
    }
    EXPECT_EQ(payloadHash(payload, summed), payloadHash(payload)) << round;
  }
}

TEST(PayloadHash, CountsWordsThatLieWithinBytes) {
  const auto expectWords = [](size_t at, size_t bytes, size_t begin, size_t end) {
    const SummedWords words = SummedWords::within(at, bytes);
    EXPECT_EQ(words.begin, begin) << at << ' ' << bytes;
    EXPECT_EQ(words.end, end) << at << ' ' << bytes;
  };
  expectWords(9, 16, 0, 2);
  expectWords(9, 15, 0, 1);
  expectWords(10, 15, 1, 2);
  expectWords(16, 18, 1, 3);
  expectWords(17, 7, 0, 0);
  expectWords(10, 14, 0, 0);
  expectWords(3, 100, 0, 0);
  EXPECT_EQ(SummedWords::within(16, 18).firstByte(), 17u);
}

TEST(PayloadHash, ChangesWithEveryByteOfWhatIsBehindTheHead) {
  std::mt19937 random(11);
  const std::vector<std::byte> payload = payloadOf(60, random);
  const uint64_t hash = payloadHash(payload);
  for (size_t i = 0; i < payload.size(); ++i) {
    std::vector<std::byte> other = payload;
    other[i] ^= std::byte{32};
    if (i > 0 && i < kPayloadHeadBytes)
      EXPECT_EQ(payloadHash(other), hash) << i;
    else
      EXPECT_NE(payloadHash(other), hash) << i;
  }
}

TEST(PayloadHash, IsSealedIntoTheHead) {
  std::mt19937 random(13);
  std::vector<std::byte> payload = payloadOf(60, random), none(kPayloadHeadBytes - 1, std::byte{5});
  const uint64_t hash = payloadHash(payload);
  sealPayload(payload);
  EXPECT_EQ(loadLittle<uint64_t>(payload.data() + 1), hash);
  sealPayload(none);
  EXPECT_EQ(none, std::vector<std::byte>(kPayloadHeadBytes - 1, std::byte{5}));
}

}  // namespace
}  // namespace warpscope
