// Raw volumes: names, sizes, types, and every way in which these can be wrong; which file is of which format.
// Mirrors what render/volume/reader.h says of raw files, and volume_format.h.
#include <cctype>
#include <cstring>

#include "render/volume/volume_format.h"
#include "tests/reader_fixture.h"

namespace warpscope {
namespace {

TEST(RawName, Parses) {
  const auto name = parseRawName("some/engine_v2_256x255x128_uint8.raw");
  ASSERT_TRUE(name);
  EXPECT_EQ(name->dims, glm::uvec3(256, 255, 128));
  EXPECT_EQ(name->type, VoxelType::uint8);
  EXPECT_EQ(parseRawName("a_1x2x3_float64.RAW")->type, VoxelType::float64);
}

TEST(RawName, OtherFormsAreNoRawNames) {
  for (const char* name : {"engine.raw", "engine_256x256_uint8.raw", "engine_256x256x128.raw", "256x256x128_uint8.nrrd",
                           "e_-1x2x3_uint8.raw", "e_1x2x3_uint8", "", "e_1x2x3x4_uint8.raw"})
    EXPECT_FALSE(parseRawName(name)) << name;
  EXPECT_FALSE(parseRawName(std::string(100'000, 'x') + "_1x1x1_uint8.raw"));
}

TEST(RawName, RefusesOverflowAndUnknownTypes) {
  EXPECT_THROW(parseRawName("a_4294967296x1x1_uint8.raw"), InputError);
  EXPECT_THROW(parseRawName("a_99999999999999999999999x1x1_uint8.raw"), InputError);
  EXPECT_THROW(parseRawName("a_1x1x1_uint9.raw"), InputError);
}

TEST(VolumeFormat, ByTheEndingInEitherCase) {
  for (const VolumeEnding& known : kVolumeEndings) {
    std::string upper("A");
    for (const char c : known.ending) upper += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    EXPECT_EQ(formatOf("some.folder/a" + std::string(known.ending)), known.format) << known.ending;
    EXPECT_EQ(formatOf(upper), known.format) << upper;
    EXPECT_EQ(formatOf(known.ending), std::nullopt) << known.ending << " is all there is of the name";
  }
  for (const char* name : {"", "a", "a.nii.zip", "a.gz", "a.nrrd/", "nrrd", "a.raw "}) EXPECT_EQ(formatOf(name), std::nullopt) << name;
}

TEST_F(Reader, RawOfEveryType) {
  for (int i = 0; i < 8; ++i)
    visitVoxelType(static_cast<VoxelType>(i), [&](auto voxel) {
      using T = decltype(voxel);
      std::vector<T> values(24);
      for (size_t k = 0; k < values.size(); ++k) values[k] = static_cast<T>(k * 5);
      const auto type = static_cast<VoxelType>(i);
      const VolumePtr volume = openVolume(write("v_2x3x4_" + std::string(nameOf(type)) + ".raw", bytesOf(values)));
      EXPECT_EQ(volume->type(), type);
      EXPECT_EQ(volume->dims(), glm::uvec3(2, 3, 4));
      EXPECT_EQ(std::memcmp(volume->voxels(), values.data(), volume->sizeBytes()), 0);
      EXPECT_EQ(volume->statistics().highest, 115.0);
      EXPECT_FALSE(volume->geometry().hasOrientation);
    });
}

TEST_F(Reader, RawTakesItsSpacingFromTheCaller) {
  const fs::path path = write("v_2x1x1_uint8.raw", "ab");
  EXPECT_EQ(openVolume(path, glm::dvec3(1.0, 2.0, 3.5))->geometry().spacing, glm::dvec3(1.0, 2.0, 3.5));
  EXPECT_THROW(openVolume(path, glm::dvec3(1.0, 0.0, 1.0)), InputError);
}

TEST_F(Reader, RawErrors) {
  expectRefused(directory_ / "no_1x1x1_uint8.raw", "there is no such file");
  fs::create_directory(directory_ / "dir_1x1x1_uint8.raw");
  expectRefused(directory_ / "dir_1x1x1_uint8.raw", "is a directory");
  expectRefused(write("empty_1x1x1_uint8.raw", ""), "is empty");
  expectRefused(write("short_3x2x1_uint16.raw", "12345"), "holds 5 bytes, but its name says 3x2x1 uint16 = 12 bytes");
  expectRefused(write("long_1x1x1_uint8.raw", "12"), "holds 2 bytes, but its name says 1x1x1 uint8 = 1 bytes");
  expectRefused(write("misnamed.raw", "1"), "name_256x256x128_uint8.raw");
  expectRefused(write("type_1x1x1_int64.raw", "12345678"), "\"int64\" is not a voxel type; there are uint8");
  expectRefused(write("zero_0x1x1_uint8.raw", "1"), "is empty");
  expectRefused(write("wide_4294967296x1x1_uint8.raw", "1"), "4294967296");
  expectRefused(write("huge_4294967295x4294967295x4294967295_float64.raw", "1"), "at most");
  expectRefused(write("large_65536x65536x65536_float64.raw", "1"), "2251799813685248 bytes");
  expectRefused(write("picture.jpg", "1"), "known are .raw");
}

TEST_F(Reader, Unreadable) {
  const fs::path path = write("v_1x1x1_uint8.raw", "1");
  fs::permissions(path, fs::perms::none);
  if (std::ifstream(path)) GTEST_SKIP() << "this user may read every file";
  expectRefused(path, "cannot be read");
}

TEST(SupportedEndings, RawComesFirst) { EXPECT_EQ(supportedVolumeEndings().front(), ".raw"); }

}  // namespace
}  // namespace warpscope
