// Devices that fail: memory that runs out, a device that is lost in the middle of its work. The work goes on on the CPU.
// Mirrors app/frames/backend.h, render/march/fallback_marcher.h and render/cuda/check.h.
#include <gtest/gtest.h>

#include "app/frames/backend.h"
#include "render/base/error.h"
#include "render/cuda/devices.h"
#include "render/cuda/memory.h"
#include "render/march/marcher_cuda.h"
#include "render/warp/spheres_warp.h"
#include "render/warp/spheres_warp_cuda.h"
#include "tests/gpu/agreement.h"
#include "tests/gpu/core_probe.h"
#include "tests/gpu/device_memory.h"
#include "tests/headless.h"

namespace warpscope {
namespace {

TEST(DeviceFailure, TooLittleMemoryIsSaidAndPasses) {
  WARPSCOPE_NEEDS_GPU();
  const Scene scene = smallScene("block", 64);
  const MarcherPtr marcher = makeCudaMarcher(scene.volume, scene.transferFunction);
  const Camera small = makeCamera(scene, scene.views.front(), 64, 64);
  const Camera large = makeCamera(scene, scene.views.front(), 8192, 8192);
  const SampleFrame before = marcher->march(small, scene.march);
  {
    const auto taken = takeMemory(size_t{64} << 20);
    try {
      marcher->march(large, scene.march);
      FAIL() << "a frame of 67 million pixels fitted into 64 MiB";
    } catch (const DeviceError& error) {
      EXPECT_NE(std::string(error.what()).find("out of memory"), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find("MiB are free"), std::string::npos) << error.what();
    }
  }
  const SampleFrame after = marcher->march(small, scene.march);  // nothing is broken
  EXPECT_TRUE(before.samples == after.samples);
}

TEST(DeviceFailure, AutomaticGoesOnOnTheCpu) {
  WARPSCOPE_NEEDS_GPU();
  const Scene scene = smallScene("block", 64);
  const MarcherPtr marcher = makeMarcher(Backend::automatic, scene.volume, scene.transferFunction);
  EXPECT_EQ(marcher->backend(), Backend::cuda);
  const auto taken = takeMemory(size_t{32} << 20);
  const SampleFrame frame = marcher->march(makeCamera(scene, scene.views.front(), 3000, 3000), scene.march);
  EXPECT_GT(frame.size(), 100000u);
  EXPECT_EQ(marcher->backend(), Backend::cpu);
}

/// A hierarchy that is built when a picture first wants it does not stand if that failed.
TEST(DeviceFailure, AHierarchyThatFoundNoRoomIsBuiltAgain) {
  WARPSCOPE_NEEDS_GPU();
  const Scene scene = smallScene("shells", 96);
  const MarcherPtr marcher = makeCudaMarcher(scene.volume, scene.transferFunction);
  const auto frame = std::make_shared<SampleFrame>(marcher->march(makeCamera(scene, scene.views.front(), 3000, 3000), scene.march));
  const Camera camera = makeCamera(scene, scene.views.back(), 100, 80);
  const auto settingsOf = [](SphereTracing tracing) {
    WarpSettings settings;
    settings.knobs.set(kSphereTracingKnob, tracing);
    return settings;
  };
  for (const SphereTracing tracing : {SphereTracing::clusters, SphereTracing::lbvh}) {
    const std::unique_ptr<Warp> warp = makeCudaSpheresWarp();
    warp->setFrame(frame, settingsOf(SphereTracing::footprints));
    WarpedImage expected, actual;
    warp->draw(camera, settingsOf(SphereTracing::footprints), expected);
    {
      const auto taken = takeMemory(size_t{8} << 20);
      EXPECT_THROW(warp->draw(camera, settingsOf(tracing), actual), DeviceError);
      EXPECT_THROW(warp->draw(camera, settingsOf(tracing), actual), DeviceError);
    }
    warp->draw(camera, settingsOf(tracing), actual);
    EXPECT_TRUE(expected.samples == actual.samples);
  }
}

/// In a process of its own, whose device is gone afterwards.
void marchOnALostDevice() {
  Stage stage(smallScene("block", 48), gl::Platform::automatic, Backend::automatic);
  const Camera camera = stage.camera(100, 100);
  const SampleFramePtr before = stage.frame(camera, stage.scene().march);
  WarpSettings settings;
  WarpResources resources = stage.resources();
  resources.onFallback = reportFallback;
  const std::unique_ptr<Warp> warp = makeWarp(findWarp("spheres"), resources);
  warp->setFrame(before, settings);
  WarpedImage first, second;
  warp->draw(camera, settings, first);
  if (stage.marcher().backend() != Backend::cuda) std::exit(2);
  if (loseDevice().empty()) std::exit(3);
  const SampleFramePtr after = stage.frame(camera, stage.scene().march);
  if (stage.marcher().backend() != Backend::cpu) std::exit(4);
  if (!(before->samples == after->samples)) std::exit(5);
  warp->draw(camera, settings, second);
  if (!(first.samples == second.samples) || !(first.color == second.color)) std::exit(6);
  std::exit(0);
}

TEST(DeviceFailureDeathTest, ALostDeviceIsLeftForTheCpu) {
  WARPSCOPE_NEEDS_GPU();
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(marchOnALostDevice(), testing::ExitedWithCode(0), "going on with the CPU");
}

}  // namespace
}  // namespace warpscope
