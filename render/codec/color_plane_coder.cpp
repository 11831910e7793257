// Colours, predicted or as a picture.
// See color_plane_coder.h.
#include "render/codec/color_plane_coder.h"

#include <algorithm>
#include <bit>

#include "render/codec/color_differences.h"
#include "render/codec/jpeg.h"
#include "render/codec/zstd_section.h"

namespace warpscope {
namespace {

/// Places of samples in a picture of the area, whose first row is the picture's `firstRow`.
struct AreaPlaces {
  const uint32_t* columns;
  const uint32_t* rows;
  uint32_t firstColumn, firstRow, width;

  AreaPlaces(const BandLayout& layout, uint32_t firstRowOfBand)
      : columns(layout.columns.data()), rows(layout.rows.data()), firstColumn(layout.area.x0), firstRow(firstRowOfBand + layout.area.y0),
        width(layout.area.width()) {}
  size_t operator()(size_t i) const { return size_t{rows[i] - firstRow} * width + columns[i] - firstColumn; }
};

void toPicture(const Rgba8* colors, size_t count, const AreaPlaces& places, Rgba8* picture) {
  const AreaPlaces at = places;
  for (size_t i = 0; i < count; ++i) picture[at(i)] = colors[i];
}

void addFromPicture(const Rgba8* picture, size_t count, const AreaPlaces& places, Rgba8* colors) {
  const AreaPlaces at = places;
  for (size_t i = 0; i < count; ++i) colors[i] |= picture[at(i)] & 0xffffffu;
}

/// Gives pixels without samples the mean colour of their 8x8 block, so that they cost its transform nothing; blocks without samples the
/// colour of the block before. `mask` begins at the area.
void fillGaps(Rgba8* picture, const CoveredArea& area, const uint8_t* mask, uint32_t rowBytes) {
  const uint32_t width = area.width();
  Rgba8 mean = 0xff808080u;
  for (uint32_t y0 = 0; y0 < area.height(); y0 += 8) {
    const uint32_t y1 = std::min(y0 + 8, area.height());
    for (uint32_t x0 = 0; x0 < width; x0 += 8) {
      const uint8_t* column = mask + x0 / 8;
      uint32_t covered = 0;
      for (uint32_t y = y0; y < y1; ++y) covered += static_cast<uint32_t>(std::popcount(column[size_t{y} * rowBytes]));
      if (covered == 8 * (y1 - y0)) continue;
      if (covered > 0) {
        uint32_t red = 0, green = 0, blue = 0;
        for (uint32_t y = y0; y < y1; ++y)
          for (uint32_t bits = column[size_t{y} * rowBytes]; bits != 0; bits &= bits - 1) {
            const Rgba8 color = picture[size_t{y} * width + x0 + static_cast<uint32_t>(std::countr_zero(bits))];
            red += color & 255;
            green += color >> 8 & 255;
            blue += color >> 16 & 255;
          }
        mean = red / covered | green / covered << 8 | blue / covered << 16;
      }
      for (uint32_t y = y0; y < y1; ++y) {
        const uint8_t bits = column[size_t{y} * rowBytes];
        Rgba8* row = picture + size_t{y} * width + x0;
        for (uint32_t x = 0; x < 8; ++x) row[x] = bits >> x & 1 ? row[x] : mean;
      }
    }
  }
}

}  // namespace

uint64_t ColorPlaneCoder::mostBytes(uint32_t width, uint32_t rows, uint64_t samples, uint64_t layers, ColorCoding coding) {
  constexpr uint64_t kColors = 3;
  const uint64_t alpha = layers * kSectionHeadBytes + samples;
  if (coding == ColorCoding::lossless) return alpha + kColors * (layers * kSectionHeadBytes + samples);
  return alpha + layers * (sizeof(uint32_t) + mostJpegBytes((width + 7) / 8 * 8, rows));
}

void ColorPlaneCoder::append(ByteVector& out, const BandLayout& layout, uint32_t firstRow, std::span<const uint8_t> mask,
                         uint32_t rowBytes, std::span<const Rgba8> colors, const CodecSettings& settings) {
  const size_t count = colors.size();
  startColors(slots_, count);
  std::copy(colors.begin(), colors.end(), slots_.begin() + 1);
  alpha_.resize(count);

  if (settings.color == ColorCoding::jpeg) {
    putAlpha(slots_.data(), layout.runs, alpha_.data());
    appendSection(out, alpha_);
    const size_t start = out.size();
    appendLittle(out, uint32_t{0});
    const CoveredArea& area = layout.area;
    if (!area.isEmpty()) {
      picture_.resize(size_t{area.width()} * area.height());
      toPicture(colors.data(), layout.size(), AreaPlaces(layout, firstRow), picture_.data());
      fillGaps(picture_.data(), area, mask.data() + size_t{area.y0} * rowBytes + area.x0 / 8, rowBytes);
      appendJpeg(out, picture_.data(), area.width(), area.height(), settings.jpegQuality);
    }
    storeLittle(out.data() + start, static_cast<uint32_t>(out.size() - start - 4));
    return;
  }

  green_.resize(count);
  red_.resize(count);
  blue_.resize(count);
  putColors(slots_, layout.runs, count, differences_, {alpha_.data(), green_.data(), red_.data(), blue_.data()});
  appendSection(out, alpha_);
  appendSection(out, green_);
  appendSection(out, red_);
  appendSection(out, blue_);
}

DecodeError ColorPlaneCoder::take(ByteReader& reader, const BandLayout& layout, uint32_t firstRow, ColorCoding coding, std::span<Rgba8> colors) {
  const size_t count = colors.size();
  alpha_.resize(count);
  if (!takeSection(reader, alpha_)) return "the opacities are damaged";
  slots_.resize(count + 1);
  slots_[0] = 0;

  if (coding == ColorCoding::jpeg) {
    takeAlpha(alpha_.data(), layout.runs, slots_.data());
    const auto length = reader.take<uint32_t>();
    const std::span<const std::byte> jpeg = reader.take(length);
    const CoveredArea& area = layout.area;
    if (reader.ranOut() || jpeg.empty() != area.isEmpty()) return "the colours' picture is missing";
    if (!area.isEmpty()) {
      picture_.resize(size_t{area.width()} * area.height());
      if (DecodeError error = readJpeg(jpeg, picture_.data(), area.width(), area.height())) return error;
      addFromPicture(picture_.data(), layout.size(), AreaPlaces(layout, firstRow), slots_.data() + 1);
    }
  }

  if (coding == ColorCoding::lossless) {
    green_.resize(count);
    red_.resize(count);
    blue_.resize(count);
    if (!takeSection(reader, green_) || !takeSection(reader, red_) || !takeSection(reader, blue_)) return "the colours are damaged";
    joinDifferences({alpha_.data(), green_.data(), red_.data(), blue_.data()}, count, slots_.data() + 1);
    makeFromNeighbors(layout.runs, makingColors(slots_.data() + 1, slots_.data()));
  }
  std::copy(slots_.begin() + 1, slots_.end(), colors.begin());
  return std::nullopt;
}

}  // namespace warpscope
