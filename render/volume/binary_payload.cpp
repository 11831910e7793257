// Reading fields.
// See binary_payload.h. Decompression: zlib.
#include "render/volume/binary_payload.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "render/base/input_file.h"
#include "render/base/range.h"
#include "render/volume/payload_parts.h"
#include "render/volume/volume_format.h"

namespace warpscope {
namespace {

namespace fs = std::filesystem;
using Encoding = Payload::Encoding;
using payload_parts::fail;
using payload_parts::fieldAt;
using payload_parts::headOf;
using payload_parts::requirePart;
using payload_parts::wholeFile;

/// The scalar types of the format that a volume can have.
std::optional<VoxelType> niftiVoxelType(int16_t datatype) {
  switch (datatype) {
    case 2:
      return VoxelType::uint8;
    case 4:
      return VoxelType::int16;
    case 8:
      return VoxelType::int32;
    case 16:
      return VoxelType::float32;
    case 64:
      return VoxelType::float64;
    case 256:
      return VoxelType::int8;
    case 512:
      return VoxelType::uint16;
    case 768:
      return VoxelType::uint32;
    default:
      return {};
  }
}

/// Of the twelve in srow_x to srow_z: the rows of a matrix, each with an offset behind.
double entryOfRows(const std::vector<unsigned char>& head, size_t i, bool isTwo, bool swap) {
  return isTwo ? fieldAt<double>(head, 400 + 8 * i, swap) : fieldAt<float>(head, 280 + 4 * i, swap);
}

/// The spacing and both forms of orientation, which ITK hands to code that aborts on NaN, and to a search for singular values in floats that never ends where
/// squares overflow, or where numbers that are hardly any (denormal) stand beside large ones.
bool hasUsableGeometry(const std::vector<unsigned char>& head, bool isTwo, bool swap) {
  constexpr double kLargest = 1e12;  // mm: beyond any volume
  const auto areUsable = [&](size_t offset, size_t count) {
    for (size_t i = 0; i < count; ++i) {
      const double value = isTwo ? fieldAt<double>(head, offset + 8 * i, swap) : fieldAt<float>(head, offset + 4 * i, swap);
      if (!(std::abs(value) <= kLargest)) return false;
    }
    return true;
  };
  double least = std::numeric_limits<double>::infinity(), largest = 0.0;
  for (size_t i = 0; i < 12; ++i) {
    const double value = std::abs(entryOfRows(head, i, isTwo, swap));
    if (i % 4 == 3 || value == 0.0) continue;
    least = std::min(least, value);
    largest = std::max(largest, value);
  }
  if (least < 1e-46 * largest) return false;
  // pixdim[0..3], then quatern_b to srow_z.
  return isTwo ? areUsable(104, 4) && areUsable(352, 18) : areUsable(76, 4) && areUsable(256, 18);
}

/// Whether the columns of srow_x to srow_z, the volume's axes in the world, are far from lying in a plane. The search of ITK's library for the nearest rotation (LINPACK's ssvdc, in single
/// precision) need not end where they nearly do.
bool hasAxesApart(const std::vector<unsigned char>& head, bool isTwo, bool swap) {
  constexpr double kLeastVolume = 1e-4;  // of a parallelepiped of unit edges
  glm::dmat3 axes(0.0);
  for (size_t row = 0; row < 3; ++row)
    for (size_t column = 0; column < 3; ++column) axes[static_cast<int>(column)][static_cast<int>(row)] = entryOfRows(head, 4 * row + column, isTwo, swap);
  for (int column = 0; column < 3; ++column) {
    glm::dvec3& axis = axes[column];
    const double largest = std::max({std::abs(axis.x), std::abs(axis.y), std::abs(axis.z)});
    if (!(largest > 0.0)) return true;  // no axis at all, which the library sees by itself
    axis = glm::normalize(axis / largest);
  }
  return std::abs(glm::determinant(axes)) >= kLeastVolume;
}

/// Throws if the header's extensions, which ITK copies anew for each of them, are too many or too large. They follow the header in `file`, each behind
/// its size and code, up to `endBytes` or the file's end; code that reads them ends at the first of a size that cannot be.
void requireFewExtensions(const fs::path& path, const fs::path& file, uint64_t headerBytes, uint64_t endBytes, bool swap) {
  constexpr size_t kHeadBytes = 8, kSmallest = 16;
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> stream(gzopen(file.string().c_str(), "rb"), gzclose);
  std::vector<unsigned char> head(kHeadBytes);
  const auto read = [&](unsigned count) { return stream && gzread(stream.get(), head.data(), count) == static_cast<int>(count); };
  if (!stream || gzseek(stream.get(), static_cast<z_off_t>(headerBytes), SEEK_SET) < 0 || !read(4) || head[0] == 0) return;
  uint64_t at = headerBytes + 4;
  for (size_t count = 1; at + kSmallest <= endBytes && read(kHeadBytes); ++count) {
    const auto sizeBytes = fieldAt<int32_t>(head, 0, swap);
    if (sizeBytes < static_cast<int32_t>(kSmallest) || sizeBytes % 16 != 0) return;
    at += static_cast<uint64_t>(sizeBytes);
    if (at > endBytes) return;
    if (count > kMaxExtensions || at > headerBytes + kMaxExtensionBytes)
      fail(path, "its header has " + std::to_string(count) + " extensions or more, of " + std::to_string(at - headerBytes - 4) + " bytes so far; at most " +
                     std::to_string(kMaxExtensions) + " and " + sizeText(kMaxExtensionBytes) + " are read");
    if (gzseek(stream.get(), static_cast<z_off_t>(at), SEEK_SET) < 0) return;
  }
}

/// Whether bytes (mode 0) have signs, where the header says it: by IMOD's flag (its stamp stands before it), or as MRC2014 has it from its version on (Cheng et al. 2015).
std::optional<bool> areMrcBytesSigned(const std::vector<unsigned char>& head, bool swap) {
  constexpr int32_t kImodStamp = 1146047817, kMrc2014 = 20140;
  if (fieldAt<int32_t>(head, 152, swap) == kImodStamp) return (fieldAt<int32_t>(head, 156, swap) & 1) != 0;
  if (fieldAt<int32_t>(head, 108, swap) >= kMrc2014) return true;
  return {};
}

/// Whether the header's byte order is not this machine's, told as ITK tells it: by the machine stamp (MACHST) and, in files older than
/// that, by the axes (MAPC, MAPR, MAPS), which are 1 to 3.
bool isMrcSwapped(const std::vector<unsigned char>& head) {
  constexpr unsigned char kBigStamp = 0x11, kLittleStamp = 0x44;
  constexpr bool kIsBigMachine = std::endian::native == std::endian::big;
  const unsigned char stamp = head[212];
  if (stamp == kBigStamp) return !kIsBigMachine;
  if (stamp == kLittleStamp) return kIsBigMachine;
  for (const size_t offset : {64, 68, 72})
    if (const auto axis = fieldAt<int32_t>(head, offset, false); axis < 1 || axis > 3) return true;
  return false;
}

}  // namespace

// --- NIfTI: a binary header of 348 (version 1) or 540 bytes.

Payload locateNifti(const fs::path& path) {
  // Of a pair, the .hdr holds the header and the .img the voxels.
  fs::path header = path, voxels = path;
  const std::string ending = lowered(path.extension().string());
  if (ending == ".img") header.replace_extension(path.extension() == ".IMG" ? ".HDR" : ".hdr");
  if (ending == ".hdr") voxels.replace_extension(path.extension() == ".HDR" ? ".IMG" : ".img");
  requirePart(path, header, "its header " + header.filename().string() + " beside it");
  requirePart(path, voxels, "its voxel file " + voxels.filename().string() + " beside it");

  const std::vector<unsigned char> head = headOf(header, 540);
  if (head.size() < 348) fail(path, "is no NIfTI file: it ends before a header of 348 bytes does");
  const auto size = fieldAt<int32_t>(head, 0, false), swapped = fieldAt<int32_t>(head, 0, true);
  const bool swap = size != 348 && size != 540;
  const int32_t headerBytes = swap ? swapped : size;
  if (headerBytes != 348 && headerBytes != 540) fail(path, "is no NIfTI file: its header has the wrong size");
  const bool isTwo = headerBytes == 540;
  if (isTwo && head.size() < 540) fail(path, "is no NIfTI file: it ends before a header of 540 bytes does");
  const auto signatureAt = [&](size_t offset) { return std::string(reinterpret_cast<const char*>(head.data()) + offset, 3); };
  const std::string magic = signatureAt(isTwo ? 4 : 344), other = signatureAt(isTwo ? 344 : 4);
  // ITK's library goes by what looks like a signature, of any version, in the first version's place, and by other fields then than are looked at here.
  if (other[0] == 'n' && (other[1] == '+' || other[1] == 'i') && other[2] >= '1' && other[2] <= '9')
    fail(path, "is no NIfTI file: its header has the signatures of two versions");
  const bool isSingle = magic == (isTwo ? "n+2" : "n+1"), isPair = magic == (isTwo ? "ni2" : "ni1");
  if (!isSingle && !isPair)
    fail(path, "is no NIfTI file: its header lacks the format's signature n+1, ni1, n+2 or ni2");
  if (isSingle != (header == voxels))
    fail(path, isSingle ? "is a NIfTI file that holds its voxels itself; name it .nii"
                        : "is a NIfTI header without voxels; name it .hdr beside its .img");
  const auto axes = isTwo ? fieldAt<int64_t>(head, 16, swap) : fieldAt<int16_t>(head, 40, swap);
  if (axes < 1 || axes > 7) fail(path, "its header declares " + std::to_string(axes) + " axes; a volume has 3");
  for (int64_t axis = 1; axis <= axes; ++axis) {
    const size_t index = static_cast<size_t>(axis);
    const int64_t side =
        isTwo ? fieldAt<int64_t>(head, 16 + 8 * index, swap) : fieldAt<int16_t>(head, 40 + 2 * index, swap);
    if (side < 1)
      fail(path, "its header declares " + std::to_string(side) + " voxels along axis " + std::to_string(axis));
    if (axis > 3 && side > 1)
      fail(path, "has more than one value a voxel or more than one time point; only single 3D volumes are read");
  }
  const double offset =
      isTwo ? static_cast<double>(fieldAt<int64_t>(head, 168, swap)) : fieldAt<float>(head, 108, swap);
  if (!(offset >= 0.0 && offset < 1e15)) fail(path, "its header states an impossible place of the voxels");
  if (isSingle && offset < headerBytes + 4.0)
    fail(path, "its header states that its voxels begin at byte " + numberText(offset) + ", within the header");
  Payload payload = wholeFile(voxels, static_cast<uint64_t>(isSingle ? std::max(offset, headerBytes + 4.0) : offset));
  const uint64_t extensionsEnd = isSingle ? static_cast<uint64_t>(std::max(offset, headerBytes + 4.0)) : std::numeric_limits<uint64_t>::max();
  requireFewExtensions(path, header, static_cast<uint64_t>(headerBytes), extensionsEnd, swap);
  const auto qform = isTwo ? fieldAt<int32_t>(head, 344, swap) : fieldAt<int16_t>(head, 252, swap);
  const auto sform = isTwo ? fieldAt<int32_t>(head, 348, swap) : fieldAt<int16_t>(head, 254, swap);
  if (header != voxels) payload.others = {header};
  payload.hasOrientation = qform > 0 || sform > 0;
  const auto datatype = isTwo ? fieldAt<int16_t>(head, 12, swap) : fieldAt<int16_t>(head, 70, swap);
  payload.storedType = niftiVoxelType(datatype);
  if (!payload.storedType)
    fail(path, "its voxels have the NIfTI datatype " + std::to_string(datatype) +
                   " (64-bit integers, colours, complex numbers or unknown); only scalars of at most 32-bit integers "
                   "or 64-bit "
                   "floating point are read");
  payload.isBigEndian = swap != (std::endian::native == std::endian::big);
  const double slope = isTwo ? fieldAt<double>(head, 176, swap) : fieldAt<float>(head, 112, swap);
  payload.isDescending = slope < 0.0;
  if (!hasUsableGeometry(head, isTwo, swap)) fail(path, "its header's voxel spacing or orientation is not finite, beyond 10^12, or ranges over more than 10^46");
  if (sform > 0 && !hasAxesApart(head, isTwo, swap)) fail(path, "its header's orientation (srow_x to srow_z) has axes that nearly lie in a plane");
  return payload;
}

// --- MRC: a binary header of 1024 bytes and an extended one of any size.

Payload locateMrc(const fs::path& path) {
  constexpr uint64_t kHeaderBytes = 1024;
  const std::vector<unsigned char> head = headOf(path, kHeaderBytes);
  if (head.size() < kHeaderBytes) fail(path, "is no MRC file: it ends before a header of 1024 bytes does");
  const bool swap = isMrcSwapped(head);
  for (size_t axis = 0; axis < 3; ++axis)
    if (const auto side = fieldAt<int32_t>(head, 4 * axis, swap); side < 1)
      fail(path, "its header declares " + std::to_string(side) + " voxels along axis " + std::to_string(axis + 1));
  const auto extendedBytes = fieldAt<int32_t>(head, 92, swap);  // NSYMBT
  if (extendedBytes < 0)
    fail(path, "its header declares an extended header of " + std::to_string(extendedBytes) + " bytes (NSYMBT); it is damaged");
  const std::array<int32_t, 3> order{fieldAt<int32_t>(head, 64, swap), fieldAt<int32_t>(head, 68, swap), fieldAt<int32_t>(head, 72, swap)};
  if (order != std::array<int32_t, 3>{1, 2, 3} && order != std::array<int32_t, 3>{0, 0, 0})
    fail(path, "its columns, rows and sections lie along the axes " + std::to_string(order[0]) + ", " + std::to_string(order[1]) + ", " + std::to_string(order[2]) +
                   " (MAPC, MAPR, MAPS); only 1, 2, 3 is read");
  Payload payload = wholeFile(path, kHeaderBytes + static_cast<uint64_t>(extendedBytes));
  if (const auto areSigned = areMrcBytesSigned(head, swap); areSigned && fieldAt<int32_t>(head, 12, swap) == 0) payload.storedType = *areSigned ? VoxelType::int8 : VoxelType::uint8;
  std::error_code error;
  const uint64_t fileBytes = fs::file_size(path, error);
  if (!error && payload.encoding == Encoding::plain && payload.offsetBytes > fileBytes)
    fail(path, "its header declares an extended header of " + std::to_string(extendedBytes) + " bytes (NSYMBT), but the file holds " +
                   std::to_string(fileBytes) + " in all; it is cut off or damaged");
  if (static_cast<uint64_t>(extendedBytes) > kMaxExtensionBytes)
    fail(path, "its header declares an extended header of " + std::to_string(extendedBytes) + " bytes (NSYMBT); at most " + sizeText(kMaxExtensionBytes) +
                   " are read");
  return payload;
}

}  // namespace warpscope
