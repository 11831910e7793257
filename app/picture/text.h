// Lines of text in pictures.
// TrueType outlines through stb_truetype; the font is compiled into the program.
#pragma once

#include <string_view>

#include "render/core/color.h"
#include "render/core/image.h"

namespace warpscope {

/// The TrueType file whose glyphs these are, as it was compiled into the program.
std::string_view fontFile();

/// Width of a line of UTF-8 text in pixels.
float textWidth(std::string_view text, float heightPx);
/// From a line's top to its base line, in pixels.
float textAscent(float heightPx);
/// The height of lines whose type has that size: what styles of pages call the size of a font.
float textHeightOf(float sizePx);

/// Draws a line over an opaque picture; (x, y) is the left end of the line's top. What falls outside is cut off.
void drawText(Image<Rgba8>& picture, float x, float y, std::string_view text, float heightPx, Rgba8 color);

}  // namespace warpscope
