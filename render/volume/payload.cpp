// Finds and measures the voxels of a file.
// See payload.h. Decompression: zlib.
#include "render/volume/payload.h"

#include <zlib.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <memory>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include "render/base/error.h"
#include "render/base/printable.h"
#include "render/volume/binary_payload.h"
#include "render/volume/payload_parts.h"
#include "render/volume/text_payload.h"
#include "render/volume/volume_format.h"

namespace warpscope {
namespace {

namespace fs = std::filesystem;
using Encoding = Payload::Encoding;
using payload_parts::fail;
using payload_parts::wholeFile;

/// What is wrong with a word as a number of that type; null if nothing is.
const char* faultOf(std::string_view word, Payload::Words words, VoxelType type) {
  if (word.starts_with('+')) word.remove_prefix(1);
  const bool isReal = type == VoxelType::float32 || type == VoxelType::float64;
  const bool isDigits = word.find_first_not_of("+-.0123456789eE") == std::string_view::npos;
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || (!isDigits && !(isReal && words == Payload::Words::nrrd))) return "which is no number";
  if (isReal) return type == VoxelType::float32 && std::isfinite(value) && std::abs(value) > static_cast<double>(std::numeric_limits<float>::max()) ? "which its type does not hold" : nullptr;
  const bool isWritten = word.find_first_of(".eE") == std::string_view::npos;
  if (value != std::trunc(value) || (!isWritten && words != Payload::Words::meta)) return "which is no whole number";
  return visitVoxelType(type, [&](auto tag) {
    using Limits = std::numeric_limits<decltype(tag)>;
    return value >= static_cast<double>(Limits::lowest()) && value <= static_cast<double>(Limits::max()) ? nullptr : "which its type does not hold";
  });
}

/// Words in the text from `payload.offsetBytes` on, counted no further than `enough`. Throws InputError for one that the file's library would not bear, or would not read.
uint64_t countWords(const fs::path& path, const Payload& payload, VoxelType type, uint64_t enough, const std::stop_token& stop) {
  std::ifstream file(payload.file, std::ios::binary);
  file.seekg(static_cast<std::streamoff>(payload.offsetBytes));
  std::vector<char> piece(1 << 16);
  uint64_t words = 0;
  std::string word;
  const auto refuse = [&](const std::string& what) { fail(path, "its voxel " + std::to_string(words) + " is \"" + printable(word.substr(0, 40)) + "\", " + what); };
  const auto endWord = [&] {
    std::string_view number(word);
    if (payload.words == Payload::Words::nrrd) {
      number.remove_prefix(std::min(number.find_first_not_of(','), number.size()));
      number = number.substr(0, number.find_last_not_of(',') + 1);
    }
    if (!number.empty()) {
      if (const char* const fault = faultOf(number, payload.words, type)) refuse(fault);
      ++words;
    }
    word.clear();
  };
  constexpr std::string_view kBlanks = " \t\n\v\f\r";  // of the standard library's streams
  while (words < enough && file) {
    if (stop.stop_requested()) throw OperationCancelled();
    file.read(piece.data(), static_cast<std::streamsize>(piece.size()));
    for (std::streamsize i = 0; i < file.gcount() && words < enough; ++i) {
      const char c = piece[static_cast<size_t>(i)];
      if (kBlanks.find(c) != std::string_view::npos) {
        endWord();
        continue;
      }
      word += c;
      if (word.size() > kMaxWord) refuse("and goes on: words of at most " + std::to_string(kMaxWord) + " bytes are read");
    }
  }
  if (words < enough) endWord();
  return words;
}

/// Bytes in the deflated payload, counted no further than `enough`. `isWhole` tells whether the stream ended or
/// sufficed undamaged, `deflated` how many bytes of the file that took.
uint64_t countInflated(const Payload& payload, uint64_t enough, const std::stop_token& stop, bool& isWhole, uint64_t& deflated) {
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
  deflated = 0;
  while (true) {
    if (stop.stop_requested()) throw OperationCancelled();
    if (stream.avail_in == 0) {
      file.read(reinterpret_cast<char*>(in.data()), kPiece);
      stream.next_in = in.data();
      stream.avail_in = static_cast<unsigned>(file.gcount());
      if (stream.avail_in == 0) break;
      deflated += stream.avail_in;
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
  deflated -= stream.avail_in;
  return total;
}

std::string declaredText(uint64_t sizeBytes) { return "its header declares " + std::to_string(sizeBytes) + " bytes of voxels, but "; }

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

void requirePayload(const fs::path& path, const Payload& payload, VoxelType type, uint64_t count, uint64_t sizeBytes, const std::stop_token& stop) {
  requirePlausible(path, payload, sizeBytes);
  if (payload.encoding == Encoding::text) {
    const uint64_t held = countWords(path, payload, type, count, stop);
    if (held < count)
      fail(path, "its header declares " + std::to_string(count) + " voxels, but the file holds " +
                     std::to_string(held) + " numbers; it is cut off or damaged");
    return;
  }
  if (payload.encoding != Encoding::deflated) return;
  bool isWhole = false;
  uint64_t deflated = 0;
  const uint64_t needed = payload.skipBytes + sizeBytes;
  const uint64_t held = countInflated(payload, needed, stop, isWhole, deflated);
  if (held < needed)
    fail(path, declaredText(sizeBytes) + "only " + std::to_string(held - std::min(held, payload.skipBytes)) +
                   " can be decompressed; it is cut off or damaged");
  if (!isWhole) fail(path, "its compressed voxels are damaged: the stream's end or checksum is wrong");
  if (payload.deflatedBytes && *payload.deflatedBytes < deflated)
    fail(path, "its header says that its compressed voxels take " + std::to_string(*payload.deflatedBytes) + " bytes, but they take " + std::to_string(deflated));
}

}  // namespace warpscope
