// Colours, predicted or as a picture.
// See color_planes.h.
#include "render/codec/color_planes.h"

#include <algorithm>
#include <bit>

#include "render/codec/jpeg.h"
#include "render/codec/zstd_section.h"

namespace warpscope {
namespace {

inline int32_t channel(Rgba8 color, int shift) { return static_cast<int32_t>(color >> shift & 255); }

inline int32_t predictedChannel(const Rgba8* slots, const Neighbors& from, int shift) {
  return predicted(channel(slots[from.west], shift), channel(slots[from.north], shift), channel(slots[from.northWest], shift));
}

// Loops over all samples read and write through locals only: what they write cannot be what they read then.

/// Differences of `count` samples' opacities from their prediction; `slots` are their colours, one place on.
void putAlpha(const Rgba8* slots, const Neighbors* neighbors, size_t count, uint8_t* alpha) {
  for (size_t i = 0; i < count; ++i)
    alpha[i] = static_cast<uint8_t>(channel(slots[i + 1], 24) - predictedChannel(slots, neighbors[i], 24));
}

/// Makes colours of opacity alone.
void takeAlpha(const uint8_t* alpha, const Neighbors* neighbors, size_t count, Rgba8* slots) {
  Rgba8 last = 0;  // what slots[i] became, nearly always the western neighbour's: it need not come back from memory
  for (size_t i = 0; i < count; ++i) {
    const Neighbors from = neighbors[i];
    const int32_t west = channel(from.west == i ? last : slots[from.west], 24), north = channel(slots[from.north], 24);
    const int32_t likely = predicted(west, north, channel(slots[from.northWest], 24));
    last = static_cast<Rgba8>((alpha[i] + likely) & 255) << 24;
    slots[i + 1] = last;
  }
}

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

/// Differences of red, green and blue from their prediction, a plane each; green's is taken off the others'.
struct ColorDifferences {
  uint8_t* green;
  uint8_t* red;
  uint8_t* blue;
};

/// Of `count` samples; `slots` are their colours, one place on.
void putColors(const Rgba8* slots, const Neighbors* neighbors, size_t count, ColorDifferences out) {
  for (size_t i = 0; i < count; ++i) {
    const Neighbors from = neighbors[i];
    const Rgba8 color = slots[i + 1], west = slots[from.west], north = slots[from.north], northWest = slots[from.northWest];
    const auto difference = [&](int shift) {
      return channel(color, shift) - predicted(channel(west, shift), channel(north, shift), channel(northWest, shift));
    };
    const int32_t green = difference(8);
    out.green[i] = static_cast<uint8_t>(green);
    out.red[i] = static_cast<uint8_t>(difference(0) - green);
    out.blue[i] = static_cast<uint8_t>(difference(16) - green);
  }
}

/// Back: adds red, green and blue to slots that have their opacity alone.
void takeColors(ColorDifferences in, const Neighbors* neighbors, size_t count, Rgba8* slots) {
  Rgba8 last = slots[0];  // what slots[i] became, nearly always the western neighbour's: it need not come back from memory
  for (size_t i = 0; i < count; ++i) {
    const Neighbors at = neighbors[i];
    const Rgba8 west = at.west == i ? last : slots[at.west], north = slots[at.north], northWest = slots[at.northWest];
    const int32_t green = in.green[i];
    const auto decoded = [&](int shift, int32_t difference) {
      const int32_t likely = predicted(channel(west, shift), channel(north, shift), channel(northWest, shift));
      return static_cast<Rgba8>((likely + difference) & 255) << shift;
    };
    last = slots[i + 1] | decoded(8, green) | decoded(0, in.red[i] + green) | decoded(16, in.blue[i] + green);
    slots[i + 1] = last;
  }
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

uint64_t ColorPlanes::mostBytes(uint32_t width, uint32_t rows, uint64_t samples, uint64_t layers, ColorCoding coding) {
  constexpr uint64_t kColors = 3;
  const uint64_t alpha = layers * kSectionHeadBytes + samples;
  if (coding == ColorCoding::lossless) return alpha + kColors * (layers * kSectionHeadBytes + samples);
  return alpha + layers * (sizeof(uint32_t) + mostJpegBytes((width + 7) / 8 * 8, rows));
}

void ColorPlanes::append(std::vector<std::byte>& out, const BandLayout& layout, uint32_t firstRow, std::span<const uint8_t> mask,
                         uint32_t rowBytes, std::span<const Rgba8> colors, const CodecSettings& settings) {
  const size_t count = colors.size();
  slots_.resize(count + 1);
  slots_[0] = 0;
  std::copy(colors.begin(), colors.end(), slots_.begin() + 1);
  alpha_.resize(count);
  putAlpha(slots_.data(), layout.neighbors.data(), layout.size(), alpha_.data());
  appendSection(out, alpha_);

  if (settings.color == ColorCoding::jpeg) {
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
  putColors(slots_.data(), layout.neighbors.data(), count, {green_.data(), red_.data(), blue_.data()});
  appendSection(out, green_);
  appendSection(out, red_);
  appendSection(out, blue_);
}

DecodeError ColorPlanes::take(ByteReader& reader, const BandLayout& layout, uint32_t firstRow, ColorCoding coding, std::span<Rgba8> colors) {
  const size_t count = colors.size();
  alpha_.resize(count);
  if (!takeSection(reader, alpha_)) return "the opacities are damaged";
  slots_.resize(count + 1);
  slots_[0] = 0;
  takeAlpha(alpha_.data(), layout.neighbors.data(), layout.size(), slots_.data());

  if (coding == ColorCoding::jpeg) {
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
    takeColors({green_.data(), red_.data(), blue_.data()}, layout.neighbors.data(), count, slots_.data());
  }
  std::copy(slots_.begin() + 1, slots_.end(), colors.begin());
  return std::nullopt;
}

}  // namespace warpscope
