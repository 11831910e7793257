// Bands: mask, and the layers of what lies in pixels.
// See packed_band.h.
#include "render/codec/packed_band.h"

#include <algorithm>
#include <bit>

#include "render/codec/band_layers.h"
#include "render/codec/layer_packer.h"
#include "render/codec/zstd_section.h"

namespace warpscope {
namespace {

uint64_t hashSamples(std::span<const PackedSample> samples) {
  WordHash hash(samples.size());
  hash.addAll(samples);
  return hash.value();
}

MaskShape shapeOf(const SampleFrame& frame, const BandRows& rows) {
  return {frame.camera.width, rows.first, rows.count};
}

}  // namespace

size_t mostLayers(const SampleFrame& frame) {
  if (frame.plane(kLayerPlane) == nullptr) return 1;
  return std::min(static_cast<size_t>(std::max(frame.settings.sample.samplesPerRay, 1)), kMaxLayers);
}

struct BandPacker::Buffers {
  BandLayers layers;
  LayerPacker packer;
  TransferVector<uint32_t> pixels;
  TransferVector<uint8_t> mask, changes, further;

  /// Fills `mask`, and `further` if there are such. No pixel has more than `mostLayers` samples.
  DecodeError takeMask(ByteReader& reader, const MaskShape& shape, size_t samples, size_t mostLayers);
};

BandPacker::BandPacker() : buffers_(std::make_unique<Buffers>()) {}
BandPacker::~BandPacker() = default;
BandPacker::BandPacker(BandPacker&&) noexcept = default;

uint64_t BandPacker::mostBytes(uint32_t width, uint32_t rows, uint64_t samples, uint64_t layers, ColorCoding coding) {
  const MaskShape shape{width, 0, rows};
  const uint64_t mask = kSectionHeadBytes + shape.size() + 1;
  const uint64_t further = layers > 1 ? kSectionHeadBytes + samples : 0;
  return kLeastBandBytes + mask + further + LayerPacker::mostBytes(shape, samples, layers, coding);
}

void BandPacker::pack(const SampleFrame& frame, const BandRows& rows, size_t begin, size_t end,
                      const CodecSettings& settings, ByteVector& out) {
  Buffers& b = *buffers_;
  const size_t count = end - begin;
  const MaskShape shape = shapeOf(frame, rows);
  const std::span<const PackedSample> samples(frame.samples.data() + begin, count);
  const std::span<const Rgba8> colors(frame.colors.data() + begin, count);

  b.pixels.resize(count);
  {
    // Locals: what is written cannot be what is read then.
    const uint32_t width = shape.width;
    const PackedSample* const sample = samples.data();
    uint32_t* const pixel = b.pixels.data();
    for (size_t i = 0; i < count; ++i) pixel[i] = rowOf(sample[i]) * width + columnOf(sample[i]);
  }
  b.mask.assign(shape.size(), 0);
  const bool hasFurther = !frame.layers().empty() && b.layers.begin(b.pixels);
  setBits(hasFurther ? b.layers.covered() : std::span<const uint32_t>(b.pixels), shape, b.mask);

  appendLittle(out, static_cast<uint32_t>(count));
  appendLittle(out, hashSamples(samples));
  const uint32_t rowBytes = shape.rowBytes();
  b.changes.resize(b.mask.size());
  std::copy_n(b.mask.begin(), rowBytes, b.changes.begin());
  for (size_t i = rowBytes; i < b.mask.size(); ++i) b.changes[i] = b.mask[i] ^ b.mask[i - rowBytes];
  appendSection(out, b.changes);
  appendLittle(out, static_cast<uint8_t>(hasFurther));
  if (!hasFurther) {
    b.packer.append(out, frame, rows.placement, shape, b.mask, samples, colors, settings);
    return;
  }
  appendSection(out, b.layers.behind());
  b.layers.gather(samples, colors);
  b.packer.append(out, frame, rows.placement, shape, b.mask, b.layers.samples(), b.layers.colors(), settings);
  while (b.layers.goBehind(shape)) {
    b.layers.gather(samples, colors);
    b.packer.append(out, frame, rows.placement, shape, b.layers.mask(), b.layers.samples(), b.layers.colors(),
                    settings);
  }
}

DecodeError BandPacker::Buffers::takeMask(ByteReader& reader, const MaskShape& shape, size_t samples,
                                          size_t mostLayers) {
  const uint32_t rowBytes = shape.rowBytes(), unused = 8 * rowBytes - shape.width;
  if (!takeSection(reader, mask)) return "the mask of a band's pixels is damaged";
  for (size_t i = rowBytes; i < mask.size(); ++i) mask[i] ^= mask[i - rowBytes];
  for (size_t end = rowBytes; end <= mask.size(); end += rowBytes)
    if (mask[end - 1] >> (8 - unused) != 0) return "the mask of a band covers pixels outside the picture";
  size_t covered = 0, furtherSamples = 0;
  for (const uint8_t byte : mask) covered += static_cast<size_t>(std::popcount(byte));
  if (reader.take<uint8_t>() != 0) {
    if (covered > samples) return "a band covers more pixels than it has samples";
    further.resize(covered);
    if (!takeSection(reader, further)) return "the numbers of samples a pixel are damaged";
    uint8_t deepest = 0;
    for (const uint8_t more : further) {
      furtherSamples += more;
      deepest = std::max(deepest, more);
    }
    if (deepest >= mostLayers) return "a band has more samples in a pixel than the frame's rays have";
  }
  if (covered + furtherSamples != samples) return "a band covers more or fewer pixels than it has samples";
  return std::nullopt;
}

DecodeError BandPacker::unpack(std::span<const std::byte> bytes, const SampleFrame& frame, const BandRows& rows,
                               ColorCoding coding, std::span<PackedSample> samples, std::span<Rgba8> colors,
                               std::span<uint8_t> layers) {
  Buffers& b = *buffers_;
  ByteReader reader(bytes);
  const auto itsCount = reader.take<uint32_t>();
  const auto hash = reader.take<uint64_t>();
  if (reader.ranOut() || itsCount != samples.size()) return "a band's numbers of samples contradict each other";

  const MaskShape shape = shapeOf(frame, rows);
  b.mask.resize(shape.size());
  b.further.clear();
  if (DecodeError error = b.takeMask(reader, shape, samples.size(), mostLayers(frame))) return error;

  // Layer 0 is all there is unless pixels have further samples.
  if (DecodeError error = b.packer.take(reader, frame, rows.placement, shape, b.mask, coding)) return error;
  if (b.further.empty()) {
    std::ranges::copy(b.packer.samples(), samples.begin());
    std::ranges::copy(b.packer.colors(), colors.begin());
    std::ranges::fill(layers, uint8_t{0});
  } else {
    b.layers.begin(b.packer.columns(), b.packer.rows(), shape.width, b.further);
    b.layers.scatter(b.packer.samples(), b.packer.colors(), samples, colors, layers);
    while (b.layers.goBehind(shape)) {
      if (DecodeError error = b.packer.take(reader, frame, rows.placement, shape, b.layers.mask(), coding))
        return error;
      b.layers.scatter(b.packer.samples(), b.packer.colors(), samples, colors, layers);
    }
  }
  if (reader.ranOut() || reader.left() > 0) return "a band is longer or shorter than it should be";
  if (hashSamples(samples) != hash)
    return "a band's samples are not those that were sent: other camera or settings than the sender's, or a machine "
           "that rounds differently";
  return std::nullopt;
}

}  // namespace warpscope
