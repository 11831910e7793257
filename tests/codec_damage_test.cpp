// Whatever a payload holds, decoding answers with a sentence: payloads cut short, changed, invented, and such that ask
// for very much memory.
#include "render/codec/codec.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory_resource>
#include <random>

#include "render/base/error.h"
#include "render/codec/pixel_path.h"
#include "render/codec/zstd_section.h"
#include "tests/codec_frames.h"

namespace warpscope {
namespace {

/// Frames whose payloads are few bytes.
class CodecDamage : public testing::TestWithParam<bool> {
 protected:
  const SampleFrame frame_ = GetParam() ? smallLayeredFrame() : marched(shells(), {}, 24, 20);
};
INSTANTIATE_TEST_SUITE_P(, CodecDamage, testing::Bool(),
                         [](const auto& layered) { return std::string(layered.param ? "Layers" : "OneSampleARay"); });

TEST_P(CodecDamage, PayloadsCutShortAreRefused) {
  const SampleFrame& frame = frame_;
  ASSERT_GT(frame.size(), 100u);
  for (const CodecSettings& settings : kEveryCoding) {
    const ByteVector payload = FrameCodec().encode(frame, settings);
    for (size_t length = 0; length < payload.size(); ++length) {
      const std::span<const std::byte> part(payload.data(), length);
      SampleFrame decoded = headOf(frame);
      ASSERT_NE(FrameCodec().decode(part, frame.size(), decoded), std::nullopt) << length;
      // And with a hash that says all is well.
      ASSERT_NE(FrameCodec().decode(sealed({part.begin(), part.end()}), frame.size(), decoded), std::nullopt) << length;
    }
  }
}

TEST_P(CodecDamage, ChangedBytesAreFoundOut) {
  const SampleFrame& frame = frame_;
  ASSERT_GT(frame.size(), 100u);
  for (const CodecSettings& settings : kEveryCoding) {
    ByteVector payload = FrameCodec().encode(frame, settings);
    for (size_t i = 0; i < payload.size(); ++i)
      for (const int flip : {1, 0x10, 0x80, 0xff}) {
        payload[i] ^= static_cast<std::byte>(flip);
        SampleFrame decoded = headOf(frame);
        ASSERT_NE(FrameCodec().decode(payload, frame.size(), decoded), std::nullopt) << i;
        ASSERT_TRUE(survives(sealed(payload), frame)) << i;
        payload[i] ^= static_cast<std::byte>(flip);
      }
  }
}

TEST(Codec, GarbageIsRefused) {
  std::mt19937 random(11);
  const SampleFrame frame = garbageFrame(64, 64, 500, 1);
  for (int round = 0; round < 3000; ++round) {
    ByteVector payload(random() % 400);
    for (std::byte& byte : payload) byte = static_cast<std::byte>(random() % (round % 2 ? 256 : 4));
    if (!payload.empty()) payload[0] = static_cast<std::byte>(random() % 3);
    ASSERT_TRUE(survives(payload, frame));
    ASSERT_TRUE(survives(sealed(payload), frame));
  }
}

/// What a peer could make up to keep a decoder busy: each layer is as much work as the first.
TEST(Codec, MoreSamplesInAPixelThanARayMayHaveAreRefused) {
  for (const CodecSettings& settings : kEveryCoding) {
    std::vector<uint32_t> pixels(3, 20);
    SampleFrame frame = withLayers(framedPixels(8, 8, pixels), pixels);
    frame.settings.sample.samplesPerRay = 3;
    const ByteVector payload = FrameCodec().encode(frame, settings);
    SampleFrame decoded = headOf(frame);
    EXPECT_EQ(FrameCodec().decode(payload, frame.size(), decoded), std::nullopt);
    for (const int fewer : {2, 1, 0, -1}) {
      decoded = headOf(frame);
      decoded.settings.sample.samplesPerRay = fewer;
      EXPECT_NE(FrameCodec().decode(payload, frame.size(), decoded), std::nullopt) << fewer;
      frame.settings.sample.samplesPerRay = fewer;
      EXPECT_THROW(FrameCodec().encode(frame, settings), InputError) << fewer;
    }
  }
  // A band whose front layer covers one pixel that has 255 further samples; its layers would follow.
  for (const bool hasLayers : {false, true}) {
    const std::vector<uint32_t> pixels(256, 20);
    SampleFrame frame = framedPixels(8, 8, pixels);
    frame.settings.sample.samplesPerRay = 8;
    if (hasLayers) frame.planes.push_back(layerPlane({}));
    ByteVector band;
    appendLittle(band, static_cast<uint32_t>(pixels.size()));
    appendLittle(band, uint64_t{0});
    std::vector<uint8_t> mask(8, 0);
    mask[2] = mask[3] = 1u << 4;  // each row changed by the row above
    appendSection(band, mask);
    appendLittle(band, uint8_t{1});
    appendSection(band, std::vector<uint8_t>{255});
    ByteVector payload;
    appendLittle(payload, static_cast<uint8_t>(PayloadFormat::packed));
    appendLittle(payload, uint64_t{0});
    if (hasLayers) appendLittle(payload, uint32_t{0});
    appendLittle(payload, static_cast<uint8_t>(Placement::steps));
    appendLittle(payload, static_cast<uint8_t>(ColorCoding::lossless));
    appendLittle(payload, static_cast<uint32_t>(band.size()));
    appendLittle(payload, static_cast<uint32_t>(pixels.size()));
    payload.insert(payload.end(), band.begin(), band.end());
    SampleFrame decoded = headOf(frame);
    const DecodeError error = FrameCodec().decode(sealed(payload), pixels.size(), decoded);
    ASSERT_TRUE(error.has_value());
    EXPECT_NE(error->find("more samples in a pixel"), std::string::npos) << *error;
  }
}

TEST(Codec, SizesBeyondTheLimitsAreRefused) {
  const SampleFrame frame = marched(shells(), {}, 24, 20);
  ASSERT_GT(frame.size(), 100u);
  const ByteVector payload = FrameCodec().encode(frame, kLossless);
  SampleFrame decoded = headOf(frame);
  EXPECT_EQ(FrameCodec().decode(payload, frame.size(), decoded, {frame.size(), payload.size()}), std::nullopt);
  EXPECT_NE(FrameCodec().decode(payload, frame.size(), decoded, {frame.size() - 1, payload.size()}), std::nullopt);
  EXPECT_NE(FrameCodec().decode(payload, frame.size(), decoded, {frame.size(), payload.size() - 1}), std::nullopt);
}

/// Counts the bytes that vectors ask it for.
class CountingMemory final : public std::pmr::memory_resource {
 public:
  size_t largest = 0;

