// Conversion and PNG.
// See picture.h.
#include "app/picture/picture.h"

#include <stb_image.h>
#include <stb_image_write.h>

#include <algorithm>
#include <limits>

#include "render/base/error.h"
#include "render/base/input_file.h"
#include "render/core/parallel.h"

namespace warpscope {
namespace {

/// A picture of `perPixel(i)`.
template <class PerPixel>
Image<Rgba8> convert(uint32_t width, uint32_t height, const PerPixel& perPixel) {
  Image<Rgba8> picture(width, height);
  parallelForRanges(picture.size(), 1 << 15, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) picture[i] = perPixel(i);
  });
  return picture;
}

template <class PerColor>
Image<Rgba8> convert(const WarpedImage& image, const PixelMarks& marks, const PerColor& perColor) {
  return convert(image.color.width(), image.color.height(), [&](size_t i) {
    const Rgba8 mark = marks.of(image.samples[i]);
    return mark != 0 ? mark : perColor(image.color[i]);
  });
}

constexpr uint64_t kMostPngSide = 1 << 24;  // stb_image's own

}  // namespace

Image<Rgba8> toPicture(const WarpedImage& image, const PixelMarks& marks) {
  const ColorTables& tables = ColorTables::instance();
  return convert(image, marks, [&](const glm::vec4& color) { return tables.encode(color); });
}

Image<Rgba8> toScreen(const WarpedImage& image, const glm::vec3& background, const PixelMarks& marks) {
  const ColorTables& tables = ColorTables::instance();
  return convert(image, marks, [&](const glm::vec4& color) { return tables.encodeOver(color, background); });
}

Image<Rgba8> toScreen(const Image<glm::vec4>& color, const glm::vec3& background) {
  const ColorTables& tables = ColorTables::instance();
  return convert(color.width(), color.height(), [&](size_t i) { return tables.encodeOver(color[i], background); });
}

bool fitsPng(uint64_t width, uint64_t height) {
  // Its encoder counts bytes, and a filter's byte a row, in an int.
  return width < kMostPngSide && height < kMostPngSide && (width * sizeof(Rgba8) + 1) * height <= std::numeric_limits<int>::max();
}

std::string encodePng(const Image<Rgba8>& picture, const std::stop_token& stop) {
  if (stop.stop_requested()) throw OperationCancelled();
  std::string bytes;
  const auto append = [](void* context, void* data, int size) {
    static_cast<std::string*>(context)->append(static_cast<const char*>(data), static_cast<size_t>(size));
  };
  if (!fitsPng(picture.width(), picture.height()))
    throw InputError("a picture of " + std::to_string(picture.width()) + "x" + std::to_string(picture.height()) + " pixels is too large for a PNG file");
  const int written = picture.empty() ? 0
                                      : stbi_write_png_to_func(append, &bytes, static_cast<int>(picture.width()),
                                                               static_cast<int>(picture.height()), 4, picture.data(),
                                                               static_cast<int>(picture.width() * sizeof(Rgba8)));
  if (written == 0) throw InputError("a picture could not be encoded as PNG: it is empty, or there is not enough memory");
  return bytes;
}

Image<Rgba8> readPng(const std::filesystem::path& path) {
  int width = 0, height = 0, channels = 0;
  constexpr uint64_t kMostBytes = 1 << 30;
  const std::string bytes = readInputFile(path, kMostBytes, "a picture");
  stbi_uc* pixels = stbi_load_from_memory(reinterpret_cast<const stbi_uc*>(bytes.data()), static_cast<int>(bytes.size()), &width, &height, &channels, 4);
  if (pixels == nullptr) throw InputError(path.string() + ": cannot be read as a picture: " + stbi_failure_reason());
  Image<Rgba8> picture(static_cast<uint32_t>(width), static_cast<uint32_t>(height));
  for (size_t i = 0; i < picture.size(); ++i)
    picture[i] = pixels[4 * i] | pixels[4 * i + 1] << 8 | pixels[4 * i + 2] << 16 |
                 static_cast<Rgba8>(pixels[4 * i + 3]) << 24;
  stbi_image_free(pixels);
  return picture;
}

Image<Rgba8> resized(const Image<Rgba8>& picture, uint32_t width, uint32_t height) {
  Image<Rgba8> result(width, height);
  const ColorTables& tables = ColorTables::instance();
  parallelForRanges(height, 8, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      const size_t y0 = y * picture.height() / height;
      const size_t y1 = std::max(y0 + 1, (y + 1) * picture.height() / height);
      for (size_t x = 0; x < width; ++x) {
        const size_t x0 = x * picture.width() / width;
        const size_t x1 = std::max(x0 + 1, (x + 1) * picture.width() / width);
        glm::vec4 sum(0.0f);
        for (size_t v = y0; v < y1; ++v)
          for (size_t u = x0; u < x1; ++u) sum += tables.decode(picture(static_cast<uint32_t>(u), static_cast<uint32_t>(v)));
        result(static_cast<uint32_t>(x), static_cast<uint32_t>(y)) =
            tables.encode(sum / static_cast<float>((y1 - y0) * (x1 - x0)));
      }
    }
  });
  return result;
}

}  // namespace warpscope
