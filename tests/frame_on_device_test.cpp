// Frames that were left on a device, with a device that is none.
// Mirrors render/march/frame_on_device.h.
#include "render/march/frame_on_device.h"

#include <gtest/gtest.h>

#include <thread>

#include "render/base/error.h"
#include "render/codec/plane_coding.h"
#include "tests/codec_frames.h"
#include "tests/held_frame.h"
#include "tests/staying_coder.h"

namespace warpscope {
namespace {

std::vector<SampleFrame> framesOfAllKinds() {
  MarchSettings lit, spread;
  lit.sample.segments = 3;
  lit.render.effects.shading.strength = 1.0f;
  spread.sample.sendsSpread = true;
  // Whoever says that there may be several samples a ray, and sends one.
  SampleFrame zeros = marched(shells(), {}, 60, 40);
  zeros.settings.sample.samplesPerRay = 2;
  zeros.planes.push_back({std::string(kLayerPlane), PlaneElement::uint8, TransferVector<std::byte>(zeros.size(), std::byte{0})});
  return {std::move(zeros), marched(shells(), {}, 80, 50), marched(shells(), lit, 70, 40), marched(shells(), spread, 40, 30), smallLayeredFrame(), garbageFrame(64, 48, 0, 0)};
}

TEST(FrameOnDevice, IsTheSameFrameOnceItIsHere) {
  for (const SampleFrame& frame : framesOfAllKinds()) {
    const SampleFrame left = leftOnDevice(frame);
    EXPECT_EQ(left.size(), frame.size());
    const SampleFrame here = onHost(left);
    EXPECT_EQ(here.device, nullptr);
    EXPECT_FALSE(here.isAway);
    EXPECT_EQ(here.samples, frame.samples);
    EXPECT_EQ(here.colors, frame.colors);
    EXPECT_EQ(here.planes, frame.planes);
    EXPECT_EQ(here.segments.rays, frame.segments.rays);
    EXPECT_EQ(here.segments.depths, frame.segments.depths);
    EXPECT_EQ(here.segments.colors, frame.segments.colors);
    EXPECT_EQ(here.segments.normals, frame.segments.normals);
    EXPECT_EQ(here.camera, frame.camera);
  }
}

TEST(FrameOnDevice, IsCodedAsOneThatIsHere) {
  for (const SampleFrame& frame : framesOfAllKinds())
    for (const CodecSettings& settings : kEveryCoding) {
      FrameCodec codec;
      const ByteVector expected = codec.encode(frame, settings);
      const FrameBytes bytes = codec.bytes();
      EXPECT_TRUE(codec.encode(leftOnDevice(frame), settings) == expected) << nameOf(settings.format);
      EXPECT_EQ(codec.bytes(), bytes);
    }
}

TEST(FrameOnDevice, ThatIsLostIsADevicesError) {
  for (const CodecSettings& settings : kEveryCoding)
    EXPECT_THROW(FrameCodec().encode(leftOnDevice(marched(shells(), {}, 80, 50), true), settings), DeviceError) << nameOf(settings.format);
}

TEST(FrameOnDevice, IsBroughtHereOnceForAllWhoAsk) {
  const auto here = std::make_shared<const SampleFrame>(marched(shells(), {}, 80, 50));
  EXPECT_EQ(onHost(here), here);
  EXPECT_EQ(onHost(SampleFramePtr()), nullptr);
  auto left = std::make_shared<const SampleFrame>(leftOnDevice(*here));
  const SampleFramePtr brought = onHost(left);
  EXPECT_TRUE(areSame(*brought, *here));
  EXPECT_EQ(onHost(left), brought);
  std::vector<std::thread> threads;
  auto fresh = std::make_shared<const SampleFrame>(*left);
  std::vector<SampleFramePtr> got(8);
  for (SampleFramePtr& one : got) threads.emplace_back([&one, &fresh] { one = onHost(fresh); });
  for (std::thread& thread : threads) thread.join();
  for (const SampleFramePtr& one : got) EXPECT_EQ(one, got.front());
  fresh.reset();
  got.clear();
  // The same samples in another frame: who asks gets that one's settings.
  auto other = std::make_shared<SampleFrame>(*left);
  other->functionVersion = 7;
  EXPECT_EQ(onHost(SampleFramePtr(other))->functionVersion, 7u);
  EXPECT_EQ(onHost(left)->functionVersion, 0u);
  // It goes with the frame that it is of, and all others of the same samples.
  const std::weak_ptr<const SampleFrame> last = onHost(left);
  EXPECT_FALSE(last.expired());
  left.reset();
  other.reset();
  EXPECT_TRUE(last.expired());
  EXPECT_THROW(onHost(std::make_shared<const SampleFrame>(leftOnDevice(*here, true))), DeviceError);
}

/// Decoded frames stay with who wants them there, where all of them can.
TEST(FrameOnDevice, IsWhereItsDecoderLeavesIt) {
  for (const SampleFrame& frame : framesOfAllKinds())
    for (const CodecSettings& settings : kEveryCoding) {
      FrameCodec codec(std::make_shared<StayingCoder>());
      const ByteVector payload = codec.encode(frame, settings);
      SampleFrame expected = headOf(frame);
      ASSERT_EQ(FrameCodec().decode(payload, frame.size(), expected), std::nullopt);
      for (const DecodedPlace place : {DecodedPlace::device, DecodedPlace::host, DecodedPlace::device}) {
        SampleFrame back = headOf(frame);
        ASSERT_EQ(codec.decode(payload, frame.size(), back, {.place = place}), std::nullopt);
        const bool mayStay = settings.format == PayloadFormat::tiled && frame.size() > 0 && std::ranges::all_of(frame.planes, isImplied);
        EXPECT_EQ(back.isAway, mayStay && place == DecodedPlace::device) << nameOf(settings.format) << ", " << frame.size();
        EXPECT_EQ(back.size(), frame.size());
        EXPECT_TRUE(areSame(onHost(back), expected)) << nameOf(settings.format) << ", " << frame.size();
      }
    }
}

TEST(FrameOnDevice, WhoseSegmentsAreLostWithTheDeviceIsTakenAgain) {
  MarchSettings settings;
  settings.sample.segments = 3;
  const SampleFrame frame = marched(shells(), settings, 80, 50);
  const ByteVector payload = FrameCodec().encode(frame, kTiled);
  FrameCodec codec(makeFallbackTiledCoder([] { return std::make_shared<StayingCoder>(true); }, {}));
  for (int round = 0; round < 2; ++round) {
    SampleFrame back = headOf(frame);
    ASSERT_EQ(codec.decode(payload, frame.size(), back, {.place = DecodedPlace::device}), std::nullopt);
    EXPECT_FALSE(back.isAway);
    EXPECT_TRUE(areSame(back, frame));
  }
}

}  // namespace
}  // namespace warpscope