 private:
  void* do_allocate(size_t bytes, size_t alignment) override {
    largest = std::max(largest, bytes);
    return std::pmr::new_delete_resource()->allocate(bytes, alignment);
  }
  void do_deallocate(void* place, size_t bytes, size_t alignment) override {
    std::pmr::new_delete_resource()->deallocate(place, bytes, alignment);
  }
  bool do_is_equal(const memory_resource& other) const noexcept override { return this == &other; }
};

TEST(Codec, BombsAreRefusedBeforeMemoryIsTaken) {
  CountingMemory memory;
  SampleFrame frame = garbageFrame(8192, 8192, 0, 0);
  frame.samples = TransferVector<PackedSample>(TransferAllocator<PackedSample>(&memory));
  frame.colors = TransferVector<Rgba8>(TransferAllocator<Rgba8>(&memory));
  const size_t claimed = size_t{1} << 25;
  for (const auto& format : kPayloadFormats)
    for (const uint8_t placement : {0, 1, 2}) {
      // Few bytes that say there are very many samples, each band as many as it may have.
      ByteVector payload;
      appendLittle(payload, static_cast<uint8_t>(format.value));
      appendLittle(payload, uint64_t{0});
      appendLittle(payload, placement);
      appendLittle(payload, uint8_t{0});
      for (int band = 0; band < 512; ++band) {
        appendLittle(payload, uint32_t{0});
        appendLittle(payload, static_cast<uint32_t>(claimed / 512));
      }
      EXPECT_NE(FrameCodec().decode(sealed(payload), claimed, frame), std::nullopt) << format.name << " " << int{placement};
      EXPECT_EQ(memory.largest, 0u) << format.name << " " << int{placement};
    }
}

TEST(Codec, LengthsOfPlanesBeyondThePayloadAreRefusedBeforeMemoryIsTaken) {
  CountingMemory memory;
  for (const auto& format : kPayloadFormats)
    for (const uint32_t length : {0u, 1u, 1000u, 0x7fffffffu, 0xffffffffu}) {
      SampleFrame frame = garbageFrame(8192, 8192, 0, 0);
      frame.samples = TransferVector<PackedSample>(TransferAllocator<PackedSample>(&memory));
      frame.colors = TransferVector<Rgba8>(TransferAllocator<Rgba8>(&memory));
      for (const KnownPlane& known : kKnownPlanes)
        frame.planes.push_back(
            {std::string(known.name), known.element, TransferVector<std::byte>(TransferAllocator<std::byte>(&memory))});
      ByteVector payload;
      appendLittle(payload, static_cast<uint8_t>(format.value));
      appendLittle(payload, uint64_t{0});
      appendLittle(payload, length);
      payload.resize(payload.size() + 500, std::byte{0});
      EXPECT_NE(FrameCodec().decode(sealed(payload), size_t{1} << 25, frame), std::nullopt) << format.name << " " << length;
      EXPECT_EQ(memory.largest, 0u) << format.name << " " << length;
    }
}

}  // namespace
}  // namespace warpscope
