// Laying out and labelling.
// See montage.h.
#include "app/picture/montage.h"

#include <algorithm>
#include <cmath>

#include "app/picture/picture.h"
#include "app/picture/text.h"

namespace warpscope {
namespace {

constexpr Rgba8 kPaper = 0xffffffffu;
constexpr Rgba8 kInk = 0xff202020u;
constexpr Rgba8 kFaintInk = 0xff606060u;
constexpr float kTitleHeight = 26.0f;
constexpr float kLabelHeight = 20.0f;
constexpr float kCaptionHeight = 16.0f;
constexpr uint32_t kGap = 8;

void drawCentered(Image<Rgba8>& page, float center, float y, const std::string& text, float height, Rgba8 color) {
  drawText(page, center - 0.5f * textWidth(text, height), y, text, height, color);
}

}  // namespace

Image<Rgba8> drawMontage(const Montage& montage, uint32_t cellWidth) {
  const Image<Rgba8>& first = montage.rows.front().cells.front().picture;
  const uint32_t width = std::min(cellWidth, first.width());
  const uint32_t height = std::max<uint32_t>(
      1, static_cast<uint32_t>(std::lround(static_cast<double>(first.height()) * width / first.width())));
  float labelWidth = 0.0f;
  for (const MontageRow& row : montage.rows) labelWidth = std::max(labelWidth, textWidth(row.label, kLabelHeight));

  const auto left = static_cast<uint32_t>(labelWidth) + 3 * kGap;
  const uint32_t top = static_cast<uint32_t>(kTitleHeight + kLabelHeight) + 3 * kGap;
  // Small pictures stand as far apart as what is written above and below them wants.
  float textRoom = 0.0f;
  for (const std::string& column : montage.columns) textRoom = std::max(textRoom, textWidth(column, kLabelHeight));
  for (const MontageRow& row : montage.rows)
    for (const MontageCell& cell : row.cells) textRoom = std::max(textRoom, textWidth(cell.caption, kCaptionHeight));
  const uint32_t room = std::max(width, static_cast<uint32_t>(std::ceil(textRoom)));
  const uint32_t pitchX = room + kGap;
  const uint32_t pitchY = height + static_cast<uint32_t>(kCaptionHeight) + kGap;
  const auto titleWidth = static_cast<uint32_t>(textWidth(montage.title, kTitleHeight)) + 2 * kGap;
  Image<Rgba8> page(std::max(left + pitchX * static_cast<uint32_t>(montage.columns.size()), titleWidth),
                    top + pitchY * static_cast<uint32_t>(montage.rows.size()) + kGap, kPaper);

  drawText(page, kGap, kGap, montage.title, kTitleHeight, kInk);
  for (size_t column = 0; column < montage.columns.size(); ++column)
    drawCentered(page, static_cast<float>(left + pitchX * column) + 0.5f * static_cast<float>(room),
                 kTitleHeight + 2 * kGap, montage.columns[column], kLabelHeight, kInk);
  for (size_t row = 0; row < montage.rows.size(); ++row) {
    const uint32_t y = top + pitchY * static_cast<uint32_t>(row);
    drawText(page, static_cast<float>(left) - kGap - textWidth(montage.rows[row].label, kLabelHeight),
             static_cast<float>(y) + 0.5f * (static_cast<float>(height) - kLabelHeight), montage.rows[row].label,
             kLabelHeight, kInk);
    for (size_t column = 0; column < montage.rows[row].cells.size(); ++column) {
      const MontageCell& cell = montage.rows[row].cells[column];
      const Image<Rgba8> picture = resized(cell.picture, width, height);
      const uint32_t x = left + pitchX * static_cast<uint32_t>(column) + (room - width) / 2;
      for (uint32_t v = 0; v < height; ++v) std::copy_n(picture.row(v), width, page.row(y + v) + x);
      drawCentered(page, static_cast<float>(x) + 0.5f * static_cast<float>(width), static_cast<float>(y + height),
                   cell.caption, kCaptionHeight, kFaintInk);
    }
  }
  return page;
}

}  // namespace warpscope
