// Wherever a volume is cut, its frames are those of one process, bit for bit: volumes, what is visible of them and numbers of ranks drawn by lot. The ranks are threads here.
// Mirrors render/bricks/brick_tree.h, render/bricks/brick_ranks.h.
#include <gtest/gtest.h>

#include <random>

#include "marcher_cases.h"
#include "spread_cases.h"
#include "spread_volume.h"
#include "test_volumes.h"

namespace warpscope {
namespace {

TEST(SpreadVolume, FramesAreTheSameWhereverItIsCut) {
  std::mt19937 random(19);
  const auto draw = [&](uint32_t from, uint32_t to) { return std::uniform_int_distribution<uint32_t>(from, to)(random); };
  const auto all = variants();
  const std::vector<Camera> views = cameras();
  size_t shown = 0;
  for (uint32_t i = 0; i < 24; ++i) {
    const glm::uvec3 dims(draw(17, 60), draw(17, 60), draw(17, 60));
    const VolumePtr whole = makeTestVolume(i % 2 == 0 ? VoxelType::uint8 : VoxelType::float32, dims, blobs(dims, i));
    const double lower = draw(5, 50);
    const TransferFunction function = band(lower, lower + draw(5, 45), 0.02f * static_cast<float>(draw(1, 40)));
    const auto count = static_cast<int>(draw(2, 16));
    const auto& [name, settings] = all[draw(0, static_cast<uint32_t>(all.size()) - 1)];
    const Camera& camera = views[draw(0, static_cast<uint32_t>(views.size()) - 1)];
    SCOPED_TRACE(testing::Message() << i << ": " << dims.x << "x" << dims.y << "x" << dims.z << " by " << count << ", " << name);
    const Spread spread(whole, function, count);
    const MarcherPtr alone = makeCpuMarcher(whole, function);
    const SampleFrame expected = alone->march(camera, settings);
    shown += expected.size() > 100;
    EXPECT_TRUE(sameFrame(spread->march(camera, settings), expected));
    EXPECT_TRUE(sameBits(rendered(*spread, camera, settings), rendered(*alone, camera, settings)));
  }
  EXPECT_GT(shown, 12u) << "or little was looked at";
}

}  // namespace
}  // namespace warpscope
