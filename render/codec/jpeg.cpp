// JPEG through libjpeg-turbo.
// See jpeg.h.
#include "render/codec/jpeg.h"

#include <turbojpeg.h>

#include <memory>
#include <new>
#include <stdexcept>

#include "render/core/parallel.h"
#include "render/march/own_picture.h"

namespace warpscope {
namespace {

struct TurboJpegDeleter {
  void operator()(void* handle) const { tjDestroy(handle); }
};
using TurboJpeg = std::unique_ptr<void, TurboJpegDeleter>;

constexpr int kSubsampling = TJSAMP_444;

TurboJpeg made(tjhandle handle) {
  if (!handle) throw std::bad_alloc();
  return TurboJpeg(handle);
}

// Making them takes a while: one for each thread.
TurboJpeg& jpegCompressor() {
  thread_local TurboJpeg handle;
  if (!handle) handle = made(tjInitCompress());
  return handle;
}

TurboJpeg& jpegDecompressor() {
  thread_local TurboJpeg handle;
  if (!handle) handle = made(tjInitDecompress());
  return handle;
}

/// What went wrong. libjpeg-turbo 2.1 goes on inside a damaged picture's header when it is asked for the next: the handle must go.
std::string failureOf(TurboJpeg& handle, const char* what) {
  std::string sentence = std::string(what) + tjGetErrorStr2(handle.get());
  handle.reset();
  return sentence;
}

const unsigned char* bytesOf(std::span<const std::byte> jpeg) { return reinterpret_cast<const unsigned char*>(jpeg.data()); }

}  // namespace

uint64_t mostJpegBytes(uint32_t width, uint32_t height) {
  return width < 1 || height < 1 ? 0 : tjBufSize(static_cast<int>(width), static_cast<int>(height), kSubsampling);
}

void appendJpeg(ByteVector& out, const Rgba8* pixels, uint32_t width, uint32_t height, int quality) {
  const size_t start = out.size();
  unsigned long length = tjBufSize(static_cast<int>(width), static_cast<int>(height), kSubsampling);
  out.resize(start + length);
  auto* place = reinterpret_cast<unsigned char*>(out.data() + start);
  if (tjCompress2(jpegCompressor().get(), reinterpret_cast<const unsigned char*>(pixels), static_cast<int>(width), 0, static_cast<int>(height), TJPF_RGBX,
                  &place, &length, kSubsampling, quality, TJFLAG_NOREALLOC) != 0)
    throw std::runtime_error(failureOf(jpegCompressor(), "libjpeg-turbo could not compress a picture: "));
  out.resize(start + length);
}

std::optional<std::string> readJpeg(std::span<const std::byte> jpeg, Rgba8* pixels, uint32_t width, uint32_t height) {
  TurboJpeg& handle = jpegDecompressor();
  int itsWidth = 0, itsHeight = 0, subsampling = 0, colorSpace = 0;
  if (tjDecompressHeader3(handle.get(), bytesOf(jpeg), jpeg.size(), &itsWidth, &itsHeight, &subsampling, &colorSpace) != 0)
    return failureOf(handle, "the JPEG picture cannot be read: ");
  if (static_cast<uint32_t>(itsWidth) != width || static_cast<uint32_t>(itsHeight) != height)
    return "the JPEG picture has " + std::to_string(itsWidth) + "x" + std::to_string(itsHeight) + " pixels instead of " +
           std::to_string(width) + "x" + std::to_string(height);
  // Few bytes can ask for very many scans of a large picture; ours have one.
  constexpr int kFlags = TJFLAG_LIMITSCANS | TJFLAG_STOPONWARNING;
  if (tjDecompress2(handle.get(), bytesOf(jpeg), jpeg.size(), reinterpret_cast<unsigned char*>(pixels), itsWidth, 0, itsHeight, TJPF_RGBA,
                    kFlags) != 0)
    return failureOf(handle, "the JPEG picture is damaged: ");
  return std::nullopt;
}

ByteVector encodeFramePicture(const SampleFrame& frame, const glm::vec3& background, int quality) {
  requireUsable(frame.camera);
  Image<glm::vec4> colors;
  resolveRayColors(frame, ownPicture(frame), colors);
  Image<Rgba8> picture(colors.width(), colors.height());
  const ColorTables& tables = ColorTables::instance();
  parallelForRanges(colors.size(), 1 << 15, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) picture[i] = tables.encodeOver(colors[i], background);
  });
  ByteVector jpeg;
  appendJpeg(jpeg, picture.data(), picture.width(), picture.height(), quality);
  return jpeg;
}

std::optional<std::string> decodeFramePicture(std::span<const std::byte> jpeg, const Camera& camera, Image<Rgba8>& picture) {
  picture.reshape(camera.width, camera.height);
  std::optional<std::string> error = readJpeg(jpeg, picture.data(), picture.width(), picture.height());
  if (error) picture.reshape(0, 0);
  return error;
}

}  // namespace warpscope
