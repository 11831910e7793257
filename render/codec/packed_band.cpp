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
  TransferVector<PackedSample> onPath, positions, strays;
  TransferVector<Rgba8> colors;  // of samples on paths, then of strays
  TransferVector<uint8_t> isStray, strayBytes;
  TransferVector<uint32_t> covered;  // pixels
  TransferVector<uint8_t> mask, changes, further;
  TransferVector<uint8_t> tokens, deltas, radiusTokens, bitBytes;
  TransferVector<int32_t> places;
  TransferVector<float> depths;
  BandLayout layout;
  PixelPaths paths;
  PlaceTokens placeTokens;
  ColorPlanes colorPlanes;

  /// Takes what is in no pixel's place out, and finds which pixels are covered and how often. `pixels` are of the samples.
  void sortOut(const SampleFrame& frame, const BandRows& rows, size_t begin, std::span<const uint32_t> pixels, uint32_t rowBytes);
};

bool isAscending(std::span<const uint32_t> pixels) {
  bool isOutOfOrder = !pixels.empty() && pixels.back() == kNoSample;
  for (size_t i = 1; i < pixels.size(); ++i) isOutOfOrder |= pixels[i - 1] >= pixels[i];
  return !isOutOfOrder;
}

BandPacker::BandPacker() : buffers_(std::make_unique<Buffers>()) {}
BandPacker::~BandPacker() = default;
BandPacker::BandPacker(BandPacker&&) noexcept = default;

void BandPacker::Buffers::sortOut(const SampleFrame& frame, const BandRows& rows, size_t begin, std::span<const uint32_t> pixels, uint32_t rowBytes) {
  const size_t count = pixels.size();
  const uint32_t width = frame.camera.width;
  onPath.resize(count);
  colors.resize(count);
  isStray.assign((count + 7) / 8, 0);
  covered.clear();
  size_t placed = 0;
  bool anyFurther = false;
  for (size_t i = 0; i < count; ++i) {
    if (pixels[i] == kNoSample) {
      isStray[i / 8] |= static_cast<uint8_t>(1u << i % 8);
      strays.push_back(frame.samples[begin + i]);
      continue;
    }
    onPath[placed] = frame.samples[begin + i];
    colors[placed++] = frame.colors[begin + i];
    if (!covered.empty() && pixels[i] == covered.back()) {
      ++further.back();
      anyFurther = true;
      continue;
    }
    covered.push_back(pixels[i]);
    further.push_back(0);
  }
  if (!anyFurther) further.clear();
  onPath.resize(placed);
  if (!strays.empty())
    for (size_t i = 0, next = placed; i < count; ++i)
      if (isStray[i / 8] >> i % 8 & 1) colors[next++] = frame.colors[begin + i];
  setBits(covered, rows.first, width, rowBytes, mask.data());
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

  b.strays.clear();
  b.further.clear();
  b.mask.assign(size_t{rowBytes} * rows.count, 0);
  if (rows.count == 0) {
    b.isStray.assign((count + 7) / 8, 0);
    for (size_t i = 0; i < count; ++i) b.isStray[i / 8] |= static_cast<uint8_t>(1u << i % 8);
    b.strays.assign(samples.begin(), samples.end());
    onPath = {};
  } else if (const auto itsPixels = pixels.subspan(begin, count); isAscending(itsPixels)) {
    setBits(itsPixels, rows.first, width, rowBytes, b.mask.data());
  } else {
    b.sortOut(frame, rows, begin, itsPixels, rowBytes);
    onPath = b.onPath;
    colors = b.colors;
  }
  const bool anyFurther = !b.further.empty();

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
  }

  b.layout.build(width, rows.first, rows.count, b.mask, b.further);
  if (rows.count > 0) {
    b.changes.resize(b.mask.size());
    std::copy_n(b.mask.begin(), rowBytes, b.changes.begin());
    for (size_t i = rowBytes; i < b.mask.size(); ++i) b.changes[i] = b.mask[i] ^ b.mask[i - rowBytes];
    appendSection(out, b.changes);
    appendLittle(out, static_cast<uint8_t>(anyFurther));
    if (anyFurther) appendSection(out, b.further);

    const size_t size = b.layout.size();
    b.paths.aim(frame, rows.placement, b.layout.columns, b.layout.rows);
    b.places.resize(size);
    b.positions.resize(size);
    b.depths.resize(size);
    b.paths.locate(onPath, b.places);
    b.paths.place(b.places, b.positions, b.depths);
    b.tokens.resize(size);
    b.deltas.resize(size);
    b.radiusTokens.resize(size);
    b.bitBytes.resize(size * (2 * kMostTokenBits + 2 * kEscapedBits + 7) / 8 + BitWriter::kSpareBytes);
    BitWriter bits(b.bitBytes.data());
    b.placeTokens.put(b.paths, b.layout, b.places, b.tokens, bits);
    findDeltas(onPath, b.positions, b.deltas);
    for (size_t i = 0; i < size; ++i) {
      if (b.deltas[i] != kEscape) continue;
      bits.put(static_cast<uint32_t>(onPath[i] & 0x7ffffffu), kEscapedBits);
      bits.put(static_cast<uint32_t>(onPath[i] >> 27 & 0x7ffffffu), kEscapedBits);
    }
    putRadii(RadiusPrediction(frame), onPath, b.paths, b.depths, colors, b.radiusTokens, bits);
    appendSection(out, b.tokens);
    appendSection(out, b.deltas);
    appendSection(out, b.radiusTokens);
    const std::span<const uint8_t> written = bits.finish();
    appendLittle(out, static_cast<uint32_t>(written.size()));
    appendSection(out, written);
  }
  b.colorPlanes.append(out, b.layout, rows.first, b.mask, rowBytes, colors, settings);
}

