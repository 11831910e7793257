// A panel's worker and memory: one large frame does not inflate it for good.
// Mirrors app/session/warp_worker.h; what it draws is in session_test.cpp.
#include "app/session/warp_worker.h"

#include <gtest/gtest.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <semaphore>

#include "app/frames/backend.h"
#include "render/base/recent_need.h"
#include "tests/headless.h"

namespace warpscope {
namespace {

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
size_t heldBytes() {
  const struct mallinfo2 info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

class WarpWorkerMemory : public testing::TestWithParam<const char*> {};

TEST_P(WarpWorkerMemory, WhatOneLargeFrameTookIsGivenBack) {
  constexpr size_t kMiB = size_t{1} << 20;
  const Scene scene = smallScene("shells");
  const MarcherPtr marcher = makeMarcher(Backend::cpu, scene.volume, scene.transferFunction);
  std::counting_semaphore<> news(0);
  const std::unique_ptr<WarpWorker> worker =
      makeWarpWorker(gl::Platform::automatic, {.marcher = {}, .context = {}, .backend = Backend::cpu, .onFallback = {}},
                     [&] { news.release(); });
  std::string error;
  const auto paint = [&](uint32_t width, uint32_t height) {
    const Camera camera = makeCamera(scene, scene.views.front(), width, height);
    WarpJob job{.technique = &findWarp(GetParam()),
                .marcher = marcher,
                .frame = {},
                .camera = camera,
                .settings = {},
                .marks = {},
                .reference = {},
                .timedAs = {}};
    job.frame = std::make_shared<const SampleFrame>(
        marcher->twin()->march(camera, scene.march));  // what a marcher keeps is not the worker's
    worker->post(std::move(job));
    news.acquire();
    const std::optional<WarpResult> result = worker->tryTake();
    error = result ? result->error : "no result";
  };
  for (size_t i = 0; i < 4; ++i) paint(64, 64);
  ASSERT_EQ(error, "");
  const size_t before = heldBytes();
  paint(2048, 1024);
  ASSERT_EQ(error, "");
  paint(64, 64);
  const size_t kept = heldBytes();
  EXPECT_GT(kept, before + 4 * kMiB) << "nothing was kept: this test shows nothing";
  for (size_t i = 0; i < RecentNeed::kUses; ++i) paint(64, 64);
  ASSERT_EQ(error, "");
  EXPECT_LT(heldBytes(), before + kMiB + kMiB / 2) << "of " << (kept - before) / kMiB << " MiB";
}

INSTANTIATE_TEST_SUITE_P(Techniques, WarpWorkerMemory, testing::Values("splats", "spheres", "multihit"),
                         [](const auto& info) { return std::string(info.param); });
#endif

}  // namespace
}  // namespace warpscope
