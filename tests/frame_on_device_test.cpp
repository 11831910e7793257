// Frames that were left on a device, with a device that is none.
// Mirrors render/march/frame_on_device.h.
#include "render/march/frame_on_device.h"

#include <gtest/gtest.h>

#include "render/base/error.h"
#include "tests/codec_frames.h"
#include "tests/held_frame.h"

namespace warpscope {
namespace {

std::vector<SampleFrame> framesOfAllKinds() {
  MarchSettings lit, spread;
  lit.sample.segments = 3;
  lit.render.effects.shading.strength = 1.0f;
  spread.sample.sendsSpread = true;
  return {marched(shells(), {}, 80, 50), marched(shells(), lit, 70, 40), marched(shells(), spread, 40, 30), smallLayeredFrame(), garbageFrame(64, 48, 0, 0)};
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

}  // namespace
}  // namespace warpscope
