// Looking things up, and writing them down.
// See pixel_report.h.
#include "app/picture/pixel_report.h"

#include <array>
#include <cmath>

#include "app/picture/picture.h"
#include "render/base/error.h"
#include "render/base/formatted.h"
#include "render/metrics/holes.h"

namespace warpscope {
namespace {

Rgba8 shownOf(const glm::vec4& premultiplied, const glm::vec3& background) {
  Image<glm::vec4> pixel(1, 1);
  pixel[0] = premultiplied;
  return toScreen(pixel, background)[0];
}

PixelKind kindOf(uint32_t sample, const ContentInputs& inputs, float opacity, const std::optional<glm::vec4>& truth) {
  if (sample == kNoSample || (sample == kNotASample && opacity == 0.0f)) return truth && truth->a >= kShownAlpha ? PixelKind::hole : PixelKind::nothing;
  if (sample == kFilled) return PixelKind::guess;
  if (framesBack(sample) > 0) return PixelKind::earlierFrame;
  return inputs.frame != nullptr && sample < inputs.frame->size() ? PixelKind::sample : PixelKind::other;
}

ServerPixel serverPixelOf(const ContentInputs& inputs, uint32_t sample) {
  const PackedSample packed = inputs.frame->samples[sample];
  const Sphere sphere = unpackSample(packed, inputs.frame->grid());
  return {{columnOf(packed), rowOf(packed)}, sample, glm::length(sphere.center - inputs.camera.eye), sphere.radius};
}

/// As displayed, of 255: "128 64 0".
std::string codesText(Rgba8 shown) { return std::to_string(shown & 255) + " " + std::to_string(shown >> 8 & 255) + " " + std::to_string(shown >> 16 & 255); }

std::string placeText(const glm::uvec2& place) { return std::to_string(place.x) + ", " + std::to_string(place.y); }

std::string kindText(const PixelReport& report) {
  switch (report.kind) {
    case PixelKind::sample: return "sample " + std::to_string(report.server->sample);
    case PixelKind::earlierFrame: return "of the kept frame " + std::to_string(report.framesBack) + " before";
    case PixelKind::guess: return "a guess";
    case PixelKind::hole: return "a hole";
    case PixelKind::nothing: return "nothing";
    case PixelKind::other: return "something";
  }
  return "";
}

}  // namespace

PixelReport pixelReport(const ContentInputs& inputs, const glm::uvec2& place) {
  const WarpedImage& image = inputs.image;
  if (place.x >= image.color.width() || place.y >= image.color.height()) throw InputError("the pixel is outside of the picture");
  PixelReport report;
  report.place = place;
  report.color = image.color(place.x, place.y);
  report.shown = shownOf(report.color, inputs.background);
  const Image<glm::vec4>* truth = inputs.reference;
  if (truth != nullptr && truth->width() == image.color.width() && truth->height() == image.color.height()) {
    report.truth = (*truth)(place.x, place.y);
    report.truthShown = shownOf(*report.truth, inputs.background);
  }
  if (inputs.flip != nullptr && inputs.flip->width() == image.color.width() && inputs.flip->height() == image.color.height())
    report.flip = (*inputs.flip)(place.x, place.y);
  const uint32_t sample = image.samples(place.x, place.y);
  report.kind = kindOf(sample, inputs, report.color.a, report.truth);
  report.framesBack = framesBack(sample);
  if (report.kind == PixelKind::sample) report.server = serverPixelOf(inputs, sample);
  const SegmentLook* look = inputs.segments;
  if (look != nullptr && look->count.width() == image.color.width() && look->count.height() == image.color.height()) {
    report.segments = look->count(place.x, place.y);
    if (const float depth = look->depth(place.x, place.y); std::isfinite(depth)) report.segmentDepth = depth;
  }
  return report;
}

std::vector<std::pair<std::string, std::string>> linesOf(const PixelReport& report) {
  std::vector<std::pair<std::string, std::string>> lines{
      {"pixel", placeText(report.place)},
      {"shows", kindText(report)},
      {"colour", codesText(report.shown)},
      {"opacity", formatted("%.3f", report.color.a)},
  };
  if (report.server) {
    lines.emplace_back("depth", formatted("%.4g", report.server->depth));
    lines.emplace_back("radius", formatted("%.3g", report.server->radius));
    lines.emplace_back("server's pixel", placeText(report.server->place));
  }
  if (report.segments) lines.emplace_back("segments", formatted("%.0f", *report.segments));
  if (report.segmentDepth) lines.emplace_back("their depth", formatted("%.4g", *report.segmentDepth));
  if (report.truth) {
    lines.emplace_back("truth", codesText(*report.truthShown));
    lines.emplace_back("its opacity", formatted("%.3f", report.truth->a));
  }
  if (report.flip) lines.emplace_back("FLIP", formatted("%.4f", *report.flip));
  return lines;
}

void shorten(std::vector<std::pair<std::string, std::string>>& lines, size_t most) {
  constexpr std::array<std::string_view, 8> kLeastFirst{"server's pixel", "pixel", "its opacity", "radius", "shows", "segments", "opacity", "their depth"};
  for (const std::string_view name : kLeastFirst)
    if (lines.size() > most) std::erase_if(lines, [&](const auto& line) { return line.first == name; });
  if (lines.size() > most) lines.resize(most);
}

std::string textOf(const PixelReport& report) {
  std::string text;
  for (const auto& [name, figure] : linesOf(report)) text += name + "\t" + figure + "\n";
  return text;
}

}  // namespace warpscope
