// What counts in a measurement, what ends it, and which clock each stage goes by.
// Mirrors app/experiment/measuring.h.
#include "app/experiment/measuring.h"

#include <gtest/gtest.h>

#include <thread>

#include "tests/headless.h"
#include "render/codec/proxy_coding.h"

namespace warpscope {
namespace {

/// A technique that takes what it is told to, on a device or not, and counts.
class FakeWarp final : public Warp {
 public:
  class Picture final : public DevicePicture {
   public:
    uint32_t width() const override { return 1; }
    uint32_t height() const override { return 1; }
    void download(std::span<Rgba8>) const override {}
  };

  void setFrame(SampleFramePtr, const WarpSettings&, const std::stop_token& stop) override {
    ++builds;
    sawStop |= stop.stop_possible();
    device.uploadMs = 1.0 * builds;
    device.buildMs = 10.0 * builds;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  void draw(const Camera&, const WarpSettings&, WarpedImage& image, const std::stop_token& stop) override {
    ++draws;
    sawStop |= stop.stop_possible();
    image.color.resize(3, 2);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  DevicePicturePtr drawForScreen(const Camera&, const WarpSettings&, const glm::vec3&, const PixelMarks&, const std::stop_token&) override {
    if (!isOnDevice) return nullptr;
    ++screens;
    device.drawMs = 100.0 * screens;
    return std::make_shared<Picture>();
  }
  std::optional<DeviceTimings> deviceTimings() const override { return isOnDevice ? std::optional(device) : std::nullopt; }

  bool isOnDevice = false;
  int builds = 0, draws = 0, screens = 0;
  bool sawStop = false;
  DeviceTimings device;
};

TEST(Measuring, TheFirstRunDoesNotCount) {
  int calls = 0;
  const auto [first, second] = Measuring(3, {}).parts([&] {
    ++calls;
    return std::array{calls == 1 ? 1000.0 : calls * 1.0, calls == 1 ? 1000.0 : 7.0};
  });
  EXPECT_EQ(calls, 4);
  EXPECT_EQ(first, (Measured{3.0, 1.0}));  // of 2, 3, 4
  EXPECT_EQ(second, (Measured{7.0, 0.0}));
}

TEST(Measuring, TheSpreadIsBetweenTheQuartilesNotBetweenTheExtremes) {
  const double times[] = {0.0, 1.0, 2.0, 3.0, 4.0, 500.0};
  int run = 0;
  EXPECT_EQ(Measuring(5, {}).parts([&] { return std::array{times[run++]}; })[0], (Measured{3.0, 2.0}));
}

TEST(Measuring, TimesByTheHostsClock) {
  const Measured slept = Measuring(3, {}).time([] { std::this_thread::sleep_for(std::chrono::milliseconds(5)); });
  EXPECT_GE(slept.medianMs, 5.0);
}

TEST(Measuring, EndsBetweenTwoRuns) {
  std::stop_source source;
  int calls = 0;
  EXPECT_THROW(Measuring(100, source.get_token()).time([&] {
    if (++calls == 3) source.request_stop();
  }), OperationCancelled);
  EXPECT_EQ(calls, 3);
  EXPECT_THROW(Measuring(1, source.get_token()).time([&] { ++calls; }), OperationCancelled);
  EXPECT_EQ(calls, 3);
}

TEST(Measuring, WorkMayBeToldToEndOrMayNot) {
  const std::stop_source source;
  const glm::vec3 background(0.0f);
  const WarpSettings settings;
  FakeWarp warp;
  WarpedImage image;
  measureBuild(Measuring::inWholeRuns(2, source.get_token()), warp, nullptr, settings);
  measureDraw(Measuring::inWholeRuns(2, source.get_token()), {warp, settings, background}, {}, image);
  EXPECT_FALSE(warp.sawStop);
  measureBuild(Measuring(2, source.get_token()), warp, nullptr, settings);
  EXPECT_TRUE(warp.sawStop);
}

TEST(Measuring, OnTheCpuStagesGoByTheHostsClock) {
  const glm::vec3 background(0.0f);
  const WarpSettings settings;
  FakeWarp warp;
  WarpedImage image;
  const MeasuredBuild build = measureBuild(Measuring(2, {}), warp, nullptr, settings);
  EXPECT_EQ(warp.builds, 3);
  EXPECT_GE(build.build.medianMs, 2.0);
  EXPECT_EQ(build.upload, Measured{});
  const MeasuredDraw draw = measureDraw(Measuring(2, {}), {warp, settings, background}, {}, image);
  EXPECT_EQ(warp.draws, 3);
  EXPECT_GE(draw.draw.medianMs, 2.0);
  EXPECT_FALSE(draw.isOnDevice);
  EXPECT_EQ(image.color.width(), 3u);
  const MeasuredFirstPicture first = measureFirstPicture(Measuring(2, {}), {warp, settings, background}, nullptr, {}, image);
  EXPECT_EQ(warp.builds, 6);
  EXPECT_EQ(warp.draws, 6);
  EXPECT_GE(first.firstPicture.medianMs, 4.0);
  EXPECT_GE(first.firstPicture.medianMs, first.build.build.medianMs);
}

TEST(Measuring, OnADeviceStagesGoByItsEventsAndPicturesStayThere) {
  const glm::vec3 background(0.0f);
  const WarpSettings settings;
  FakeWarp warp;
  warp.isOnDevice = true;
  WarpedImage image;
  const MeasuredBuild build = measureBuild(Measuring(3, {}), warp, nullptr, settings);
  EXPECT_EQ(build.upload, (Measured{3.0, 1.0}));  // 1 warmed up
  EXPECT_EQ(build.build, (Measured{30.0, 10.0}));
  const MeasuredDraw draw = measureDraw(Measuring(3, {}), {warp, settings, background}, {}, image);
  EXPECT_EQ(draw.draw, (Measured{300.0, 100.0}));
  EXPECT_TRUE(draw.isOnDevice);
  EXPECT_EQ(warp.draws, 0);
  EXPECT_TRUE(image.color.empty());
  const MeasuredDraw once = drawOnce({warp, settings, background}, {}, image, {});
  EXPECT_EQ(once.draw, (Measured{500.0, 0.0}));
}

TEST(Measuring, AMarchAndItsWayThroughTheCodec) {
  const Stage stage(smallScene("block"));
  const Camera camera = stage.camera(64, 48);
  const MeasuredMarch march = measureMarch(Measuring(3, {}), stage.marcher(), camera, stage.scene().march);
  const SampleFramePtr expected = stage.frame(camera, stage.scene().march);
  EXPECT_EQ(march.frame->samples, expected->samples);
  EXPECT_GT(march.march.medianMs, 0.0);
  EXPECT_GE(march.samples.medianMs, march.march.medianMs);
  EXPECT_EQ(march.copy, Measured{});  // not on the CPU

  FrameCodec codec;
  CodecSettings lossless, jpeg;
  lossless.color = ColorCoding::lossless;
  jpeg.jpegQuality = 20;
  const MeasuredCoding exact = measureCoding(Measuring(2, {}), codec, march.frame, lossless);
  EXPECT_EQ(exact.frame->samples, expected->samples);
  EXPECT_EQ(exact.frame->colors, expected->colors);
  EXPECT_EQ(exact.bytes.all(), codec.encode(*expected, lossless).size());
  EXPECT_EQ(exact.bytes, codec.bytes());
  EXPECT_EQ(exact.bytes.proxy, proxyBytesOf(*expected->proxy));
  EXPECT_GT(exact.encode.medianMs, 0.0);
  EXPECT_GT(exact.decode.medianMs, 0.0);
  const MeasuredCoding coarse = measureCoding(Measuring(2, {}), codec, march.frame, jpeg);
  EXPECT_EQ(coarse.frame->samples, expected->samples);
  EXPECT_NE(coarse.frame->colors, expected->colors);  // as a client gets them
  EXPECT_EQ(march.frame->colors, expected->colors);
}

TEST(Measuring, APictureIsDecodingBuildingAndDrawing) {
  const Stage stage(smallScene("block"));
  const Camera camera = stage.camera(64, 48);
  const SampleFramePtr frame = stage.frame(camera, stage.scene().march);
  const glm::vec3 background(0.0f);
  const WarpSettings settings;
  FakeWarp warp;
  warp.isOnDevice = true;
  FrameCodec codec;
  const MeasuredPicture picture = measurePicture(Measuring(3, {}), {warp, settings, background}, codec, {}, frame, camera);
  EXPECT_GT(picture.decode.medianMs, 0.0);
  EXPECT_EQ(picture.frameMs(), picture.decode.medianMs + 3.0 + 30.0 + 300.0);
}

}  // namespace
}  // namespace warpscope
