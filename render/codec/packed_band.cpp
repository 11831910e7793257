// Bands: strays, mask, places along rays, what these do not give, colours.
// See packed_band.h.
#include "render/codec/packed_band.h"

#include <algorithm>
#include <array>

#include "render/codec/band_layout.h"
#include "render/codec/color_planes.h"
#include "render/codec/place_tokens.h"
#include "render/codec/tokens.h"
#include "render/codec/zstd_section.h"
#include "render/march/march_setup.h"

namespace warpscope {
namespace {

constexpr size_t kWordBytes = sizeof(PackedSample);

// How a position differs from its place's: each coordinate by -2..2, or too much to say so.
constexpr int kReach = 2;
constexpr int kDeltas = 2 * kReach + 1;
constexpr int kNoDelta = (kReach * kDeltas + kReach) * kDeltas + kReach;
constexpr int kDeltaCodes = kDeltas * kDeltas * kDeltas;
constexpr uint8_t kExact = 0;
constexpr uint8_t kEscape = kDeltaCodes;
constexpr uint32_t kEscapedBits = 27;  // twice

inline int coordinate(PackedSample sample, int axis) {
  return static_cast<int>(sample >> static_cast<int>(kPositionBits) * axis & kPositionMax);
}

inline uint8_t deltaCode(PackedSample sample, PackedSample place) {
  const int x = coordinate(sample, 0) - coordinate(place, 0), y = coordinate(sample, 1) - coordinate(place, 1),
            z = coordinate(sample, 2) - coordinate(place, 2);
  const bool isFar = glm::max(glm::max(std::abs(x), std::abs(y)), std::abs(z)) > kReach;
  const int code = ((x + kReach) * kDeltas + y + kReach) * kDeltas + z + kReach - kNoDelta;
  return static_cast<uint8_t>(isFar ? kEscape : code < 0 ? code + kDeltaCodes : code);
}

/// What deltaCode() stands for, for every byte: three coordinates to be added, each within its 18 bits.
constexpr std::array<PackedSample, 256> kMoves = [] {
  std::array<PackedSample, 256> moves{};
  for (int code = 0; code < 256; ++code) {
    const int shifted = (code + kNoDelta) % kDeltaCodes;
    const int deltas[] = {shifted / (kDeltas * kDeltas) - kReach, shifted / kDeltas % kDeltas - kReach, shifted % kDeltas - kReach};
    for (int axis = 0; axis < 3; ++axis)
      moves[static_cast<size_t>(code)] |= static_cast<uint64_t>(static_cast<uint32_t>(deltas[axis]) & kPositionMax)
                                          << static_cast<int>(kPositionBits) * axis;
  }
  return moves;
}();
static_assert(kMoves[kExact] == 0 && kMoves[kEscape] == 0);

/// Coordinates that leave their 18 bits wrap around: no carry leaves a coordinate's highest bit.
inline PackedSample moved(PackedSample place, uint8_t deltaCode) {
  constexpr uint64_t kHighest = uint64_t{1} << (kPositionBits - 1) | uint64_t{1} << (2 * kPositionBits - 1) | uint64_t{1} << (3 * kPositionBits - 1);
  const PackedSample move = kMoves[deltaCode];
  return ((place & ~kHighest) + (move & ~kHighest)) ^ ((place ^ move) & kHighest);
}

/// What a sample's radius should be, from what else is known of it.
class RadiusPrediction {
 public:
  explicit RadiusPrediction(const SampleFrame& frame)
      : rule_(sampleRuleOf(frame)), camera_(frame.camera),
        isSame_(rule_.policy == RadiusPolicy::voxel || rule_.policy == RadiusPolicy::constant),
        same_(code(1.0f, 1.0f, 0)) {}

  uint32_t operator()(float depth, float cosine, Rgba8 color) const { return isSame_ ? same_ : code(depth, cosine, color); }
  bool isSame() const { return isSame_; }
  uint32_t same() const { return same_; }

 private:
  uint32_t code(float depth, float cosine, Rgba8 color) const {
    const float opacity = static_cast<float>(color >> 24) / 255.0f;
    return encodeRadius(sampleRadius(rule_, camera_, depth, cosine, opacity), rule_.quantization.radiusUnit);
  }

