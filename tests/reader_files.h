// Headers and voxels of files, made byte by byte, so that no library vouches for itself.
// What tests of the readers for NRRD, MetaImage, NIfTI and MRC share.
#pragma once

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <vector>

#include "tests/reader_fixture.h"

namespace warpscope {

inline std::vector<int16_t> ramp(int16_t count) {
  std::vector<int16_t> values(static_cast<size_t>(count));
  for (int16_t i = 0; i < count; ++i) values[static_cast<size_t>(i)] = i;
  return values;
}

inline std::string gzip(const std::string& bytes) {
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
inline std::string noise(size_t count) {
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

inline std::string nrrdHeader(const std::string& fields) { return "NRRD0004\n" + fields + "\n"; }
inline const std::string kNrrd = "type: short\ndimension: 3\nsizes: 3 4 5\nendian: little\n";
inline std::string metaHeader(const std::string& fields) {
  return "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n" + fields +
         "ElementDataFile = LOCAL\n";
}
inline const std::string kMeta = "DimSize = 3 4 5\nElementType = MET_SHORT\n";
inline const std::string kVoxels = bytesOf(ramp(60));

/// A header of 4 x 4 x 4 voxels of 8 bits that declares `extendedBytes` of an extended one.
inline std::string mrcHeader(int32_t extendedBytes, bool isBig, bool hasStamp) {
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

}  // namespace warpscope
