// Pictures as JPEG and back, and a frame's picture as viewers that stream images send it.
// ISO/IEC 10918-1 through libjpeg-turbo, baseline, 4:4:4: half-size colour planes cost a picture of thin coloured structures more than they save.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "render/codec/bytes.h"
#include "render/core/color.h"
#include "render/core/image.h"
#include "render/march/sample_frame.h"

namespace warpscope {

/// What appendJpeg() appends at most; 0 for no pixels.
uint64_t mostJpegBytes(uint32_t width, uint32_t height);

/// Appends width x height pixels (both within kMaxImageSide, alpha ignored) as JPEG of that quality (1..100).
void appendJpeg(ByteVector& out, const Rgba8* pixels, uint32_t width, uint32_t height, int quality);

/// Fills width x height pixels, opaque. Nothing on success; else why not: no JPEG, of another size, or damaged where that shows.
std::optional<std::string> readJpeg(std::span<const std::byte> jpeg, Rgba8* pixels, uint32_t width, uint32_t height);

/// What an image-streaming server would send instead of the frame: its picture (as `hold` shows it) over an opaque background (linear
/// RGB) as JPEG. Throws InputError for an unusable camera.
ByteVector encodeFramePicture(const SampleFrame& frame, const glm::vec3& background, int quality);

/// Back to a picture, which must be of the size that the frame's camera has. Nothing on success; else what was wrong.
std::optional<std::string> decodeFramePicture(std::span<const std::byte> jpeg, const Camera& camera, Image<Rgba8>& picture);

}  // namespace warpscope
