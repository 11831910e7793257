// PNG files, compressed in stripes of rows on all cores.
// ISO 15948; stripes are joined as pigz (Adler) does: each ends on a byte boundary and knows the 32 KiB before it.
#include <zlib.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <vector>

#include "app/picture.h"
#include "render/core/error.h"
#include "render/core/parallel.h"

namespace warpscope {
namespace {

constexpr size_t kPixelBytes = 4;
constexpr size_t kStripeBytes = 1 << 18;
constexpr size_t kWindowBytes = 1 << 15;

void appendBigEndian(std::string& bytes, uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 255);
}

void appendChunk(std::string& bytes, std::string_view type, std::string_view content) {
  appendBigEndian(bytes, static_cast<uint32_t>(content.size()));
  const size_t begin = bytes.size();
  bytes += type;
  bytes += content;
  const uLong crc = crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data() + begin), bytes.size() - begin);
  appendBigEndian(bytes, static_cast<uint32_t>(crc));
}

int paeth(int left, int above, int corner) {
  const int toLeft = std::abs(above - corner), toAbove = std::abs(left - corner), toCorner = std::abs(left + above - 2 * corner);
  if (toLeft <= toAbove && toLeft <= toCorner) return left;
  return toAbove <= toCorner ? above : corner;
}

/// Filters a row in each of the five ways and keeps the one with the least sum of absolute values (ISO 15948, section 12.8).
void filterRow(const uint8_t* row, const uint8_t* above, size_t rowBytes, std::vector<uint8_t>& candidate, uint8_t* out) {
  size_t least = SIZE_MAX;
  for (uint8_t filter = 0; filter < 5; ++filter) {
    candidate[0] = filter;
    size_t sum = 0;
    for (size_t i = 0; i < rowBytes; ++i) {
      const int left = i < kPixelBytes ? 0 : row[i - kPixelBytes];
      const int corner = i < kPixelBytes ? 0 : above[i - kPixelBytes];
      const int predicted[] = {0, left, above[i], (left + above[i]) / 2, filter == 4 ? paeth(left, above[i], corner) : 0};
      const auto difference = static_cast<uint8_t>(row[i] - predicted[filter]);
      candidate[i + 1] = difference;
      sum += static_cast<size_t>(std::abs(static_cast<int8_t>(difference)));
    }
    if (sum >= least) continue;
    least = sum;
    std::copy_n(candidate.data(), rowBytes + 1, out);
  }
}

/// One stripe as raw deflate data; `begin` has `before` bytes in front of it. Empty if memory runs out.
std::string deflated(const uint8_t* begin, size_t count, size_t before, bool isLast) {
  z_stream stream{};
  if (deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, -15, 8, Z_DEFAULT_STRATEGY) != Z_OK) return {};
  const size_t window = std::min(before, kWindowBytes);
  if (window > 0) deflateSetDictionary(&stream, begin - window, static_cast<uInt>(window));
  std::string bytes(deflateBound(&stream, count) + 16, '\0');
  stream.next_in = const_cast<Bytef*>(begin);
  stream.avail_in = static_cast<uInt>(count);
  stream.next_out = reinterpret_cast<Bytef*>(bytes.data());
  stream.avail_out = static_cast<uInt>(bytes.size());
  deflate(&stream, isLast ? Z_FINISH : Z_SYNC_FLUSH);
  bytes.resize(stream.avail_in == 0 ? bytes.size() - stream.avail_out : 0);
  deflateEnd(&stream);
  return bytes;
}

}  // namespace

std::string encodePng(const Image<Rgba8>& picture, const std::stop_token& stop) {
  // Red is the lowest byte: on a little-endian machine pixels lie in memory as PNG wants them.
  const auto* pixels = reinterpret_cast<const uint8_t*>(picture.data());
  const size_t rowBytes = kPixelBytes * picture.width();
  const size_t rowsPerStripe = std::max<size_t>(1, kStripeBytes / (rowBytes + 1));
  const size_t stripes = (picture.height() + rowsPerStripe - 1) / rowsPerStripe;
  const auto forEachStripe = [&](const auto& body) {
    parallelForRanges(stripes, 1, [&](size_t begin, size_t end) {
      for (size_t stripe = begin; stripe < end && !stop.stop_requested(); ++stripe)
        body(stripe, stripe * rowsPerStripe, std::min<size_t>(picture.height(), (stripe + 1) * rowsPerStripe));
    });
    if (stop.stop_requested()) throw OperationCancelled();
  };

  std::vector<uint8_t> filtered((rowBytes + 1) * picture.height());
  const std::vector<uint8_t> nothing(rowBytes, 0);
  forEachStripe([&](size_t, size_t first, size_t last) {
    std::vector<uint8_t> candidate(rowBytes + 1);
    for (size_t y = first; y < last; ++y) {
      const uint8_t* row = pixels + y * rowBytes;
      filterRow(row, y == 0 ? nothing.data() : row - rowBytes, rowBytes, candidate, filtered.data() + y * (rowBytes + 1));
    }
  });

  std::vector<std::string> parts(stripes);
  std::vector<uLong> checksums(stripes);
  std::atomic<bool> failed = false;
  forEachStripe([&](size_t stripe, size_t first, size_t last) {
    const size_t begin = first * (rowBytes + 1), count = (last - first) * (rowBytes + 1);
    checksums[stripe] = adler32_z(1, filtered.data() + begin, count);
    parts[stripe] = deflated(filtered.data() + begin, count, begin, stripe + 1 == stripes);
    if (parts[stripe].empty()) failed = true;
  });
  if (failed || picture.empty()) throw InputError("a picture could not be encoded as PNG");

  std::string data("\x78\x9c", 2);  // zlib's header: deflate with a window of 32 KiB
  uLong checksum = 1;
  for (size_t stripe = 0; stripe < stripes; ++stripe) {
    data += parts[stripe];
    const size_t rows = std::min<size_t>(rowsPerStripe, picture.height() - stripe * rowsPerStripe);
    checksum = adler32_combine(checksum, checksums[stripe], static_cast<z_off_t>(rows * (rowBytes + 1)));
  }
  appendBigEndian(data, static_cast<uint32_t>(checksum));

  std::string header;
  appendBigEndian(header, picture.width());
  appendBigEndian(header, picture.height());
  header.append("\x08\x06\0\0\0", 5);  // 8 bit RGBA, not interlaced
  std::string bytes = "\x89PNG\r\n\x1a\n";
  appendChunk(bytes, "IHDR", header);
  appendChunk(bytes, "IDAT", data);
  appendChunk(bytes, "IEND", {});
  return bytes;
}

}  // namespace warpscope
