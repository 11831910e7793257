// Bands: strays, mask, and the layers of what lies in pixels.
// See packed_band.h.
#include "render/codec/packed_band.h"

#include <algorithm>
#include <bit>

#include "render/codec/band_layers.h"
#include "render/codec/band_strays.h"
#include "render/codec/layer_packer.h"
#include "render/codec/zstd_section.h"

namespace warpscope {
namespace {

uint64_t hashSamples(std::span<const PackedSample> samples) {
  WordHash hash(samples.size());
  hash.addAll(samples);
  return hash.value();
}

/// Samples in one pixel. Where the frame does not say which are of one ray, those of several rays may be.
size_t mostLayers(const SampleFrame& frame) {
  if (frame.plane(kLayerPlane) == nullptr) return kMaxLayers;
  return std::min(static_cast<size_t>(std::max(frame.settings.sample.samplesPerRay, 1)), kMaxLayers);
}

MaskShape shapeOf(const SampleFrame& frame, const BandRows& rows) {
  return rows.count > 0 ? MaskShape{frame.camera.width, rows.first, rows.count} : MaskShape{};
}

}  // namespace

struct BandPacker::Buffers {
  BandStrays strays;
  BandLayers layers;
  LayerPacker packer;
  TransferVector<uint8_t> mask, changes, further;
  TransferVector<Rgba8> colors;  // of a layer, and then of strays

  /// These, which are the front layer's, with those of strays behind.
  std::span<const Rgba8> withStrays(std::span<const Rgba8> front) {
    if (strays.size() == 0) return front;
    colors.assign(front.begin(), front.end());
    colors.insert(colors.end(), strays.colors().begin(), strays.colors().end());
    return colors;
  }

