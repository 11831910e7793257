// Pictures as a display shows them: over a background, linear and through the sRGB curve, red, green and blue each in a plane of its own.
// What metrics of pictures work on. The curve: display_curve.h.
#pragma once

#include <array>
#include <string_view>

#include "render/core/host_device.h"
#include "render/core/image.h"

namespace warpscope {

/// Red, green and blue.
using ColorPlanes = std::array<Image<float>, 3>;

struct DisplayedPlanes {
  ColorPlanes linear;  ///< light, 0..1
  ColorPlanes srgb;    ///< the same through the curve, 0..1
};

/// `image` is linear and premultiplied, `background` linear. Throws InputError naming `metric` for a pixel that is not finite.
DisplayedPlanes displayedPlanes(const Image<glm::vec4>& image, const glm::vec3& background, std::string_view metric);
/// One half of them.
ColorPlanes linearPlanes(const Image<glm::vec4>& image, const glm::vec3& background, std::string_view metric);
ColorPlanes srgbPlanes(const Image<glm::vec4>& image, const glm::vec3& background, std::string_view metric);

/// Arrays for as many values as there are pixels; null where they are not wanted.
using ChannelPointers = std::array<float*, 3>;

/// As displayedPlanes, of `count` pixels, into arrays. False if a pixel is not finite.
[[nodiscard]] bool displayPixels(const glm::vec4* pixels, size_t count, const glm::vec3& background, const ChannelPointers& linear,
                                 const ChannelPointers& srgb);

/// Turns planes of sRGB values 0..1 into linear ones.
void linearize(ColorPlanes& planes);

/// Throws the InputError that says so.
[[noreturn]] void refuseNonFinite(std::string_view metric);

/// Throws InputError naming `metric` unless both have one size, which is not empty.
void requireOneSize(const Image<glm::vec4>& a, const Image<glm::vec4>& b, std::string_view metric);

}  // namespace warpscope
