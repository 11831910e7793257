// What files may not ask of their readers: endless headers, sizes below 0 and beyond integers, more memory than there is.
// Mirrors render/volume/reader.h.
#include "render/volume/reader.h"

#if WARPSCOPE_WITH_ITK

#include <gtest/gtest.h>

#include <chrono>
#include <cstring>
#include <system_error>

#include "render/volume/payload.h"
#include "tests/reader_files.h"

namespace warpscope {
namespace {

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

}  // namespace
}  // namespace warpscope

#endif
