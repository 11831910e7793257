// Masks crop: what they hide is gone and bleeds into nothing, the rest is what it was, and masks of other volumes are refused.
// Mirrors render/volume/masked_volume.h.
#include "render/volume/masked_volume.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "marcher_cases.h"
#include "render/base/error.h"
#include "test_volumes.h"

namespace warpscope {
namespace {

constexpr glm::uvec3 kMaskedDims(12, 10, 8);

double ramp(const glm::ivec3& p) { return p.x + 2.0 * p.y + 3.0 * p.z; }
bool isRight(const glm::ivec3& p) { return p.x >= 6; }

VolumePtr markOf(VoxelType type, const glm::uvec3& dims = kMaskedDims) {
  return makeTestVolume(type, dims, [](const glm::ivec3& p) { return isRight(p) ? 3.0 : 0.0; });
}

std::string refusal(const Volume& volume, const Volume& mask) {
  try {
    masked(volume, mask);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Masked, KeepsValuesWhereTheMaskIsNotZero) {
  for (const VoxelType type : kAllVoxelTypes)
    for (const VoxelType markType : kAllVoxelTypes) {
      const VolumePtr volume = makeTestVolume(type, kMaskedDims, ramp);
      const VolumePtr kept = masked(*volume, *markOf(markType));
      EXPECT_EQ(kept->statistics().nonFinite, volume->voxelCount() / 2) << nameOf(type) << " by " << nameOf(markType);
      EXPECT_EQ(kept->statistics().lowest, 6.0);
      EXPECT_EQ(kept->statistics().highest, volume->statistics().highest);
      EXPECT_EQ(kept->geometry().dims, kMaskedDims);
    }
}

TEST(Masked, LargeWholeNumbersStayWhatTheyAre) {
  const VolumePtr volume = makeTestVolume(VoxelType::int32, kMaskedDims, [](const glm::ivec3& p) { return p.x % 2 ? 2147483647.0 : 16777217.0; });
  const VolumePtr kept = masked(*volume, *markOf(VoxelType::uint8));
  ASSERT_EQ(kept->type(), VoxelType::float64);
  EXPECT_EQ(kept->statistics().highest, 2147483647.0);
  EXPECT_EQ(kept->statistics().lowest, 16777217.0);
}

TEST(Masked, WhatIsHiddenIsNotSeenAndDoesNotBleed) {
  // Bright matter hidden beside dark matter: where they were blended nothing bright may be left.
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, kMaskedDims, [](const glm::ivec3& p) { return isRight(p) ? 10.0 : 200.0; });
  const VolumePtr kept = masked(*volume, *markOf(VoxelType::uint8));
  const TransferFunction brightAlone{{{50.0, {1.0f, 1.0f, 1.0f}, 0.0f}, {51.0, {1.0f, 1.0f, 1.0f}, 0.9f}}};
  const Camera camera = lookingFrom({3.0f, 5.0f, 40.0f}, glm::vec3(0.0f), 60, 60, 0.3f);
  const auto opacityOf = [&](const VolumePtr& shown, const TransferFunction& function) {
    double sum = 0.0;
    const Image<glm::vec4> picture = rendered(*makeCpuMarcher(shown, function), camera, MarchSettings{});
    for (size_t i = 0; i < picture.size(); ++i) sum += picture[i].a;
    return sum;
  };
  EXPECT_GT(opacityOf(volume, brightAlone), 100.0);
  EXPECT_EQ(opacityOf(kept, brightAlone), 0.0);
  const double whole = opacityOf(volume, everywhere(0.9f)), right = opacityOf(kept, everywhere(0.9f));
  EXPECT_GT(right, 0.3 * whole);
  EXPECT_LT(right, 0.7 * whole);
}

TEST(Masked, OtherSizesAndEmptyMasksAreRefused) {
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, kMaskedDims, ramp);
  EXPECT_THAT(refusal(*volume, *markOf(VoxelType::uint8, {12, 10, 9})), ::testing::HasSubstr("differ in size: 12x10x9 voxels and 12x10x8 voxels"));
  EXPECT_THAT(refusal(*volume, *makeTestVolume(VoxelType::uint8, kMaskedDims, [](const glm::ivec3&) { return 0.0; })), ::testing::HasSubstr("leaves nothing of the volume"));
  EXPECT_THAT(refusal(*volume, *makeTestVolume(VoxelType::float32, kMaskedDims, [](const glm::ivec3&) { return std::nan(""); })), ::testing::HasSubstr("leaves nothing"));
}

TEST(Masked, MasksOfOtherPlacesAreRefusedWhereBothSayWhereTheyAre) {
  VolumeGeometry here;
  here.dims = kMaskedDims;
  here.hasOrientation = true;
  VolumeGeometry there = here;
  there.origin.x = 5.0;
  const auto of = [&](const VolumeGeometry& geometry) { return makeTestVolume(VoxelType::uint8, geometry, [](const glm::ivec3& p) { return isRight(p) ? 1.0 : 0.0; }); };
  EXPECT_EQ(refusal(*of(here), *of(here)), "");
  EXPECT_THAT(refusal(*of(here), *of(there)), ::testing::HasSubstr("different places"));
  there.hasOrientation = false;
  EXPECT_EQ(refusal(*of(here), *of(there)), "");
}

}  // namespace
}  // namespace warpscope
