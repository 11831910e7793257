// Readers: every way in which a file can be wrong, and what a right one says about types, spacing and orientation.
// Mirrors render/volume/reader.h; files are written byte by byte, so that no library vouches for itself.
#include "render/volume/reader.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>

#include "render/base/error.h"
#include "render/volume/payload.h"
#include "tests/reader_fixture.h"
#include "tests/real_data.h"

#if WARPSCOPE_WITH_ITK
#include <sys/stat.h>
#include <zlib.h>
#endif

namespace warpscope {
namespace {

#if !WARPSCOPE_WITH_ITK
TEST_F(Reader, SaysHowToGetItk) { expectRefused(write("a.nrrd", "NRRD0004"), "WARPSCOPE_WITH_ITK=ON"); }
#else

std::vector<int16_t> ramp(int16_t count) {
  std::vector<int16_t> values(static_cast<size_t>(count));
  for (int16_t i = 0; i < count; ++i) values[static_cast<size_t>(i)] = i;
  return values;
}

std::string gzip(const std::string& bytes) {
  z_stream stream{};
  deflateInit2(&stream, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);
  std::string packed(deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<unsigned>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<unsigned>(packed.size());
  deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

/// Bytes that do not compress.
std::string noise(size_t count) {
  std::string bytes(count, '\0');
  uint32_t state = 1;
  for (char& c : bytes) c = static_cast<char>((state = state * 1664525u + 1013904223u) >> 24);
  return bytes;
}

struct Nifti {
  std::array<int16_t, 8> dim{3, 3, 4, 5, 1, 1, 1, 1};
  int16_t datatype = 4, bitpix = 16;
  std::array<float, 4> pixdim{1.0f, 1.0f, 1.0f, 1.0f};
  float slope = 0.0f;
  int16_t sform = 0;
  std::array<float, 12> rows{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  std::string magic{"n+1\0", 4};

  std::string header() const {
    std::string bytes(352, '\0');
    const auto put = [&](size_t offset, const auto& value) {
      std::memcpy(bytes.data() + offset, &value, sizeof(value));
    };
    put(0, int32_t{348}), put(40, dim), put(70, datatype), put(72, bitpix), put(76, pixdim), put(108, 352.0f),
        put(112, slope);
    put(254, sform), put(280, rows);
    std::memcpy(bytes.data() + 344, magic.data(), 4);
    return bytes;
  }
};

std::string nrrdHeader(const std::string& fields) { return "NRRD0004\n" + fields + "\n"; }
const std::string kNrrd = "type: short\ndimension: 3\nsizes: 3 4 5\nendian: little\n";
std::string metaHeader(const std::string& fields) {
  return "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n" + fields +
         "ElementDataFile = LOCAL\n";
}
const std::string kMeta = "DimSize = 3 4 5\nElementType = MET_SHORT\n";
const std::string kVoxels = bytesOf(ramp(60));

void expectRamp(const Volume& volume) {
  EXPECT_EQ(volume.type(), VoxelType::int16);
  EXPECT_EQ(volume.dims(), glm::uvec3(3, 4, 5));
  ASSERT_EQ(volume.sizeBytes(), kVoxels.size());
  EXPECT_EQ(std::memcmp(volume.voxels(), kVoxels.data(), kVoxels.size()), 0);
}

void expectGeometry(const Volume& volume, const glm::dvec3& spacing, const glm::dvec3& origin,
                    const glm::dmat3& direction) {
  const VolumeGeometry& geometry = volume.geometry();
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(geometry.spacing[axis], spacing[axis], 1e-6);
    EXPECT_NEAR(geometry.origin[axis], origin[axis], 1e-5);
    for (int row = 0; row < 3; ++row)
      EXPECT_NEAR(geometry.direction[axis][row], direction[axis][row], 1e-6) << axis << row;
  }
}

TEST_F(Reader, NiftiOrientationBecomesLeftPosteriorSuperior) {
  // Right, anterior, superior in the file: x runs to the left, y to anterior, z up.
  Nifti nifti;
  nifti.sform = 1;
  nifti.pixdim = {1, 2, 3, 4};
  nifti.rows = {-2, 0, 0, 10, 0, 3, 0, 20, 0, 0, 4, 30};
  const glm::dmat3 expected(glm::dvec3(1, 0, 0), glm::dvec3(0, -1, 0), glm::dvec3(0, 0, 1));
  for (const bool packed : {false, true}) {
    const std::string bytes = nifti.header() + kVoxels;
    const VolumePtr volume = openVolume(packed ? write("a.nii.gz", gzip(bytes)) : write("a.nii", bytes));
    expectRamp(*volume);
    expectGeometry(*volume, {2, 3, 4}, {-10, -20, 30}, expected);
    EXPECT_TRUE(volume->geometry().hasOrientation);
  }
  // Flipped: x to the right, z down; and the axes exchanged.
  nifti.rows = {2, 0, 0, 0, 0, 3, 0, 0, 0, 0, -4, 0};
  expectGeometry(*openVolume(write("b.nii", nifti.header() + kVoxels)), {2, 3, 4}, {0, 0, 0},
                 {glm::dvec3(-1, 0, 0), glm::dvec3(0, -1, 0), glm::dvec3(0, 0, -1)});
  nifti.rows = {0, 3, 0, 0, 0, 0, 4, 0, 2, 0, 0, 0};
  expectGeometry(*openVolume(write("c.nii", nifti.header() + kVoxels)), {2, 3, 4}, {0, 0, 0},
                 {glm::dvec3(0, 0, 1), glm::dvec3(-1, 0, 0), glm::dvec3(0, -1, 0)});
  EXPECT_FALSE(openVolume(write("d.nii", Nifti{}.header() + kVoxels))->geometry().hasOrientation);
}

TEST_F(Reader, NiftiKeepsItsStoredTypeThoughItHasASlope) {
  Nifti nifti;
  nifti.slope = 0.25f;
  expectRamp(*openVolume(write("a.nii", nifti.header() + kVoxels)));
  nifti.slope = -2.0f;  // a descending map must not be lost
  const VolumePtr descending = openVolume(write("b.nii", nifti.header() + kVoxels));
  EXPECT_EQ(descending->type(), VoxelType::float32);
  EXPECT_EQ(descending->statistics().lowest, -118.0);
}

TEST_F(Reader, NrrdOrientation) {
  const std::string space = "space directions: (-2,0,0) (0,3,0) (0,0,4)\nspace origin: (10,20,30)\n";
  const VolumePtr ras = openVolume(
      write("a.nrrd", nrrdHeader(kNrrd + "encoding: raw\nspace: right-anterior-superior\n" + space) + kVoxels));
  expectRamp(*ras);
  expectGeometry(*ras, {2, 3, 4}, {-10, -20, 30}, {glm::dvec3(1, 0, 0), glm::dvec3(0, -1, 0), glm::dvec3(0, 0, 1)});
  EXPECT_TRUE(ras->geometry().hasOrientation);
  const VolumePtr lps = openVolume(
      write("b.nrrd", nrrdHeader(kNrrd + "encoding: gzip\nspace: left-posterior-superior\n" + space) + gzip(kVoxels)));
  expectRamp(*lps);
  expectGeometry(*lps, {2, 3, 4}, {10, 20, 30}, {glm::dvec3(-1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1)});
  const VolumePtr none = openVolume(write("c.nrrd", nrrdHeader(kNrrd + "encoding: raw\nspacings: 1 2 3\n") + kVoxels));
  expectGeometry(*none, {1, 2, 3}, {0, 0, 0}, glm::dmat3(1.0));
  EXPECT_FALSE(none->geometry().hasOrientation);
}

TEST_F(Reader, MetaImageOrientation) {
  const VolumePtr turned = openVolume(write(
      "a.mha",
      metaHeader(kMeta + "ElementSpacing = 2 3 4\nOffset = 1 2 3\nTransformMatrix = 0 1 0 -1 0 0 0 0 1\n") + kVoxels));
  expectRamp(*turned);
  expectGeometry(*turned, {2, 3, 4}, {1, 2, 3}, {glm::dvec3(0, 1, 0), glm::dvec3(-1, 0, 0), glm::dvec3(0, 0, 1)});
  EXPECT_TRUE(turned->geometry().hasOrientation);
  // Negative spacing turns the axis round.
  const VolumePtr negative = openVolume(write("b.mha", metaHeader(kMeta + "ElementSpacing = -2 3 4\n") + kVoxels));
  expectGeometry(*negative, {2, 3, 4}, {0, 0, 0}, {glm::dvec3(-1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1)});
  EXPECT_FALSE(negative->geometry().hasOrientation);
}

TEST_F(Reader, DetachedData) {
  write("voxels.raw", kVoxels);
  expectRamp(*openVolume(write("a.nhdr", nrrdHeader(kNrrd + "encoding: raw\ndata file: voxels.raw\n"))));
  std::string meta = metaHeader(kMeta);
  meta.replace(meta.find("LOCAL"), 5, "voxels.raw");
  expectRamp(*openVolume(write("a.mhd", meta)));
  expectRefused(write("b.nhdr", nrrdHeader(kNrrd + "encoding: raw\ndata file: gone.raw\n")), "\"gone.raw\" is missing");
  fs::create_directory(directory_ / "folder.raw");
  fs::create_symlink("circle.raw", directory_ / "circle.raw");
  ASSERT_EQ(mkfifo((directory_ / "pipe.raw").c_str(), 0600), 0);
  const std::pair<std::string, std::string> wrong[] = {
      {"folder.raw", "\"folder.raw\" is a folder"},
      {"circle.raw", "\"circle.raw\" cannot be looked at: "},
      {"pipe.raw", "\"pipe.raw\" is no regular file"},
      {"/dev/zero", "\"/dev/zero\" is no regular file"},
      {std::string(1000, 'n'), "nnn...\" cannot be looked at: "},
      {std::string("gone\0.raw", 9), "zero byte"},
  };
  for (const auto& [name, reason] : wrong) {
    expectRefused(write("c.nhdr", nrrdHeader(kNrrd + "encoding: raw\ndata file: " + name + "\n")), reason);
    std::string other = metaHeader(kMeta);
    other.replace(other.find("LOCAL"), 5, name);
    expectRefused(write("c.mhd", other), reason);
  }
}

/// A library that opens each of many files would wait for a pipe among them.
TEST_F(Reader, VoxelsInSeveralFiles) {
  constexpr size_t kSlice = 3 * 4 * sizeof(int16_t);
  for (size_t i = 0; i < 5; ++i) write("slice" + std::to_string(i) + ".raw", kVoxels.substr(i * kSlice, kSlice));
  const std::string list = "NRRD0004\n" + kNrrd + "encoding: raw\ndata file: LIST\n", pattern = "NRRD0004\n" + kNrrd + "encoding: raw\ndata file: ";
  expectRamp(*openVolume(write("a.nhdr", list + "slice0.raw\nslice1.raw\nslice2.raw\nslice3.raw\nslice4.raw\n")));
  expectRamp(*openVolume(write("b.nhdr", pattern + "slice%d.raw 0 4 1\n")));
  expectRefused(write("gone.nhdr", list + "slice0.raw\nslice1.raw\ngone.raw\nslice3.raw\nslice4.raw\n"), "\"gone.raw\" is missing");
  ASSERT_EQ(mkfifo((directory_ / "slice7.raw").c_str(), 0600), 0);
  expectRefused(write("pipe.nhdr", list + "slice0.raw\nslice1.raw\nslice7.raw\nslice3.raw\nslice4.raw\n"), "\"slice7.raw\" is no regular file");
  expectRefused(write("pattern.nhdr", pattern + "slice%01d.raw 7 3 -1\n"), "\"slice7.raw\" is no regular file");
  expectRefused(write("many.nhdr", pattern + "slice%01d.raw 0 1000000000 1\n"), "more than 4096 data files");
  for (const std::string wrong : {"slice%s.raw 0 4 1", "slice%d.raw 0 4 0", "slice%d.raw", "%n%n%d 0 1 1", "slice%99999d.raw 0 4 1"})
    expectRefused(write("wrong.nhdr", pattern + wrong + "\n"), "known is NAME%03d.raw");
}

/// Editors that leave out the last line's end make such files.
TEST_F(Reader, DetachedHeadersNeedNoLineEndAfterTheirLastLine) {
  write("voxels.raw", kVoxels);
  std::string meta = metaHeader(kMeta);
  meta.replace(meta.find("LOCAL"), std::string::npos, "voxels.raw");
  ASSERT_NE(meta.back(), '\n');
  expectRamp(*openVolume(write("a.mhd", meta)));
  // NrrdIO insists on the line's end; it says so.
  expectRefused(write("a.nhdr", "NRRD0004\n" + kNrrd + "encoding: raw\ndata file: voxels.raw"), "hit end of header");
  write("short.raw", kVoxels.substr(1));
  meta.replace(meta.find("voxels"), 6, "short");
  expectRefused(write("short.mhd", meta), "cut off");
}

/// What is read for a line is bounded: a file of something else costs no memory, and what comes after is still understood or refused.
TEST_F(Reader, HeadersWithEndlessLinesAreRefused) {
  const std::string endless(10'000'000, 'x');
  expectRefused(write("a.vtk", endless), "no VTK file");
  // A reader of whole lines would find the scalars behind the endless one.
  expectRefused(write("b.vtk", "# vtk DataFile Version 3.0\n" + endless + "\nASCII\nSCALARS s short 1\nLOOKUP_TABLE default\n1\n"),
                "no SCALARS");
  expectRefused(write("a.mha", "NDims = 3\nComment = " + endless), "no MetaImage file");
  expectRefused(write("a.nrrd", endless), "does not begin with NRRD000");
}

TEST_F(Reader, OpeningStopsWhenToldTo) {
  std::stop_source stopped;
  stopped.request_stop();
  for (const fs::path& path :
       {write("v_3x4x5_int16.raw", kVoxels), write("a.nii.gz", gzip(Nifti{}.header() + kVoxels)),
        write("a.nrrd", nrrdHeader(kNrrd + "encoding: ascii\n") + "1 2 3"), write("a.mha", metaHeader(kMeta) + kVoxels)})
    EXPECT_THROW(openVolume(path, {}, stopped.get_token()), OperationCancelled) << path;
}

TEST_F(Reader, SpacingBelongsToTheFile) {
  EXPECT_THROW(openVolume(write("a.nii", Nifti{}.header() + kVoxels), glm::dvec3(2.0)), InputError);
}

TEST_F(Reader, NiftiErrors) {
  const auto header = [](auto change) {
    Nifti nifti;
    change(nifti);
    return nifti.header();
  };
  expectRefused(write("tiny.nii", Nifti{}.header().substr(0, 200)), "ends before a header");
  expectRefused(write("magic.nii", header([](auto& n) { n.magic = "oops"; }) + kVoxels), "signature");
  expectRefused(write("noise.nii", noise(5000)), "no NIfTI file");
  expectRefused(write("noise.nii.gz", "\x1f\x8b" + noise(5000)), "no NIfTI file");
  expectRefused(write("short.nii", Nifti{}.header() + kVoxels.substr(1)), "cut off");
  expectRefused(write("none.nii", Nifti{}.header()), "the file holds 0");
  expectRefused(write("huge.nii", header([](auto& n) { n.dim = {3, 32767, 32767, 32767, 1, 1, 1, 1}; }) + kVoxels),
                "cut off");
  expectRefused(write("huge.nii.gz", gzip(header([](auto& n) { n.dim = {3, 32767, 32767, 32767, 1, 1, 1, 1}; }))),
                "cannot hold");
  expectRefused(write("negative.nii", header([](auto& n) { n.dim[1] = -3; }) + kVoxels), "-3 voxels");
  expectRefused(write("axes.nii", header([](auto& n) { n.dim[0] = 9; }) + kVoxels), "9 axes");
  expectRefused(write("times.nii", header([](auto& n) { n.dim[0] = 4, n.dim[4] = 2; }) + kVoxels + kVoxels),
                "time point");
  expectRefused(write("rgb.nii", header([](auto& n) { n.datatype = 128, n.bitpix = 24; }) + noise(180)),
                "datatype 128");
  expectRefused(write("int64.nii", header([](auto& n) { n.datatype = 1024, n.bitpix = 64; }) + noise(480)),
                "datatype 1024");
  expectRefused(write("nan.nii", header([](auto& n) { n.sform = 1, n.rows[0] = NAN; }) + kVoxels), "not finite");
  // Such an orientation keeps ITK's search for singular values going for ever.
  expectRefused(write("endless.nii", header([](auto& n) { n.sform = 1, n.rows[0] = -4.0f, n.rows[1] = -4.15e34f; }) + kVoxels), "beyond 10^12");
  // Likewise, with a number that is hardly one.
  expectRefused(write("denormal.nii", header([](auto& n) { n.sform = 1, n.rows[1] = 1.34e8f, n.rows[6] = 1e-43f; }) + kVoxels), "more than 10^46");
  // Of both versions: the library would go by fields that nobody has looked at.
  std::string both = Nifti{}.header();
  both.resize(544);
  both.replace(0, 7, std::string("\x1c\x02\0\0n+2", 7));
  expectRefused(write("both.nii", both + kVoxels), "signatures of two versions");
  expectRefused(write("flat.nii", header([](auto& n) { n.sform = 1, n.rows.fill(0.0f); }) + kVoxels), "orthonormal");
}

TEST_F(Reader, CompressedFilesThatAreCutOffOrDamaged) {
  Nifti nifti;
  nifti.dim = {3, 50, 40, 50, 1, 1, 1, 1};
  const std::string whole = gzip(nifti.header() + noise(200'000));
  EXPECT_EQ(openVolume(write("whole.nii.gz", whole))->voxelCount(), 100'000u);
  for (const size_t kept : {size_t{40}, whole.size() / 2, whole.size() - 9})
    expectRefused(write("cut.nii.gz", whole.substr(0, kept)), kept == 40 ? "NIfTI" : "damaged");
  expectRefused(write("tail.nii.gz", whole.substr(0, whole.size() - 4)), "damaged");
  std::string flipped = whole;
  flipped[flipped.size() - 7] ^= 1;  // in the checksum
  expectRefused(write("flipped.nii.gz", flipped), "damaged");

  const std::string fields = "type: short\ndimension: 3\nsizes: 50 40 50\nendian: little\nencoding: gzip\n";
  const std::string stream = gzip(noise(200'000));
  expectRefused(write("cut.nrrd", nrrdHeader(fields) + stream.substr(0, stream.size() / 2)), "cut off");
  expectRefused(write("cut.mha", metaHeader("CompressedData = True\nDimSize = 50 40 50\nElementType = MET_SHORT\n") +
                                     stream.substr(0, stream.size() / 2)),
                "cut off");
}

TEST_F(Reader, NrrdErrors) {
  expectRefused(write("noise.nrrd", noise(5000)), "does not begin with NRRD000");
  expectRefused(write("short.nrrd", nrrdHeader(kNrrd + "encoding: raw\n") + kVoxels.substr(3)), "cut off");
  expectRefused(write("text.nrrd", nrrdHeader(kNrrd + "encoding: ascii\n") + "1 2 3"), "holds 3 numbers");
  expectRefused(
      write("huge.nrrd",
            nrrdHeader("type: short\ndimension: 3\nsizes: 60000 60000 60000\nendian: little\nencoding: raw\n")),
      "cut off");
  expectRefused(write("type.nrrd", nrrdHeader("type: quux\ndimension: 3\nsizes: 3 4 5\nencoding: raw\n") + kVoxels),
                "quux");
  expectRefused(write("sides.nrrd", nrrdHeader("type: short\ndimension: 3\nsizes: 3 x 5\nencoding: raw\n") + kVoxels),
                "declares x voxels along axis 2");
  expectRefused(
      write("int64.nrrd",
            nrrdHeader("type: int64\ndimension: 3\nsizes: 3 4 5\nendian: little\nencoding: raw\n") + noise(480)),
      "are not read");
  expectRefused(
      write("vector.nrrd", nrrdHeader("type: short\ndimension: 4\nsizes: 3 3 4 5\nkinds: vector space space space\n"
                                      "endian: little\nencoding: raw\n") +
                               noise(360)),
      "3 values a voxel");
  expectRefused(write("zero.nrrd", nrrdHeader(kNrrd + "encoding: raw\nspacings: 1 2 0\n") + kVoxels), "spacing");
}

TEST_F(Reader, MetaImageErrors) {
  expectRefused(write("noise.mha", noise(5000)), "no MetaImage file");
  expectRefused(write("short.mha", metaHeader(kMeta) + kVoxels.substr(3)), "cut off");
  expectRefused(write("huge.mha", metaHeader("DimSize = 60000 60000 60000\nElementType = MET_SHORT\n") + kVoxels),
                "cut off");
  expectRefused(write("negative.mha", metaHeader("DimSize = -3 4 5\nElementType = MET_SHORT\n") + kVoxels), "DimSize");
  expectRefused(write("axes.mha", metaHeader("DimSize = 3 4\nElementType = MET_SHORT\n") + kVoxels), "do not agree");
  expectRefused(write("type.mha", metaHeader("DimSize = 3 4 5\nElementType = MET_FOO\n") + kVoxels), "are not read");
  expectRefused(write("vector.mha", metaHeader("ElementNumberOfChannels = 3\n" + kMeta) + noise(360)),
                "3 values a voxel");
  expectRefused(write("zero.mha", metaHeader(kMeta + "ElementSpacing = 0 1 1\n") + kVoxels), "spacing");
  expectRefused(write("nan.mha", metaHeader(kMeta + "ElementSpacing = nan 1 1\n") + kVoxels), "finite");
  expectRefused(write("flat.mha", metaHeader(kMeta + "TransformMatrix = 0 0 0 0 0 0 0 0 0\n") + kVoxels),
                "orthonormal");
  std::string list = metaHeader(kMeta);
  list.replace(list.find("LOCAL"), 5, "LIST");
  expectRefused(write("list.mha", list), "several files");
}

TEST_F(Reader, Vtk) {
  const std::string header =
      "# vtk DataFile Version 3.0\nx\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 3 4 5\nSPACING 1 2 3\nORIGIN 0 0 0\n"
      "POINT_DATA 60\nSCALARS s short 1\nLOOKUP_TABLE default\n";
  std::string numbers;
  for (int i = 0; i < 60; ++i) numbers += std::to_string(i) + "\n";
  const VolumePtr volume = openVolume(write("a.vtk", header + numbers));
  expectRamp(*volume);
  expectGeometry(*volume, {1, 2, 3}, {0, 0, 0}, glm::dmat3(1.0));
  expectRefused(write("short.vtk", header + "1 2 3\n"), "holds 3 numbers");
  expectRefused(write("none.vtk", header.substr(0, header.size() - 1)), "Premature EOF");
  expectRefused(write("noise.vtk", noise(5000)), "no VTK file");
}

/// A header of 4 x 4 x 4 voxels of 8 bits that declares `extendedBytes` of an extended one.
std::string mrcHeader(int32_t extendedBytes, bool isBig, bool hasStamp) {
  std::string bytes(1024, '\0');
  const auto put = [&](size_t offset, const auto& value) {
    std::memcpy(bytes.data() + offset, &value, sizeof value);
    if (isBig) std::reverse(bytes.begin() + static_cast<std::ptrdiff_t>(offset), bytes.begin() + static_cast<std::ptrdiff_t>(offset + sizeof value));
  };
  for (size_t axis = 0; axis < 3; ++axis) {
    put(4 * axis, int32_t{4});
    put(28 + 4 * axis, int32_t{4});
    put(40 + 4 * axis, 4.0f);
    put(64 + 4 * axis, static_cast<int32_t>(axis) + 1);
  }
  put(92, extendedBytes);
  bytes.replace(208, 4, "MAP ");
  if (hasStamp) bytes.replace(212, 2, isBig ? "\x11\x11" : "DD");
  return bytes;
}

TEST_F(Reader, Mrc) {
  for (const bool isBig : {false, true})
    for (const bool hasStamp : {true, false}) {
      SCOPED_TRACE(std::string(isBig ? "big" : "little") + (hasStamp ? ", stamped" : ""));
      const std::string voxels = noise(64);
      for (const int32_t extendedBytes : {0, 96}) {
        const std::string bytes = mrcHeader(extendedBytes, isBig, hasStamp) + std::string(static_cast<size_t>(extendedBytes), 'e') + voxels;
        const VolumePtr volume = openVolume(write("a.mrc", bytes));
        EXPECT_EQ(volume->dims(), glm::uvec3(4));
        ASSERT_EQ(volume->sizeBytes(), voxels.size());
        EXPECT_EQ(std::memcmp(volume->voxels(), voxels.data(), voxels.size()), 0);
        expectRefused(write("short.mrc", bytes.substr(0, bytes.size() - 1)), "cut off");
      }
      // ITK takes a size of an extended header on trust and frees memory twice when it cannot be had.
      for (const int32_t impossible : {-1, -2, -256, -1024, std::numeric_limits<int32_t>::min()})
        expectRefused(write("negative.mrc", mrcHeader(impossible, isBig, hasStamp) + voxels), std::to_string(impossible) + " bytes (NSYMBT)");
      for (const int32_t tooMuch : {65, 1 << 24, std::numeric_limits<int32_t>::max()})
        expectRefused(write("large.mrc", mrcHeader(tooMuch, isBig, hasStamp) + voxels), std::to_string(tooMuch) + " bytes (NSYMBT)");
    }
  expectRefused(write("noise.mrc", noise(5000)), "noise.mrc");
  expectRefused(write("head.mrc", mrcHeader(0, false, true).substr(1)), "1024 bytes");
}

/// What libraries take the square of in time, or keep copies of, is limited before they see it.
TEST_F(Reader, HeadersHaveLimits) {
  const auto lines = [](const std::string& line, size_t count) {
    std::string text;
    for (size_t i = 0; i < count; ++i) text += "k" + std::to_string(i) + line;
    return text;
  };
  const std::string nrrd = kNrrd + "encoding: raw\n", meta = "NDims = 3\n" + kMeta;
  const size_t ownLines = 10;
  EXPECT_NO_THROW(openVolume(write("many.nrrd", nrrdHeader(nrrd + lines(":=v\n", kMaxHeaderLines - ownLines)) + kVoxels)));
  const auto start = std::chrono::steady_clock::now();
  expectRefused(write("more.nrrd", nrrdHeader(nrrd + lines(":=v\n", 100'000)) + kVoxels),
                "its header goes on after line 4096, byte");
  expectRefused(write("long.nrrd", nrrdHeader(nrrd + lines(":=" + std::string(60'000, 'v') + "\n", 18)) + kVoxels), "at most 4096 lines and 1 MiB are read");
  expectRefused(write("more.mha", meta + lines(" = v\n", 100'000) + "ElementDataFile = LOCAL\n" + kVoxels), "its header goes on after line 4096, byte");
  expectRefused(write("long.mha", meta + lines(" = " + std::string(60'000, 'v') + "\n", 18) + "ElementDataFile = LOCAL\n" + kVoxels), "1 MiB");

  // MetaIO 5.2 writes beyond arrays of 255 bytes.
  const auto meta300 = [&](const std::string& line) { return metaHeader(kMeta + line + "\n") + kVoxels; };
  for (const std::string& key : {std::string("Comment"), std::string("Name"), std::string("ObjectSubType"), std::string(100, 'k')}) {
    const std::string start = key + " = ";
    EXPECT_NO_THROW(openVolume(write("text.mha", meta300(start + std::string(kMaxTextLine - start.size(), 'v')))));
    for (const char filling : {'v', '1'})
      expectRefused(write("text.mha", meta300(start + "a\n" + start + std::string(300, filling))), "bytes; at most 200 are read");
  }
  for (const std::string& line : {std::string(300, 'k') + " = v", '#' + std::string(5000, 'k') + " = v", "Comment:" + std::string(150, 'k') + "=" + std::string(150, 'v')})
    expectRefused(write("key.mha", meta300(line)), "bytes; at most 200 are read");
  expectRefused(write("long.mha", meta300("TransformMatrix = 1 0 0 0 1 0 0 0 1\nTransformMatrix = 1 x" + std::string(300, 'x'))), "at most 200 are read");
  EXPECT_NO_THROW(openVolume(write("matrix.mha", meta300("TransformMatrix = 1.0" + std::string(300, '0') + " 0 0 0 1 0 0 0 1"))));
  // It would go on reading behind the voxels' begin.
  expectRefused(write("joined.mha", "NDims = 3\nDimSize = 3 4 5\nElementType 2 MET_SHORT\nElementDataFile = LOCAL\n" + kVoxels), "a line without =: \"ElementType 2");
  // A key with a zero byte is another key for the library.
  expectRefused(write("zero.mha", std::string("NDims\0 = 20\nNDims = 3\nDimSize = 3 4 5\nElementType = MET_SHORT\nElementDataFile = LOCAL\n", 86) + kVoxels),
                "its header has a zero byte");
  // Of two the library takes the second, of which nothing was checked: -3 axes made it read numbers for an hour.
  expectRefused(write("twice.mha", "NDims = 3\nDimSize = 3 4 5\nNDims = -3\nElementType = MET_SHORT\nElementDataFile = LOCAL\n" + kVoxels),
                "has ndims twice");

  // A header of 348 bytes and extensions of 16 each.
  const auto extended = [](size_t count, int32_t sizeBytes) {
    std::string bytes = Nifti{}.header();
    const float offset = 352.0f + static_cast<float>(count) * static_cast<float>(sizeBytes);
    std::memcpy(bytes.data() + 108, &offset, sizeof offset);
    bytes[348] = 1;
    std::string extension(static_cast<size_t>(sizeBytes), '\0');
    std::memcpy(extension.data(), &sizeBytes, sizeof sizeBytes);
    for (size_t i = 0; i < count; ++i) bytes += extension;
    return bytes + kVoxels;
  };
  const VolumePtr volume = openVolume(write("many.nii", extended(kMaxExtensions, 16)));
  EXPECT_EQ(std::memcmp(volume->voxels(), kVoxels.data(), kVoxels.size()), 0);
  expectRefused(write("more.nii", extended(kMaxExtensions + 1, 16)), "has 4097 extensions or more, of 65552 bytes so far");
  expectRefused(write("more.nii.gz", gzip(extended(500'000, 16))), "has 4097 extensions or more");
  expectRefused(write("large.nii", extended(2, 16 << 20)), "at most 4096 and 16 MiB are read");

  const int32_t extendedBytes = (16 << 20) + 1;
  expectRefused(write("large.mrc", mrcHeader(extendedBytes, false, true) + std::string(static_cast<size_t>(extendedBytes), 'e') + noise(64)),
                "at most 16 MiB are read");
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
}

TEST_F(Reader, NegativeSizesAreCalledWhatTheyAre) {
  // More than a library's integer holds.
  for (const char* side : {"49000000000000004089650035136921601e", "1e3", "123456789"})
    expectRefused(write("a.nrrd", nrrdHeader("type: short\ndimension: 3\nsizes: 3 " + std::string(side) + " 5\nencoding: raw\n") + kVoxels), "voxels along axis 2");
  expectRefused(write("a.nrrd", nrrdHeader("type: short\ndimension: 3\nsizes: 3 -16 5\nencoding: raw\n") + kVoxels), "declares -16 voxels along axis 2");
  expectRefused(write("a.mha", metaHeader("DimSize = -16 4 5\nElementType = MET_SHORT\n") + kVoxels), "not -16");
  std::string mrc = mrcHeader(0, false, true) + noise(64);
  const int32_t side = -16;
  std::memcpy(mrc.data() + 8, &side, sizeof side);
  expectRefused(write("a.mrc", mrc), "declares -16 voxels along axis 3");
  expectRefused(write("a.vtk", "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 -16 2\nSPACING 1 1 1\nORIGIN 0 0 0\nPOINT_DATA 8\n"
                               "SCALARS s short 1\nLOOKUP_TABLE default\n1 2 3 4 5 6 7 8\n"),
                "declares -16 voxels");
}

/// The file holds what its header declares, as a hole; the machine has not as much memory.
TEST_F(Reader, MoreThanThereIsMemoryIsRefusedBeforeItIsTaken) {
  const std::string nrrd = nrrdHeader("type: uchar\ndimension: 3\nsizes: 16384 16384 8192\nencoding: raw\n");
  const fs::path path = write("honest.nrrd", nrrd);
  std::error_code error;
  fs::resize_file(path, nrrd.size() + (uint64_t{1} << 41), error);
  if (error) GTEST_SKIP() << "no files of 2 TiB here: " << error.message();
  expectRefused(path, "needs 2 TiB of memory, and ");
}

TEST_F(Reader, RealBrain) {
  const RealData brain("spm152.nii.gz");
  if (!brain.whyMissing().empty()) GTEST_SKIP() << brain.whyMissing();
  const VolumePtr volume = openVolume(brain.path());
  EXPECT_EQ(volume->dims(), glm::uvec3(207, 256, 215));
  EXPECT_EQ(volume->type(), VoxelType::uint8);
  EXPECT_NEAR(volume->geometry().spacing.x, 0.737, 1e-3);
  EXPECT_TRUE(volume->geometry().hasOrientation);
  EXPECT_NEAR(volume->geometry().direction[2].z, 1.0, 1e-6);  // the third axis runs up
  EXPECT_EQ(volume->statistics().highest, 250.0);
}
#endif

}  // namespace
}  // namespace warpscope
