// Places along rays, what these do not give, colours.
// See layer_packer.h.
#include "render/codec/layer_packer.h"

#include "render/codec/position_deltas.h"
#include "render/codec/radius_tokens.h"
#include "render/codec/zstd_section.h"

namespace warpscope {
namespace {

/// Bits that a sample takes at most: two tokens' and a position's.
constexpr size_t kMostBits = 2 * kMostTokenBits + kMostDeltaBits;

}  // namespace

void LayerPacker::append(std::vector<std::byte>& out, const SampleFrame& frame, Placement placement,
                         const MaskShape& shape, std::span<const uint8_t> mask, std::span<const PackedSample> samples,
                         std::span<const Rgba8> colors, const CodecSettings& settings) {
  layout_.build(shape.width, shape.firstRow, shape.rowCount, mask);
  if (shape.rowCount > 0) {
    const size_t size = layout_.size();
    paths_.aim(frame, placement, layout_.columns, layout_.rows);
    places_.resize(size);
    positions_.resize(size);
    depths_.resize(size);
    paths_.locate(samples, places_);
    paths_.place(places_, positions_, depths_);
    tokens_.resize(size);
    deltas_.resize(size);
    radiusTokens_.resize(size);
    bitBytes_.resize((size * kMostBits + 7) / 8 + BitWriter::kSpareBytes);
    BitWriter bits(bitBytes_.data());
    placeTokens_.put(paths_, layout_, places_, tokens_, bits);
    putDeltas(samples, positions_, deltas_, bits);
    putRadii(frame, paths_, samples, depths_, colors, radiusTokens_, bits);
    appendSection(out, tokens_);
    appendSection(out, deltas_);
    appendSection(out, radiusTokens_);
    const std::span<const uint8_t> written = bits.finish();
    appendLittle(out, static_cast<uint32_t>(written.size()));
    appendSection(out, written);
  }
  colorPlanes_.append(out, layout_, shape.firstRow, mask, shape.rowBytes(), colors, settings);
}

DecodeError LayerPacker::take(ByteReader& reader, const SampleFrame& frame, Placement placement, const MaskShape& shape,
                              std::span<const uint8_t> mask, size_t strayCount, ColorCoding coding) {
  layout_.build(shape.width, shape.firstRow, shape.rowCount, mask);
  const size_t size = layout_.size();
  positions_.resize(size);
  BitReader bits({});
  if (shape.rowCount > 0) {
    tokens_.resize(size);
    deltas_.resize(size);
    radiusTokens_.resize(size);
    if (!takeSection(reader, tokens_) || !takeSection(reader, deltas_) || !takeSection(reader, radiusTokens_))
      return "the depths of a band are damaged";
    const auto bitLength = reader.take<uint32_t>();
    static_assert(kMostBits <= 8 * 16);
    if (bitLength > 16 * size) return "the depths of a band have more bits than they can use";
    bitBytes_.resize(bitLength);
    if (!takeSection(reader, bitBytes_)) return "the depths of a band are damaged";
    bits = BitReader(bitBytes_);
    paths_.aim(frame, placement, layout_.columns, layout_.rows);
    places_.resize(size);
    placeTokens_.take(paths_, layout_, tokens_, bits, places_);
    depths_.resize(size);
    paths_.place(places_, positions_, depths_);
    takeDeltas(deltas_, positions_, bits);
  }
  colors_.resize(size + strayCount);
  // Radii may follow from opacities, and their bits come before the colours' bytes: no other order would do for both.
  if (DecodeError error = colorPlanes_.take(reader, layout_, shape.firstRow, coding, colors_)) return error;
  if (size == 0) return std::nullopt;
  takeRadii(frame, paths_, radiusTokens_, depths_, colors_, positions_, bits);
  if (bits.ranOut()) return "the depths of a band end too early";
  return std::nullopt;
}

}  // namespace warpscope
