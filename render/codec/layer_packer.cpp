// Places along rays, what these do not give, colours.
// See layer_packer.h.
#include "render/codec/layer_packer.h"

#include "render/codec/radius_tokens.h"
#include "render/codec/zstd_section.h"

namespace warpscope {
namespace {

/// Bits that a sample takes at most: three tokens'.
constexpr size_t kMostBits = 3 * kMostTokenBits;

}  // namespace

uint64_t LayerPacker::mostBytes(const MaskShape& shape, uint64_t samples, uint64_t layers, ColorCoding coding) {
  constexpr uint64_t kTokens = 3;
  const uint64_t bits = (samples * kMostBits + 7) / 8 + layers;  // each layer's are filled up to a byte
  const uint64_t heads = kTokens * kSectionHeadBytes + sizeof(uint32_t) + kSectionHeadBytes;
  return layers * heads + kTokens * samples + bits +
         ColorPlaneCoder::mostBytes(shape.width, shape.rowCount, samples, layers, coding);
}

void LayerPacker::append(ByteVector& out, const SampleFrame& frame, Placement placement,
                         const MaskShape& shape, std::span<const uint8_t> mask, std::span<const PackedSample> samples,
                         std::span<const Rgba8> colors, const CodecSettings& settings) {
  layout_.build(shape.width, shape.firstRow, shape.rowCount, mask);
  const size_t size = layout_.size();
  paths_.aim(frame, placement, layout_.columns, layout_.rows);
  places_.resize(size);
  depthCodes_.resize(size);
  paths_.locate(samples, places_);
  paths_.place(places_, depthCodes_);
  differences_.resize(size);
  {
    // Locals: what is written cannot be what is read then.
    const PackedSample* const sample = samples.data();
    const uint32_t* const likely = depthCodes_.data();
    uint32_t* const difference = differences_.data();
    for (size_t i = 0; i < size; ++i) difference[i] = zigzag(static_cast<int32_t>(depthCode(sample[i])) - static_cast<int32_t>(likely[i]));
  }
  tokens_.resize(size);
  depthTokens_.resize(size);
  radiusTokens_.resize(size);
  bitBytes_.resize((size * kMostBits + 7) / 8 + BitWriter::kSpareBytes);
  BitWriter bits(bitBytes_.data());
  placeTokens_.put(paths_, layout_, places_, tokens_, bits);
  putTokens(differences_, depthTokens_, bits);
  putRadii(frame, samples, colors, radiusTokens_, bits);
  appendSection(out, tokens_);
  appendSection(out, depthTokens_);
  appendSection(out, radiusTokens_);
  const std::span<const uint8_t> written = bits.finish();
  appendLittle(out, static_cast<uint32_t>(written.size()));
  appendSection(out, written);
  colorCoder_.append(out, layout_, shape.firstRow, mask, shape.rowBytes(), colors, settings);
}

DecodeError LayerPacker::take(ByteReader& reader, const SampleFrame& frame, Placement placement, const MaskShape& shape,
                              std::span<const uint8_t> mask, ColorCoding coding) {
  layout_.build(shape.width, shape.firstRow, shape.rowCount, mask);
  const size_t size = layout_.size();
  tokens_.resize(size);
  depthTokens_.resize(size);
  radiusTokens_.resize(size);
  if (!takeSection(reader, tokens_) || !takeSection(reader, depthTokens_) || !takeSection(reader, radiusTokens_))
    return "the depths of a band are damaged";
  const auto bitLength = reader.take<uint32_t>();
  static_assert(kMostBits <= 8 * 16);
  if (bitLength > 16 * size) return "the depths of a band have more bits than they can use";
  bitBytes_.resize(bitLength);
  if (!takeSection(reader, bitBytes_)) return "the depths of a band are damaged";
  BitReader bits(bitBytes_);
  paths_.aim(frame, placement, layout_.columns, layout_.rows);
  places_.resize(size);
  placeTokens_.take(paths_, layout_, tokens_, bits, places_);
  depthCodes_.resize(size);
  paths_.place(places_, depthCodes_);
  positions_.resize(size);
  takePositions(bits);
  colors_.resize(size);
  // Radii may follow from opacities, and their bits come before the colours' bytes: no other order would do for both.
  if (DecodeError error = colorCoder_.take(reader, layout_, shape.firstRow, coding, colors_)) return error;
  if (size == 0) return std::nullopt;
  takeRadii(frame, radiusTokens_, colors_, positions_, bits);
  if (bits.ranOut()) return "the depths of a band end too early";
  return std::nullopt;
}

void LayerPacker::takePositions(BitReader& bits) {
  // Locals: what is written cannot be what is read then.
  const size_t size = positions_.size();
  uint32_t* const code = depthCodes_.data();
  if (!isZero(depthTokens_)) {
    const uint8_t* const token = depthTokens_.data();
    BitReader take = bits;
    for (size_t i = 0; i < size; ++i) code[i] = (code[i] + static_cast<uint32_t>(unzigzag(takeToken(token[i], take)))) & kDepthCodeMax;
    bits = take;
  }
  const uint32_t* const column = layout_.columns.data();
  const uint32_t* const row = layout_.rows.data();
  PackedSample* const position = positions_.data();
  for (size_t i = 0; i < size; ++i) position[i] = packCodes(column[i], row[i], code[i], 0);
}

}  // namespace warpscope
