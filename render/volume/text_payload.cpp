// Parsing lines.
// See text_payload.h.
#include "render/volume/text_payload.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
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
using payload_parts::requirePart;

std::string trimmed(const std::string& text) {
  const size_t first = text.find_first_not_of(" \t\r");
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}
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
  std::vector<std::string> lines;             // all of them
  std::string repeated;                       // a key that comes twice, not being a comment; empty if there is none
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
    header.lines.push_back(line);
    const size_t at = line.find(separator);
    if (at == std::string::npos) continue;
    const std::string key = lowered(trimmed(line.substr(0, at)));
    if (!header.fields.emplace(key, trimmed(line.substr(at + 1))).second && key != "comment") header.repeated = key;
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

/// Throws for a line of a MetaImage header that its library does not bear. It copies keys and texts to places of 255 bytes without a look, and takes a line
/// without a separator together with the next, so that it may miss where the header ends. It knows ':' as a separator as well.
void requireBorne(const fs::path& path, const std::string& line) {
  const size_t at = line.find('=');
  const std::string key = lowered(trimmed(line.substr(0, at)));
  if (at == std::string::npos && !key.empty()) fail(path, "its header has a line without =: \"" + line.substr(0, 40) + "\"");
  if (line.size() <= kMaxTextLine || key == "elementdatafile") return;
  const bool isNumbers = line.find_first_not_of("0123456789.+-eE \t\r", at + 1) == std::string::npos;
  for (const char* known : {"dimsize", "elementspacing", "elementsize", "offset", "origin", "position", "centerofrotation", "transformmatrix", "rotation", "orientation"})
    if (isNumbers && key == known) return;
  fail(path, "its header's " + key.substr(0, 40) + " is a line of " + std::to_string(line.size()) + " bytes; at most " + std::to_string(kMaxTextLine) +
                 " are read, but of vectors and matrices");
}

/// Throws for a header with characters that no text has: a library takes a zero byte for the end of a key.
void requireTextual(const fs::path& path, const TextHeader& header) {
  for (const std::string& line : header.lines)
    for (const char c : line)
      if (c >= 0 && c < ' ' && c != '\t' && c != '\r') fail(path, c == 0 ? "its header has a zero byte" : "its header has a control character, of code " + std::to_string(static_cast<int>(c)));
}

/// Digits of the number of voxels along an axis, at most: 10^8 - 1 of them.
constexpr size_t kMostSideDigits = 8;

}  // namespace

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
  requireTextual(path, header);
  // The library puts what is wrong with a field into a place of a kilobyte, the field with it.
  const auto isText = [](const std::string& line) {
    const std::string key = lowered(line.substr(0, line.find(':')));
    return line.find(":=") != std::string::npos || key == "content" || key == "data file" || key == "datafile";
  };
  for (const std::string& line : header.lines)
    if (line.size() > kMaxFieldLine && !isText(line))
      fail(path, "its header's \"" + line.substr(0, 40) + "\" is a line of " + std::to_string(line.size()) + " bytes; at most " + std::to_string(kMaxFieldLine) + " are read");
  std::istringstream sizes(valueOf("sizes"));
  std::string side;
  // The library reads these without a sign, and with more digits than it has room for.
  for (int axis = 1; sizes >> side; ++axis)
    if (side.find_first_not_of("0123456789") != std::string::npos || side.size() > kMostSideDigits)
      fail(path, "its header declares " + side.substr(0, 40) + " voxels along axis " + std::to_string(axis));
  Payload payload{.file = path, .offsetBytes = header.endBytes};
  const std::string encoding = valueOf("encoding");
  payload.encoding = encoding == "raw"                                                ? Encoding::plain
                     : encoding == "gzip" || encoding == "gz"                         ? Encoding::deflated
                     : encoding == "txt" || encoding == "text" || encoding == "ascii" ? Encoding::text
                                                                                      : Encoding::unchecked;
  payload.words = Payload::Words::nrrd;
  const bool isDeflated = payload.encoding == Encoding::deflated;
  const bool hasWords = payload.encoding == Encoding::text;  // all of which are looked at, in one file from its first line on
  const std::string space = valueOf("space");
  payload.hasOrientation = space.starts_with("left-") || space.starts_with("right-") || space.starts_with("scanner") ||
                           space == "ras" || space == "las" || space == "lps";
  for (const char* key : {"data file", "datafile"})
    if (const auto field = header.fields.find(key); field != header.fields.end())
      if (!followDetached(path, field->second, payload)) {
        if (hasWords) fail(path, "spreads numbers that are written as text over several files; only one such file is read");
        for (const std::string& name : partsOf(path, field->second)) {
          payload.others.push_back(path.parent_path() / name);
          requirePart(path, payload.others.back(), dataFileText(name));
        }
        return payload;
      }
  // Skips make room for foreign headers; -1 means "the last bytes", for which a size check is all that is left.
  for (const char* key : {"line skip", "lineskip"})
    if (!valueOf(key).empty() && valueOf(key) != "0") {
      if (hasWords) fail(path, "skips lines before numbers that are written as text; such are read from their first line on");
      if (isDeflated) fail(path, "skips lines before its compressed voxels; such are read from their first byte on");
      payload.encoding = Encoding::unchecked;
    }
  for (const char* key : {"byte skip", "byteskip"}) {
    const std::string skip = valueOf(key);
    if (skip.empty() || skip == "0") continue;
    if (hasWords) fail(path, "skips bytes before numbers that are written as text; such are read from their first byte on");
    if (skip == "-1" && isDeflated) fail(path, "says that its compressed voxels are the last bytes (byte skip: -1), which only others can be");
    if (skip == "-1")
      payload.offsetBytes = 0;
    else if (skip.find_first_not_of("0123456789") == std::string::npos && skip.size() < 16 && (payload.encoding == Encoding::plain || isDeflated))
      (isDeflated ? payload.skipBytes : payload.offsetBytes) += std::stoull(skip);  // of what is decompressed
    else
      payload.encoding = Encoding::unchecked;
  }
  return payload;
}

