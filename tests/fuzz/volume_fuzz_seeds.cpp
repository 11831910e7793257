// Writes what the fuzzers of volume files begin with, into folders of their names in the folder that is its argument.
// Honest files of 2 x 3 x 4 voxels, written byte by byte.
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

namespace {

struct Writer {
  void operator()(const char* fuzzer, const std::string& bytes) {
    const std::filesystem::path to = std::filesystem::path(folder) / fuzzer;
    std::filesystem::create_directories(to);
    std::ofstream(to / std::to_string(number++), std::ios::binary) << bytes;
  }

  const char* folder;
  int number = 0;
};

const std::string kVoxels = "abcdefghijklmnopqrstuvwx";
const std::string kText = "1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24\n";

template <class T>
void put(std::string& bytes, size_t offset, T value) {
  std::memcpy(bytes.data() + offset, &value, sizeof value);
}

void writeNrrd(Writer& write) {
  const std::string plain = "NRRD0004\n# a comment\ntype: uchar\ndimension: 3\nsizes: 2 3 4\nendian: little\n";
  write("nrrd_fuzz", plain + "encoding: raw\n\n" + kVoxels);
  write("nrrd_fuzz", plain + "encoding: ascii\n\n" + kText);
  write("nrrd_fuzz", plain + "encoding: hex\n\n" + kText);
  write("nrrd_fuzz", plain + "encoding: gzip\nbyte skip: 0\nline skip: 0\n\n" + kVoxels);
  write("nrrd_fuzz", plain + "spacings: 1 2 3\nthicknesses: 1 1 1\naxis mins: 0 0 0\naxis maxs: 1 1 1\ncenterings: cell cell cell\nkinds: domain domain domain\nlabels: \"x\" \"y\" \"z\"\n"
                             "units: \"mm\" \"mm\" \"mm\"\nkey:=value\nmodality:=CT\nencoding: raw\n\n" + kVoxels);
  write("nrrd_fuzz", plain + "space: left-posterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (1,2,3)\nspace units: \"mm\" \"mm\" \"mm\"\n"
                             "measurement frame: (1,0,0) (0,1,0) (0,0,1)\nencoding: raw\n\n" + kVoxels);
  write("nrrd_fuzz", plain + "encoding: raw\ndata file: a%02d.raw 1 4 1\n");
  write("nrrd_fuzz", plain + "encoding: raw\ndata file: LIST\na.raw\nb.raw\n");
}

void writeMetaImage(Writer& write) {
  const std::string plain = "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nDimSize = 2 3 4\nElementType = MET_UCHAR\n";
  const std::string local = "ElementDataFile = LOCAL\n";
  write("meta_image_fuzz", plain + local + kVoxels);
  write("meta_image_fuzz", plain + "CompressedData = True\nCompressedDataSize = 20\n" + local + kVoxels);
  write("meta_image_fuzz", plain + "ElementSpacing = 1 2 3\nOffset = 1 2 3\nTransformMatrix = 1 0 0 0 1 0 0 0 1\nCenterOfRotation = 0 0 0\nAnatomicalOrientation = RAI\n" +
                               "ElementNumberOfChannels = 1\nHeaderSize = -1\nModality = MET_MOD_CT\nElementMin = 0\nElementMax = 9\nComment = a\nName = b\nID = 1\nColor = 1 0 0 1\n" +
                               local + kVoxels);
  write("meta_image_fuzz", "NDims = 3\nBinaryData = False\nDimSize = 2 3 4\nElementType = MET_SHORT\n" + local + kText);
  write("meta_image_fuzz", plain + "ElementDataFile = LIST\na.raw\n");
}

void writeMrc(Writer& write) {
  std::string plain(1024, '\0');
  constexpr std::array<int32_t, 3> kSides{2, 3, 4};
  for (size_t axis = 0; axis < 3; ++axis) {
    put(plain, 4 * axis, kSides[axis]);
    put(plain, 28 + 4 * axis, kSides[axis]);
    put(plain, 40 + 4 * axis, static_cast<float>(kSides[axis]));
    put(plain, 64 + 4 * axis, static_cast<int32_t>(axis + 1));
  }
  plain.replace(208, 4, "MAP ");
  plain.replace(212, 2, "DD");
  write("mrc_fuzz", plain + kVoxels);
  std::string extended = plain;
  put(extended, 92, int32_t{16});
  extended.replace(104, 4, "FEI1");
  write("mrc_fuzz", extended + "sixteen bytes of" + kVoxels);
  std::string real = plain;
  put(real, 12, int32_t{2});
  write("mrc_fuzz", real + kVoxels + kVoxels + kVoxels + kVoxels);
  std::string old = plain;
  old.replace(208, 8, std::string(8, '\0'));
  write("mrc_fuzz", old + kVoxels);
}

void writeNifti(Writer& write) {
  std::string one(352, '\0'), two(544, '\0');
  constexpr std::array<int16_t, 8> kDim{3, 2, 3, 4, 1, 1, 1, 1};
  put(one, 0, int32_t{348});
  put(one, 40, kDim);
  put(one, 70, int16_t{2});
  put(one, 72, int16_t{8});
  for (size_t i = 0; i < 4; ++i) put(one, 76 + 4 * i, 1.0f);
  put(one, 108, 352.0f);
  one.replace(344, 3, "n+1");
  write("nifti_fuzz", one + kVoxels);
  std::string oriented = one;
  put(oriented, 252, int16_t{1});
  put(oriented, 254, int16_t{1});
  for (size_t row = 0; row < 3; ++row) put(oriented, 280 + 20 * row, 1.0f);
  put(oriented, 112, 2.0f);
  write("nifti_fuzz", oriented + kVoxels);
  std::string extended = one;
  put(extended, 108, 384.0f);
  extended[348] = 1;
  std::string extension(32, 'e');
  put(extension, 0, int32_t{32});
  put(extension, 4, int32_t{6});
  write("nifti_fuzz", extended + extension + kVoxels);
  put(two, 0, int32_t{540});
  two.replace(4, 8, std::string("n+2\0\r\n\x1a\n", 8));
  put(two, 12, int16_t{2});
  put(two, 14, int16_t{8});
  for (size_t i = 0; i < kDim.size(); ++i) put(two, 16 + 8 * i, static_cast<int64_t>(kDim[i]));
  for (size_t i = 0; i < 4; ++i) put(two, 104 + 8 * i, 1.0);
  put(two, 168, int64_t{544});
  write("nifti_fuzz", two + kVoxels);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: volume_fuzz_seeds FOLDER\n");
    return 2;
  }
  Writer write{argv[1]};
  writeNrrd(write);
  writeMetaImage(write);
  writeMrc(write);
  writeNifti(write);
  return 0;
}