  SampleRule rule_;
  const Camera& camera_;
  bool isSame_;  // for all samples
  uint32_t same_;
};

/// Sets the bits of pixels that rise; `mask` has `rowBytes` for each row of `width` from `firstRow` on.
void setBits(std::span<const uint32_t> pixels, uint32_t firstRow, uint32_t width, uint32_t rowBytes, uint8_t* mask) {
  uint32_t rowStart = firstRow * width;
  size_t rowAt = 0, at = 0;
  uint32_t bits = 0;  // of the byte at `at`
  for (const uint32_t pixel : pixels) {
    while (pixel - rowStart >= width) {
      rowStart += width;
      rowAt += rowBytes;
    }
    const uint32_t column = pixel - rowStart;
    const size_t byte = rowAt + column / 8;
    if (byte != at) {
      mask[at] |= static_cast<uint8_t>(bits);
      bits = 0;
      at = byte;
    }
    bits |= 1u << column % 8;
  }
  if (bits != 0) mask[at] |= static_cast<uint8_t>(bits);
}

uint64_t hashSamples(std::span<const PackedSample> samples) {
  WordHash hash(samples.size());
  hash.addAll(samples);
  return hash.value();
}

// Loops read and write through locals only: what they write cannot be what they read then.

void findDeltas(std::span<const PackedSample> samples, std::span<const PackedSample> places, std::span<uint8_t> deltas) {
  const PackedSample* const sample = samples.data();
  const PackedSample* const place = places.data();
  uint8_t* const delta = deltas.data();
  for (size_t i = 0; i < deltas.size(); ++i) delta[i] = deltaCode(sample[i], place[i]);
}

void addDeltas(std::span<const uint8_t> deltas, std::span<PackedSample> positions) {
  const uint8_t* const delta = deltas.data();
  PackedSample* const position = positions.data();
  for (size_t i = 0; i < deltas.size(); ++i) position[i] = moved(position[i], delta[i]);
}

void putRadii(const RadiusPrediction& radius, std::span<const PackedSample> samples, const PixelPaths& paths, std::span<const float> depths,
              std::span<const Rgba8> colors, std::span<uint8_t> tokens, BitWriter& bits) {
  const size_t count = tokens.size();
  if (radius.isSame()) {
    uint32_t differing = 0;
    for (size_t i = 0; i < count; ++i) differing |= radiusCode(samples[i]) ^ radius.same();
    if (differing == 0) {
      std::fill(tokens.begin(), tokens.end(), uint8_t{0});
      return;
    }
  }
  for (size_t i = 0; i < count; ++i) {
    const auto likely = static_cast<int32_t>(radius(depths[i], paths.cosine(i), colors[i]));
    tokens[i] = putToken(zigzag(static_cast<int32_t>(radiusCode(samples[i])) - likely), bits);
  }
}

void takeRadii(const RadiusPrediction& radius, std::span<const uint8_t> tokens, const PixelPaths& paths, std::span<const float> depths,
               std::span<const Rgba8> colors, std::span<PackedSample> positions, BitReader& bits) {
  const size_t count = tokens.size();
  PackedSample* const position = positions.data();
  if (radius.isSame() && isZero(tokens)) {
    const uint64_t code = static_cast<uint64_t>(radius.same() & kRadiusCodeMax) << kRadiusShift;
    for (size_t i = 0; i < count; ++i) position[i] = (position[i] & kPositionMask) | code;
    return;
  }
  BitReader take = bits;
  for (size_t i = 0; i < count; ++i) {
    const auto likely = radius(depths[i], paths.cosine(i), colors[i]);
    const uint32_t difference = static_cast<uint32_t>(unzigzag(takeToken(tokens[i], take)));
    position[i] = (position[i] & kPositionMask) | static_cast<uint64_t>((likely + difference) & kRadiusCodeMax) << kRadiusShift;
  }
  bits = take;
}

}  // namespace

struct BandPacker::Buffers {
  // Of a band:
  TransferVector<PackedSample> onPath, strays;
  TransferVector<Rgba8> pathColors, strayColors;
  TransferVector<uint32_t> pathPixels;
  TransferVector<uint8_t> isStray, strayBytes, strayLayers;
  TransferVector<uint8_t> mask, changes, further;
  // Of the pixels that a layer covers: which they are; how many more samples they have behind this one.
  TransferVector<uint32_t> covered;
  TransferVector<uint8_t> behind;
  // Samples on paths, layer after layer, and where each layer begins.
  TransferVector<PackedSample> byLayer;
  TransferVector<Rgba8> colorsByLayer;
  std::array<size_t, kMaxLayers> layerBegins{};
  // Of a layer:
  TransferVector<PackedSample> positions;
  TransferVector<Rgba8> colors;  // and then of strays
  TransferVector<uint8_t> layerMask, tokens, deltas, radiusTokens, bitBytes;
  TransferVector<int32_t> places;
  TransferVector<float> depths;
  BandLayout layout;
  PixelPaths paths;
  PlaceTokens placeTokens;
  ColorPlanes colorPlanes;

