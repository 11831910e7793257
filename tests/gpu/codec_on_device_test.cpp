// Tiles that a device makes and reads against the host's: the same bytes, and the same frames of any bytes.
// Mirrors render/codec/tiled/tiled_coder_cuda.h.
#include <gtest/gtest.h>

#include <atomic>
#include <random>
#include <thread>

#include "render/codec/segment_coding.h"
#include "render/codec/tiled/tiled_coder_cuda.h"
#include "render/cuda/devices.h"
#include "render/march/frame_places.h"
#include "render/warp/device/sphere_samples.h"
#include "render/warp/multihit_warp_cuda.h"
#include "render/warp/segments_warp_cuda.h"
#include "render/warp/spheres_warp_cuda.h"
#include "render/warp/splats_warp_cuda.h"
#include "tests/codec_frames.h"
#include "tests/gpu/march_pairs.h"
#include "tests/hostile_tiles.h"

namespace warpscope {
namespace {

class CodecOnDevice : public testing::Test {
 protected:
  void SetUp() override {
    WARPSCOPE_NEEDS_GPU();
    onDevice_ = std::make_unique<FrameCodec>(makeCudaTiledCoder());
  }

  void expectSame(const SampleFrame& frame, const std::string& what) {
    const ByteVector payload = FrameCodec().encode(frame, kTiled);
    EXPECT_TRUE(onDevice_->encode(frame, kTiled) == payload) << what;
    EXPECT_EQ(onDevice_->bytes().segments > 0, frame.settings.sample.segments > 0) << what;
    SampleFrame decoded = headOf(frame);
    decoded.proxy = frame.proxy;
    const DecodeError error = onDevice_->decode(payload, frame.size(), decoded);
    ASSERT_EQ(error, std::nullopt) << what;
    EXPECT_TRUE(areSame(decoded, frame)) << what;
    expectSameThere(frame, what);
  }

  /// The same where it stays on the device, and codes again to the same bytes.
  void expectSameThere(const SampleFrame& frame, const std::string& what) {
    SampleFrame decoded = headOf(frame);
    ASSERT_EQ(onDevice_->decode(FrameCodec().encode(frame, kTiled), frame.size(), decoded, {.place = DecodedPlace::device}), std::nullopt) << what;
    const bool isHosts = frame.size() == 0 || std::ranges::any_of(frame.planes, [](const SamplePlane& plane) { return plane.name != kLayerPlane; });
    EXPECT_EQ(decoded.isAway, !isHosts) << what;
    EXPECT_TRUE(areSame(onHost(decoded), frame)) << what;
    decoded.proxy = frame.proxy;
    for (const CodecSettings& coding : kEveryCoding) EXPECT_TRUE(onDevice_->encode(decoded, coding) == FrameCodec().encode(frame, coding)) << what << ", " << nameOf(coding.format);
    if (isHosts) return;
    EXPECT_EQ(decoded.device->haveRadii(), std::ranges::none_of(frame.samples, [](PackedSample sample) { return radiusCode(sample) == 0; })) << what;
  }

  /// Whatever the bytes, the device answers as the host does.
  void expectSameAnswer(std::span<const std::byte> payload, const SampleFrame& frame, const std::string& what) {
    SampleFrame ofHost = headOf(frame), ofDevice = headOf(frame);
    const DecodeError host = FrameCodec().decode(payload, frame.size(), ofHost), device = onDevice_->decode(payload, frame.size(), ofDevice);
    ASSERT_EQ(host.has_value(), device.has_value()) << what << ": " << host.value_or("accepted") << " / " << device.value_or("accepted");
    ASSERT_TRUE(areSame(ofHost, ofDevice)) << what;
    SampleFrame there = headOf(frame);
    ASSERT_EQ(onDevice_->decode(payload, frame.size(), there, {.place = DecodedPlace::device}), device) << what;
    ASSERT_TRUE(areSame(ofHost, onHost(there))) << what;
  }