  /// Fills `mask`, and `further` if there are such. No pixel has more than `mostLayers` samples.
  DecodeError takeMask(ByteReader& reader, const MaskShape& shape, size_t samplesOnPaths, size_t mostLayers);
};

bool isAscending(std::span<const uint32_t> pixels) {
  bool isOutOfOrder = !pixels.empty() && pixels.back() == kNoSample;
  for (size_t i = 1; i < pixels.size(); ++i) isOutOfOrder |= pixels[i - 1] >= pixels[i];
  return !isOutOfOrder;
}

BandPacker::BandPacker() : buffers_(std::make_unique<Buffers>()) {}
BandPacker::~BandPacker() = default;
BandPacker::BandPacker(BandPacker&&) noexcept = default;

void BandPacker::pack(const SampleFrame& frame, const BandRows& rows, size_t begin, size_t end,
                      std::span<const uint32_t> pixels, const CodecSettings& settings, std::vector<std::byte>& out) {
  Buffers& b = *buffers_;
  const size_t count = end - begin;
  const MaskShape shape = shapeOf(frame, rows);
  const std::span<const PackedSample> samples(frame.samples.data() + begin, count);
  std::span<const PackedSample> onPath = samples;
  std::span<const Rgba8> colors(frame.colors.data() + begin, count);
  bool hasFurther = false;

  b.strays.clear();
  b.mask.assign(shape.size(), 0);
  if (rows.count == 0) {
    b.strays.takeAll(frame, begin, count);
    onPath = {};
    colors = {};
  } else if (const auto itsPixels = pixels.subspan(begin, count); isAscending(itsPixels)) {
    setBits(itsPixels, shape, b.mask);
  } else {
    std::span<const uint32_t> pathPixels = itsPixels;
    if (std::ranges::find(itsPixels, kNoSample) != itsPixels.end()) {
      b.strays.takeOut(frame, begin, itsPixels);
      onPath = b.strays.onPath();
      colors = b.strays.pathColors();
      pathPixels = b.strays.pathPixels();
    }
    hasFurther = b.layers.begin(pathPixels);
    setBits(b.layers.covered(), shape, b.mask);
  }

  appendLittle(out, static_cast<uint32_t>(count));
  appendLittle(out, static_cast<uint32_t>(b.strays.size()));
  appendLittle(out, hashSamples(samples));
  b.strays.append(out);
  if (rows.count > 0) {
    const uint32_t rowBytes = shape.rowBytes();
    b.changes.resize(b.mask.size());
    std::copy_n(b.mask.begin(), rowBytes, b.changes.begin());
    for (size_t i = rowBytes; i < b.mask.size(); ++i) b.changes[i] = b.mask[i] ^ b.mask[i - rowBytes];
    appendSection(out, b.changes);
    appendLittle(out, static_cast<uint8_t>(hasFurther));
    if (hasFurther) appendSection(out, b.layers.behind());
  }

  if (!hasFurther) {
    b.packer.append(out, frame, rows.placement, shape, b.mask, onPath, b.withStrays(colors), settings);
    return;
  }
  b.layers.gather(onPath, colors);
  b.packer.append(out, frame, rows.placement, shape, b.mask, b.layers.samples(), b.withStrays(b.layers.colors()),
                  settings);
  while (b.layers.goBehind(shape)) {
    b.layers.gather(onPath, colors);
    b.packer.append(out, frame, rows.placement, shape, b.layers.mask(), b.layers.samples(), b.layers.colors(),
                    settings);
  }
}

DecodeError BandPacker::Buffers::takeMask(ByteReader& reader, const MaskShape& shape, size_t samplesOnPaths,
                                          size_t mostLayers) {
  const uint32_t rowBytes = shape.rowBytes(), unused = 8 * rowBytes - shape.width;
  if (!takeSection(reader, mask)) return "the mask of a band's pixels is damaged";
  for (size_t i = rowBytes; i < mask.size(); ++i) mask[i] ^= mask[i - rowBytes];
  for (size_t end = rowBytes; end <= mask.size(); end += rowBytes)
    if (mask[end - 1] >> (8 - unused) != 0) return "the mask of a band covers pixels outside the picture";
  size_t covered = 0, furtherSamples = 0;
  for (const uint8_t byte : mask) covered += static_cast<size_t>(std::popcount(byte));
  if (reader.take<uint8_t>() != 0) {
    if (covered > samplesOnPaths) return "a band covers more pixels than it has samples";
    further.resize(covered);
    if (!takeSection(reader, further)) return "the numbers of samples a pixel are damaged";
    uint8_t deepest = 0;
    for (const uint8_t more : further) {
      furtherSamples += more;
      deepest = std::max(deepest, more);
    }
    if (deepest >= mostLayers) return "a band has more samples in a pixel than the frame's rays have";
  }
  if (covered + furtherSamples != samplesOnPaths) return "a band covers more or fewer pixels than it has samples";
  return std::nullopt;
}

DecodeError BandPacker::unpack(std::span<const std::byte> bytes, const SampleFrame& frame, const BandRows& rows,
                               ColorCoding coding, std::span<PackedSample> samples, std::span<Rgba8> colors,
                               std::span<uint8_t> layers) {
  Buffers& b = *buffers_;
  ByteReader reader(bytes);
  const size_t count = samples.size();
  const auto itsCount = reader.take<uint32_t>();
  const size_t strayCount = reader.take<uint32_t>();
  const auto hash = reader.take<uint64_t>();
  if (reader.ranOut() || itsCount != count || strayCount > count)
    return "a band's numbers of samples contradict each other";
  if (strayCount > kMaxBandStrays) return "a band has too many samples without place";
  if (DecodeError error = b.strays.take(reader, count, strayCount, !layers.empty())) return error;

  const MaskShape shape = shapeOf(frame, rows);
  b.mask.resize(shape.size());
  b.further.clear();
  if (rows.count > 0) {
    if (DecodeError error = b.takeMask(reader, shape, count - strayCount, mostLayers(frame))) return error;
  } else if (strayCount != count) {
    return "a band without pixels has samples in them";
  }

  // Layer 0 has the colours of strays, and is all there is unless pixels have further samples.
  if (DecodeError error = b.packer.take(reader, frame, rows.placement, shape, b.mask, strayCount, coding)) return error;
  const size_t size = b.packer.samples().size();
  b.strays.setColors(b.packer.colors().subspan(size));
  // Samples on paths; straight to where they belong if no strays stand between them.
  const std::span<PackedSample> onPath = strayCount > 0 ? b.strays.roomOnPath(count - strayCount) : samples;
  const std::span<Rgba8> pathColors = strayCount > 0 ? b.strays.roomForColors(count - strayCount) : colors;
  const std::span<uint8_t> pathLayers = layers.empty() ? layers : layers.first(count - strayCount);
  if (b.further.empty()) {
    std::copy_n(b.packer.samples().begin(), size, onPath.begin());
    std::copy_n(b.packer.colors().begin(), size, pathColors.begin());
    std::fill(pathLayers.begin(), pathLayers.end(), uint8_t{0});
  } else {
    b.layers.begin(b.packer.columns(), b.packer.rows(), shape.width, b.further);
    b.layers.scatter(b.packer.samples(), b.packer.colors(), onPath, pathColors, pathLayers);
    while (b.layers.goBehind(shape)) {
      if (DecodeError error = b.packer.take(reader, frame, rows.placement, shape, b.layers.mask(), 0, coding))
        return error;
      b.layers.scatter(b.packer.samples(), b.packer.colors(), onPath, pathColors, pathLayers);
    }
  }
  if (reader.ranOut() || reader.left() > 0) return "a band is longer or shorter than it should be";
  if (strayCount > 0) b.strays.merge(samples, colors, layers);
  if (hashSamples(samples) != hash)
    return "a band's samples are not those that were sent: other camera or settings than the sender's, or a machine "
           "that rounds differently";
  return std::nullopt;
}

}  // namespace warpscope