DecodeError BandPacker::unpack(std::span<const std::byte> bytes, const SampleFrame& frame, const BandRows& rows, ColorCoding coding,
                               std::span<PackedSample> samples, std::span<Rgba8> colors) {
  Buffers& b = *buffers_;
  ByteReader reader(bytes);
  const size_t count = samples.size();
  const auto itsCount = reader.take<uint32_t>();
  const size_t strayCount = reader.take<uint32_t>();
  const auto hash = reader.take<uint64_t>();
  if (reader.ranOut() || itsCount != count || strayCount > count) return "a band's numbers of samples contradict each other";
  const uint32_t width = rows.count > 0 ? frame.camera.width : 0;
  const uint32_t rowBytes = (width + 7) / 8;

  b.isStray.assign((count + 7) / 8, 0);
  b.strays.resize(strayCount);
  if (strayCount > 0) {
    b.strayBytes.resize(strayCount * kWordBytes);
    if (!takeSection(reader, b.isStray) || !takeSection(reader, b.strayBytes)) return "a band's samples without place are damaged";
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
  b.layout.build(width, rows.first, rows.count, b.mask, b.further);
  const size_t size = b.layout.size();

  BitReader bits({});
  if (rows.count > 0) {
    b.tokens.resize(size);
    b.deltas.resize(size);
    b.radiusTokens.resize(size);
    if (!takeSection(reader, b.tokens) || !takeSection(reader, b.deltas) || !takeSection(reader, b.radiusTokens))
      return "the depths of a band are damaged";
    const auto bitLength = reader.take<uint32_t>();
    // At most 30 bits for a token, of which there are two, and 54 for an escaped position.
    if (bitLength > 16 * size) return "the depths of a band have more bits than they can use";
    b.bitBytes.resize(bitLength);
    if (!takeSection(reader, b.bitBytes)) return "the depths of a band are damaged";
    bits = BitReader(b.bitBytes);
    b.paths.aim(frame, rows.placement, b.layout.columns, b.layout.rows);
    b.places.resize(size);
    b.placeTokens.take(b.paths, b.layout, b.tokens, bits, b.places);
    b.positions.resize(size);
    b.depths.resize(size);
    b.paths.place(b.places, b.positions, b.depths);
    addDeltas(b.deltas, b.positions);
    for (size_t i = 0; i < size; ++i) {
      if (b.deltas[i] != kEscape) continue;
      const uint64_t low = bits.take(kEscapedBits);
      b.positions[i] = low | static_cast<uint64_t>(bits.take(kEscapedBits)) << kEscapedBits;
    }
  }

  b.colors.resize(count);
  // Radii may follow from opacities, and their bits come before the colours' bytes: no other order would do for both.
  if (DecodeError error = b.colorPlanes.take(reader, b.layout, rows.first, coding, b.colors)) return error;
  if (reader.ranOut() || reader.left() > 0) return "a band is longer or shorter than it should be";
  if (size > 0) {
    takeRadii(RadiusPrediction(frame), b.radiusTokens, b.paths, b.depths, b.colors, b.positions, bits);
    if (bits.ranOut()) return "the depths of a band end too early";
  }

  if (strayCount == 0) {
    std::copy(b.positions.begin(), b.positions.begin() + static_cast<ptrdiff_t>(size), samples.begin());
    std::copy(b.colors.begin(), b.colors.end(), colors.begin());
  } else {
    size_t onPath = 0, stray = 0;
    for (size_t i = 0; i < count; ++i) {
      const bool isStray = b.isStray[i / 8] >> i % 8 & 1;
      samples[i] = isStray ? b.strays[stray] : b.positions[onPath];
      colors[i] = b.colors[isStray ? size + stray : onPath];
      ++(isStray ? stray : onPath);
    }
  }
  if (hashSamples(samples) != hash)
    return "a band's samples are not those that were sent: other camera or settings than the sender's, or a machine that rounds differently";
  return std::nullopt;
}

}  // namespace warpscope