  std::unique_ptr<FrameCodec> onDevice_;
};

TEST_F(CodecOnDevice, SamplesOfEveryHeuristicAndRadiusPolicy) {
  for (const auto& heuristic : kHeuristics)
    for (const auto& policy : kRadiusPolicies) {
      MarchSettings settings;
      settings.sample.heuristic = heuristic.value;
      settings.sample.radiusPolicy = policy.value;
      settings.render.effects.jitter = heuristic.value == Heuristic::gradient ? 0.7f : 0.0f;
      expectSame(marched(shells(), settings, 530, 310), std::string(heuristic.name) + " " + std::string(policy.name));
    }
}

TEST_F(CodecOnDevice, SamplesWithFurtherOnesAndPlanes) {
  constexpr Heuristic kAll[] = {Heuristic::entrance, Heuristic::gradient, Heuristic::exit, Heuristic::peak};
  expectSame(withExtents(marchedLayers(shells(), kAll, {}, 301, 140)), "four heuristics");
  expectSame(smallLayeredFrame(), "small");
  expectSame(withLayers(framedPixels(1, 1, {0, 0, 0}), {0, 0, 0}), "one pixel");
}

TEST_F(CodecOnDevice, SamplesOfAnyBitsAndPicturesOfAnySize) {
  std::mt19937 random(5);
  for (int round = 0; round < 60; ++round) {
    const uint32_t width = 1 + random() % (round % 4 == 0 ? 900 : 70), height = 1 + random() % (round % 5 == 0 ? 300 : 70);
    const size_t pixels = size_t{width} * height;
    expectSame(garbageFrame(width, height, round % 3 == 0 ? pixels : random() % (pixels + 1), random()), std::to_string(width) + "x" + std::to_string(height));
  }
  expectSame(garbageFrame(640, 480, 0, 0), "none");
}

TEST_F(CodecOnDevice, SegmentsLitAndUnlit) {
  const MarcherPtr marcher = makeCpuMarcher(shells(), translucent(*shells()));
  for (const int segments : {1, 4, 16})
    for (const float shading : {0.0f, 1.0f})
      for (const auto& [width, height] : {std::pair(530u, 310u), std::pair(31u, 77u), std::pair(1u, 1u)}) {
        MarchSettings settings;
        settings.sample.segments = segments;
        settings.render.effects.shading.strength = shading;
        settings.render.effects.jitter = segments == 4 ? 0.7f : 0.0f;
        if (segments == 16) settings.render.effects.clip.planes = parseClipPlanes("1,0.2,0,0", "it");
        expectSame(marcher->march(cornerCamera(*shells(), width, height), settings), std::to_string(segments) + " of " + std::to_string(width));
      }
}

/// What a marcher leaves on the device against what it brings from there.
TEST_F(CodecOnDevice, FramesThatStayedThere) {
  const MarcherPtr marcher = makeCudaMarcher(shells(), translucent(*shells()));
  MarchSettings settings[7];
  settings[1].sample.segments = 4;
  settings[2].sample.segments = 3;
  settings[2].render.effects.shading.strength = 1.0f;
  settings[3].sample.samplesPerRay = 4;
  settings[4].sample.samplesPerRay = 2;
  settings[4].sample.segments = 2;
  settings[4].render.effects.jitter = 0.7f;
  settings[5].sample.sendsSpread = true;
  settings[6].render.effects.clip.planes = parseClipPlanes("1,0,0,1e6", "it");  // nothing is left
  settings[6].sample.segments = 2;
  SampleFrame held;  // others are marched meanwhile
  ByteVector payloadOfHeld;
  for (const MarchSettings& own : settings)
    for (const auto& [width, height] : {std::pair(530u, 310u), std::pair(31u, 77u), std::pair(1u, 1u)}) {
      const Camera camera = cornerCamera(*shells(), width, height);
      const SampleFrame brought = marcher->march(camera, own);
      for (const CodecSettings& coding : kEveryCoding) {
        const SampleFrame left = marcher->marchToCode(camera, own);
        EXPECT_TRUE(left.isAway);
        EXPECT_EQ(left.size(), brought.size());
        EXPECT_EQ(left.device->placements(), (FramePlacements{placementOf(brought), borderPlacementOf(brought)})) << &own - settings << ", " << width;
        EXPECT_TRUE(onDevice_->encode(left, coding) == FrameCodec().encode(brought, coding)) << &own - settings << ", " << width << ", " << nameOf(coding.format);
        EXPECT_TRUE(areSame(onHost(left), brought)) << &own - settings << ", " << width;
      }
      EXPECT_TRUE(!held.isAway || onDevice_->encode(held, kTiled) == payloadOfHeld);
      held = marcher->marchToCode(camera, own);
      payloadOfHeld = FrameCodec().encode(brought, kTiled);
    }
}

/// A frame that was decoded on the device is drawn from where it is: as the same frame from host memory, however many came after it.
TEST_F(CodecOnDevice, TechniquesGoOnWithWhatWasDecodedThere) {
  MarchSettings plain, segments, lit;
  segments.sample.segments = lit.sample.segments = 4;
  lit.render.effects.shading.strength = 1.0f;
  const MarcherPtr marcher = makeCpuMarcher(shells(), translucent(*shells()));
  std::vector<std::shared_ptr<SampleFrame>> frames;
  for (const MarchSettings& settings : {plain, segments, lit, segments, plain}) {
    const SampleFrame frame = marcher->march(cornerCamera(*shells(), 200 + 40 * static_cast<uint32_t>(frames.size()), 150), settings);
    const ByteVector payload = onDevice_->encode(frame, kTiled);
    const auto& decoded = frames.emplace_back(std::make_shared<SampleFrame>(headOf(frame)));
    const DecodedPlace place = frames.size() % 2 == 0 ? DecodedPlace::device : DecodedPlace::host;
    ASSERT_EQ(onDevice_->decode(payload, frame.size(), *decoded, {.place = place}), std::nullopt);
    EXPECT_NE(decoded->device, nullptr);
    EXPECT_EQ(decoded->isAway, place == DecodedPlace::device);
    EXPECT_TRUE(areSame(onHost(*decoded), frame));
  }
  const Camera camera = cornerCamera(*shells(), 180, 140);
  using Make = std::unique_ptr<Warp> (*)();
  for (const Make make : std::initializer_list<Make>{makeCudaSpheresWarp, makeCudaSplatsWarp, [] { return makeCudaMultihitWarp(); }, makeCudaSegmentsWarp})
    for (const std::shared_ptr<SampleFrame>& frame : frames) {
      // Colours that the host has are looked at by nobody.
      const auto there = std::make_shared<SampleFrame>(*frame);
      std::ranges::fill(there->colors, Rgba8{0});
      std::ranges::fill(there->segments.colors, Rgba8{0});
      WarpedImage expected, got;
      for (WarpedImage* image : {&expected, &got}) {
        const std::unique_ptr<Warp> warp = make();
        warp->setFrame(image == &got ? SampleFramePtr(there) : std::make_shared<const SampleFrame>(onHost(*frame)), {}, {});
        warp->draw(camera, {}, *image, {});
      }
      EXPECT_TRUE(got.samples == expected.samples && got.color == expected.color) << frame->settings.sample.segments;
    }
}

TEST_F(CodecOnDevice, DamageIsFoundAsTheHostFindsIt) {
  std::mt19937 random(17);
  MarchSettings settings;
  settings.sample.segments = 3;
  const SampleFrame frames[] = {smallLayeredFrame(), marched(shells(), {}, 300, 60), marched(shells(), settings, 290, 50)};
  for (const SampleFrame& frame : frames) {
    const ByteVector payload = FrameCodec().encode(frame, kTiled);
    for (int round = 0; round < 400; ++round) {
      ByteVector damaged = payload;
      const size_t from = round % 4 == 0 ? 9 + random() % (damaged.size() - 9) : 9 + random() % std::min<size_t>(damaged.size() - 9, 1500);
      if (round % 7 == 0)
        damaged.resize(from);
      else
        for (int k = 0; k <= round % 3; ++k) damaged[std::min(from + k, damaged.size() - 1)] = static_cast<std::byte>(random());
      const bool isSealed = round % 5 > 0;  // else the hash tells, when the device has begun
      expectSameAnswer(isSealed ? sealed(std::move(damaged)) : damaged, frame, "round " + std::to_string(round));
      if (!isSealed || round % 40 == 1) expectSameAnswer(payload, frame, "undamaged after round " + std::to_string(round));
      if (HasFatalFailure()) return;
    }
    expectSameAnswer(payload, frame, "undamaged");
  }
}

/// Bytes that are whole, of segments that lie in each other's way: in many pixels of a large picture, so that blocks find it out while others are at work.
TEST_F(CodecOnDevice, SegmentsOutOfOrderAreRefusedAsTheHostRefusesThem) {
  MarchSettings settings;
  settings.sample.segments = 4;
  const SampleFrame frame = marched(shells(), settings, 900, 700);
  for (const size_t every : {size_t{1}, size_t{1000}}) {
    SampleFrame wrong = frame;
    for (size_t i = 0; i < wrong.segments.size(); i += every) std::swap(wrong.segments.depths[i].begin, wrong.segments.depths[i].end);
    ByteVector bytes;
    makeHostTiledCoder()->appendSegments(bytes, wrong, Placement::depth);
    for (const TiledCoderPtr& coder : {makeHostTiledCoder(), makeCudaTiledCoder()}) {
      SampleFrame back = headOf(frame);
      ByteReader reader(bytes);
      EXPECT_EQ(coder->takeSegments(reader, Placement::depth, false, kMostFrameSegments, back), std::string(kDisorderedSegments)) << every;
      coder->endBegun();
    }
  }
}

TEST_F(CodecOnDevice, TilesOfLayersThatHaveNoModelsAreRefused) {
  expectSame(marched(shells(), {}, 100, 100), "whose models are there still");
  for (const HostilePayload& hostile : tilesWithoutModels()) {
    SampleFrame head = hostile.head;
    EXPECT_EQ(onDevice_->decode(hostile.payload, hostile.count, head), hostile.sentence) << hostile.what;
  }
}

/// One coder for frames of many sizes and kinds, one after the other.
TEST_F(CodecOnDevice, FramesOfAllKindsInTurns) {
  MarchSettings settings;
  settings.sample.segments = 5;
  for (int round = 0; round < 3; ++round)
    for (const auto& [width, height] : {std::pair(700u, 500u), std::pair(60u, 40u), std::pair(257u, 33u)}) {
      expectSame(marched(shells(), round == 1 ? settings : MarchSettings{}, width, height), "marched");
      expectSame(garbageFrame(width, height, 900, static_cast<uint32_t>(round)), "garbage");
    }
}

TEST_F(CodecOnDevice, SamplesWithoutARadiusAreKnown) {
  SampleFrame frame = garbageFrame(640, 480, 5000, 3);
  for (PackedSample& sample : frame.samples) sample = packCodes(columnOf(sample), rowOf(sample), depthCode(sample), std::max(radiusCode(sample), 1u));
  expectSameThere(frame, "all have one");
  PackedSample& last = frame.samples.back();
  last = packCodes(columnOf(last), rowOf(last), depthCode(last), 0);
  expectSame(frame, "the last has none");
}

/// A stream without values, and models of no layer.
TEST_F(CodecOnDevice, RaysThatEndedWithoutASegment) {
  for (const auto& [width, height] : {std::pair(1u, 1u), std::pair(200u, 90u)})
    for (const bool isFirst : {true, false}) {
      if (isFirst) onDevice_ = std::make_unique<FrameCodec>(makeCudaTiledCoder());
      MarchSettings settings;
      settings.sample.segments = 3;
      SampleFrame frame = marched(shells(), {}, width, height);
      frame.settings = settings;
      frame.settings.sample.proxy = 0;
      frame.segments.rays.assign(size_t{width} * height, RaySegmentCount(0, true));
      expectSame(frame, std::to_string(width));
    }
}

/// Whoever says that there may be several samples a ray, and sends one.
TEST_F(CodecOnDevice, LayersOfRaysWithOneSampleEach) {
  SampleFrame frame = marched(shells(), {}, 90, 70);
  frame.settings.sample.samplesPerRay = 2;
  frame.planes.push_back({std::string(kLayerPlane), PlaneElement::uint8, TransferVector<std::byte>(frame.size(), std::byte{0})});
  expectSame(frame, "zeros");
  frame.settings.sample.samplesPerRay = 0;
  SampleFrame there = headOf(frame);
  frame.settings.sample.samplesPerRay = 1;
  const ByteVector payload = FrameCodec().encode(frame, kTiled);
  EXPECT_NE(onDevice_->decode(payload, frame.size(), there, {.place = DecodedPlace::device}), std::nullopt);
}

/// Of a frame that is nowhere else.
TEST_F(CodecOnDevice, SpheresThatStandForAllAreThoseOfTheHost) {
  const MarcherPtr marcher = makeCudaMarcher(shells(), translucent(*shells()));
  const Camera near = cornerCamera(*shells(), 500, 400);
  for (const auto& [width, height] : {std::pair(530u, 310u), std::pair(9u, 7u), std::pair(1u, 1u)}) {
    const SampleFrame left = marcher->marchToCode(cornerCamera(*shells(), width, height), {}), here = onHost(left);
    cuda::Stream stream;
    DeviceFrame there;
    there.upload(left, stream);
    const SphereLoad expected = SphereLoadProbe(here).loadFor(near), got = SphereSamples().probeOf(left, there.view(), stream).loadFor(near);
    EXPECT_EQ(got.fragments, expected.fragments) << width;
    EXPECT_EQ(got.tiles, expected.tiles) << width;
    EXPECT_EQ(got.spheres, expected.spheres) << width;
    EXPECT_TRUE(expected.fragments > 0.0 || width == 1) << width;
  }
}

/// Coders of many clients share what works for them.
TEST_F(CodecOnDevice, CodersOfManyThreads) {
  MarchSettings settings;
  settings.sample.segments = 3;
  const SampleFrame frames[] = {marched(shells(), settings, 400, 300), marched(shells(), {}, 90, 700), garbageFrame(333, 222, 5000, 1)};
  std::vector<ByteVector> payloads;
  for (const SampleFrame& frame : frames) payloads.push_back(FrameCodec().encode(frame, kTiled));
  std::atomic<int> wrong = 0;
  std::vector<std::thread> threads;
  for (size_t t = 0; t < 6; ++t)
    threads.emplace_back([&, t] {
      FrameCodec codec(makeCudaTiledCoder());
      for (size_t round = 0; round < 12; ++round) {
        const size_t i = (t + round) % std::size(frames);
        SampleFrame back = headOf(frames[i]);
        if (codec.encode(frames[i], kTiled) != payloads[i] || codec.decode(payloads[i], frames[i].size(), back) || !areSame(back, frames[i])) ++wrong;
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace warpscope
