// Glyphs, kerned, blended in sRGB codes as screens do.
// See text.h.
#include "app/picture/text.h"

#include <stb_truetype.h>

#include <cmath>
#include <vector>

#include "fonts.h"

namespace warpscope {
namespace {

const stbtt_fontinfo& font() {
  static const stbtt_fontinfo loaded = [] {
    stbtt_fontinfo info;
    const auto* data = reinterpret_cast<const unsigned char*>(fontFile().data());
    stbtt_InitFont(&info, data, stbtt_GetFontOffsetForIndex(data, 0));
    return info;
  }();
  return loaded;
}

/// Takes the next code point off `text`; a malformed byte counts as one.
int nextCodePoint(std::string_view& text) {
  const auto lead = static_cast<unsigned char>(text.front());
  const size_t length = lead < 0x80 ? 1 : lead >> 5 == 6 ? 2 : lead >> 4 == 14 ? 3 : lead >> 3 == 30 ? 4 : 1;
  int code = length == 1 ? lead : lead & (0x7f >> length);
  if (length > text.size()) {
    text = {};
    return '?';
  }
  for (size_t i = 1; i < length; ++i) code = code << 6 | (static_cast<unsigned char>(text[i]) & 0x3f);
  text.remove_prefix(length);
  return code;
}

/// Calls visit(glyph, x) for each glyph and returns where the line ends.
template <class Visit>
float layOut(std::string_view text, float scale, const Visit& visit) {
  float x = 0.0f;
  int previous = 0;
  while (!text.empty()) {
    const int glyph = stbtt_FindGlyphIndex(&font(), nextCodePoint(text));
    if (previous != 0) x += scale * static_cast<float>(stbtt_GetGlyphKernAdvance(&font(), previous, glyph));
    visit(glyph, x);
    int advance = 0;
    stbtt_GetGlyphHMetrics(&font(), glyph, &advance, nullptr);
    x += scale * static_cast<float>(advance);
    previous = glyph;
  }
  return x;
}

}  // namespace

std::string_view fontFile() { return fonts::files()[0].content; }

float textWidth(std::string_view text, float heightPx) {
  return layOut(text, stbtt_ScaleForPixelHeight(&font(), heightPx), [](int, float) {});
}

float textAscent(float heightPx) {
  int ascent = 0;
  stbtt_GetFontVMetrics(&font(), &ascent, nullptr, nullptr);
  return stbtt_ScaleForPixelHeight(&font(), heightPx) * static_cast<float>(ascent);
}

float textHeightOf(float sizePx) { return sizePx * stbtt_ScaleForMappingEmToPixels(&font(), 1.0f) / stbtt_ScaleForPixelHeight(&font(), 1.0f); }

void drawText(Image<Rgba8>& picture, float x, float y, std::string_view text, float heightPx, Rgba8 color) {
  const float scale = stbtt_ScaleForPixelHeight(&font(), heightPx);
  const float baseline = std::round(y + textAscent(heightPx));
  layOut(text, scale, [&](int glyph, float offset) {
    const float left = std::floor(x + offset);
    int x0, y0, x1, y1;
    stbtt_GetGlyphBitmapBoxSubpixel(&font(), glyph, scale, scale, x + offset - left, 0.0f, &x0, &y0, &x1, &y1);
    const int width = x1 - x0, height = y1 - y0;
    if (width <= 0 || height <= 0) return;
    std::vector<unsigned char> coverage(static_cast<size_t>(width) * height);
    stbtt_MakeGlyphBitmapSubpixel(&font(), coverage.data(), width, height, width, scale, scale, x + offset - left, 0.0f,
                                  glyph);
    for (int v = 0; v < height; ++v)
      for (int u = 0; u < width; ++u) {
        const int px = static_cast<int>(left) + x0 + u, py = static_cast<int>(baseline) + y0 + v;
        if (px < 0 || py < 0 || px >= static_cast<int>(picture.width()) || py >= static_cast<int>(picture.height())) continue;
        Rgba8& pixel = picture(static_cast<uint32_t>(px), static_cast<uint32_t>(py));
        const uint32_t a = coverage[static_cast<size_t>(v) * width + u];
        Rgba8 mixed = 0xff000000u;
        for (int shift = 0; shift < 24; shift += 8)
          mixed |= (((color >> shift & 255) * a + (pixel >> shift & 255) * (255 - a) + 127) / 255) << shift;
        pixel = mixed;
      }
  });
}

}  // namespace warpscope
