// Distances to shapes, and what they cover.
// See plot_picture.h.
#include "app/picture/plot_picture.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <string>

#include "app/picture/plot_drawing.h"
#include "app/picture/text.h"

namespace warpscope {
namespace {

constexpr uint32_t kWhite = 0xffffff, kInk = 0x222222, kGrid = 0xdddddd, kAxis = 0x777777;
constexpr double kDash = 5.0, kGap = 4.0;

Rgba8 codeOf(uint32_t rgb) { return 0xff000000u | (rgb & 255) << 16 | (rgb & 0xff00) | rgb >> 16; }

void blend(Rgba8& pixel, uint32_t rgb, double coverage) {
  const Rgba8 color = codeOf(rgb);
  Rgba8 mixed = 0xff000000u;
  for (int shift = 0; shift < 24; shift += 8) {
    const double behind = pixel >> shift & 255, front = color >> shift & 255;
    mixed |= static_cast<Rgba8>(std::lround(behind + coverage * (front - behind))) << shift;
  }
  pixel = mixed;
}

/// Draws onto a picture in the plot's units.
class Canvas {
 public:
  Canvas(double width, double height, double scale)
      : scale_(scale), picture_(static_cast<uint32_t>(std::ceil(width * scale)), static_cast<uint32_t>(std::ceil(height * scale)), codeOf(kWhite)) {}

  Image<Rgba8> take() { return std::move(picture_); }

  void drawLine(const glm::dvec2& from, const glm::dvec2& to, double width, uint32_t rgb) {
    const glm::dvec2 along = to - from;
    const double length2 = std::max(glm::dot(along, along), 1e-12);
    cover(glm::min(from, to), glm::max(from, to), width, [&](const glm::dvec2& at) {
      const double share = std::clamp(glm::dot(at - from, along) / length2, 0.0, 1.0);
      return std::pair{glm::distance(at, from + share * along) - 0.5 * width, rgb};
    });
  }

  /// A polyline; its dashes go on around corners.
  void drawCurve(const PlotDrawing::Curve& curve) {
    double walked = 0.0;
    for (size_t i = 0; i + 1 < curve.points.size(); ++i) {
      const glm::dvec2 from = curve.points[i], to = curve.points[i + 1];
      const double length = glm::distance(from, to);
      if (!(length > 0.0)) continue;  // nor points that are no numbers
      if (!curve.isDashed) {
        drawLine(from, to, PlotDrawing::kCurvePx, curve.rgb);
        continue;
      }
      for (double begin = -std::fmod(walked, kDash + kGap); begin < length; begin += kDash + kGap) {
        const double first = std::max(begin, 0.0), last = std::min(begin + kDash, length);
        if (first < last) drawLine(glm::mix(from, to, first / length), glm::mix(from, to, last / length), PlotDrawing::kCurvePx, curve.rgb);
      }
      walked += length;
    }
  }

  void drawRing(const glm::dvec2& center, double radius, double width, uint32_t rgb) {
    cover(center - radius, center + radius, width, [&](const glm::dvec2& at) { return std::pair{std::abs(glm::distance(at, center) - radius) - 0.5 * width, rgb}; });
  }

  /// In as many equal sectors as there are colours, the first one's from the top, clockwise.
  void drawDisc(const glm::dvec2& center, double radius, const std::vector<uint32_t>& colors) {
    cover(center - radius, center + radius, 0.0, [&](const glm::dvec2& at) {
      const glm::dvec2 from = at - center;
      const double turns = std::atan2(from.x, -from.y) / (2.0 * std::numbers::pi), share = turns < 0.0 ? turns + 1.0 : turns;
      const size_t sector = std::min(static_cast<size_t>(share * static_cast<double>(colors.size())), colors.size() - 1);
      return std::pair{glm::length(from) - radius, colors[sector]};
    });
  }

