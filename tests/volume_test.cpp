// Geometry checks and statistics of volumes.
// Mirrors render/volume/volume.h.
#include "render/volume/volume.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <cstring>
#include <numeric>
#include <random>

#include "render/base/error.h"

namespace warpscope {
namespace {

template <class T>
constexpr VoxelType voxelTypeFor() {
  VoxelType found{};
  for (int i = 0; i < 8; ++i)
    visitVoxelType(static_cast<VoxelType>(i), [&](auto voxel) {
      if constexpr (std::is_same_v<decltype(voxel), T>) found = static_cast<VoxelType>(i);
    });
  return found;
}

template <class T>
Volume makeVolume(const std::vector<T>& values, VolumeGeometry geometry = {}) {
  if (geometry.dims == glm::uvec3(0)) geometry.dims = {values.size(), 1, 1};
  const auto storage = std::make_shared<std::vector<T>>(values);
  return Volume("test", voxelTypeFor<T>(), geometry, storage, storage->data());
}

template <class T>
class VolumeOfType : public testing::Test {};
using VoxelTypes = testing::Types<uint8_t, int8_t, uint16_t, int16_t, uint32_t, int32_t, float, double>;
TYPED_TEST_SUITE(VolumeOfType, VoxelTypes);

TYPED_TEST(VolumeOfType, StatisticsAgreeWithANaiveCount) {
  constexpr uint32_t kSeed = 7;
  std::mt19937_64 random(kSeed);
  VolumeGeometry geometry;
  geometry.dims = {701, 999, 1};
  std::vector<TypeParam> values(701 * 999);  // several pieces, and a rest
  for (TypeParam& value : values) {
    const uint64_t bits = random();
    if constexpr (std::is_floating_point_v<TypeParam>)
      value = static_cast<TypeParam>((static_cast<double>(bits >> 11) * 0x1p-53 - 0.3) * 1e4);
    else
      std::memcpy(&value, &bits, sizeof(value));
  }
  const VoxelStatistics statistics = makeVolume(values, geometry).statistics();
  const auto [lowest, highest] = std::minmax_element(values.begin(), values.end());
  EXPECT_EQ(statistics.lowest, static_cast<double>(*lowest));
  EXPECT_EQ(statistics.highest, static_cast<double>(*highest));
  EXPECT_EQ(statistics.nonFinite, 0u);
  const bool isByte = std::is_same_v<TypeParam, uint8_t>;
  EXPECT_EQ(statistics.rangeLower, isByte ? 0.0 : statistics.lowest);
  EXPECT_EQ(statistics.rangeUpper, isByte ? 255.0 : statistics.highest);

  std::array<size_t, 256> naive{};
  for (const TypeParam value : values) {
    const long double unit = (static_cast<long double>(value) - statistics.rangeLower) /
                             (static_cast<long double>(statistics.rangeUpper) - statistics.rangeLower);
    // Bytes have a bin each; others 256 bins of equal width.
    ++naive[isByte ? static_cast<size_t>(value) : std::min<size_t>(static_cast<size_t>(unit * 256), 255)];
  }
  size_t moved = 0;
  for (size_t bin = 0; bin < 256; ++bin)
    moved += naive[bin] > statistics.histogram[bin] ? naive[bin] - statistics.histogram[bin]
                                                    : statistics.histogram[bin] - naive[bin];
  EXPECT_LE(moved, values.size() / 10'000) << "seed " << kSeed;  // values on a bin's edge
  EXPECT_EQ(std::accumulate(statistics.histogram.begin(), statistics.histogram.end(), size_t{0}), values.size());
}

TYPED_TEST(VolumeOfType, OneVoxel) {
  const Volume volume = makeVolume(std::vector<TypeParam>{TypeParam{42}});
  EXPECT_EQ(volume.voxelCount(), 1u);
  EXPECT_EQ(volume.sizeBytes(), sizeof(TypeParam));
  EXPECT_EQ(volume.bounds(), (Box{glm::vec3(-0.5f), glm::vec3(0.5f)}));
  EXPECT_EQ(volume.statistics().lowest, 42.0);
  EXPECT_EQ(volume.statistics().highest, 42.0);
}

TYPED_TEST(VolumeOfType, ConstantVolume) {
  const VoxelStatistics statistics = makeVolume(std::vector<TypeParam>(1000, TypeParam{9})).statistics();
  EXPECT_EQ(statistics.lowest, 9.0);
  EXPECT_EQ(statistics.highest, 9.0);
  EXPECT_EQ(statistics.histogram[(std::is_same_v<TypeParam, uint8_t>) ? 9 : 0], 1000u);
}

TEST(Volume, CountsNonFiniteVoxelsAndLeavesThemOut) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const VoxelStatistics statistics = makeVolume(std::vector<float>{nan, 1.0f, -inf, 3.0f, inf, nan}).statistics();
  EXPECT_EQ(statistics.nonFinite, 4u);
  EXPECT_EQ(statistics.lowest, 1.0);
  EXPECT_EQ(statistics.highest, 3.0);
  EXPECT_EQ(statistics.histogram[0], 1u);
  EXPECT_EQ(statistics.histogram[255], 1u);

  const VoxelStatistics none = makeVolume(std::vector<double>(5, std::nan(""))).statistics();
  EXPECT_EQ(none.nonFinite, 5u);
  EXPECT_EQ(none.lowest, 0.0);
  EXPECT_EQ(none.highest, 0.0);
}

TEST(Volume, ExtremeRangesKeepEveryVoxelInTheHistogram) {
  constexpr double kMax = std::numeric_limits<double>::max(), kTiny = std::numeric_limits<double>::denorm_min();
  for (const std::vector<double>& values :
       {std::vector<double>{-kMax, 0.0, kMax}, {0.0, kTiny, 5 * kTiny}, {0.0, 1e-310, 2e-310}}) {
    const VoxelStatistics statistics = makeVolume(values).statistics();
    EXPECT_EQ(std::accumulate(statistics.histogram.begin(), statistics.histogram.end(), size_t{0}), values.size());
  }
  // Large beside their extent: the middle value belongs into the middle.
  const std::vector<double> close{1e15, 1e15 + 0.5, 1e15 + 1.0};
  EXPECT_EQ(makeVolume(close).statistics().histogram[128], 1u);
}

TEST(Volume, AnisotropicSpacingGivesVolumeSpaceInUnitsOfTheSmallestEdge) {
  VolumeGeometry geometry;
  geometry.dims = {4, 2, 3};
  geometry.spacing = {2e-9, 1e-9, 3e-9};
  geometry.origin = {1e7, -1e7, 0.0};
  const Volume volume = makeVolume(std::vector<uint8_t>(24), geometry);
  EXPECT_EQ(volume.geometry().voxelEdges(), glm::vec3(2.0f, 1.0f, 3.0f));
  EXPECT_EQ(volume.bounds(), (Box{{-4.0f, -1.0f, -4.5f}, {4.0f, 1.0f, 4.5f}}));
}

RC_GTEST_PROP(Volume, BoundsAreSymmetricAndIgnoreTheWorldsScale, ()) {
  VolumeGeometry geometry;
  for (int axis = 0; axis < 3; ++axis) {
    geometry.dims[axis] = *rc::gen::inRange<uint32_t>(1, 65536);
    geometry.spacing[axis] = *rc::gen::inRange(1, 1000) * 0.125;
  }
  const Box bounds = geometry.bounds();
  RC_ASSERT(bounds.lower == -bounds.upper);
  geometry.spacing *= 0x1p-30;
  RC_ASSERT(bounds == geometry.bounds());
}

TEST(Validate, RefusesWhatMakesNoSense) {
  VolumeGeometry good;
  good.dims = {2, 3, 4};
  EXPECT_EQ(validate(good, VoxelType::uint8, "x"), 24u);
  const auto refuses = [&](auto change) {
    VolumeGeometry bad = good;
    change(bad);
    EXPECT_THROW(validate(bad, VoxelType::float64, "x"), InputError);
  };
  const double nan = std::nan("");
  refuses([](auto& g) { g.dims.y = 0; });
  refuses([](auto& g) { g.dims.z = 65537; });
  refuses([](auto& g) { g.spacing.x = 0.0; });
  refuses([](auto& g) { g.spacing.x = -1.0; });
  refuses([&](auto& g) { g.spacing.x = nan; });
  refuses([](auto& g) { g.spacing.x = 1e300; });
  refuses([&](auto& g) { g.origin.z = nan; });
  refuses([](auto& g) { g.direction = glm::dmat3(0.0); });
  refuses([&](auto& g) { g.direction[1][1] = nan; });
  refuses([](auto& g) { g.direction[1] = {0.5, 1.0, 0.0}; });              // sheared, with determinant 1
  refuses([](auto& g) { g.direction[0] *= 2.0, g.direction[1] *= 0.5; });  // stretched, with determinant 1
  VolumeGeometry leftHanded = good;
  leftHanded.direction[2] = -leftHanded.direction[2];
  EXPECT_EQ(validate(leftHanded, VoxelType::float64, "x"), 24u);
}

}  // namespace
}  // namespace warpscope
