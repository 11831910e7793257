// Loops over places. They read and write through locals only: what they write cannot be what they read then.
// See place_tokens.h.
#include "render/codec/place_tokens.h"

namespace warpscope {
void PlaceTokens::put(const PixelPaths& paths, const BandLayout& layout, std::span<const int32_t> places, std::span<uint8_t> tokens, BitWriter& bits) {
  const size_t count = places.size();
  fine_.resize(count + 1);
  fine_[0] = 0;
  codes_.resize(count);
  const FineScale scale = paths.fineScale();
  const Neighbors* const neighbors = layout.neighbors.data();
  const int32_t* const place = places.data();
  int32_t* const fine = fine_.data();
  uint32_t* const codes = codes_.data();
  for (size_t i = 0; i < count; ++i) fine[i + 1] = scale.fineOf(i, place[i]);
  for (size_t i = 0; i < count; ++i) {
    const Neighbors from = neighbors[i];
    const int32_t likely = scale.placeOf(i, predicted(fine[from.west], fine[from.north], fine[from.northWest]));
    codes[i] = zigzag(static_cast<int32_t>(static_cast<uint32_t>(place[i]) - static_cast<uint32_t>(likely)));
  }
  putTokens(codes_, tokens, bits);
}

void PlaceTokens::take(const PixelPaths& paths, const BandLayout& layout, std::span<const uint8_t> tokens, BitReader& bits, std::span<int32_t> places) {
  const size_t count = places.size();
  fine_.resize(count + 1);
  fine_[0] = 0;
  const FineScale scale = paths.fineScale();
  const Neighbors* const neighbors = layout.neighbors.data();
  const uint8_t* const token = tokens.data();
  int32_t* const fine = fine_.data();
  int32_t* const place = places.data();
  BitReader take = bits;
  int32_t last = 0;  // what fine[i] became, nearly always the western neighbour's: it need not come back from memory
  for (size_t i = 0; i < count; ++i) {
    const Neighbors from = neighbors[i];
    const int32_t west = from.west == i ? last : fine[from.west];
    const int32_t likely = scale.placeOf(i, predicted(west, fine[from.north], fine[from.northWest]));
    const int32_t difference = unzigzag(takeToken(token[i], take));
    place[i] = static_cast<int32_t>(static_cast<uint32_t>(likely) + static_cast<uint32_t>(difference));
    last = scale.fineOf(i, place[i]);
    fine[i + 1] = last;
  }
  bits = take;
}

}  // namespace warpscope
