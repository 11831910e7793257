// What the program's pages have in common: their head with one style sheet, and pictures that the page holds itself.
// HTML 5; pages need nothing but themselves.
#pragma once

#include <string>

#include "render/core/color.h"
#include "render/core/image.h"

namespace warpscope {

/// Up to and with "<body>". `title` is plain text.
std::string pageHead(const std::string& title);

/// The picture as an element, reduced to `mostPx` pixels in width if it is wider; `description` is plain text.
std::string imageTag(const Image<Rgba8>& picture, const std::string& description, uint32_t mostPx = 240);

}  // namespace warpscope
