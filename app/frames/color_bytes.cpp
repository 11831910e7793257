// Plane by plane.
// See color_bytes.h.
#include "app/frames/color_bytes.h"

#include <algorithm>
#include <bit>

#include "render/base/error.h"
#include "render/codec/bytes.h"
#include "render/codec/zstd_section.h"

namespace warpscope {
namespace {

/// Bytes of one plane are compressed together; a plane holds at most this many, which zstd_section.h takes.
constexpr size_t kPlaneBytes = size_t{1} << 26;
constexpr size_t kPlanes = sizeof(glm::vec4);

}  // namespace

ByteVector encodeColors(const Image<glm::vec4>& image) {
  const size_t pixels = size_t{image.width()} * image.height();
  ByteVector bytes;
  std::vector<uint8_t> plane;
  for (size_t begin = 0; begin < pixels; begin += kPlaneBytes) {
    plane.resize(std::min(kPlaneBytes, pixels - begin));
    for (size_t k = 0; k < kPlanes; ++k) {
      for (size_t i = 0; i < plane.size(); ++i) {
        const float channel = image.data()[begin + i][static_cast<int>(k / 4)];
        plane[i] = static_cast<uint8_t>(std::bit_cast<uint32_t>(channel) >> (8 * (k % 4)));
      }
      appendSection(bytes, plane);
    }
  }
  return bytes;
}

uint64_t mostColorBytes(uint32_t width, uint32_t height) {
  const uint64_t pixels = uint64_t{width} * height, parts = (pixels + kPlaneBytes - 1) / kPlaneBytes;
  return kPlanes * (pixels + parts * kSectionHeadBytes);
}

Image<glm::vec4> decodeColors(std::span<const std::byte> bytes, uint32_t width, uint32_t height) {
  Image<glm::vec4> image(width, height);
  const size_t pixels = size_t{width} * height;
  ByteReader reader(bytes);
  std::vector<uint8_t> plane;
  for (size_t begin = 0; begin < pixels; begin += kPlaneBytes) {
    plane.resize(std::min(kPlaneBytes, pixels - begin));
    for (size_t k = 0; k < kPlanes; ++k) {
      if (!takeSection(reader, plane)) throw InputError("the server's picture is damaged");
      for (size_t i = 0; i < plane.size(); ++i) {
        float& channel = image.data()[begin + i][static_cast<int>(k / 4)];
        const uint32_t before = k % 4 == 0 ? 0u : std::bit_cast<uint32_t>(channel);
        channel = std::bit_cast<float>(before | static_cast<uint32_t>(plane[i]) << (8 * (k % 4)));
      }
    }
  }
  if (reader.left() != 0) throw InputError("the server's picture is damaged");
  return image;
}

}  // namespace warpscope
