// Frames as bytes and back: the same samples bit for bit, whatever the frame. Marched frames with every heuristic and
// radius policy, made-up and random ones. Several samples a ray, planes and damaged payloads: codec_layers_test.cpp,
// codec_planes_test.cpp, codec_damage_test.cpp.
#include "render/codec/codec.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <random>

#include "render/base/error.h"
#include "render/codec/tiled/tiled_coder.h"
#include "render/core/image.h"
#include "render/volume/reader.h"
#include "tests/codec_frames.h"
#include "tests/real_data.h"

namespace warpscope {
namespace {

void expectAllHeuristicsAndPolicies(const VolumePtr& volume) {
  const MarcherPtr marcher = makeCpuMarcher(volume, translucent(*volume));
  for (const auto& heuristic : kHeuristics)
    for (const auto& policy : kRadiusPolicies) {
      MarchSettings settings;
      settings.sample.heuristic = heuristic.value;
      settings.sample.radiusPolicy = policy.value;
      const SampleFrame frame = marcher->march(cornerCamera(*volume, 160, 120), settings);
      ASSERT_GT(frame.size(), 1000u);
      const std::string what = std::string(heuristic.name) + " " + std::string(policy.name);
      expectRoundTrips(frame, what);
      EXPECT_LT(bytesPerSample(frame, kLossless), 6.0) << what;  // escapes would show
    }
}

TEST(Codec, MarchedFramesComeBackWithEveryHeuristicAndRadiusPolicy) { expectAllHeuristicsAndPolicies(shells()); }

TEST(Codec, MarchedFramesOfOtherVolumesComeBack) {
  for (const auto& volume : kProceduralVolumes)
    expectRoundTrips(marched(makeProceduralVolume(volume.name, {40, 32, 24}), {}), std::string(volume.name));
}

TEST(Codec, TheEngineComesBack) {
  const RealData engine("engine_256x256x128_uint8.raw");
  if (!engine.whyMissing().empty()) GTEST_SKIP() << engine.whyMissing();
  expectAllHeuristicsAndPolicies(openVolume(engine.path()));
}

TEST(Codec, TheBrainComesBack) {
  const RealData brain("spm152.nii.gz");
  if (!brain.whyMissing().empty()) GTEST_SKIP() << brain.whyMissing();
  expectAllHeuristicsAndPolicies(openVolume(brain.path()));
}

TEST(Codec, SamplesOnTheLatticeTakeFewBytes) {
  // What is measured at 1024x1024 is below 1; small pictures have more edges.
  for (const Heuristic heuristic : {Heuristic::entrance, Heuristic::exit, Heuristic::peak, Heuristic::gradient}) {
    MarchSettings settings;
    settings.sample.heuristic = heuristic;
    const SampleFrame frame = marched(shells(), settings, 400, 400);
    EXPECT_LT(bytesPerSample(frame, kJpeg), 3.0) << nameOf(heuristic);
    EXPECT_GT(bytesPerSample(frame, kRaw), 12.0);
  }
}

TEST(Codec, EmptyFramesComeBack) {
  for (const auto& [width, height] : {std::pair(1u, 1u), std::pair(0u, 0u), std::pair(640u, 480u)})
    expectRoundTrips(garbageFrame(width, height, 0, 0), std::to_string(width));
}

TEST(Codec, SinglePixelsAndOddSizesComeBack) {
  expectRoundTrips(framedPixels(1, 1, {0}), "one pixel");
  expectRoundTrips(withLayers(framedPixels(1, 1, {0, 0, 0}), {0, 0, 0}), "one pixel, three samples");
  for (const auto& [width, height] :
       {std::pair(7u, 3u), std::pair(1u, 300u), std::pair(300u, 1u), std::pair(9u, 17u)}) {
    std::vector<uint32_t> all(width * height);
    for (uint32_t i = 0; i < all.size(); ++i) all[i] = i;
    const SampleFrame frame = framedPixels(width, height, all);
    expectRoundTrips(frame, std::to_string(width));
  }
}

TEST(Codec, LargeSparsePicturesComeBack) {
  constexpr uint32_t kSide = 8192;
  std::vector<uint32_t> pixels{0};
  std::mt19937 random(7);
  while (pixels.back() < kSide * kSide - 40000) pixels.push_back(pixels.back() + 1 + random() % 20000);
  pixels.push_back(kSide * kSide - 1);
  const SampleFrame frame = framedPixels(kSide, kSide, pixels);
  expectRoundTrips(frame, "sparse");
}

TEST(Codec, AFullLargePlaneComesBack) {
  constexpr uint32_t kSide = 8192;
  SampleFrame frame = garbageFrame(kSide, kSide, 0, 0);
  const size_t count = size_t{kSide} * kSide / 4;  // its upper quarter: 200 MB in memory are enough
  frame.samples.resize(count);
  frame.colors.assign(count, 0xff4080c0u);
  for (size_t i = 0; i < count; ++i) {
    frame.samples[i] = sampleOnRay(frame, static_cast<uint32_t>(i), 50.0f, 0.8f);
  }
  EXPECT_EQ(roundTrip(frame, kJpeg), "");
}

/// What a raw payload of this frame would be, whatever the frame.
ByteVector rawPayload(const SampleFrame& frame) {
  ByteVector payload;
  appendLittle(payload, static_cast<uint8_t>(PayloadFormat::raw));
  appendLittle(payload, uint64_t{0});
  for (const SamplePlane& plane : frame.planes) {
    appendLittle(payload, static_cast<uint32_t>(plane.values.size()));
    payload.insert(payload.end(), plane.values.begin(), plane.values.end());
  }
  for (size_t i = 0; i < frame.size(); ++i) {
    appendLittle(payload, frame.samples[i]);
    appendLittle(payload, frame.colors[i]);
  }
  return sealed(payload);
}

bool isRefused(const SampleFrame& frame) {
  bool refuses = true;
  for (const CodecSettings& settings : kEveryCoding) {
    try {
      FrameCodec().encode(frame, settings);
      refuses = false;
    } catch (const InputError&) {
    }
  }
  SampleFrame decoded = headOf(frame);
  return refuses && FrameCodec().decode(rawPayload(frame), frame.size(), decoded) && decoded.samples.empty();
}

TEST(Codec, FramesOutOfOrderAreRefused) {
  EXPECT_FALSE(isRefused(framedPixels(8, 8, {3, 4, 60})));
  EXPECT_TRUE(isRefused(framedPixels(8, 8, {4, 3, 60})));
  EXPECT_TRUE(isRefused(framedPixels(8, 8, {3, 60, 60})));
  SampleFrame off = framedPixels(8, 8, {3, 4, 63});
  off.camera.width = 7;  // the last is in column 7
  EXPECT_TRUE(isRefused(off));
  off.camera.width = 8;
  EXPECT_FALSE(isRefused(off));
  off.camera.height = 7;
  EXPECT_TRUE(isRefused(off));
  off.camera.height = 0;
  EXPECT_TRUE(isRefused(off));
  off.camera.height = kMaxImageSide + 1;
  EXPECT_TRUE(isRefused(off));
  off = framedPixels(8, 8, {7});  // alone, and outside
  off.camera.width = 7;
  EXPECT_TRUE(isRefused(off));
}

TEST(Codec, RaysThatAreNotInOnePixelEachAreRefused) {
  const auto layered = [](std::vector<uint32_t> pixels, std::vector<uint8_t> layers) {
    SampleFrame frame = framedPixels(8, 8, pixels);
    frame.planes.push_back(layerPlane(layers));
    frame.settings.sample.samplesPerRay = 4;
    return frame;
  };
  EXPECT_FALSE(isRefused(layered({3, 3, 4}, {0, 1, 0})));
  EXPECT_TRUE(isRefused(layered({3, 3, 4}, {0, 0, 0})));  // two rays in one pixel
  EXPECT_TRUE(isRefused(layered({3, 4, 4}, {0, 1, 0})));  // a ray in two
  EXPECT_TRUE(isRefused(layered({3, 4, 4}, {0, 1, 2})));
  EXPECT_TRUE(isRefused(layered({4, 4, 3}, {0, 1, 0})));  // out of order
  EXPECT_TRUE(isRefused(layered({3, 4, 5}, {0, 2, 0})));
}

TEST(Codec, UnusableCamerasDoNotMatter) {
  SampleFrame frame = garbageFrame(50, 40, 1500, 5);
  for (const float bad : {std::nanf(""), 0.0f, 1e30f}) {
    frame.camera.tanHalfFovY = bad;
    expectRoundTrips(frame, std::to_string(bad));
  }
  frame = framedPixels(8, 8, {1, 2, 3, 4});
  frame.quantization.bounds = {glm::vec3(0.0f), glm::vec3(0.0f)};
  expectRoundTrips(frame, "flat");
  frame.quantization.bounds = {};
  frame.settings.render.step = 0.0f;
  frame.voxelRadius = std::nanf("");
  expectRoundTrips(frame, "bounds that hold nothing");
  for (const float bad : {std::nanf(""), 0.0f, -1.0f, 1e-45f, 1e38f}) {
    frame = marched(shells(), {}, 24, 20);
    frame.quantization.nearDepth = bad;
    expectRoundTrips(frame, "near depth " + std::to_string(bad));
    frame.quantization.depthStep = bad;
    expectRoundTrips(frame, "depth step " + std::to_string(bad));
  }
}

RC_GTEST_PROP(Codec, RandomFramesComeBack, ()) {
  const auto width = *rc::gen::inRange<uint32_t>(1, 300), height = *rc::gen::inRange<uint32_t>(1, 300);
  const auto count = *rc::gen::inRange<size_t>(0, 5000);
  SampleFrame frame = garbageFrame(width, height, count, *rc::gen::arbitrary<uint32_t>());
  frame.settings.sample.radiusPolicy =
      *rc::gen::elementOf(std::vector{RadiusPolicy::voxel, RadiusPolicy::opacity, RadiusPolicy::pixel, RadiusPolicy::uncertainty});
  for (const CodecSettings& settings : kEveryCoding) RC_ASSERT(roundTrip(frame, settings) == "");
}

RC_GTEST_PROP(Codec, RandomFramesInOrderComeBack, ()) {
  const auto width = *rc::gen::inRange<uint32_t>(1, 200), height = *rc::gen::inRange<uint32_t>(1, 200);
  const auto seed = *rc::gen::arbitrary<uint32_t>();
  const auto oneIn = *rc::gen::inRange<uint32_t>(1, 40);
  std::mt19937 random(seed);
  std::vector<uint32_t> pixels;
  for (uint32_t pixel = 0; pixel < width * height && pixels.size() < 5000; ++pixel)
    if (random() % oneIn == 0) pixels.push_back(pixel);
  const SampleFrame frame = framedPixels(width, height, pixels, seed);
  for (const CodecSettings& settings : kEveryCoding) RC_ASSERT(roundTrip(frame, settings) == "");
}

TEST(Codec, JpegKeepsColoursNearly) {
  const SampleFrame frame = marched(shells(), {}, 300, 300);
  double last = 0.0;
  for (const auto& [quality, leastDb] : {std::pair(50, 28.0), std::pair(90, 34.0), std::pair(100, 40.0)}) {
    const ByteVector payload =
        FrameCodec().encode(frame, {PayloadFormat::packed, ColorCoding::jpeg, quality});
    SampleFrame decoded = headOf(frame);
    ASSERT_EQ(FrameCodec().decode(payload, frame.size(), decoded), std::nullopt);
    EXPECT_EQ(decoded.samples, frame.samples);
    double squares = 0.0;
    for (size_t i = 0; i < frame.size(); ++i)
      for (int shift = 0; shift < 24; shift += 8) {
        const double difference = (frame.colors[i] >> shift & 255) / 255.0 - (decoded.colors[i] >> shift & 255) / 255.0;
        squares += difference * difference;
      }
    const double psnrDb = 10.0 * std::log10(3.0 * static_cast<double>(frame.size()) / squares);
    EXPECT_GT(psnrDb, leastDb) << quality;
    EXPECT_GT(psnrDb, last) << quality;
    last = psnrDb;
  }
}

TEST(Codec, BytesDoNotDependOnTheNumberOfThreads) {
  const SampleFrame frame = marched(shells(), {}, 700, 700);
  for (const CodecSettings& settings : kEveryCoding) {
    const ByteVector payload = FrameCodec().encode(frame, settings);
    for (const size_t threads : {1, 2, 5}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      EXPECT_EQ(FrameCodec().encode(frame, settings), payload) << threads;
      EXPECT_EQ(roundTrip(frame, settings), "") << threads;
    }
  }
}

TEST(Codec, OneCodecServesFramesOfAllKinds) {
  FrameCodec codec;
  for (int round = 0; round < 2; ++round)
    for (const SampleFrame& frame :
         {marched(shells(), {}), garbageFrame(20, 30, 500, 2), smallLayeredFrame(), garbageFrame(9, 9, 0, 0),
          framedPixels(5, 5, {1, 2, 7}), withLayers(framedPixels(5, 5, {1, 1, 7}), {1, 1, 7})})
      for (const CodecSettings& settings : {kRaw, kLossless, kTiled}) {
        SampleFrame decoded = headOf(frame);
        const ByteVector payload = codec.encode(frame, settings);
        EXPECT_EQ(payload, FrameCodec().encode(frame, settings));
        EXPECT_EQ(codec.decode(payload, frame.size(), decoded), std::nullopt);
        EXPECT_TRUE(sameFrame(decoded, frame));
      }
}

TEST(Codec, ReceiversWithOtherHeadsFindOut) {
  MarchSettings settings;
  settings.sample.radiusPolicy = RadiusPolicy::pixel;
  const SampleFrame frame = marched(shells(), settings);
  const ByteVector payload = FrameCodec().encode(frame, kLossless);
  const auto errorFor = [&](const auto& change, size_t count) {
    SampleFrame decoded = headOf(frame);
    change(decoded);
    const DecodeError error = FrameCodec().decode(payload, count, decoded);
    EXPECT_TRUE(!error || decoded.samples.empty());
    return error;
  };
  EXPECT_EQ(errorFor([](SampleFrame&) {}, frame.size()), std::nullopt);
  EXPECT_NE(errorFor([](SampleFrame&) {}, frame.size() - 1), std::nullopt);
  EXPECT_NE(errorFor([](SampleFrame&) {}, frame.size() + 1), std::nullopt);
  EXPECT_NE(errorFor([](SampleFrame& head) { head.camera.eye.x += 1.0f; }, frame.size()), std::nullopt);
  EXPECT_NE(errorFor([](SampleFrame& head) { head.camera.width = 161; }, frame.size()), std::nullopt);
  EXPECT_NE(errorFor([](SampleFrame& head) { head.camera.height = 12; }, frame.size()), std::nullopt);
  EXPECT_NE(errorFor([](SampleFrame& head) { head.camera.tanHalfFovY = 0.0f; }, frame.size()), std::nullopt);
  EXPECT_NE(errorFor([](SampleFrame& head) { head.settings.render.step = 0.25f; }, frame.size()), std::nullopt);
  EXPECT_NE(
      errorFor([](SampleFrame& head) { head.settings.sample.radiusPolicy = RadiusPolicy::constant; }, frame.size()),
      std::nullopt);
  EXPECT_NE(errorFor([](SampleFrame& head) { head.quantization.bounds.upper *= 1.5f; }, frame.size()), std::nullopt);
  EXPECT_NE(errorFor([](SampleFrame& head) { head.quantization.nearDepth *= 0.5f; }, frame.size()), std::nullopt);
  EXPECT_NE(errorFor([](SampleFrame& head) { head.quantization.depthStep *= 2.0f; }, frame.size()), std::nullopt);
}

TEST(Codec, SettingsOutOfRangeAreRefused) {
  const SampleFrame frame = garbageFrame(8, 8, 3, 1);
  for (const int quality : {0, 101, -5})
    EXPECT_THROW(FrameCodec().encode(frame, {PayloadFormat::packed, ColorCoding::jpeg, quality}), UsageError);
  SampleFrame lame = frame;
  lame.colors.pop_back();
  EXPECT_THROW(FrameCodec().encode(lame, kRaw), InputError);
}

TEST(Codec, EveryFormatHasANameAndAMaker) {
  ASSERT_EQ(codecRegistry().size(), kPayloadFormats.size());
  for (const CodecDescriptor& codec : codecRegistry()) {
    EXPECT_NE(nameOf(codec.format), "?");
    EXPECT_NE(codec.make(makeHostTiledCoder()), nullptr);
  }
}

}  // namespace
}  // namespace warpscope
