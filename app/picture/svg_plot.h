// Plots as SVG, where each point says what it is when pointed at.
// SVG 1.1 elements alone, coloured by the page's style sheet where they have no colour of their own.
#pragma once

#include <string>

#include "app/picture/plot.h"

namespace warpscope {

std::string svgOf(const Plot& plot);
/// The same as a file of its own, on white.
std::string svgFileOf(const Plot& plot);

/// "&lt;" for "<" and so on: text for HTML, SVG and their attributes.
std::string escaped(const std::string& text);

}  // namespace warpscope