  /// Tells samples without a pixel from those on paths. `pixels` are of the samples, which begin at `begin`.
  void takeStraysOut(const SampleFrame& frame, size_t begin, std::span<const uint32_t> pixels);
  /// Finds which pixels are covered and how often. `pixels` are of the samples on paths. True if a pixel has further samples.
  bool findCovered(std::span<const uint32_t> pixels);
  /// Fills byLayer and colorsByLayer with samples on paths, whose pixels these are.
  void sortIntoLayers(std::span<const uint32_t> pixels, std::span<const PackedSample> itsSamples, std::span<const Rgba8> itsColors);
  /// Goes on to the next layer: leaves out the pixels that have no sample there. Fills layerMask. False if no pixel is left.
  bool goBehind(uint32_t width, const BandRows& rows, uint32_t rowBytes);

  /// Colours: of the samples, then of strays.
  void packLayer(const SampleFrame& frame, const BandRows& rows, std::span<const uint8_t> itsMask, std::span<const PackedSample> itsSamples,
                 std::span<const Rgba8> itsColors, const CodecSettings& settings, std::vector<std::byte>& out);
  /// Fills `positions` and `colors`, the latter with those of so many strays behind.
  DecodeError unpackLayer(ByteReader& reader, const SampleFrame& frame, const BandRows& rows, std::span<const uint8_t> itsMask, size_t strayCount,
                          ColorCoding coding);
};

bool isAscending(std::span<const uint32_t> pixels) {
  bool isOutOfOrder = !pixels.empty() && pixels.back() == kNoSample;
  for (size_t i = 1; i < pixels.size(); ++i) isOutOfOrder |= pixels[i - 1] >= pixels[i];
  return !isOutOfOrder;
}

BandPacker::BandPacker() : buffers_(std::make_unique<Buffers>()) {}
BandPacker::~BandPacker() = default;
BandPacker::BandPacker(BandPacker&&) noexcept = default;

void BandPacker::Buffers::takeStraysOut(const SampleFrame& frame, size_t begin, std::span<const uint32_t> pixels) {
  const size_t count = pixels.size();
  const std::span<const uint8_t> layers = frame.layers();
  onPath.resize(count);
  pathColors.resize(count);
  pathPixels.resize(count);
  isStray.assign((count + 7) / 8, 0);
  size_t placed = 0;
  for (size_t i = 0; i < count; ++i) {
    if (pixels[i] == kNoSample) {
      isStray[i / 8] |= static_cast<uint8_t>(1u << i % 8);
      strays.push_back(frame.samples[begin + i]);
      strayColors.push_back(frame.colors[begin + i]);
      if (!layers.empty()) strayLayers.push_back(layers[begin + i]);
      continue;
    }
    onPath[placed] = frame.samples[begin + i];
    pathColors[placed] = frame.colors[begin + i];
    pathPixels[placed++] = pixels[i];
  }
  onPath.resize(placed);
  pathColors.resize(placed);
  pathPixels.resize(placed);
}

bool BandPacker::Buffers::findCovered(std::span<const uint32_t> pixels) {
  const size_t count = pixels.size();
  covered.resize(count);
  behind.resize(count);
  // Locals: what is written cannot be what is read then.
  uint32_t* const pixelOf = covered.data();
  uint8_t* const furtherOf = behind.data();
  uint32_t last = kNoSample, rank = 0, deepest = 0;
  size_t found = 0;
  for (size_t i = 0; i < count; ++i) {
    const uint32_t pixel = pixels[i];
    const bool isNext = pixel != last;
    rank = isNext ? 0 : rank + 1;
    deepest = rank > deepest ? rank : deepest;
    found += isNext;
    pixelOf[found - 1] = pixel;
    furtherOf[found - 1] = static_cast<uint8_t>(rank);
    last = pixel;
  }
  covered.resize(found);
  behind.resize(found);
  return deepest > 0;
}

void BandPacker::Buffers::sortIntoLayers(std::span<const uint32_t> pixels, std::span<const PackedSample> itsSamples, std::span<const Rgba8> itsColors) {
  const size_t count = pixels.size();
  byLayer.resize(count);
  colorsByLayer.resize(count);
  std::array<size_t, kMaxLayers + 1> sizes{};
  for (const uint8_t deepest : behind) ++sizes[deepest];
  for (size_t layer = kMaxLayers; layer-- > 0;) sizes[layer] += sizes[layer + 1];  // pixels that are at least as deep
  size_t begin = 0;
  for (size_t layer = 0; layer < kMaxLayers; ++layer) {
    layerBegins[layer] = begin;
    begin += sizes[layer];
  }
  std::array<size_t, kMaxLayers> next = layerBegins;
  PackedSample* const sorted = byLayer.data();
  Rgba8* const sortedColors = colorsByLayer.data();
  const PackedSample* const sample = itsSamples.data();
  const Rgba8* const color = itsColors.data();
  uint32_t last = kNoSample, rank = 0;
  for (size_t i = 0; i < count; ++i) {
    const uint32_t pixel = pixels[i];
    rank = pixel != last ? 0 : rank + 1;
    const size_t place = next[rank]++;
    sorted[place] = sample[i];
    sortedColors[place] = color[i];
    last = pixel;
  }
}

bool BandPacker::Buffers::goBehind(uint32_t width, const BandRows& rows, uint32_t rowBytes) {
  size_t left = 0;
  for (size_t j = 0; j < covered.size(); ++j) {
    covered[left] = covered[j];
    const uint8_t more = behind[j];
    behind[left] = static_cast<uint8_t>(more - 1);
    left += more > 0;
  }
  covered.resize(left);
  behind.resize(left);
  layerMask.assign(size_t{rowBytes} * rows.count, 0);
  setBits(covered, rows.first, width, rowBytes, layerMask.data());
  return left > 0;
}

void BandPacker::Buffers::packLayer(const SampleFrame& frame, const BandRows& rows, std::span<const uint8_t> itsMask,
                                    std::span<const PackedSample> itsSamples, std::span<const Rgba8> itsColors, const CodecSettings& settings,
                                    std::vector<std::byte>& out) {
  const uint32_t width = rows.count > 0 ? frame.camera.width : 0;
  layout.build(width, rows.first, rows.count, itsMask);
  if (rows.count > 0) {
    const size_t size = layout.size();
    paths.aim(frame, rows.placement, layout.columns, layout.rows);
    places.resize(size);
    positions.resize(size);
    depths.resize(size);
    paths.locate(itsSamples, places);
    paths.place(places, positions, depths);
    tokens.resize(size);
    deltas.resize(size);
    radiusTokens.resize(size);
    bitBytes.resize(size * (2 * kMostTokenBits + 2 * kEscapedBits + 7) / 8 + BitWriter::kSpareBytes);
    BitWriter bits(bitBytes.data());
    placeTokens.put(paths, layout, places, tokens, bits);
    findDeltas(itsSamples, positions, deltas);
    for (size_t i = 0; i < size; ++i) {
      if (deltas[i] != kEscape) continue;
      bits.put(static_cast<uint32_t>(itsSamples[i] & 0x7ffffffu), kEscapedBits);
      bits.put(static_cast<uint32_t>(itsSamples[i] >> 27 & 0x7ffffffu), kEscapedBits);
    }
    putRadii(RadiusPrediction(frame), itsSamples, paths, depths, itsColors, radiusTokens, bits);
    appendSection(out, tokens);
    appendSection(out, deltas);
    appendSection(out, radiusTokens);
    const std::span<const uint8_t> written = bits.finish();
    appendLittle(out, static_cast<uint32_t>(written.size()));
    appendSection(out, written);
  }
  colorPlanes.append(out, layout, rows.first, itsMask, (width + 7) / 8, itsColors, settings);
}

void BandPacker::pack(const SampleFrame& frame, const BandRows& rows, size_t begin, size_t end, std::span<const uint32_t> pixels,
                      const CodecSettings& settings, std::vector<std::byte>& out) {
  Buffers& b = *buffers_;
  const size_t count = end - begin;
  const uint32_t width = rows.count > 0 ? frame.camera.width : 0;
  const uint32_t rowBytes = (width + 7) / 8;
  const std::span<const PackedSample> samples(frame.samples.data() + begin, count);
  std::span<const PackedSample> onPath = samples;
  std::span<const Rgba8> colors(frame.colors.data() + begin, count);
  bool hasFurther = false;

  b.strays.clear();
  b.strayColors.clear();
  b.strayLayers.clear();
  b.mask.assign(size_t{rowBytes} * rows.count, 0);
  if (rows.count == 0) {
    b.isStray.assign((count + 7) / 8, 0);
    for (size_t i = 0; i < count; ++i) b.isStray[i / 8] |= static_cast<uint8_t>(1u << i % 8);
    b.strays.assign(samples.begin(), samples.end());
    if (const std::span<const uint8_t> layers = frame.layers(); !layers.empty())
      b.strayLayers.assign(layers.begin() + static_cast<ptrdiff_t>(begin), layers.begin() + static_cast<ptrdiff_t>(end));
    onPath = {};
  } else if (const auto itsPixels = pixels.subspan(begin, count); isAscending(itsPixels)) {
    setBits(itsPixels, rows.first, width, rowBytes, b.mask.data());
  } else {
    std::span<const uint32_t> pathPixels = itsPixels;
    if (std::ranges::find(itsPixels, kNoSample) != itsPixels.end()) {
      b.takeStraysOut(frame, begin, itsPixels);
      onPath = b.onPath;
      colors = b.pathColors;
      pathPixels = b.pathPixels;
    }
    hasFurther = b.findCovered(pathPixels);
    if (hasFurther) b.sortIntoLayers(pathPixels, onPath, colors);
    setBits(b.covered, rows.first, width, rowBytes, b.mask.data());
  }

  appendLittle(out, static_cast<uint32_t>(count));
  appendLittle(out, static_cast<uint32_t>(b.strays.size()));
  appendLittle(out, hashSamples(samples));
  if (!b.strays.empty()) {
    appendSection(out, b.isStray);
    b.strayBytes.resize(b.strays.size() * kWordBytes);
    for (size_t byte = 0; byte < kWordBytes; ++byte)
      for (size_t i = 0; i < b.strays.size(); ++i)
        b.strayBytes[byte * b.strays.size() + i] = static_cast<uint8_t>(b.strays[i] >> 8 * byte);
    appendSection(out, b.strayBytes);
    if (!b.strayLayers.empty()) appendSection(out, b.strayLayers);
  }
  if (rows.count > 0) {
    b.changes.resize(b.mask.size());
    std::copy_n(b.mask.begin(), rowBytes, b.changes.begin());
    for (size_t i = rowBytes; i < b.mask.size(); ++i) b.changes[i] = b.mask[i] ^ b.mask[i - rowBytes];
    appendSection(out, b.changes);
    appendLittle(out, static_cast<uint8_t>(hasFurther));
    if (hasFurther) appendSection(out, b.behind);
  }

  if (!hasFurther) {
    if (!b.strayColors.empty()) {
      b.colors.assign(colors.begin(), colors.end());
      b.colors.insert(b.colors.end(), b.strayColors.begin(), b.strayColors.end());
      colors = b.colors;
    }
    b.packLayer(frame, rows, b.mask, onPath, colors, settings, out);
    return;
  }
  std::span<const uint8_t> mask = b.mask;
  for (uint32_t layer = 0; layer == 0 || b.goBehind(width, rows, rowBytes); ++layer) {
    if (layer > 0) mask = b.layerMask;
    const size_t first = b.layerBegins[layer], size = b.covered.size();
    colors = std::span(b.colorsByLayer).subspan(first, size);
    if (layer == 0 && !b.strayColors.empty()) {
      b.colors.assign(colors.begin(), colors.end());
      b.colors.insert(b.colors.end(), b.strayColors.begin(), b.strayColors.end());
      colors = b.colors;
    }
    b.packLayer(frame, rows, mask, std::span(b.byLayer).subspan(first, size), colors, settings, out);
  }
}

DecodeError BandPacker::Buffers::unpackLayer(ByteReader& reader, const SampleFrame& frame, const BandRows& rows, std::span<const uint8_t> itsMask,
                                             size_t strayCount, ColorCoding coding) {
  layout.build(rows.count > 0 ? frame.camera.width : 0, rows.first, rows.count, itsMask);
  const size_t size = layout.size();
  BitReader bits({});
  if (rows.count > 0) {
    tokens.resize(size);
    deltas.resize(size);
    radiusTokens.resize(size);
    if (!takeSection(reader, tokens) || !takeSection(reader, deltas) || !takeSection(reader, radiusTokens))
      return "the depths of a band are damaged";
    const auto bitLength = reader.take<uint32_t>();
    // At most 30 bits for a token, of which there are two, and 54 for an escaped position.
    if (bitLength > 16 * size) return "the depths of a band have more bits than they can use";
    bitBytes.resize(bitLength);
    if (!takeSection(reader, bitBytes)) return "the depths of a band are damaged";
    bits = BitReader(bitBytes);
    paths.aim(frame, rows.placement, layout.columns, layout.rows);
    places.resize(size);
    placeTokens.take(paths, layout, tokens, bits, places);
    positions.resize(size);
    depths.resize(size);
    paths.place(places, positions, depths);
    addDeltas(deltas, positions);
    for (size_t i = 0; i < size; ++i) {
      if (deltas[i] != kEscape) continue;
      const uint64_t low = bits.take(kEscapedBits);
      positions[i] = low | static_cast<uint64_t>(bits.take(kEscapedBits)) << kEscapedBits;
    }
  }
  colors.resize(size + strayCount);
  // Radii may follow from opacities, and their bits come before the colours' bytes: no other order would do for both.
  if (DecodeError error = colorPlanes.take(reader, layout, rows.first, coding, colors)) return error;
  if (size == 0) return std::nullopt;
  takeRadii(RadiusPrediction(frame), radiusTokens, paths, depths, colors, positions, bits);
  if (bits.ranOut()) return "the depths of a band end too early";
  return std::nullopt;
}

DecodeError BandPacker::unpack(std::span<const std::byte> bytes, const SampleFrame& frame, const BandRows& rows, ColorCoding coding,
                               std::span<PackedSample> samples, std::span<Rgba8> colors, std::span<uint8_t> layers) {
  Buffers& b = *buffers_;
  ByteReader reader(bytes);
  const size_t count = samples.size();
  const auto itsCount = reader.take<uint32_t>();
  const size_t strayCount = reader.take<uint32_t>();
  const auto hash = reader.take<uint64_t>();
  if (reader.ranOut() || itsCount != count || strayCount > count) return "a band's numbers of samples contradict each other";
  if (strayCount > kMaxBandStrays) return "a band has too many samples without place";
  const uint32_t width = rows.count > 0 ? frame.camera.width : 0;
  const uint32_t rowBytes = (width + 7) / 8;

  b.strays.resize(strayCount);
  b.strayLayers.resize(layers.empty() ? 0 : strayCount);
  if (strayCount > 0) {
    b.isStray.resize((count + 7) / 8);
    b.strayBytes.resize(strayCount * kWordBytes);
    if (!takeSection(reader, b.isStray) || !takeSection(reader, b.strayBytes)) return "a band's samples without place are damaged";
    if (!layers.empty() && !takeSection(reader, b.strayLayers)) return "the layers of a band's samples without place are damaged";
    size_t marked = 0;
    for (size_t i = 0; i < count; ++i) marked += b.isStray[i / 8] >> i % 8 & 1;
    if (marked != strayCount) return "a band's samples without place are not as many as it says";
    std::fill(b.strays.begin(), b.strays.end(), PackedSample{0});
    for (size_t byte = 0; byte < kWordBytes; ++byte)
      for (size_t i = 0; i < strayCount; ++i) b.strays[i] |= static_cast<uint64_t>(b.strayBytes[byte * strayCount + i]) << 8 * byte;
  }

  b.mask.resize(size_t{rowBytes} * rows.count);
  b.further.clear();
  if (rows.count > 0) {
    if (!takeSection(reader, b.mask)) return "the mask of a band's pixels is damaged";
    for (size_t i = rowBytes; i < b.mask.size(); ++i) b.mask[i] ^= b.mask[i - rowBytes];
    const uint32_t unused = 8 * rowBytes - width;
    size_t covered = 0, further = 0;
    for (size_t end = rowBytes; end <= b.mask.size(); end += rowBytes)
      if (b.mask[end - 1] >> (8 - unused) != 0) return "the mask of a band covers pixels outside the picture";
    for (const uint8_t byte : b.mask) covered += static_cast<size_t>(std::popcount(byte));
    if (reader.take<uint8_t>() != 0) {
      if (covered > count) return "a band covers more pixels than it has samples";
      b.further.resize(covered);
      if (!takeSection(reader, b.further)) return "the numbers of samples a pixel are damaged";
      for (const uint8_t more : b.further) further += more;
    }
    if (covered + further + strayCount != count) return "a band covers more or fewer pixels than it has samples";
  } else if (strayCount != count) {
    return "a band without pixels has samples in them";
  }

  // Layer 0 has the colours of strays, and is all there is unless pixels have further samples.
  if (DecodeError error = b.unpackLayer(reader, frame, rows, b.mask, strayCount, coding)) return error;
  const size_t size = b.layout.size();
  b.strayColors.assign(b.colors.begin() + static_cast<ptrdiff_t>(size), b.colors.end());
  // Samples on paths; straight to where they belong if no strays stand between them.
  std::span<PackedSample> onPath = samples;
  std::span<Rgba8> pathColors = colors;
  if (strayCount > 0) {
    b.onPath.resize(count - strayCount);
    b.pathColors.resize(count - strayCount);
    onPath = b.onPath;
    pathColors = b.pathColors;
  }
  std::span<uint8_t> pathLayers;
  if (!layers.empty()) {
    std::fill(layers.begin(), layers.end(), uint8_t{0});
    pathLayers = layers.first(count - strayCount);
  }
  if (b.further.empty()) {
    std::copy_n(b.positions.begin(), size, onPath.begin());
    std::copy_n(b.colors.begin(), size, pathColors.begin());
  } else {
    b.covered.resize(size);
    for (size_t j = 0; j < size; ++j) b.covered[j] = b.layout.rows[j] * width + b.layout.columns[j];
    b.behind.assign(b.further.begin(), b.further.end());
    b.byLayer.resize(onPath.size());
    b.colorsByLayer.resize(onPath.size());
    size_t layer = 0, begin = 0;
    do {
      if (layer > 0)
        if (DecodeError error = b.unpackLayer(reader, frame, rows, b.layerMask, 0, coding)) return error;
      const auto to = static_cast<ptrdiff_t>(begin);
      std::copy(b.positions.begin(), b.positions.end(), b.byLayer.begin() + to);
      std::copy_n(b.colors.begin(), b.positions.size(), b.colorsByLayer.begin() + to);
      b.layerBegins[layer++] = begin;
      begin += b.positions.size();
    } while (b.goBehind(width, rows, rowBytes));
    std::array<size_t, kMaxLayers> next = b.layerBegins;
    size_t at = 0;
    for (const uint32_t more : b.further)
      for (uint32_t rank = 0; rank <= more; ++rank, ++at) {
        const size_t place = next[rank]++;
        onPath[at] = b.byLayer[place];
        pathColors[at] = b.colorsByLayer[place];
        if (!pathLayers.empty()) pathLayers[at] = static_cast<uint8_t>(rank);
      }
  }
  if (reader.ranOut() || reader.left() > 0) return "a band is longer or shorter than it should be";

  if (strayCount > 0) {
    // From the end: layers on paths move to where they belong within the same memory.
    size_t path = count - strayCount, stray = strayCount;
    for (size_t i = count; i-- > 0;) {
      const bool isStray = b.isStray[i / 8] >> i % 8 & 1;
      --(isStray ? stray : path);
      samples[i] = isStray ? b.strays[stray] : b.onPath[path];
      colors[i] = isStray ? b.strayColors[stray] : b.pathColors[path];
      if (!layers.empty()) layers[i] = isStray ? b.strayLayers[stray] : pathLayers[path];
    }
  }
  if (hashSamples(samples) != hash)
    return "a band's samples are not those that were sent: other camera or settings than the sender's, or a machine that rounds differently";
  return std::nullopt;
}

}  // namespace warpscope
