// Finds and measures the voxels of a file.
// See payload.h. Decompression: zlib.
#include "render/volume/payload.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "render/base/error.h"
#include "render/base/input_file.h"
#include "render/base/range.h"
#include "render/volume/volume_format.h"

namespace warpscope {
namespace {

namespace fs = std::filesystem;
using Encoding = Payload::Encoding;

[[noreturn]] void fail(const fs::path& path, const std::string& reason) {
  throw InputError(path.string() + ": " + reason);
}

/// Throws unless `part`, which belongs to `path` and is called `name` there, is a file.
void requirePart(const fs::path& path, const fs::path& part, const std::string& name) {
  std::error_code error;
  const fs::file_status status = fs::status(part, error);
  if (status.type() == fs::file_type::regular) return;
  if (status.type() == fs::file_type::not_found) fail(path, name + " is missing");
  if (status.type() == fs::file_type::none) fail(path, name + " cannot be looked at: " + error.message());
  fail(path, name + (status.type() == fs::file_type::directory ? " is a folder" : " is no regular file but a pipe or a device"));
}

std::string trimmed(const std::string& text) {
  const size_t first = text.find_first_not_of(" \t\r");
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// The first bytes of a file, decompressed if it is a gzip file.
std::vector<unsigned char> headOf(const fs::path& path, size_t sizeBytes) {
  std::vector<unsigned char> head(sizeBytes);
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> file(gzopen(path.string().c_str(), "rb"), gzclose);
  const int got = file ? gzread(file.get(), head.data(), static_cast<unsigned>(sizeBytes)) : 0;
  head.resize(got > 0 ? static_cast<size_t>(got) : 0);
  return head;
}

bool isGzip(const fs::path& path) {
  std::array<char, 2> magic{};
  std::ifstream(path, std::ios::binary).read(magic.data(), 2);
  return magic[0] == '\x1f' && magic[1] == '\x8b';
}

/// A file that is either plain or wholly gzipped, with its voxels after `skipBytes`.
Payload wholeFile(const fs::path& path, uint64_t skipBytes) {
  Payload payload{.file = path};
  payload.encoding = isGzip(path) ? Encoding::deflated : Encoding::plain;
  (payload.encoding == Encoding::plain ? payload.offsetBytes : payload.skipBytes) = skipBytes;
  return payload;
}

// --- NIfTI: a binary header of 348 (version 1) or 540 bytes, in either byte order.

template <class T>
T fieldAt(const std::vector<unsigned char>& head, size_t offset, bool swap) {
  std::array<unsigned char, sizeof(T)> bytes;
  std::copy_n(head.begin() + static_cast<std::ptrdiff_t>(offset), sizeof(T), bytes.begin());
  if (swap) std::reverse(bytes.begin(), bytes.end());
  T value;
  std::memcpy(&value, bytes.data(), sizeof(T));
  return value;
}

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

/// The spacing and both forms of orientation, which ITK hands to code that aborts on NaN, and whose search for singular values never ends where squares of
/// these overflow.
bool hasUsableGeometry(const std::vector<unsigned char>& head, bool isTwo, bool swap) {
  constexpr double kLargest = 1e12;  // mm: beyond any volume
  const auto areUsable = [&](size_t offset, size_t count) {
    for (size_t i = 0; i < count; ++i) {
      const double value = isTwo ? fieldAt<double>(head, offset + 8 * i, swap) : fieldAt<float>(head, offset + 4 * i, swap);
      if (!(std::abs(value) <= kLargest)) return false;
    }
    return true;
  };
  // pixdim[0..3], then quatern_b to srow_z.
  return isTwo ? areUsable(104, 4) && areUsable(352, 18) : areUsable(76, 4) && areUsable(256, 18);
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
  const std::string magic(reinterpret_cast<const char*>(head.data()) + (isTwo ? 4 : 344), 3);
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
  Payload payload = wholeFile(voxels, static_cast<uint64_t>(isSingle ? std::max(offset, headerBytes + 4.0) : offset));
  const uint64_t extensionsEnd = isSingle ? static_cast<uint64_t>(std::max(offset, headerBytes + 4.0)) : std::numeric_limits<uint64_t>::max();
  requireFewExtensions(path, header, static_cast<uint64_t>(headerBytes), extensionsEnd, swap);
  const auto qform = isTwo ? fieldAt<int32_t>(head, 344, swap) : fieldAt<int16_t>(head, 252, swap);
  const auto sform = isTwo ? fieldAt<int32_t>(head, 348, swap) : fieldAt<int16_t>(head, 254, swap);
  payload.hasOrientation = qform > 0 || sform > 0;
  const auto datatype = isTwo ? fieldAt<int16_t>(head, 12, swap) : fieldAt<int16_t>(head, 70, swap);
  payload.storedType = niftiVoxelType(datatype);
  if (!payload.storedType)
    fail(path, "its voxels have the NIfTI datatype " + std::to_string(datatype) +
                   " (64-bit integers, colours, complex numbers or unknown); only scalars of at most 32-bit integers "
                   "or 64-bit "
                   "floating point are read");
  const double slope = isTwo ? fieldAt<double>(head, 176, swap) : fieldAt<float>(head, 112, swap);
  payload.isDescending = slope < 0.0;
  if (!hasUsableGeometry(head, isTwo, swap)) fail(path, "its header's voxel spacing or orientation is not finite, or beyond 10^12");
  return payload;
}

// --- NRRD and MetaImage: lines of "key separator value"; the voxels follow or lie in another file.

/// Lines of a header, one after the other. None is longer than any header's, so that a file of something else costs no memory.
class HeaderLines {
 public:
  explicit HeaderLines(const fs::path& path) : file_(path, std::ios::binary) {}

  /// The next line without its end, which the file's last need not have. False when there is none left. Of a line that is too long the
  /// rest comes as another.
  bool next(std::string& line) {
    constexpr size_t kMaxLine = 1 << 16;
    line.clear();
    while (line.size() < kMaxLine) {
      const int c = file_.get();
      if (c == EOF) return !line.empty();
      ++endBytes_;
      if (c == '\n') break;
      line += static_cast<char>(c);
    }
    return true;
  }

  /// Where what was read ends.
  uint64_t endBytes() const { return endBytes_; }

 private:
  std::ifstream file_;
  uint64_t endBytes_ = 0;
};

struct TextHeader {
  std::map<std::string, std::string> fields;  // keys in lower case
  uint64_t endBytes = 0;                      // where the header stops
  std::string excess;                         // what makes it too large to be read; empty if it is not
  std::map<std::string, size_t> longest;      // bytes of each key's longest value: a key may be there several times
  size_t longestKey = 0;                      // bytes before a separator, or of a line without one
};

/// Reads lines up to an empty one, or up to and with the line of `lastKey`.
TextHeader readTextHeader(const fs::path& path, char separator, const std::string& lastKey) {
  HeaderLines lines(path);
  TextHeader header;
  std::string line;
  for (size_t count = 1; lines.next(line); ++count) {
    if (count > kMaxHeaderLines || lines.endBytes() > kMaxHeaderBytes) {
      header.excess = "its header goes on after line " + std::to_string(count - 1) + ", byte " + std::to_string(lines.endBytes() - line.size() - 1) +
                      "; at most " + std::to_string(kMaxHeaderLines) + " lines and " + sizeText(kMaxHeaderBytes) + " are read";
      break;
    }
    if (lastKey.empty() && trimmed(line).empty()) break;
    if (separator == ':' && line[0] == '#') continue;  // NRRD's comments
    const size_t at = line.find(separator);
    header.longestKey = std::max(header.longestKey, std::min(at, line.size()));
    if (at == std::string::npos) continue;
    const std::string key = lowered(trimmed(line.substr(0, at)));
    const std::string value = trimmed(line.substr(at + 1));
    size_t& longest = header.longest[key];
    longest = std::max(longest, value.size());
    header.fields.emplace(key, value);
    if (!lastKey.empty() && key == lastKey) break;
  }
  header.endBytes = lines.endBytes();
  return header;
}

/// The shortest form in which a name is shown.
std::string dataFileText(const std::string& name) {
  constexpr size_t kLongestShown = 80;
  return "its data file \"" + (name.size() > kLongestShown ? name.substr(0, kLongestShown) + "..." : name) + "\"";
}

/// The files that a NRRD header spreads its voxels over: those whose names follow the line "data file: LIST", or "NAME%03d.raw FIRST LAST STEP".
std::vector<std::string> partsOf(const fs::path& path, const std::string& value) {
  std::vector<std::string> names;
  if (lowered(value).starts_with("list")) {
    HeaderLines lines(path);
    bool isListed = false;
    for (std::string line; lines.next(line);) {
      const std::string text = trimmed(line);
      if (isListed && !text.empty()) names.push_back(text);
      const std::string key = lowered(text);
      isListed = isListed || key.starts_with("data file:") || key.starts_with("datafile:");
    }
    return names;
  }
  std::istringstream fields(value);
  std::string name;
  int32_t first = 0, last = 0, step = 0;
  const size_t percent = value.find('%'), letter = value.find_first_not_of("0123456789", percent + 1);
  const std::string digits = letter == std::string::npos ? "" : value.substr(percent + 1, letter - percent - 1);
  if (!(fields >> name >> first >> last >> step) || letter >= name.size() || value[letter] != 'd' || digits.size() > 2 || step == 0 ||
      name.find('%', letter) != std::string::npos)
    fail(path, "its header names its data files as \"" + value.substr(0, 80) + "\"; known is NAME%03d.raw FIRST LAST STEP");
  const size_t width = digits.empty() ? 0 : std::stoul(digits);
  for (int64_t i = first; step > 0 ? i <= last : i >= last; i += step) {
    if (names.size() == kMaxHeaderLines) fail(path, "its header names more than " + std::to_string(kMaxHeaderLines) + " data files, the most that are read");
    std::string number = std::to_string(i);
    if (number.size() < width) number.insert(0, width - number.size(), '0');
    names.push_back(name.substr(0, percent) + number + name.substr(letter + 1));
  }
  return names;
}

/// Sets the data file of a detached header; false for a list or a pattern of files, whose sizes are left unchecked.
bool followDetached(const fs::path& path, const std::string& name, Payload& payload) {
  if (lowered(name).starts_with("list") || name.find('%') != std::string::npos) {
    payload.encoding = Encoding::unchecked;
    return false;
  }
  if (name.find('\0') != std::string::npos) fail(path, "its header has a zero byte in the name of its data file");
  payload.file = path.parent_path() / name;
  payload.offsetBytes = 0;
  requirePart(path, payload.file, dataFileText(name));
  return true;
}

Payload locateNrrd(const fs::path& path) {
  std::string magic;
  HeaderLines(path).next(magic);
  if (!magic.starts_with("NRRD000")) fail(path, "is no NRRD file: it does not begin with NRRD000");
  const TextHeader header = readTextHeader(path, ':', "");
  if (!header.excess.empty()) fail(path, header.excess);
  const auto valueOf = [&](const char* key) {
    const auto field = header.fields.find(key);
    return field == header.fields.end() ? std::string() : lowered(field->second);
  };
  std::istringstream sizes(valueOf("sizes"));
  std::string side;
  for (int axis = 1; sizes >> side; ++axis)  // a library that reads these without their sign would take them for huge
    if (side.starts_with('-')) fail(path, "its header declares " + side.substr(0, 40) + " voxels along axis " + std::to_string(axis));
  Payload payload{.file = path, .offsetBytes = header.endBytes};
  const std::string encoding = valueOf("encoding");
  payload.encoding = encoding == "raw"                                                ? Encoding::plain
                     : encoding == "gzip" || encoding == "gz"                         ? Encoding::deflated
                     : encoding == "txt" || encoding == "text" || encoding == "ascii" ? Encoding::text
                                                                                      : Encoding::unchecked;
  const std::string space = valueOf("space");
  payload.hasOrientation = space.starts_with("left-") || space.starts_with("right-") || space.starts_with("scanner") ||
                           space == "ras" || space == "las" || space == "lps";
  for (const char* key : {"data file", "datafile"})
    if (const auto field = header.fields.find(key); field != header.fields.end())
      if (!followDetached(path, field->second, payload)) {
        for (const std::string& name : partsOf(path, field->second)) requirePart(path, path.parent_path() / name, dataFileText(name));
        return payload;
      }
  // Skips make room for foreign headers; -1 means "the last bytes", for which a size check is all that is left.
  for (const char* key : {"line skip", "lineskip"})
    if (!valueOf(key).empty() && valueOf(key) != "0") payload.encoding = Encoding::unchecked;
  for (const char* key : {"byte skip", "byteskip"}) {
    const std::string skip = valueOf(key);
    if (skip.empty() || skip == "0") continue;
    if (skip == "-1")
      payload.offsetBytes = 0;
    else if (payload.encoding == Encoding::plain && skip.find_first_not_of("0123456789") == std::string::npos &&
             skip.size() < 16)
      payload.offsetBytes += std::stoull(skip);
    else
      payload.encoding = Encoding::unchecked;
  }
  return payload;
}

Payload locateMetaImage(const fs::path& path) {
  const TextHeader header = readTextHeader(path, '=', "elementdatafile");
  const auto dataFile = header.fields.find("elementdatafile");
  if (!header.excess.empty() && header.fields.contains("ndims") && header.fields.contains("dimsize")) fail(path, header.excess);
  if (!header.fields.contains("ndims") || !header.fields.contains("dimsize") || dataFile == header.fields.end())
    fail(path, "is no MetaImage file: its header lacks NDims, DimSize or ElementDataFile");
  if (header.longestKey > kMaxKeyBytes)
    fail(path, "its header has a key of " + std::to_string(header.longestKey) + " bytes; at most " + std::to_string(kMaxKeyBytes) + " are read");
  // Of what follows numbers are asked for, or a file's name.
  const auto mayBeLong = [](const std::string& key) {
    for (const char* known : {"elementdatafile", "dimsize", "elementspacing", "elementsize", "offset", "origin", "position", "centerofrotation", "transformmatrix",
                              "rotation", "orientation"})
      if (key == known) return true;
    return false;
  };
  for (const auto& [key, sizeBytes] : header.longest)
    if (sizeBytes > kMaxKeyBytes && !mayBeLong(key))
      fail(path, "its header's " + key + " is a text of " + std::to_string(sizeBytes) + " bytes; at most " + std::to_string(kMaxKeyBytes) + " are read");
  std::istringstream sides(header.fields.at("dimsize"));
  std::vector<double> dims{std::istream_iterator<double>(sides), {}};
  if (std::to_string(dims.size()) != header.fields.at("ndims") || dims.empty() || dims.size() > 7)
    fail(path, "its header's DimSize and NDims do not agree");
  for (const double side : dims)
    if (!(side >= 1.0 && side <= 65536.0))
      fail(path, "its header's DimSize must be between 1 and 65536 along every axis, not " + numberText(side));
  // MetaIO takes "nan" for the end of the line and reports it on stderr.
  const auto requireNumbers = [&](const char* key, size_t count) {
    const auto field = header.fields.find(key);
    if (field == header.fields.end()) return;
    std::istringstream text(field->second);
    const std::vector<double> numbers{std::istream_iterator<double>(text), {}};
    if (numbers.size() != count || !text.eof())
      fail(path, "its header's " + std::string(key) + " must be " + std::to_string(count) + " finite numbers");
  };
  for (const char* key : {"elementspacing", "offset", "origin", "position"}) requireNumbers(key, dims.size());
  for (const char* key : {"transformmatrix", "rotation", "orientation"}) requireNumbers(key, dims.size() * dims.size());
  const auto isTrue = [&](const char* key) {
    const auto field = header.fields.find(key);
    return field != header.fields.end() && lowered(field->second).starts_with("t");
  };
  Payload payload{.file = path, .offsetBytes = header.endBytes};
  const auto binary = header.fields.find("binarydata");
  const bool isText = binary != header.fields.end() && lowered(binary->second).starts_with("f");
  payload.encoding = isText ? Encoding::text : isTrue("compresseddata") ? Encoding::deflated : Encoding::plain;
  for (const char* key : {"transformmatrix", "orientation", "rotation", "anatomicalorientation"})
    if (const auto field = header.fields.find(key); field != header.fields.end() && !field->second.starts_with("?"))
      payload.hasOrientation = true;
  if (lowered(dataFile->second) != "local" && !followDetached(path, dataFile->second, payload))
    fail(path, "spreads its voxels over several files, which ITK reads unchecked; convert it to a single .mha file");
  if (const auto size = header.fields.find("headersize"); size != header.fields.end() && size->second != "0")
    payload.offsetBytes = 0;
  return payload;
}

// --- VTK legacy: lines of text up to LOOKUP_TABLE, or to SCALARS where that is left out.

Payload locateVtk(const fs::path& path) {
  HeaderLines lines(path);
  Payload payload{.file = path, .encoding = Encoding::plain};
  constexpr int kMaxLines = 64;
  std::string line;
  for (int i = 0; i < kMaxLines && lines.next(line); ++i) {
    const std::string text = lowered(trimmed(line));
    if (i == 0 && !text.starts_with("# vtk datafile"))
      fail(path, "is no VTK file: it does not begin with # vtk DataFile");
    if (text == "ascii") payload.encoding = Encoding::text;
    if (text.starts_with("dimensions"))
      if (const size_t minus = text.find('-'); minus != std::string::npos)
        fail(path, "its header declares " + text.substr(minus, std::min<size_t>(40, text.find_first_of(" \t", minus) - minus)) + " voxels along an axis");
    const bool isTable = text.starts_with("lookup_table");
    if (isTable || text.starts_with("scalars")) payload.offsetBytes = lines.endBytes();
    if (isTable) break;
  }
  if (payload.offsetBytes == 0) fail(path, "holds no SCALARS, the only VTK attribute that is read");
  return payload;
}

// --- MRC: a binary header of 1024 bytes and an extended one of any size.

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
  const Payload payload = wholeFile(path, kHeaderBytes + static_cast<uint64_t>(extendedBytes));
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

/// Words in the text from `payload.offsetBytes` on, counted no further than `enough`.
uint64_t countWords(const Payload& payload, uint64_t enough, const std::stop_token& stop) {
  std::ifstream file(payload.file, std::ios::binary);
  file.seekg(static_cast<std::streamoff>(payload.offsetBytes));
  std::vector<char> piece(1 << 16);
  uint64_t words = 0;
  bool inWord = false;
  while (words < enough && file) {
    if (stop.stop_requested()) throw OperationCancelled();
    file.read(piece.data(), static_cast<std::streamsize>(piece.size()));
    for (std::streamsize i = 0; i < file.gcount(); ++i) {
      const bool isBlank = piece[static_cast<size_t>(i)] <= ' ' || piece[static_cast<size_t>(i)] == ',';
      words += !isBlank && !inWord;
      inWord = !isBlank;
    }
  }
  return words;
}

/// Bytes in the deflated payload, counted no further than `enough`. `isWhole` tells whether the stream ended or
/// sufficed undamaged.
uint64_t countInflated(const Payload& payload, uint64_t enough, const std::stop_token& stop, bool& isWhole) {
  constexpr size_t kPiece = 1 << 18;
  std::vector<unsigned char> in(kPiece), out(kPiece);
  std::ifstream file(payload.file, std::ios::binary);
  file.seekg(static_cast<std::streamoff>(payload.offsetBytes));
  z_stream stream{};
  if (inflateInit2(&stream, 15 + 32) != Z_OK) throw std::bad_alloc();  // + 32: gzip or zlib, whichever it is
  const std::unique_ptr<z_stream, int (*)(z_stream*)> end(&stream, inflateEnd);
  uint64_t total = 0;
  int state = Z_OK;
  isWhole = false;
  while (true) {
    if (stop.stop_requested()) throw OperationCancelled();
    if (stream.avail_in == 0) {
      file.read(reinterpret_cast<char*>(in.data()), kPiece);
      stream.next_in = in.data();
      stream.avail_in = static_cast<unsigned>(file.gcount());
      if (stream.avail_in == 0) break;
    }
    if (state == Z_STREAM_END) {
      // Members of a gzip file may follow one another; anything else after the end is padding.
      if (total >= enough || stream.next_in[0] != 0x1f || inflateReset(&stream) != Z_OK) break;
    }
    stream.next_out = out.data();
    stream.avail_out = kPiece;
    state = inflate(&stream, Z_NO_FLUSH);
    total += kPiece - stream.avail_out;
    if (state != Z_OK && state != Z_STREAM_END && state != Z_BUF_ERROR) return total;
    // A bomb, or a file with more after the volume: what follows is not read.
    if (total > enough + (uint64_t{1} << 26)) break;
  }
  isWhole = state == Z_STREAM_END || total > enough;
  return total;
}

}  // namespace

Payload locatePayload(const fs::path& path) {
  switch (formatOf(path).value_or(VolumeFormat::raw)) {
    case VolumeFormat::nifti:
      return locateNifti(path);
    case VolumeFormat::nrrd:
      return locateNrrd(path);
    case VolumeFormat::metaImage:
      return locateMetaImage(path);
    case VolumeFormat::gipl:
      return wholeFile(path, 256);
    case VolumeFormat::vtk:
      return locateVtk(path);
    case VolumeFormat::mrc:
      return locateMrc(path);
    case VolumeFormat::raw:
      break;
  }
  return {.file = path};
}

namespace {

std::string declaredText(uint64_t sizeBytes) { return "its header declares " + std::to_string(sizeBytes) + " bytes of voxels, but "; }

}  // namespace

void requirePlausible(const fs::path& path, const Payload& payload, uint64_t sizeBytes) {
  std::error_code error;
  const uint64_t fileBytes = fs::file_size(payload.file, error);
  if (error) fail(path, "its voxels in " + payload.file.string() + " cannot be read");
  if (payload.encoding == Encoding::plain) {
    const uint64_t held = fileBytes - std::min(fileBytes, payload.offsetBytes);
    if (held < sizeBytes)
      fail(path, declaredText(sizeBytes) + "the file holds " + std::to_string(held) + "; it is cut off or damaged");
    return;
  }
  if (payload.encoding == Encoding::text) return;
  // Deflate packs at most 1032 bytes into one (zlib's technical details); other codings in use here stay below that,
  // too.
  constexpr uint64_t kMaxRatio = 1032;
  if (sizeBytes / kMaxRatio > fileBytes)
    fail(path, declaredText(sizeBytes) + "a file of " + std::to_string(fileBytes) + " bytes cannot hold that");
}

void requirePayload(const fs::path& path, const Payload& payload, uint64_t count, uint64_t sizeBytes, const std::stop_token& stop) {
  requirePlausible(path, payload, sizeBytes);
  if (payload.encoding == Encoding::text) {
    const uint64_t held = countWords(payload, count, stop);
    if (held < count)
      fail(path, "its header declares " + std::to_string(count) + " voxels, but the file holds " +
                     std::to_string(held) + " numbers; it is cut off or damaged");
    return;
  }
  if (payload.encoding != Encoding::deflated) return;
  bool isWhole = false;
  const uint64_t needed = payload.skipBytes + sizeBytes;
  const uint64_t held = countInflated(payload, needed, stop, isWhole);
  if (held < needed)
    fail(path, declaredText(sizeBytes) + "only " + std::to_string(held - std::min(held, payload.skipBytes)) +
                   " can be decompressed; it is cut off or damaged");
  if (!isWhole) fail(path, "its compressed voxels are damaged: the stream's end or checksum is wrong");
}

}  // namespace warpscope
