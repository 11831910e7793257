// Frames as bytes and back: the same samples bit for bit, whatever the frame; a sentence, whatever the bytes.
// Marched frames with every heuristic and radius policy, made-up and random ones; payloads cut short, changed and invented.
#include "render/codec/codec.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <memory_resource>
#include <random>

#include "render/base/error.h"
#include "render/codec/bytes.h"
#include "render/codec/jpeg.h"
#include "render/march/own_picture.h"
#include "render/volume/procedural.h"
#include "render/volume/reader.h"
#include "tests/layered_frames.h"
#include "tests/marcher_cases.h"
#include "tests/real_data.h"

namespace warpscope {
namespace {

constexpr CodecSettings kRaw{PayloadFormat::raw, ColorCoding::lossless, 90};
constexpr CodecSettings kLossless{PayloadFormat::packed, ColorCoding::lossless, 90};
constexpr CodecSettings kJpeg{PayloadFormat::packed, ColorCoding::jpeg, 90};

/// The frame without its samples: what travels beside a payload.
SampleFrame headOf(const SampleFrame& frame) {
  SampleFrame head;
  head.camera = frame.camera;
  head.quantization = frame.quantization;
  head.settings = frame.settings;
  head.voxelRadius = frame.voxelRadius;
  for (const SamplePlane& plane : frame.planes) head.planes.push_back({plane.name, plane.element, {}});
  return head;
}

/// Empty if what comes back is what went in: samples, planes and alpha always, colours where the settings promise it.
std::string roundTrip(const SampleFrame& frame, const CodecSettings& settings) {
  FrameCodec codec;
  const std::vector<std::byte> payload = codec.encode(frame, settings);
  SampleFrame decoded = headOf(frame);
  if (const DecodeError error = FrameCodec().decode(payload, frame.size(), decoded)) return *error;
  if (decoded.samples != frame.samples) return "other samples";
  if (decoded.planes != frame.planes) return "other planes";
  if (settings.format == PayloadFormat::raw || settings.color == ColorCoding::lossless)
    return decoded.colors == frame.colors ? "" : "other colours";
  if (decoded.colors.size() != frame.colors.size()) return "another number of colours";
  for (size_t i = 0; i < frame.size(); ++i)
    if (decoded.colors[i] >> 24 != frame.colors[i] >> 24) return "other opacities";
  return "";
}

void expectRoundTrips(const SampleFrame& frame, const std::string& what) {
  for (const CodecSettings& settings : {kRaw, kLossless, kJpeg}) EXPECT_EQ(roundTrip(frame, settings), "") << what;
}

double bytesPerSample(const SampleFrame& frame, const CodecSettings& settings) {
  return static_cast<double>(FrameCodec().encode(frame, settings).size()) / static_cast<double>(frame.size());
}

/// Values above a tenth of the range, coloured, half transparent.
TransferFunction translucent(const Volume& volume) {
  const double low = volume.statistics().rangeLower, high = volume.statistics().rangeUpper, span = high - low;
  return {{{low + 0.1 * span, {0.1f, 0.2f, 0.9f}, 0.0f}, {low + 0.3 * span, {0.2f, 0.9f, 0.1f}, 0.05f}, {high, {0.9f, 0.3f, 0.1f}, 0.6f}}};
}

/// From a corner, the volume filling most of the picture.
Camera cornerCamera(const Volume& volume, uint32_t width, uint32_t height) {
  const Box& bounds = volume.bounds();
  return lookingFrom(bounds.center() + 0.6f * glm::length(bounds.extent()) * glm::vec3(1.0f, 0.7f, 1.4f), bounds.center(), width, height);
}

SampleFrame marchedLayers(const VolumePtr& volume, std::span<const Heuristic> heuristics, const MarchSettings& settings = {}, uint32_t width = 160,
                          uint32_t height = 120) {
  return marchLayers(*makeCpuMarcher(volume, translucent(*volume)), cornerCamera(*volume, width, height), settings, heuristics);
}

SampleFrame marched(const VolumePtr& volume, const MarchSettings& settings, uint32_t width = 160, uint32_t height = 120) {
  return makeCpuMarcher(volume, translucent(*volume))->march(cornerCamera(*volume, width, height), settings);
}

const VolumePtr& shells() {
  static const VolumePtr volume = makeProceduralVolume("shells", {48, 48, 48});
  return volume;
}

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

/// A frame of made-up samples: `random` in every bit of each of them.
SampleFrame garbageFrame(uint32_t width, uint32_t height, size_t count, uint32_t seed) {
  std::mt19937_64 random(seed);
  SampleFrame frame;
  frame.camera = lookingFrom({30.0f, 20.0f, 40.0f}, {}, width, height);
  frame.quantization = {{glm::vec3(-80.0f), glm::vec3(80.0f)}, 1.0f};  // holds whatever is in the picture up to 65 away
  for (size_t i = 0; i < count; ++i) {
    frame.samples.push_back(random());
    frame.colors.push_back(static_cast<Rgba8>(random()));
  }
  return frame;
}

/// Samples in the given pixels, in order, each near its pixel's ray.
SampleFrame framedPixels(uint32_t width, uint32_t height, const std::vector<uint32_t>& pixels, uint32_t seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> depth(43.0f, 65.0f);
  SampleFrame frame = garbageFrame(width, height, 0, 0);
  for (const uint32_t pixel : pixels) {
    const Ray ray = pixelRay(frame.camera, {static_cast<float>(pixel % width) + 0.5f, static_cast<float>(pixel / width) + 0.5f});
    frame.samples.push_back(packSample(ray.at(depth(random)), 0.8f, frame.quantization));
    frame.colors.push_back(0xff000000u | random());
  }
  return frame;
}

/// Says of a frame of framedPixels() that the samples of a pixel are those of one ray.
SampleFrame withLayers(SampleFrame frame, const std::vector<uint32_t>& pixels) {
  std::vector<uint8_t> layers;
  for (size_t i = 0; i < pixels.size(); ++i)
    layers.push_back(i > 0 && pixels[i] == pixels[i - 1] ? static_cast<uint8_t>(layers.back() + 1) : uint8_t{0});
  frame.planes.push_back(layerPlane(layers));
  return frame;
}

/// Adds a plane that is known, of made-up values.
SampleFrame withExtents(SampleFrame frame) {
  std::vector<float> extents;
  for (size_t i = 0; i < frame.size(); ++i) extents.push_back(0.25f * static_cast<float>(i * 7919 % 13));
  frame.planes.push_back(planeOf(kExtentPlane, PlaneElement::float32, std::span<const float>(extents)));
  return frame;
}

/// Several samples a ray and a plane besides.
SampleFrame smallLayeredFrame() {
  constexpr Heuristic kHeuristicsOfIt[] = {Heuristic::entrance, Heuristic::gradient, Heuristic::exit};
  return withExtents(marchedLayers(shells(), kHeuristicsOfIt, {}, 20, 16));
}

/// The packed format gives the samples places along rays; it could send each as it is, which would come back too.
bool isPlaced(const SampleFrame& frame) {
  const std::vector<std::byte> payload = FrameCodec().encode(frame, kLossless);
  ByteReader reader{std::span(payload).subspan(9)};
  for (size_t plane = 0; plane < frame.planes.size(); ++plane) reader.take(reader.take<uint32_t>());
  return reader.take<uint8_t>() != 0;
}

/// Decoding without a crash: an error, or `count` samples.
bool survives(std::span<const std::byte> payload, const SampleFrame& frame) {
  SampleFrame decoded = headOf(frame);
  const DecodeError error = FrameCodec().decode(payload, frame.size(), decoded);
  return error ? !error->empty() && decoded.samples.empty() && decoded.colors.empty()
               : decoded.samples.size() == frame.size() && decoded.colors.size() == frame.size();
}

std::vector<std::byte> sealed(std::vector<std::byte> payload) {
  sealPayload(payload);
  return payload;
}

TEST(Codec, MarchedFramesComeBackWithEveryHeuristicAndRadiusPolicy) { expectAllHeuristicsAndPolicies(shells()); }

TEST(Codec, MarchedFramesOfOtherVolumesComeBack) {
  for (const auto& volume : kProceduralVolumes) expectRoundTrips(marched(makeProceduralVolume(volume.name, {40, 32, 24}), {}), std::string(volume.name));
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
  expectRoundTrips(framedPixels(1, 1, {0, 0, 0}), "one pixel, three samples");
  for (const auto& [width, height] : {std::pair(7u, 3u), std::pair(1u, 300u), std::pair(300u, 1u), std::pair(9u, 17u)}) {
    std::vector<uint32_t> all(width * height);
    for (uint32_t i = 0; i < all.size(); ++i) all[i] = i;
    const SampleFrame frame = framedPixels(width, height, all);
    EXPECT_TRUE(isPlaced(frame)) << width;
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
  EXPECT_TRUE(isPlaced(frame));
  expectRoundTrips(frame, "sparse");
}

TEST(Codec, AFullLargePlaneComesBack) {
  constexpr uint32_t kSide = 8192;
  SampleFrame frame = garbageFrame(kSide, kSide, 0, 0);
  const size_t count = size_t{kSide} * kSide / 4;  // its upper quarter: 200 MB in memory are enough
  frame.samples.resize(count);
  frame.colors.assign(count, 0xff4080c0u);
  for (size_t i = 0; i < count; ++i) {
    const Ray ray = pixelRay(frame.camera, {static_cast<float>(i % kSide) + 0.5f, static_cast<float>(i / kSide) + 0.5f});
    frame.samples[i] = packSample(ray.at(50.0f), 0.8f, frame.quantization);
  }
  EXPECT_TRUE(isPlaced(frame));
  EXPECT_EQ(roundTrip(frame, kJpeg), "");
}

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
    const SampleFrame onSteps = marchedLayers(shells(), kOnSteps, settings), between = marchedLayers(shells(), kBetween, settings);
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
  constexpr uint32_t kWidth = 512, kHeight = 256, kLayersOfIt = 9;
  std::vector<uint32_t> pixels;
  for (uint32_t pixel = 0; pixel < kWidth * kHeight; ++pixel) pixels.insert(pixels.end(), kLayersOfIt, pixel);
  ASSERT_GT(pixels.size(), size_t{1} << 20);
  const SampleFrame frame = withLayers(framedPixels(kWidth, kHeight, pixels), pixels);
  EXPECT_TRUE(isPlaced(frame));
  EXPECT_EQ(roundTrip(frame, kJpeg), "");
}

TEST(Codec, AsManyLayersAsThereCanBeComeBack) {
  std::vector<uint32_t> pixels(256, 3);
  pixels.insert(pixels.end(), {4, 4, 9});
  EXPECT_TRUE(isPlaced(framedPixels(8, 8, pixels)));
  expectRoundTrips(withLayers(framedPixels(8, 8, pixels), pixels), "256");
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
  expectRoundTrips(two, "two rays in one pixel");
  // Some that no pixel sees, among others.
  const std::vector<uint32_t> ordered = pixelsOf(rays);
  SampleFrame off = withLayers(framedPixels(64, 64, ordered), ordered);
  for (size_t i = 0; i < off.size(); i += 97) off.samples[i] = i % 2 ? 0 : ~PackedSample{0};
  EXPECT_TRUE(isPlaced(off));
  expectRoundTrips(off, "strays");
}

TEST(Codec, KnownPlanesComeBack) {
  for (const SampleFrame& frame : {marched(shells(), {}), framedPixels(9, 9, {1, 1, 7}), garbageFrame(20, 30, 700, 2), garbageFrame(9, 9, 0, 0)})
    expectRoundTrips(withExtents(frame), std::to_string(frame.size()));
}

/// What is not known is skipped, by name and length; samples, colours and the other planes are as if it had not been there.
TEST(Codec, UnknownPlanesAreLeftOut) {
  constexpr Heuristic kTwo[] = {Heuristic::entrance, Heuristic::exit};
  const SampleFrame known = withExtents(marchedLayers(shells(), kTwo));
  const std::vector<uint16_t> future(known.size(), 4711);
  SampleFrame frame = known;
  frame.planes.insert(frame.planes.begin() + 1, planeOf("future", PlaneElement::uint16, std::span<const uint16_t>(future)));
  SampleFrame otherKind = known;
  otherKind.planes[1] = planeOf(kExtentPlane, PlaneElement::uint16, std::span<const uint16_t>(future));
  for (const CodecSettings& settings : {kRaw, kLossless}) {
    SampleFrame decoded = headOf(frame);
    ASSERT_EQ(FrameCodec().decode(FrameCodec().encode(frame, settings), frame.size(), decoded), std::nullopt);
    EXPECT_TRUE(sameFrame(decoded, known));
    // Of an element that there is not yet.
    decoded = headOf(frame);
    decoded.planes[1].element = static_cast<PlaneElement>(200);
    ASSERT_EQ(FrameCodec().decode(FrameCodec().encode(frame, settings), frame.size(), decoded), std::nullopt);
    EXPECT_TRUE(sameFrame(decoded, known));
    // Of a name that is known, but of other values.
    decoded = headOf(otherKind);
    ASSERT_EQ(FrameCodec().decode(FrameCodec().encode(otherKind, settings), frame.size(), decoded), std::nullopt);
    ASSERT_EQ(decoded.planes.size(), 1u);
    EXPECT_EQ(decoded.planes[0], known.planes[0]);
    EXPECT_EQ(decoded.samples, known.samples);
  }
}

TEST(Codec, FramesWithoutPlanesHaveNoBytesForThem) {
  const SampleFrame frame = marched(shells(), {}, 24, 20);
  EXPECT_EQ(FrameCodec().encode(frame, kRaw).size(), 9 + 12 * frame.size());
  for (const CodecSettings& settings : {kRaw, kLossless, kJpeg}) {
    const size_t bytes = FrameCodec().encode(frame, settings).size();
    SampleFrame layered = frame;
    layered.planes.push_back(layerPlane(std::vector<uint8_t>(frame.size(), 0)));
    EXPECT_EQ(FrameCodec().encode(layered, settings).size(), bytes + 4 + (settings.format == PayloadFormat::raw ? frame.size() : 0));
  }
}

TEST(Codec, PlanesThatAreNotWhatTheySayAreRefused) {
  const SampleFrame frame = withExtents(framedPixels(8, 8, {1, 2, 3, 4}));
  const auto refuses = [](const SampleFrame& changed) { EXPECT_THROW(FrameCodec().encode(changed, kLossless), InputError); };
  SampleFrame changed = frame;
  changed.planes[0].values.pop_back();
  refuses(changed);
  changed = frame;
  changed.planes[0].name = "";
  refuses(changed);
  changed.planes[0].name = std::string(kMaxPlaneName + 1, 'p');
  refuses(changed);
  changed = frame;
  changed.planes.push_back(changed.planes[0]);
  refuses(changed);
  changed = frame;
  changed.planes[0].element = static_cast<PlaneElement>(200);
  refuses(changed);
  changed = frame;
  for (size_t i = 0; i < kMaxPlanes; ++i) {
    changed.planes.push_back(changed.planes[0]);
    changed.planes.back().name += std::to_string(i);
  }
  refuses(changed);
  for (const std::vector<uint8_t>& layers : {std::vector<uint8_t>{1, 0, 0, 0}, {0, 2, 0, 0}, {0, 1, 1, 0}, {0, 0, 255, 0}}) {
    changed = frame;
    changed.planes.push_back(layerPlane(layers));
    refuses(changed);
  }
}

TEST(Codec, LayersThatDoNotCountUpAreRefused) {
  const std::vector<uint32_t> pixels{1, 1, 1, 5};
  const SampleFrame frame = withLayers(framedPixels(8, 8, pixels), pixels);
  std::vector<std::byte> payload = FrameCodec().encode(frame, kRaw);
  SampleFrame decoded = headOf(frame);
  ASSERT_EQ(FrameCodec().decode(payload, frame.size(), decoded), std::nullopt);
  payload.at(9 + 4 + 1) = std::byte{2};
  EXPECT_NE(FrameCodec().decode(sealed(payload), frame.size(), decoded), std::nullopt);
  EXPECT_TRUE(decoded.samples.empty());
  EXPECT_TRUE(decoded.layers().empty());
}

TEST(Codec, FramesOutOfOrderComeBack) {
  std::vector<uint32_t> pixels(64 * 64);
  for (uint32_t i = 0; i < pixels.size(); ++i) pixels[i] = i;
  const SampleFrame ordered = framedPixels(64, 64, pixels);
  std::mt19937 random(3);
  for (size_t i = 0; i < pixels.size(); i += 50) std::swap(pixels[i], pixels[random() % pixels.size()]);
  EXPECT_TRUE(isPlaced(framedPixels(64, 64, pixels)));
  expectRoundTrips(framedPixels(64, 64, pixels), "some");
  std::shuffle(pixels.begin(), pixels.end(), random);
  expectRoundTrips(framedPixels(64, 64, pixels), "all");
  SampleFrame off = ordered;  // a few that no pixel sees, and a few without radius
  for (size_t i = 0; i < off.size(); i += 97) off.samples[i] = i % 2 ? 0 : ~PackedSample{0};
  expectRoundTrips(off, "strays");
}

TEST(Codec, UnusableCamerasDoNotMatter) {
  SampleFrame frame = garbageFrame(50, 40, 3000, 5);
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
}

RC_GTEST_PROP(Codec, RandomFramesComeBack, ()) {
  const auto width = *rc::gen::inRange<uint32_t>(1, 300), height = *rc::gen::inRange<uint32_t>(1, 300);
  const auto count = *rc::gen::inRange<size_t>(0, 5000);
  SampleFrame frame = garbageFrame(width, height, count, *rc::gen::arbitrary<uint32_t>());
  frame.settings.sample.radiusPolicy = *rc::gen::elementOf(std::vector{RadiusPolicy::voxel, RadiusPolicy::opacity, RadiusPolicy::pixel});
  for (const CodecSettings& settings : {kRaw, kLossless, kJpeg}) RC_ASSERT(roundTrip(frame, settings) == "");
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
  for (const CodecSettings& settings : {kRaw, kLossless, kJpeg}) RC_ASSERT(roundTrip(frame, settings) == "");
}

RC_GTEST_PROP(Codec, RandomFramesInOrderComeBack, ()) {
  const auto width = *rc::gen::inRange<uint32_t>(1, 200), height = *rc::gen::inRange<uint32_t>(1, 200);
  const auto seed = *rc::gen::arbitrary<uint32_t>();
  const auto oneIn = *rc::gen::inRange<uint32_t>(1, 40);
  std::mt19937 random(seed);
  std::vector<uint32_t> pixels;
  for (uint32_t pixel = 0; pixel < width * height; ++pixel)
    while (random() % oneIn == 0 && pixels.size() < 5000) {
      pixels.push_back(pixel);
      if (oneIn == 1 && random() % 2) break;
    }
  const SampleFrame frame = framedPixels(width, height, pixels, seed);
  for (const CodecSettings& settings : {kRaw, kLossless, kJpeg}) RC_ASSERT(roundTrip(frame, settings) == "");
}

TEST(Codec, JpegKeepsColoursNearly) {
  const SampleFrame frame = marched(shells(), {}, 300, 300);
  double last = 0.0;
  for (const auto& [quality, leastDb] : {std::pair(50, 28.0), std::pair(90, 34.0), std::pair(100, 40.0)}) {
    const std::vector<std::byte> payload = FrameCodec().encode(frame, {PayloadFormat::packed, ColorCoding::jpeg, quality});
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
  for (const CodecSettings& settings : {kRaw, kLossless, kJpeg}) {
    const std::vector<std::byte> payload = FrameCodec().encode(frame, settings);
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
    for (const SampleFrame& frame : {marched(shells(), {}), garbageFrame(20, 30, 700, 2), smallLayeredFrame(), garbageFrame(9, 9, 0, 0),
                                     framedPixels(5, 5, {1, 1, 7}), withLayers(framedPixels(5, 5, {1, 1, 7}), {1, 1, 7})})
      for (const CodecSettings& settings : {kRaw, kLossless}) {
        SampleFrame decoded = headOf(frame);
        const std::vector<std::byte> payload = codec.encode(frame, settings);
        EXPECT_EQ(payload, FrameCodec().encode(frame, settings));
        EXPECT_EQ(codec.decode(payload, frame.size(), decoded), std::nullopt);
        EXPECT_TRUE(sameFrame(decoded, frame));
      }
}

TEST(Codec, ReceiversWithOtherHeadsFindOut) {
  MarchSettings settings;
  settings.sample.radiusPolicy = RadiusPolicy::pixel;
  const SampleFrame frame = marched(shells(), settings);
  const std::vector<std::byte> payload = FrameCodec().encode(frame, kLossless);
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
  EXPECT_NE(errorFor([](SampleFrame& head) { head.settings.sample.radiusPolicy = RadiusPolicy::constant; }, frame.size()), std::nullopt);
  EXPECT_NE(errorFor([](SampleFrame& head) { head.quantization.bounds.upper *= 1.5f; }, frame.size()), std::nullopt);
}

/// Frames whose payloads are few bytes.
class CodecDamage : public testing::TestWithParam<bool> {
 protected:
  const SampleFrame frame_ = GetParam() ? smallLayeredFrame() : marched(shells(), {}, 24, 20);
};
INSTANTIATE_TEST_SUITE_P(, CodecDamage, testing::Bool(), [](const auto& layered) { return std::string(layered.param ? "Layers" : "OneSampleARay"); });

TEST_P(CodecDamage, PayloadsCutShortAreRefused) {
  const SampleFrame& frame = frame_;
  ASSERT_GT(frame.size(), 100u);
  for (const CodecSettings& settings : {kRaw, kLossless, kJpeg}) {
    const std::vector<std::byte> payload = FrameCodec().encode(frame, settings);
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
  for (const CodecSettings& settings : {kRaw, kLossless, kJpeg}) {
    std::vector<std::byte> payload = FrameCodec().encode(frame, settings);
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
    std::vector<std::byte> payload(random() % 400);
    for (std::byte& byte : payload) byte = static_cast<std::byte>(random() % (round % 2 ? 256 : 4));
    if (!payload.empty()) payload[0] = static_cast<std::byte>(random() % 2);
    ASSERT_TRUE(survives(payload, frame));
    ASSERT_TRUE(survives(sealed(payload), frame));
  }
}

TEST(Codec, SizesBeyondTheLimitsAreRefused) {
  const SampleFrame frame = marched(shells(), {}, 24, 20);
  ASSERT_GT(frame.size(), 100u);
  const std::vector<std::byte> payload = FrameCodec().encode(frame, kLossless);
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
  const size_t claimed = size_t{1} << 25;
  for (const int format : {0, 1})
    for (const uint8_t placement : {0, 1, 3}) {
      // Few bytes that say there are very many samples, each band as many as it may have.
      std::vector<std::byte> payload;
      appendLittle(payload, static_cast<uint8_t>(format));
      appendLittle(payload, uint64_t{0});
      appendLittle(payload, placement);
      appendLittle(payload, uint8_t{0});
      for (int band = 0; band < 512; ++band) {
        appendLittle(payload, uint32_t{0});
        appendLittle(payload, static_cast<uint32_t>(claimed / 512));
      }
      EXPECT_NE(FrameCodec().decode(sealed(payload), claimed, frame), std::nullopt) << format << " " << int{placement};
      EXPECT_EQ(memory.largest, 0u) << format << " " << int{placement};
    }
}

TEST(Codec, LengthsOfPlanesBeyondThePayloadAreRefusedBeforeMemoryIsTaken) {
  CountingMemory memory;
  for (const int format : {0, 1})
    for (const uint32_t length : {0u, 1u, 1000u, 0x7fffffffu, 0xffffffffu}) {
      SampleFrame frame = garbageFrame(8192, 8192, 0, 0);
      frame.samples = TransferVector<PackedSample>(TransferAllocator<PackedSample>(&memory));
      for (const KnownPlane& known : kKnownPlanes)
        frame.planes.push_back({std::string(known.name), known.element, TransferVector<std::byte>(TransferAllocator<std::byte>(&memory))});
      std::vector<std::byte> payload;
      appendLittle(payload, static_cast<uint8_t>(format));
      appendLittle(payload, uint64_t{0});
      appendLittle(payload, length);
      payload.resize(payload.size() + 500);
      EXPECT_NE(FrameCodec().decode(sealed(payload), size_t{1} << 25, frame), std::nullopt) << format << " " << length;
      EXPECT_EQ(memory.largest, 0u) << format << " " << length;
    }
}

TEST(Codec, SettingsOutOfRangeAreRefused) {
  const SampleFrame frame = garbageFrame(8, 8, 3, 1);
  for (const int quality : {0, 101, -5}) EXPECT_THROW(FrameCodec().encode(frame, {PayloadFormat::packed, ColorCoding::jpeg, quality}), UsageError);
  SampleFrame lame = frame;
  lame.colors.pop_back();
  EXPECT_THROW(FrameCodec().encode(lame, kRaw), InputError);
}

TEST(Codec, EveryFormatHasANameAndAMaker) {
  ASSERT_EQ(codecRegistry().size(), kPayloadFormats.size());
  for (const CodecDescriptor& codec : codecRegistry()) {
    EXPECT_NE(nameOf(codec.format), "?");
    EXPECT_NE(codec.make(), nullptr);
  }
}

TEST(FramePicture, IsTheFramesOwnPicture) {
  const SampleFrame frame = marched(shells(), {}, 200, 150);
  const glm::vec3 background(0.1f, 0.2f, 0.3f);
  Image<Rgba8> picture;
  const std::vector<std::byte> jpeg = encodeFramePicture(frame, background, 95);
  ASSERT_EQ(decodeFramePicture(jpeg, frame.camera, picture), std::nullopt);
  EXPECT_LT(encodeFramePicture(frame, background, 50).size(), jpeg.size());
  const Image<uint32_t> seen = ownPicture(frame);
  double squares = 0.0;
  for (size_t i = 0; i < picture.size(); ++i) {
    const glm::vec4 color = seen[i] == kNoSample ? glm::vec4(0.0f) : decodeRgba8(frame.colors[seen[i]]);
    const Rgba8 expected = ColorTables::instance().encodeOver(color, background);
    for (int shift = 0; shift < 24; shift += 8) {
      const double difference = (picture[i] >> shift & 255) / 255.0 - (expected >> shift & 255) / 255.0;
      squares += difference * difference / (3.0 * static_cast<double>(picture.size()));
    }
  }
  EXPECT_LT(squares, 1e-3);

  Camera other = frame.camera;
  other.width = 201;
  EXPECT_NE(decodeFramePicture(jpeg, other, picture), std::nullopt);
  EXPECT_TRUE(picture.empty());
}

TEST(FramePicture, DamagedOnesAreRefusedAndDoNotSpoilTheNext) {
  const SampleFrame frame = marched(shells(), {}, 40, 32);
  std::vector<std::byte> jpeg = encodeFramePicture(frame, glm::vec3(0.0f), 80);
  Image<Rgba8> picture;
  for (size_t length = 0; length + 2 < jpeg.size(); ++length) {  // without its end marker alone a picture is whole
    EXPECT_NE(decodeFramePicture(std::span(jpeg).first(length), frame.camera, picture), std::nullopt) << length;
    ASSERT_EQ(decodeFramePicture(jpeg, frame.camera, picture), std::nullopt) << length;
  }
  const std::vector<std::byte> whole = jpeg;
  for (size_t i = 0; i < jpeg.size(); ++i) {
    jpeg[i] ^= std::byte{0xff};
    decodeFramePicture(jpeg, frame.camera, picture);
    ASSERT_EQ(decodeFramePicture(whole, frame.camera, picture), std::nullopt) << i;
    jpeg[i] ^= std::byte{0xff};
  }
}

}  // namespace
}  // namespace warpscope
