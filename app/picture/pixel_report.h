// All that is known of one pixel of a warped picture, for people who look closely: in figures, as lines of text.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/picture/content.h"

namespace warpscope {

/// What a pixel shows.
enum class PixelKind {
  sample,        ///< a sample of the newest frame
  earlierFrame,  ///< something of a frame that was kept
  guess,         ///< something that no frame has
  hole,          ///< nothing, where the ground truth shows something
  nothing,       ///< nothing, where there is nothing, as far as that is known
  other,         ///< something that is not told apart: segments, a mesh, a march
};

/// A pixel of the server's image, and what its ray found.
struct ServerPixel {
  glm::uvec2 place{0};     ///< column, row from above
  uint32_t sample = 0;     ///< index in the frame
  float depth = 0.0f;      ///< from the picture's eye, volume units
  float radius = 0.0f;     ///< volume units
};

struct PixelReport {
  glm::uvec2 place{0};  ///< column, row from above
  PixelKind kind = PixelKind::nothing;
  glm::vec4 color{0.0f};                  ///< linear, premultiplied
  Rgba8 shown = 0;                        ///< over the background, as a screen shows it, without marks
  std::optional<ServerPixel> server;      ///< where it shows a sample
  uint32_t framesBack = 0;                ///< for PixelKind::earlierFrame
  std::optional<float> segments;          ///< how many its ray goes through, where the picture is drawn of them
  std::optional<float> segmentDepth;      ///< in the mean, from the eye, volume units; where there are any
  std::optional<glm::vec4> truth;         ///< linear, premultiplied
  std::optional<Rgba8> truthShown;        ///< as `shown`
  std::optional<float> flip;              ///< of this pixel
};

/// Throws InputError for a pixel outside of the picture.
PixelReport pixelReport(const ContentInputs& inputs, const glm::uvec2& place);

/// Pairs of a name and a figure, "radius" and "0.87 volume units"; what is not known is left out.
std::vector<std::pair<std::string, std::string>> linesOf(const PixelReport& report);
/// At most so many of them, where there is no room for all: what is least asked for goes first.
void shorten(std::vector<std::pair<std::string, std::string>>& lines, size_t most);

/// These lines, one below the other, with a tab between name and figure.
std::string textOf(const PixelReport& report);

}  // namespace warpscope
