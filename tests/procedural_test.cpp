// Procedural volumes: determinism, any size, and the properties that the scenes count on.
// Mirrors render/volume/procedural.h.
#include "render/volume/procedural.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstring>
#include <numbers>

#include "render/base/error.h"

namespace warpscope {
namespace {

bool sameVoxels(const Volume& a, const Volume& b) {
  return a.dims() == b.dims() && std::memcmp(a.voxels(), b.voxels(), a.sizeBytes()) == 0;
}

uint8_t at(const Volume& volume, uint32_t x, uint32_t y, uint32_t z) {
  return volume.voxelsAs<uint8_t>()[(size_t{z} * volume.dims().y + y) * volume.dims().x + x];
}

class Procedural : public testing::TestWithParam<ProceduralVolume> {};
INSTANTIATE_TEST_SUITE_P(All, Procedural, testing::ValuesIn(kProceduralVolumes), [](const auto& info) {
  std::string name(info.param.name);
  std::erase(name, '-');
  return name;
});

TEST_P(Procedural, SameVoxelsWhateverTheNumberOfThreads) {
  const glm::uvec3 dims{70, 61, 53};
  const VolumePtr parallel = makeProceduralVolume(GetParam().name, dims, 3);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_TRUE(sameVoxels(*parallel, *makeProceduralVolume(GetParam().name, dims, 3)));
}

TEST_P(Procedural, StopsWhenToldTo) {
  std::stop_source stopped;
  stopped.request_stop();
  EXPECT_THROW(makeProceduralVolume(GetParam().name, {70, 61, 53}, 3, stopped.get_token()), OperationCancelled);
}

TEST_P(Procedural, AnySize) {
  for (const glm::uvec3 dims : {glm::uvec3(1), glm::uvec3(2, 1, 3), glm::uvec3(1, 1, 200), glm::uvec3(97, 5, 33)}) {
    const VolumePtr volume = makeProceduralVolume(GetParam().name, dims);
    EXPECT_EQ(volume->dims(), dims);
    EXPECT_EQ(volume->type(), VoxelType::uint8);
  }
}

TEST_P(Procedural, DefaultSizeHasSomethingToSeeAndSpaceAround) {
  const VolumePtr volume = makeProceduralVolume(GetParam().name, GetParam().defaultDims);
  EXPECT_GE(volume->statistics().highest, 200.0);
  const double filled = 1.0 - static_cast<double>(volume->statistics().histogram[0]) / volume->voxelCount();
  EXPECT_GT(filled, 0.01);
  if (GetParam().name != "marschner-lobb") {
    EXPECT_LT(filled, 0.6);
  }
}

TEST_P(Procedural, FeaturesScaleWithTheSize) {
  const glm::uvec3 dims = GetParam().defaultDims / 2u;
  const auto share = [&](const glm::uvec3& size) {
    const VolumePtr volume = makeProceduralVolume(GetParam().name, size);
    size_t filled = 0;
    for (size_t bin = 100; bin < 256; ++bin) filled += volume->statistics().histogram[bin];
    return static_cast<double>(filled) / static_cast<double>(volume->voxelCount());
  };
  EXPECT_NEAR(share(dims) / share(dims * 2u), 1.0, 0.35);
}

TEST(ProceduralErrors, UnknownNameListsTheKnownOnes) {
  try {
    makeProceduralVolume("teapot", glm::uvec3(8));
    FAIL();
  } catch (const InputError& error) {
    const std::string text = error.what();
    for (const ProceduralVolume& volume : kProceduralVolumes)
      EXPECT_NE(text.find(volume.name), std::string::npos) << text;
  }
}

TEST(ProceduralErrors, RefusesImpossibleSizes) {
  EXPECT_THROW(makeProceduralVolume("block", {0, 1, 1}), InputError);
  EXPECT_THROW(makeProceduralVolume("block", {70000, 1, 1}), InputError);
}

TEST(ProceduralVessels, SeedGrowsAnotherTree) {
  EXPECT_FALSE(sameVoxels(*makeProceduralVolume("vessels", glm::uvec3(64), 1),
                          *makeProceduralVolume("vessels", glm::uvec3(64), 2)));
}

TEST(ProceduralVessels, TrunkStandsAtTheBottomWithTheStatedWidth) {
  const VolumePtr volume = makeProceduralVolume("vessels", glm::uvec3(192));
  size_t inside = 0;
  for (uint32_t z = 0; z < 192; ++z)
    for (uint32_t x = 0; x < 192; ++x) inside += at(*volume, x, 2, z) > 75;
  const double diameter = 2.0 * std::sqrt(static_cast<double>(inside) / std::numbers::pi);
  EXPECT_NEAR(diameter, 192.0 / 16.0, 2.0);
  EXPECT_GT(at(*volume, 96, 2, 96), 200);
}

TEST(ProceduralShells, EveryShellSurroundsTheCentreAndNothingTouchesTheFaces) {
  constexpr uint32_t kSide = 160;
  const VolumePtr volume = makeProceduralVolume("shells", glm::uvec3(kSide));
  for (uint32_t u = 0; u < kSide; ++u)
    for (uint32_t v = 0; v < kSide; ++v)
      for (const uint32_t face : {0u, kSide - 1}) {
        ASSERT_EQ(at(*volume, face, u, v), 0);
        ASSERT_EQ(at(*volume, u, face, v), 0);
        ASSERT_EQ(at(*volume, u, v, face), 0);
      }
  // Closed: a flood through zero voxels from a corner does not reach the hollow in the middle.
  std::vector<uint8_t> reached(volume->voxelCount());
  std::vector<glm::ivec3> open{{0, 0, 0}};
  reached[0] = 1;
  while (!open.empty()) {
    const glm::ivec3 p = open.back();
    open.pop_back();
    for (int k = 0; k < 6; ++k) {
      glm::ivec3 q = p;
      q[k / 2] += k % 2 ? 1 : -1;
      if (glm::any(glm::lessThan(q, glm::ivec3(0))) || glm::any(glm::greaterThanEqual(q, glm::ivec3(kSide)))) continue;
      const size_t index = (size_t(q.z) * kSide + size_t(q.y)) * kSide + size_t(q.x);
      if (reached[index] || volume->voxelsAs<uint8_t>()[index] != 0) continue;
      reached[index] = 1;
      open.push_back(q);
    }
  }
  constexpr size_t kMiddle = (size_t{80} * kSide + 80) * kSide + 80;
  EXPECT_EQ(volume->voxelsAs<uint8_t>()[kMiddle], 0);
  EXPECT_FALSE(reached[kMiddle]);
  for (const ShellBand& band : kShellBands) {
    size_t count = 0;
    for (size_t value = band.lower; value <= band.upper; ++value) count += volume->statistics().histogram[value];
    EXPECT_GT(count, 5000u) << int{band.lower};
  }
}

TEST(ProceduralMarschnerLobb, AgreesWithTheFormula) {
  const VolumePtr volume = makeProceduralVolume("marschner-lobb", {41, 40, 39});
  constexpr double kPi = std::numbers::pi;
  for (uint32_t z = 0; z < 39; z += 3)
    for (uint32_t y = 0; y < 40; y += 3)
      for (uint32_t x = 0; x < 41; ++x) {
        const double px = (x + 0.5) / 20.5 - 1.0, py = (y + 0.5) / 20.0 - 1.0, pz = (z + 0.5) / 19.5 - 1.0;
        const double ripple = std::cos(2.0 * kPi * 6.0 * std::cos(kPi * std::hypot(px, py) / 2.0));
        const double signal = (1.0 - std::sin(kPi * pz / 2.0) + 0.25 * (1.0 + ripple)) / 2.5;
        ASSERT_NEAR(at(*volume, x, y, z), 255.0 * signal, 0.5001);
      }
}

TEST(ProceduralBlock, SharpEdgesAndTwoMaterials) {
  const VolumePtr volume = makeProceduralVolume("block", {176, 128, 128});
  const auto& histogram = volume->statistics().histogram;
  EXPECT_GT(histogram[150], 3000u);  // the bushing
  // Voxels of the edge are few beside those of the inside.
  const size_t edge = volume->voxelCount() - histogram[0] - histogram[150] - histogram[255];
  EXPECT_LT(edge * 5, histogram[255]);
}

}  // namespace
}  // namespace warpscope
