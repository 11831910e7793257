// Loops over places. They read and write through locals only: what they write cannot be what they read then.
// See place_tokens.h.
#include "render/codec/place_tokens.h"

#include <algorithm>

namespace warpscope {
namespace {

/// What loops need of a band.
struct Band {
  FineScale scale;
  const Neighbors* neighbors;
  const int32_t* kinds;  // not read if all are the same
  size_t size;
};

template <bool isOneKind>
inline Neighbors ofSameKind(Neighbors from, const int32_t* kinds, size_t i) {
  if constexpr (!isOneKind) {
    const int32_t kind = kinds[i + 1];
    if (kinds[from.west] != kind) from.west = from.north;
    if (kinds[from.north] != kind) from.north = from.west;
    if (kinds[from.northWest] != kind) from.northWest = from.north;
  }
  return from;
}

template <bool isOneKind>
void differences(const Band& band, const int32_t* fine, const int32_t* places, uint32_t* codes) {
  const FineScale scale = band.scale;
  const Neighbors* const neighbors = band.neighbors;
  const int32_t* const kinds = band.kinds;
  for (size_t i = 0; i < band.size; ++i) {
    const Neighbors from = ofSameKind<isOneKind>(neighbors[i], kinds, i);
    const int32_t likely = scale.placeOf(i, predicted(fine[from.west], fine[from.north], fine[from.northWest]));
    codes[i] = zigzag(static_cast<int32_t>(static_cast<uint32_t>(places[i]) - static_cast<uint32_t>(likely)));
  }
}

template <bool isOneKind>
void addDifferences(const Band& band, const uint8_t* tokens, int32_t* fine, int32_t* places, BitReader& bits) {
  const FineScale scale = band.scale;
  const Neighbors* const neighbors = band.neighbors;
  const int32_t* const kinds = band.kinds;
  BitReader take = bits;
  int32_t last = 0;  // what fine[i] became, nearly always the western neighbour's: it need not come back from memory
  for (size_t i = 0; i < band.size; ++i) {
    const Neighbors from = ofSameKind<isOneKind>(neighbors[i], kinds, i);
    const int32_t west = from.west == i ? last : fine[from.west];
    const int32_t likely = scale.placeOf(i, predicted(west, fine[from.north], fine[from.northWest]));
    const int32_t difference = unzigzag(takeToken(tokens[i], take));
    places[i] = static_cast<int32_t>(static_cast<uint32_t>(likely) + static_cast<uint32_t>(difference));
    last = scale.fineOf(i, places[i]);
    fine[i + 1] = last;
  }
  bits = take;
}

}  // namespace

void PlaceTokens::prepare(const PixelPaths& paths) {
  const std::span<const int32_t> kinds = paths.kinds();
  fine_.resize(kinds.size() + 1);
  fine_[0] = 0;
  if (paths.isOneKind()) return;
  kinds_.resize(kinds.size() + 1);
  kinds_[0] = 0;
  std::copy(kinds.begin(), kinds.end(), kinds_.begin() + 1);
}

void PlaceTokens::put(const PixelPaths& paths, const BandLayout& layout, std::span<const int32_t> places, std::span<uint8_t> tokens, BitWriter& bits) {
  prepare(paths);
  const Band band{paths.fineScale(), layout.neighbors.data(), kinds_.data(), places.size()};
  const FineScale scale = band.scale;
  const int32_t* const place = places.data();
  int32_t* const fine = fine_.data();
  for (size_t i = 0; i < band.size; ++i) fine[i + 1] = scale.fineOf(i, place[i]);
  codes_.resize(band.size);
  (paths.isOneKind() ? differences<true> : differences<false>)(band, fine, place, codes_.data());
  putTokens(codes_, tokens, bits);
}

void PlaceTokens::take(const PixelPaths& paths, const BandLayout& layout, std::span<const uint8_t> tokens, BitReader& bits, std::span<int32_t> places) {
  prepare(paths);
  const Band band{paths.fineScale(), layout.neighbors.data(), kinds_.data(), places.size()};
  (paths.isOneKind() ? addDifferences<true> : addDifferences<false>)(band, tokens.data(), fine_.data(), places.data(), bits);
}

}  // namespace warpscope