Payload locateMetaImage(const fs::path& path) {
  const TextHeader header = readTextHeader(path, '=', "elementdatafile");
  const auto dataFile = header.fields.find("elementdatafile");
  if (!header.excess.empty() && header.fields.contains("ndims") && header.fields.contains("dimsize")) fail(path, header.excess);
  for (const auto& [key, shown] : {std::pair("ndims", "NDims"), std::pair("dimsize", "DimSize"), std::pair("elementdatafile", "ElementDataFile")})
    if (!header.fields.contains(key)) fail(path, "is no MetaImage file: its header lacks " + std::string(shown));
  requireTextual(path, header);
  for (const std::string& line : header.lines) requireBorne(path, line);
  if (!header.fields.contains("elementtype")) fail(path, "is no MetaImage file: its header lacks ElementType");
  // Of two the library takes the second, or both.
  if (!header.repeated.empty())
    fail(path, "its header has " + header.repeated.substr(0, 40) + " twice");
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
  // By its first letter, as the library has it; words of which it makes something else than they say are refused.
  const auto flagOf = [&](const char* key, bool otherwise) {
    const auto field = header.fields.find(key);
    if (field == header.fields.end()) return otherwise;
    const std::string word = lowered(field->second);
    if (word == "true" || word == "t" || word == "1") return true;
    if (word != "false" && word != "f" && word != "0") fail(path, "its header's " + std::string(key) + " must be True or False, not \"" + field->second.substr(0, 40) + "\"");
    return false;
  };
  const auto isTrue = [&](const char* key) { return flagOf(key, false); };
  // A number of bytes, -1 among them where it stands for something.
  const auto bytesOf = [&](const char* key, int64_t least) -> std::optional<int64_t> {
    const auto field = header.fields.find(key);
    if (field == header.fields.end()) return {};
    int64_t bytes = 0;
    const std::string& text = field->second;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), bytes);
    if (error != std::errc() || end != text.data() + text.size() || bytes < least)
      fail(path, "its header's " + std::string(key) + " must be a number of bytes, not \"" + text.substr(0, 40) + "\"");
    return bytes;
  };
  Payload payload{.file = path, .offsetBytes = header.endBytes};
  const bool isFirstSaid = header.fields.contains("binarydatabyteordermsb"), isSecondSaid = header.fields.contains("elementbyteordermsb");
  if (!isFirstSaid || !isSecondSaid || isTrue("binarydatabyteordermsb") == isTrue("elementbyteordermsb"))
    payload.isBigEndian = isTrue("binarydatabyteordermsb") || isTrue("elementbyteordermsb");
  const bool isText = !flagOf("binarydata", true);
  payload.encoding = isText ? Encoding::text : isTrue("compresseddata") ? Encoding::deflated : Encoding::plain;
  payload.words = Payload::Words::meta;
  if (isText && payload.isBigEndian != false) fail(path, "says in which order the bytes of numbers are that it has as text; it must be False");
  for (const char* key : {"transformmatrix", "orientation", "rotation", "anatomicalorientation"})
    if (const auto field = header.fields.find(key); field != header.fields.end() && !field->second.starts_with("?"))
      payload.hasOrientation = true;
  if (lowered(dataFile->second) != "local" && !followDetached(path, dataFile->second, payload))
    fail(path, "spreads its voxels over several files, which ITK reads unchecked; convert it to a single .mha file");
  // From the file's beginning on; -1 means "the last bytes", for which a size check is all that is left.
  const auto skipped = bytesOf("headersize", -1);
  if (skipped.value_or(0) < 0 && payload.encoding != Encoding::plain) fail(path, "says that its voxels are the last bytes (HeaderSize = -1), which text and compressed ones cannot be");
  if (skipped.value_or(0) != 0) payload.offsetBytes = *skipped > 0 ? static_cast<uint64_t>(*skipped) : 0;
  if (payload.encoding != Encoding::deflated) return payload;
  if (const auto size = bytesOf("compresseddatasize", 1)) payload.deflatedBytes = static_cast<uint64_t>(*size);
  std::error_code unknown;
  const uint64_t fileBytes = fs::file_size(payload.file, unknown), held = fileBytes - std::min(fileBytes, payload.offsetBytes);
  if (!unknown && payload.deflatedBytes.value_or(0) > held)
    fail(path, "its header says that its compressed voxels take " + std::to_string(*payload.deflatedBytes) + " bytes, but the file holds " + std::to_string(held) + " of them; it is cut off or damaged");
  if (!payload.deflatedBytes && (payload.file == path || skipped.value_or(0) != 0)) fail(path, "its header lacks CompressedDataSize, without which its compressed voxels are not found");
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

}  // namespace warpscope
