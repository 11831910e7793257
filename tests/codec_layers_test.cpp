// Several samples a pixel as bytes and back: in layers, random ones.
#include "render/codec/packed_band.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <random>

#include "tests/codec_frames.h"

namespace warpscope {
namespace {

TEST(Codec, SeveralSamplesAPixelComeBack) {
  std::vector<uint32_t> pixels;
  for (uint32_t pixel = 0; pixel < 64 * 64; ++pixel)
    for (uint32_t k = 0; k < pixel % 5; ++k) pixels.push_back(pixel);
  expectRoundTrips(withLayers(framedPixels(64, 64, pixels), pixels), "up to four");
}

TEST(Codec, LayersComeBackWithEveryRadiusPolicy) {
  constexpr Heuristic kOnSteps[] = {Heuristic::entrance, Heuristic::gradient, Heuristic::exit};
  constexpr Heuristic kBetween[] = {Heuristic::median, Heuristic::expected};
  for (const auto& policy : kRadiusPolicies) {
    MarchSettings settings;
    settings.sample.radiusPolicy = policy.value;
    const SampleFrame onSteps = marchedLayers(shells(), kOnSteps, settings),
                      between = marchedLayers(shells(), kBetween, settings);
    ASSERT_GT(onSteps.size(), 3000u);
    expectRoundTrips(onSteps, std::string(policy.name));
    expectRoundTrips(withExtents(between), std::string(policy.name));
  }
}

TEST(Codec, ASampleOfAnyLayerTakesAboutAsManyBytesAsOneOfTheFirst) {
  constexpr Heuristic kOne[] = {Heuristic::gradient};
  constexpr Heuristic kTwo[] = {Heuristic::entrance, Heuristic::gradient};
  constexpr Heuristic kFour[] = {Heuristic::entrance, Heuristic::gradient, Heuristic::peak, Heuristic::exit};
  for (const CodecSettings& settings : {kLossless, kJpeg}) {
    const double one = bytesPerSample(marchedLayers(shells(), kOne, {}, 400, 400), settings);
    EXPECT_LT(bytesPerSample(marchedLayers(shells(), kTwo, {}, 400, 400), settings), 1.3 * one);
    EXPECT_LT(bytesPerSample(marchedLayers(shells(), kFour, {}, 400, 400), settings), 1.3 * one);
  }
}

TEST(Codec, LayersTakeNoBytesOfTheirOwn) {
  // Nothing but the length of the plane, which is 0: how many samples each pixel has is said anyway.
  std::vector<uint32_t> pixels;
  for (uint32_t pixel = 0; pixel < 64 * 64; ++pixel)
    for (uint32_t k = 0; k < pixel % 5; ++k) pixels.push_back(pixel);
  const SampleFrame layered = withLayers(framedPixels(64, 64, pixels), pixels);
  const ByteVector payload = FrameCodec().encode(layered, kLossless);
  EXPECT_EQ(ByteReader(std::span(payload).subspan(9)).take<uint32_t>(), 0u);
  EXPECT_EQ(roundTrip(layered, kLossless), "");
}

TEST(Codec, ABandOfMoreThanAMillionSamplesComesBack) {
  constexpr uint32_t kWidth = 512, kHeight = 256, kLayersOfIt = kMaxLayers;
  std::vector<uint32_t> pixels;
  for (uint32_t pixel = 0; pixel < kWidth * kHeight; ++pixel) pixels.insert(pixels.end(), kLayersOfIt, pixel);
  ASSERT_GT(pixels.size(), 1'000'000u);
  const SampleFrame frame = withLayers(framedPixels(kWidth, kHeight, pixels), pixels);
  EXPECT_EQ(roundTrip(frame, kJpeg), "");
}

TEST(Codec, AsManyLayersAsThereCanBeComeBack) {
  std::vector<uint32_t> pixels(kMaxLayers, 3);
  pixels.insert(pixels.end(), {4, 4, 9});
  expectRoundTrips(withLayers(framedPixels(8, 8, pixels), pixels), "as many");
}

RC_GTEST_PROP(Codec, RandomLayersComeBack, ()) {
  const auto width = *rc::gen::inRange<uint32_t>(1, 200), height = *rc::gen::inRange<uint32_t>(1, 200);
  const auto seed = *rc::gen::arbitrary<uint32_t>();
  const auto most = *rc::gen::inRange<uint32_t>(1, 9);
  std::mt19937 random(seed);
  std::vector<uint32_t> pixels;
  std::vector<uint8_t> layers;
  for (uint32_t pixel = 0; pixel < width * height && pixels.size() < 5000; ++pixel) {
    for (uint32_t k = 0, count = random() % (most + 1); k < count; ++k) {
      pixels.push_back(pixel);
      layers.push_back(static_cast<uint8_t>(k));
    }
  }
  SampleFrame frame = framedPixels(width, height, pixels, seed);
  frame.planes.push_back(layerPlane(layers));
  frame.settings.sample.samplesPerRay = 8;
  for (const CodecSettings& settings : kEveryCoding) RC_ASSERT(roundTrip(frame, settings) == "");
}

}  // namespace
}  // namespace warpscope
