// Pictures for files and screens: 8 bit, straight alpha, sRGB.
// PNG (ISO 15948) through stb_image_write and stb_image.
#pragma once

#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>

#include "render/core/color.h"
#include "render/core/image.h"
#include "render/warp/warp.h"

namespace warpscope {

/// What a warped image becomes: pixels that nothing covers are transparent, unless they are marked.
Image<Rgba8> toPicture(const WarpedImage& image, const PixelMarks& marks = {});

/// Composited over an opaque background (linear RGB): what a screen shows. With marks.
Image<Rgba8> toScreen(const WarpedImage& image, const glm::vec3& background, const PixelMarks& marks = {});

/// The same of a picture that stands for itself: no samples lie behind it.
Image<Rgba8> toScreen(const Image<glm::vec4>& color, const glm::vec3& background);

/// Whether a picture of that size can be a PNG file: of 2 GiB at most.
bool fitsPng(uint64_t width, uint64_t height);

/// The bytes of a PNG file. Throws OperationCancelled if `stop` is set before it begins; InputError for an empty picture, and one that does not fit.
std::string encodePng(const Image<Rgba8>& picture, const std::stop_token& stop = {});

/// Reads an 8-bit PNG. Throws InputError.
Image<Rgba8> readPng(const std::filesystem::path& path);

/// Shrinks or enlarges to width x height: averages what falls into a pixel, in linear light, opaque pictures only.
Image<Rgba8> resized(const Image<Rgba8>& picture, uint32_t width, uint32_t height);

}  // namespace warpscope
