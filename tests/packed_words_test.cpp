// What ranks on different machines send each other: it comes back as it was, is shorter, and what is damaged is refused.
// Mirrors render/bricks/packed_words.h.
#include "render/bricks/packed_words.h"

#include <gtest/gtest.h>

#include <random>

#include "marcher_cases.h"
#include "spread_cases.h"
#include "spread_volume.h"
#include "test_volumes.h"

namespace warpscope {
namespace {

struct WordsOfRay {  // without gaps, whose bytes are anything
  double light = 0.25;
  float depths[5] = {1.0f, 2.0f, 3.0f, 4.0f, 5.0f};
  uint32_t kind = 7;
};

/// Rays that differ from a usual one here and there, between other things, by any writer.
template <class Writer>
std::vector<std::byte> written(uint32_t seed, uint32_t count) {
  std::mt19937 dice(seed);
  Writer writer;
  const WordsOfRay usual{};
  std::vector<uint16_t> list(dice() % 9, static_cast<uint16_t>(seed));
  writer.putAll(list);
  for (uint32_t i = 0; i < count; ++i) {
    WordsOfRay ray = usual;
    if (dice() % 2 == 0) ray.light = 0.5 + 1e-3 * static_cast<double>(dice() % 1000);
    for (float& depth : ray.depths)
      if (dice() % 3 == 0) depth = 100.0f + 0.01f * static_cast<float>(dice() % 1000);
    writer.put(i).putBeside(ray, usual, 3);
    if (dice() % 5 == 0) writer.putBeside(static_cast<float>(i), 0.0f, 20);
  }
  return writer.take();
}

/// Throws if they are not as written<>() has them.
template <class Reader>
void readBack(Reader& reader, uint32_t seed, uint32_t count) {
  std::mt19937 dice(seed);
  const WordsOfRay usual{};
  std::vector<uint16_t> expected(dice() % 9, static_cast<uint16_t>(seed)), list;
  reader.getAll(list);
  ASSERT_EQ(list, expected);
  for (uint32_t i = 0; i < count; ++i) {
    WordsOfRay ray = usual;
    if (dice() % 2 == 0) ray.light = 0.5 + 1e-3 * static_cast<double>(dice() % 1000);
    for (float& depth : ray.depths)
      if (dice() % 3 == 0) depth = 100.0f + 0.01f * static_cast<float>(dice() % 1000);
    ASSERT_EQ(reader.template get<uint32_t>(), i);
    const WordsOfRay read = reader.getBeside(usual, 3);
    ASSERT_EQ(read.light, ray.light);
    for (int k = 0; k < 5; ++k) ASSERT_EQ(read.depths[k], ray.depths[k]);
    ASSERT_EQ(read.kind, ray.kind);
    if (dice() % 5 == 0) {
      ASSERT_EQ(reader.getBeside(0.0f, 20), static_cast<float>(i));
    }
  }
  EXPECT_TRUE(reader.isAtEnd());
}

TEST(PackedWords, ComeBackAndAreShorter) {
  for (uint32_t seed = 0; seed < 20; ++seed)
    for (const uint32_t count : {0u, 1u, 2u, 1000u}) {
      const std::vector<std::byte> packed = written<PackedWriter>(seed, count), plain = written<RankWriter>(seed, count);
      PackedReader reader(packed);
      readBack(reader, seed, count);
      RankReader other(plain);
      readBack(other, seed, count);
      if (count == 1000) {
        EXPECT_LT(5 * packed.size(), 4 * plain.size());
      }
    }
}

TEST(PackedWords, WhatIsDamagedIsRefusedOrReadAndNothingElse) {
  const std::vector<std::byte> whole = written<PackedWriter>(5, 200);
  const auto tryToRead = [](const std::vector<std::byte>& bytes) {
    try {
      PackedReader reader(bytes);
      const WordsOfRay usual{};
      std::vector<uint16_t> list;
      reader.getAll(list);
      while (!reader.isAtEnd()) {
        reader.get<uint32_t>();
        reader.getBeside(usual, 3);
      }
    } catch (const std::runtime_error&) {
    }
  };
  for (size_t kept = 0; kept < whole.size(); ++kept) {
    const std::vector<std::byte> cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(kept));
    EXPECT_THROW(PackedReader{cut}, std::runtime_error) << kept;
  }
  std::mt19937 dice(1);
  for (int i = 0; i < 20000; ++i) {
    std::vector<std::byte> other = whole;
    for (uint32_t changes = 1 + dice() % 4; changes > 0; --changes) other[dice() % other.size()] = static_cast<std::byte>(dice());
    tryToRead(other);
  }
  EXPECT_THROW(PackedReader({}), std::runtime_error);
}

TEST(PackedWords, FramesOfRanksThatAreFarApartAreThoseOfOneProcess) {
  const VolumePtr whole = makeTestVolume(VoxelType::uint8, kDims, blobs(kDims, 11));
  const TransferFunction function = band(15, 80, 0.05f);
  const MarcherPtr alone = makeCpuMarcher(whole, function);
  const auto open = [whole](RanksPtr own) { return sharedBy(whole, std::move(own)); };
  const Spread far(open, function, 4, Spread::onHost, kRankPatience, false);
  for (const auto& [name, settings] : variants())
    for (const Camera& camera : cameras()) {
      ASSERT_TRUE(sameFrame(far->march(camera, settings), alone->march(camera, settings))) << name;
      ASSERT_TRUE(sameBits(rendered(*far, camera, settings), rendered(*alone, camera, settings))) << name;
    }
  // Of the first frame: later ones are cut by what marching has taken.
  const auto sentBy = [&](bool areNear, const MarchSettings& settings) {
    const Spread spread(open, function, 4, Spread::onHost, kRankPatience, areNear);
    static_cast<void>(spread->march(lookingFrom({70.0f, 30.0f, 45.0f}, {}, 400, 300), settings));
    uint64_t bytes = 0;
    for (const RankWork& work : spread.lastWork()) bytes += work.sentBytes;
    return static_cast<double>(bytes);
  };
  MarchSettings settings;
  EXPECT_LT(sentBy(false, settings), sentBy(true, settings) / 1.5);
  settings.sample.segments = 4;
  EXPECT_LT(sentBy(false, settings), sentBy(true, settings) / 1.3);
}

}  // namespace
}  // namespace warpscope
