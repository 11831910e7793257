// Readers: every way in which a file can be wrong, and what a right one says about types, spacing and orientation.
// Mirrors render/volume/reader.h; files are written byte by byte, so that no library vouches for itself.
#include "render/volume/reader.h"

#include <cmath>
#include <cstring>
#include <limits>

#include "render/base/error.h"
#include "tests/reader_fixture.h"
#include "tests/real_data.h"

#if WARPSCOPE_WITH_ITK
#include <sys/stat.h>

#include "tests/reader_files.h"
#endif

namespace warpscope {
namespace {

#if !WARPSCOPE_WITH_ITK
TEST_F(Reader, SaysHowToGetItk) { expectRefused(write("a.nrrd", "NRRD0004"), "WARPSCOPE_WITH_ITK=ON"); }
#else

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
  Nifti within;
  std::string bytes = within.header() + kVoxels;
  for (const float offset : {0.0f, 348.0f, 351.0f}) {
    std::memcpy(bytes.data() + 108, &offset, sizeof offset);
    expectRefused(write("within.nii", bytes), "within the header");
  }
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
  expectRefused(write("sheared.nii", header([](auto& n) { n.sform = 1, n.rows[1] = 1.34e8f; }) + kVoxels), "nearly lie in a plane");
  EXPECT_NO_THROW(openVolume(write("unused.nii", header([](auto& n) { n.sform = 0, n.rows[1] = 1.34e8f; }) + kVoxels)));
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
  const auto packed = [](const std::string& more) { return metaHeader("CompressedData = True\n" + more + "DimSize = 50 40 50\nElementType = MET_SHORT\n"); };
  const auto sized = [](uint64_t bytes) { return "CompressedDataSize = " + std::to_string(bytes) + "\n"; };
  EXPECT_EQ(openVolume(write("whole.mha", packed(sized(stream.size())) + stream))->voxelCount(), 100'000u);
  expectRefused(write("cut.mha", packed(sized(stream.size())) + stream.substr(0, stream.size() / 2)), "cut off");
  // The library reads no more than the header says, and leaves the rest 0.
  expectRefused(write("small.mha", packed(sized(stream.size() / 2)) + stream), "bytes, but they take " + std::to_string(stream.size()));
  expectRefused(write("none.mha", packed("") + stream), "lacks CompressedDataSize");
  for (const char* const size : {"-5", "0", "1e3", "many"}) expectRefused(write("odd.mha", packed("CompressedDataSize = " + std::string(size) + "\n") + stream), "number of bytes");
  expectRefused(write("huge.mha", packed(sized(uint64_t{1} << 46)) + stream), "the file holds " + std::to_string(stream.size()));
  write("stream.zraw", stream);
  std::string detached = packed("");
  detached.replace(detached.find("LOCAL"), 5, "stream.zraw");
  EXPECT_EQ(openVolume(write("detached.mhd", detached))->voxelCount(), 100'000u) << "all of that file";
  expectRefused(write("half.mhd", "CompressedDataSize = " + std::to_string(stream.size() / 2) + "\n" + detached), "but they take");
}

TEST_F(Reader, WhatIsWrittenAsTextIsLookedAtWordByWord) {
  std::string numbers;
  for (int i = 0; i < 60; ++i) numbers += std::to_string(i) + (i % 2 == 0 ? " " : ",\n");
  const std::string nrrd = nrrdHeader(kNrrd + "encoding: ascii\n");
  expectRamp(*openVolume(write("a.nrrd", nrrd + numbers)));
  // The library keeps a word in a place of a kilobyte.
  expectRefused(write("long.nrrd", nrrd + std::string(5000, '0') + " " + numbers), "goes on");
  std::string commas = numbers;
  std::erase_if(commas, [](char c) { return c == ' ' || c == '\n'; });
  expectRefused(write("commas.nrrd", nrrd + commas), "goes on");
  write("words.txt", numbers);
  expectRefused(write("list.nhdr", nrrdHeader(kNrrd + "encoding: ascii\ndata file: LIST\nwords.txt\nwords.txt\n")), "several files");
  expectRefused(write("skip.nrrd", nrrdHeader(kNrrd + "encoding: ascii\nline skip: 1\n") + "x\n" + numbers), "skips lines");
  expectRefused(write("skip.nrrd", nrrdHeader(kNrrd + "encoding: ascii\nbyte skip: 2\n") + "x\n" + numbers), "skips bytes");
  const std::string packed = nrrdHeader(kNrrd + "encoding: gzip\nbyte skip: 5\n");
  expectRamp(*openVolume(write("skip.nrrd", packed + gzip("abcde" + kVoxels))));
  expectRefused(write("skip.nrrd", packed + "abcde" + gzip(kVoxels)), "cut off or damaged");
  expectRefused(write("skip.nrrd", nrrdHeader(kNrrd + "encoding: gzip\nline skip: 1\n") + "x\n" + gzip(kVoxels)), "skips lines");
  // The library writes of a field that is wrong what it is, into a place of a kilobyte.
  for (const char* const field : {"type: ", "units: ", "no field "}) expectRefused(write("line.nrrd", nrrdHeader(kNrrd + "encoding: raw\n" + field + std::string(1100, 'a') + "\n") + kVoxels), "at most 512 are read");
  expectRamp(*openVolume(write("content.nrrd", nrrdHeader(kNrrd + "encoding: raw\ncontent: " + std::string(1100, 'a') + "\n# " + std::string(1100, 'a') + "\n") + kVoxels)));

  std::string plain, odd;
  for (int i = 0; i < 60; ++i) plain += std::to_string(i) + "\n";
  const auto meta = [](const std::string& type) { return "ObjectType = Image\nNDims = 3\nBinaryData = False\nDimSize = 3 4 5\nElementType = " + type + "\nElementDataFile = LOCAL\n"; };
  expectRamp(*openVolume(write("a.mha", meta("MET_SHORT") + plain)));
  for (const char* const word : {"nan", "x", "1,5", "0x10", "1e999"}) {
    odd = plain;
    odd.replace(odd.find("\n30\n") + 1, 2, word);
    expectRefused(write("odd.mha", meta("MET_FLOAT") + odd), "its voxel 30 is \"" + std::string(word) + "\", which is no number");
  }
  const auto vtk = [](const std::string& type) {
    return "# vtk DataFile Version 3.0\nx\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 3 4 5\nSPACING 1 2 3\nORIGIN 0 0 0\nPOINT_DATA 60\nSCALARS s " + type + " 1\nLOOKUP_TABLE default\n";
  };
  // What a type does not hold becomes something else, or ends the reading.
  const auto with = [&](const std::string& word) {
    std::string text = plain;
    return text.replace(text.find("\n30\n") + 1, 2, word);
  };
  for (const auto& [name, header] : {std::pair<std::string, std::string>{"odd.nrrd", nrrd}, {"odd.mha", meta("MET_SHORT")}, {"odd.vtk", vtk("short")}}) {
    for (const char* const word : {"40000", "-32769", "99999999999999"}) expectRefused(write(name, header + with(word)), "which its type does not hold");
    expectRefused(write(name, header + with("1.5")), "no whole number");
    expectRefused(write(name, header + with("5x")), "no number");
    expectRefused(write(name, header + with(std::string("3\0004", 3))), "no number");
  }
  expectRefused(write("odd.vtk", vtk("float") + with("1e39")), "does not hold");
  EXPECT_EQ(openVolume(write("whole.mha", meta("MET_SHORT") + with("1e2")))->statistics().highest, 100.0) << "read as a double there";
  EXPECT_EQ(openVolume(write("nan.nrrd", nrrdHeader("type: float\ndimension: 3\nsizes: 3 4 5\nencoding: ascii\n") + with("nan")))->statistics().nonFinite, 1u);
  std::string msb = meta("MET_SHORT");
  expectRefused(write("msb.mha", msb.insert(msb.find("DimSize"), "BinaryDataByteOrderMSB = True\n") + plain), "must be False");
  odd = plain;
  odd.replace(odd.find("\n30\n") + 1, 2, "30.5");
  EXPECT_EQ(openVolume(write("half.vtk", vtk("float") + odd))->statistics().highest, 59.0);
  expectRefused(write("half.vtk", vtk("unsigned_short") + odd), "its voxel 30 is \"30.5\", which is no whole number");
  odd.replace(odd.find("30.5"), 4, "nan ");
  expectRefused(write("nan.vtk", vtk("float") + odd), "no number");
}

TEST_F(Reader, MetaImageFlagsAndSkips) {
  const std::string header = "ObjectType = Image\nNDims = 3\n", rest = kMeta + "ElementDataFile = LOCAL\n";
  for (const char* const yes : {"True", "true", "T", "1"}) expectRamp(*openVolume(write("a.mha", header + "BinaryData = " + yes + "\n" + rest + kVoxels)));
  for (const char* const key : {"BinaryData", "CompressedData", "BinaryDataByteOrderMSB", "ElementByteOrderMSB"})
    expectRefused(write("yes.mha", header + key + " = Yes\n" + rest + kVoxels), "must be True or False, not \"Yes\"");
  std::string detached = header + "BinaryData = True\n" + rest;
  detached.replace(detached.find("LOCAL"), 5, "voxels.raw");
  write("voxels.raw", std::string(20, 'x') + kVoxels);
  expectRamp(*openVolume(write("skip.mhd", "HeaderSize = 20\n" + detached)));
  expectRamp(*openVolume(write("last.mhd", "HeaderSize = -1\n" + detached)));
  for (const char* const skip : {"21", "2000"}) expectRefused(write("skip.mhd", "HeaderSize = " + std::string(skip) + "\n" + detached), "cut off");
  expectRefused(write("skip.mhd", "HeaderSize = -2\n" + detached), "number of bytes");
  expectRefused(write("last.mhd", "HeaderSize = -1\nCompressedData = True\nCompressedDataSize = 9\n" + detached), "the last bytes");
  expectRefused(write("skip.mhd", "HeaderSize = 10\nCompressedData = True\n" + detached), "lacks CompressedDataSize");
  const std::string stream = gzip(kVoxels);
  write("voxels.raw", std::string(20, 'x') + stream);
  expectRamp(*openVolume(write("packed.mhd", "CompressedData = True\nCompressedDataSize = " + std::to_string(stream.size()) + "\nHeaderSize = 20\n" + detached)));
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
  expectRefused(write("untyped.mha", "NDims = 3\nDimSize = 2 2 2\nElementDataFile = LOCAL\n12345678"), "its header lacks ElementType");
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
  // Bytes have signs where the header says so; axes are as they are nearly always.
  const auto withField = [](size_t offset, int32_t value) {
    std::string bytes = mrcHeader(0, false, true);
    std::memcpy(bytes.data() + offset, &value, sizeof value);
    return bytes;
  };
  EXPECT_EQ(openVolume(write("new.mrc", withField(108, 20140) + noise(64)))->type(), VoxelType::int8);
  std::string imod = withField(152, 1146047817);
  EXPECT_EQ(openVolume(write("imod.mrc", imod + noise(64)))->type(), VoxelType::uint8);
  imod[156] = 1;
  EXPECT_EQ(openVolume(write("imod.mrc", imod + noise(64)))->type(), VoxelType::int8);
  expectRefused(write("axes.mrc", withField(64, 3) + noise(64)), "only 1, 2, 3 is read");
  expectRefused(write("head.mrc", mrcHeader(0, false, true).substr(1)), "1024 bytes");
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
