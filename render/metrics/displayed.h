// Pictures as a display shows them: over a background, through the sRGB curve, red, green and blue each in a plane of its own.
// What metrics of pictures work on. IEC 61966-2-1 for the curve (core/color.h).
#pragma once

#include <array>
#include <string_view>

#include "render/core/host_device.h"
#include "render/core/image.h"

namespace warpscope {

/// Red, green and blue, 0..1.
using DisplayedPlanes = std::array<Image<float>, 3>;

/// `image` is linear and premultiplied, `background` linear. Throws InputError naming `metric` for an empty image or a pixel that is not
/// finite.
DisplayedPlanes displayedPlanes(const Image<glm::vec4>& image, const glm::vec3& background, std::string_view metric);

/// Throws InputError naming `metric` unless both have one size, which is not empty.
void requireOneSize(const Image<glm::vec4>& a, const Image<glm::vec4>& b, std::string_view metric);

}  // namespace warpscope
