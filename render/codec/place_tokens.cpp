// Differences as tokens.
// See place_tokens.h.
#include "render/codec/place_tokens.h"

#include "render/codec/place_differences.h"

namespace warpscope {

void PlaceTokens::put(const PixelPaths& paths, const BandLayout& layout, std::span<const int32_t> places, std::span<uint8_t> tokens, BitWriter& bits) {
  fine_.resize(places.size() + 1);
  fine_[0] = 0;
  codes_.resize(places.size());
  putPlaces(paths.fineScale(), layout.runs, places, fine_.data(), codes_.data());
  putTokens(codes_, tokens, bits);
}

void PlaceTokens::take(const PixelPaths& paths, const BandLayout& layout, std::span<const uint8_t> tokens, BitReader& bits, std::span<int32_t> places) {
  fine_.resize(places.size() + 1);
  fine_[0] = 0;
  const uint8_t* const token = tokens.data();
  BitReader take = bits;
  makeFromNeighbors(layout.runs, makingPlaces(paths.fineScale(), [&take, token](size_t k) { return takeToken(token[k], take); }, fine_.data(), places.data()));
  bits = take;
}

}  // namespace warpscope