  void drawLabel(const PlotDrawing::Label& label, double sizePx, uint32_t rgb) {
    const float height = textHeightOf(static_cast<float>(sizePx * scale_)), width = textWidth(label.text, height), ascent = textAscent(height);
    const float shift = label.anchor == PlotDrawing::Anchor::start ? 0.0f : label.anchor == PlotDrawing::Anchor::middle ? 0.5f * width : width;
    const glm::vec2 at = glm::vec2(scale_ * label.at);
    if (!label.isUpright) return drawText(picture_, at.x - shift, at.y - ascent, label.text, height, codeOf(rgb));
    Image<Rgba8> line(static_cast<uint32_t>(std::ceil(width)) + 2, static_cast<uint32_t>(std::ceil(height)) + 2, codeOf(kWhite));
    drawText(line, 1.0f, 1.0f, label.text, height, codeOf(rgb));
    const auto left = static_cast<int64_t>(std::lround(at.x - ascent)) - 1, below = static_cast<int64_t>(std::lround(at.y + shift)) + 1;
    for (uint32_t v = 0; v < line.height(); ++v)
      for (uint32_t u = 0; u < line.width(); ++u) {
        const int64_t x = left + v, y = below - u;
        if (x >= 0 && y >= 0 && x < picture_.width() && y < picture_.height()) picture_(static_cast<uint32_t>(x), static_cast<uint32_t>(y)) = line(u, v);
      }
  }

 private:
  /// `shape` gives the signed distance of a place from it, and its colour there; it and half of `margin` around it lie between `lower` and `upper`.
  template <class Shape>
  void cover(const glm::dvec2& lower, const glm::dvec2& upper, double margin, const Shape& shape) {
    const glm::dvec2 most{picture_.width(), picture_.height()};
    const glm::dvec2 first = glm::clamp(glm::floor(scale_ * (lower - 0.5 * margin)) - 1.0, glm::dvec2(0.0), most);
    const glm::dvec2 last = glm::clamp(glm::ceil(scale_ * (upper + 0.5 * margin)) + 1.0, glm::dvec2(0.0), most);
    for (auto y = static_cast<uint32_t>(first.y); y < static_cast<uint32_t>(last.y); ++y)
      for (auto x = static_cast<uint32_t>(first.x); x < static_cast<uint32_t>(last.x); ++x) {
        const auto [distance, rgb] = shape(glm::dvec2(x + 0.5, y + 0.5) / scale_);
        if (const double coverage = std::clamp(0.5 - scale_ * distance, 0.0, 1.0); coverage > 0.0) blend(picture_(x, y), rgb, coverage);
      }
  }

  const double scale_;
  Image<Rgba8> picture_;
};

}  // namespace

Image<Rgba8> pictureOf(const Plot& plot, float scale) {
  using Anchor = PlotDrawing::Anchor;
  const PlotDrawing drawing = layOut(plot);
  Canvas canvas(drawing.width, drawing.height, scale);
  for (const PlotDrawing::Line& line : drawing.lines) canvas.drawLine(line.from, line.to, 1.0, line.isAxis ? kAxis : kGrid);
  for (const PlotDrawing::Label& label : drawing.labels) canvas.drawLabel(label, PlotDrawing::kTextPx, kInk);
  for (const PlotDrawing::Curve& curve : drawing.curves) canvas.drawCurve(curve);
  for (const PlotDrawing::LegendEntry& entry : drawing.legend) {
    canvas.drawDisc(entry.at + PlotDrawing::kKeyOffset, PlotDrawing::kKeyRadius, {entry.rgb});
    canvas.drawLabel({entry.at, Anchor::start, entry.name}, PlotDrawing::kTextPx, kInk);
  }
  for (const PlotDrawing::Mark& mark : drawing.marks) {
    if (mark.isEmphasized) canvas.drawRing(mark.at, PlotDrawing::kRingRadius, PlotDrawing::kRingPx, kInk);
    canvas.drawDisc(mark.at, PlotDrawing::radiusOf(mark), mark.colors);
    if (mark.count > 1) canvas.drawLabel({mark.at + PlotDrawing::kCountOffset, Anchor::start, std::to_string(mark.count)}, PlotDrawing::kCountPx, kInk);
  }
  return canvas.take();
}

}  // namespace warpscope
