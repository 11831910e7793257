// How long payloads may be: no frame makes more bytes than mostPayloadBytes() says, and frames that cannot be
// compressed make more than half of them, so that a client which goes by it takes every honest payload and few others.
// Mirrors mostPayloadBytes() of render/codec/codec.h.
#include <gtest/gtest.h>

#include <random>

#include "tests/codec_frames.h"

namespace warpscope {
namespace {

/// Every pixel has as many samples of noise, with layers if that is more than one, and a plane of noise.
SampleFrame noiseFrame(uint32_t width, uint32_t height, uint32_t perRay, uint32_t seed) {
  std::mt19937_64 random(seed);
  SampleFrame frame = emptyPicture(width, height);
  frame.settings.sample.samplesPerRay = static_cast<int>(perRay);
  std::vector<uint8_t> layers;
  for (uint32_t row = 0; row < height; ++row)
    for (uint32_t column = 0; column < width; ++column)
      for (uint32_t k = 0; k < perRay; ++k) {
        frame.samples.push_back((random() & ~PackedSample{kPixelKeyMask}) | pixelKey(column, row));
        frame.colors.push_back(static_cast<Rgba8>(random()));
        layers.push_back(static_cast<uint8_t>(k));
      }
  if (perRay > 1) frame.planes.push_back(layerPlane(layers));
  SamplePlane extents{std::string(kExtentPlane), PlaneElement::float32, TransferVector<std::byte>(4 * frame.size())};
  for (std::byte& byte : extents.values) byte = static_cast<std::byte>(random());
  frame.planes.push_back(std::move(extents));
  return frame;
}

constexpr CodecSettings kBestJpeg{PayloadFormat::packed, ColorCoding::jpeg, 100};

/// The share of the bound that the frame's payload takes.
double shareOf(const SampleFrame& frame, const CodecSettings& settings) {
  return static_cast<double>(FrameCodec().encode(frame, settings).size()) /
         static_cast<double>(mostPayloadBytes(headOf(frame), frame.size(), settings));
}

TEST(CodecBounds, NoiseTakesMuchOfThemAndNoMoreThanAll) {
  for (const auto& [width, height] : {std::pair(64u, 64u), std::pair(500u, 300u), std::pair(1024u, 16u)})
    for (const uint32_t perRay : {1u, 4u, 8u})
      for (const CodecSettings& settings : {kRaw, kLossless, kJpeg, kBestJpeg, kTiled}) {
        const double share = shareOf(noiseFrame(width, height, perRay, 7), settings);
        EXPECT_LE(share, 1.0) << width << "x" << height << ", " << perRay << ", " << nameOf(settings.color);
        const double least = settings.format == PayloadFormat::raw ? 1.0 : settings == kLossless ? 0.5 : 0.4;
        EXPECT_GE(share, least)
            << width << "x" << height << ", " << perRay << ", " << nameOf(settings.color);
      }
}

TEST(CodecBounds, NoFrameExceedsThem) {
  std::mt19937 random(11);
  for (int round = 0; round < 300; ++round) {
    const uint32_t width = 1 + random() % (round % 3 == 0 ? 700 : 40), height = 1 + random() % 60;
    SampleFrame frame = round % 2 == 0 ? garbageFrame(width, height, random() % (size_t{width} * height + 1), random())
                                       : noiseFrame(width, height, 1 + random() % 8, random());
    if (round % 5 == 0) frame.planes.clear();
    if (round % 5 == 0 && round % 2 != 0) continue;  // without layers there is one sample in a pixel
    for (const CodecSettings& settings : {kRaw, kLossless, kJpeg, kBestJpeg, kTiled})
      ASSERT_LE(shareOf(frame, settings), 1.0)
          << "round " << round << ", " << width << "x" << height << ", " << frame.size();
  }
}

TEST(CodecBounds, LoneSamplesInTheCornersStayWithinThem) {
  // A picture of the whole area for each of them.
  for (const uint32_t perRay : {1u, 8u}) {
    SampleFrame frame = noiseFrame(2, 1, perRay, 5);
    frame.camera.width = 1001;
    frame.camera.height = 777;
    for (size_t i = perRay; i < 2 * perRay; ++i)
      frame.samples[i] = (frame.samples[i] & ~PackedSample{kPixelKeyMask}) | pixelKey(1000, 776);
    for (const CodecSettings& settings : {kRaw, kLossless, kBestJpeg, kTiled})
      EXPECT_LE(shareOf(frame, settings), 1.0) << perRay;
  }
}

TEST(CodecBounds, PlanesThatAreNotKnownHaveRoom) {
  SampleFrame frame = emptyPicture(64, 64);
  for (const CodecSettings& settings : {kRaw, kLossless, kTiled}) {
    const uint64_t without = mostPayloadBytes(frame, 1000, settings);
    SampleFrame with = frame;
    with.planes = {{"new", PlaneElement{77}, {}}};
    EXPECT_GE(mostPayloadBytes(with, 1000, settings), without + 1000 * kMostElementBytes);
    EXPECT_LE(mostPayloadBytes(with, 1000, settings), without + 1000 * kMostElementBytes + 100);
  }
}

TEST(CodecBounds, TheyAreSmallForSmallPictures) {
  // What a client reads at most of whoever answers a request for 64 x 64 pixels.
  const SampleFrame frame = emptyPicture(64, 64);
  EXPECT_LT(mostPayloadBytes(frame, 64 * 64, kLossless), 80'000u);
  EXPECT_LT(mostPayloadBytes(frame, 64 * 64, kJpeg), 100'000u);
  EXPECT_LT(mostPayloadBytes(frame, 0, kJpeg), 100u);
}

}  // namespace
}  // namespace warpscope
