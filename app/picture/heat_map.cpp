// The ramp.
// See heat_map.h.
#include "app/picture/heat_map.h"

#include <algorithm>
#include <array>

#include "render/core/parallel.h"

namespace warpscope {
namespace {

struct Rgb {
  float red, green, blue;  // sRGB, 0..255
};

// Lightness (CIE L*) of about 0, 19, 38, 57, 76, 96.
constexpr std::array<Rgb, 6> kStops{{{0, 0, 0}, {56, 22, 112}, {138, 38, 128}, {222, 78, 84}, {252, 160, 72}, {252, 246, 180}}};

std::array<Rgba8, 256> makeRamp() {
  std::array<Rgba8, 256> ramp{};
  for (size_t i = 0; i < ramp.size(); ++i) {
    const float at = static_cast<float>(i) / 255.0f * static_cast<float>(kStops.size() - 1);
    const size_t stop = std::min(static_cast<size_t>(at), kStops.size() - 2);
    const float share = at - static_cast<float>(stop);
    const Rgb &a = kStops[stop], &b = kStops[stop + 1];
    const auto mixed = [&](float from, float to) { return static_cast<uint32_t>(from + share * (to - from) + 0.5f); };
    ramp[i] = mixed(a.red, b.red) | mixed(a.green, b.green) << 8 | mixed(a.blue, b.blue) << 16 | 0xff000000u;
  }
  return ramp;
}

const std::array<Rgba8, 256>& ramp() {
  static const std::array<Rgba8, 256> colors = makeRamp();
  return colors;
}

}  // namespace

Rgba8 heatColor(float value) { return ramp()[quantizeUnorm8(value)]; }

Image<Rgba8> heatMap(const Image<float>& map, float gain) {
  Image<Rgba8> picture;
  picture.reshape(map.width(), map.height());
  const std::array<Rgba8, 256>& colors = ramp();
  parallelForRanges(map.size(), 1 << 16, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) picture[i] = colors[quantizeUnorm8(gain * map[i])];
  });
  return picture;
}

}  // namespace warpscope
