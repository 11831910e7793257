// Several samples a pixel as bytes and back: in layers, in any order of rays, random ones.
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
  EXPECT_TRUE(isPlaced(framedPixels(64, 64, pixels)));
  expectRoundTrips(framedPixels(64, 64, pixels), "up to four");
  expectRoundTrips(framedPixels(64, 64, std::vector<uint32_t>(1000, 77)), "a thousand in one");
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
    EXPECT_TRUE(isPlaced(onSteps));
    EXPECT_TRUE(isPlaced(between));
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
  const SampleFrame frame = framedPixels(64, 64, pixels), layered = withLayers(frame, pixels);
  EXPECT_EQ(FrameCodec().encode(layered, kLossless).size(), FrameCodec().encode(frame, kLossless).size() + 4);
  EXPECT_EQ(roundTrip(layered, kLossless), "");
}

TEST(Codec, ABandOfMoreThanAMillionSamplesIsPlaced) {
  constexpr uint32_t kWidth = 512, kHeight = 256, kLayersOfIt = kMaxLayers;
  std::vector<uint32_t> pixels;
  for (uint32_t pixel = 0; pixel < kWidth * kHeight; ++pixel) pixels.insert(pixels.end(), kLayersOfIt, pixel);
  ASSERT_GT(pixels.size(), 1'000'000u);
  const SampleFrame frame = withLayers(framedPixels(kWidth, kHeight, pixels), pixels);
  EXPECT_TRUE(isPlaced(frame));
  EXPECT_EQ(roundTrip(frame, kJpeg), "");
}

TEST(Codec, AsManyLayersAsThereCanBeComeBack) {
  std::vector<uint32_t> pixels(kMaxLayers, 3);
  pixels.insert(pixels.end(), {4, 4, 9});
  EXPECT_TRUE(isPlaced(framedPixels(8, 8, pixels)));
  expectRoundTrips(withLayers(framedPixels(8, 8, pixels), pixels), "as many");
}

TEST(Codec, RaysOutOfOrderComeBack) {
  std::mt19937 random(5);
  std::vector<uint32_t> rays(64 * 64);
  for (uint32_t i = 0; i < rays.size(); ++i) rays[i] = i;
  const auto pixelsOf = [](const std::vector<uint32_t>& order) {
    std::vector<uint32_t> pixels;
    for (const uint32_t ray : order) pixels.insert(pixels.end(), 1 + ray % 4, ray);
    return pixels;
  };
  std::vector<uint32_t> some = rays;
  for (size_t i = 0; i < some.size(); i += 400) std::swap(some[i], some[random() % some.size()]);
  std::vector<uint32_t> all = rays;
  std::shuffle(all.begin(), all.end(), random);
  for (const auto& order : {some, all}) {
    const std::vector<uint32_t> pixels = pixelsOf(order);
    expectRoundTrips(withExtents(withLayers(framedPixels(64, 64, pixels), pixels)), "shuffled");
  }
  EXPECT_TRUE(isPlaced(withLayers(framedPixels(64, 64, pixelsOf(some)), pixelsOf(some))));
  // Two rays in one pixel stay two.
  const std::vector<uint32_t> pixels(7, 20);
  SampleFrame two = framedPixels(8, 8, pixels);
  two.planes.push_back(layerPlane({0, 1, 2, 0, 1, 0, 0}));
  two.settings.sample.samplesPerRay = 3;
  expectRoundTrips(two, "two rays in one pixel");
  // Some that no pixel sees, among others.
  const std::vector<uint32_t> ordered = pixelsOf(rays);
  SampleFrame off = withLayers(framedPixels(64, 64, ordered), ordered);
  for (size_t i = 0; i < off.size(); i += 97) off.samples[i] = i % 2 ? 0 : ~PackedSample{0};
  EXPECT_TRUE(isPlaced(off));
  expectRoundTrips(off, "strays");
}

RC_GTEST_PROP(Codec, RandomLayersComeBack, ()) {
  const auto width = *rc::gen::inRange<uint32_t>(1, 200), height = *rc::gen::inRange<uint32_t>(1, 200);
  const auto seed = *rc::gen::arbitrary<uint32_t>();
  const auto most = *rc::gen::inRange<uint32_t>(1, 9);
  const auto oneIn = *rc::gen::inRange<uint32_t>(1, 400);  // rays that leave the order
  std::mt19937 random(seed);
  std::vector<uint32_t> pixels;
  std::vector<uint8_t> layers;
  for (uint32_t pixel = 0; pixel < width * height && pixels.size() < 5000; ++pixel) {
    const uint32_t where = random() % oneIn == 0 ? static_cast<uint32_t>(random()) % (width * height) : pixel;
    for (uint32_t k = 0, count = random() % (most + 1); k < count; ++k) {
      pixels.push_back(where);
      layers.push_back(static_cast<uint8_t>(k));
    }
  }
  SampleFrame frame = framedPixels(width, height, pixels, seed);
  frame.planes.push_back(layerPlane(layers));
  frame.settings.sample.samplesPerRay = 8;
  for (const CodecSettings& settings : {kRaw, kLossless, kJpeg}) RC_ASSERT(roundTrip(frame, settings) == "");
}

}  // namespace
}  // namespace warpscope
