// Bands: strays, mask, places along rays, what these do not give, colours.
// See packed_band.h.
#include "render/codec/packed_band.h"

#include <algorithm>
#include <array>
#include <type_traits>

#include "render/codec/band_layout.h"
#include "render/codec/color_planes.h"
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

/// The fine place that neighbours make likely. In slots: `fine` and `kinds` of samples; kinds are not looked at if all are the same.
template <bool isOneKind>
inline int32_t likelyFine(const int32_t* fine, const int32_t* kinds, Neighbors from, int32_t kind) {
  if constexpr (!isOneKind) {
    if (kinds[from.west] != kind) from.west = from.north;
    if (kinds[from.north] != kind) from.north = from.west;
    if (kinds[from.northWest] != kind) from.northWest = from.north;
  }
  return predicted(fine[from.west], fine[from.north], fine[from.northWest]);
}

/// Calls f(std::true_type) if all samples are of one kind, f(std::false_type) if not. Slot 0 need not be: who has it has no other neighbour.
template <class F>
void withKinds(std::span<const int32_t> kinds, F&& f) {
  bool isOneKind = true;
  for (const int32_t kind : kinds.subspan(1)) isOneKind &= kind == kinds.back();
  isOneKind ? f(std::true_type()) : f(std::false_type());
}

uint64_t hashSamples(std::span<const PackedSample> samples) {
  WordHash hash(samples.size());
  for (size_t i = 0; i < samples.size(); ++i) hash.add(samples[i], i);
  return hash.value();
}

}  // namespace

struct BandPacker::Buffers {
  TransferVector<PackedSample> onPath, positions, strays;
  TransferVector<Rgba8> colors;  // of samples on paths, then of strays
  TransferVector<uint8_t> isStray, strayBytes;
  TransferVector<uint8_t> mask, changes, further;
  TransferVector<uint8_t> tokens, deltas, radiusTokens, bitBytes;
  TransferVector<int32_t> places, fine, kinds;
  TransferVector<float> depths;
  BandLayout layout;
  PixelPaths paths;
  ColorPlanes colorPlanes;
};

BandPacker::BandPacker() : buffers_(std::make_unique<Buffers>()) {}
BandPacker::~BandPacker() = default;
BandPacker::BandPacker(BandPacker&&) noexcept = default;

void BandPacker::pack(const SampleFrame& frame, const BandRows& rows, size_t begin, size_t end, std::span<const uint32_t> pixels,
                      const CodecSettings& settings, std::vector<std::byte>& out) {
  Buffers& b = *buffers_;
  const size_t count = end - begin;
  const uint32_t width = rows.count > 0 ? frame.camera.width : 0;
  const uint32_t rowBytes = (width + 7) / 8;
  const std::span<const PackedSample> samples(frame.samples.data() + begin, count);

  // Sort out strays, find which pixels are covered and how often.
  b.onPath.resize(count);
  b.colors.resize(count);
  b.strays.clear();
  size_t onPath = 0;
  b.isStray.assign((count + 7) / 8, 0);
  b.mask.assign(size_t{rowBytes} * rows.count, 0);
  b.further.clear();
  bool anyFurther = false;
  uint32_t lastPixel = kNoSample;
  uint32_t row = rows.first, rowStart = rows.first * width;
  for (size_t i = 0; i < count; ++i) {
    const uint32_t pixel = rows.count > 0 ? pixels[begin + i] : kNoSample;
    if (pixel == kNoSample) {
      b.isStray[i / 8] |= static_cast<uint8_t>(1u << i % 8);
      b.strays.push_back(samples[i]);
      continue;
    }
    b.onPath[onPath] = samples[i];
    b.colors[onPath++] = frame.colors[begin + i];
    if (pixel == lastPixel) {
      ++b.further.back();
      anyFurther = true;
      continue;
    }
    lastPixel = pixel;
    while (pixel - rowStart >= width) {
      ++row;
      rowStart += width;
    }
    const uint32_t column = pixel - rowStart;
    b.mask[size_t{row - rows.first} * rowBytes + column / 8] |= static_cast<uint8_t>(1u << column % 8);
    b.further.push_back(0);
  }
  if (!anyFurther) b.further.clear();
  b.onPath.resize(onPath);
  if (!b.strays.empty())
    for (size_t i = 0, next = onPath; i < count; ++i)
      if (b.isStray[i / 8] >> i % 8 & 1) b.colors[next++] = frame.colors[begin + i];

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
    b.paths.locate(b.onPath, b.places);
    b.paths.place(b.places, b.positions, b.depths);
    b.fine.resize(size + 1);
    b.kinds.resize(size + 1);
    b.fine[0] = 0;
    b.kinds[0] = 0;
    std::copy_n(b.paths.kinds().begin(), size, b.kinds.begin() + 1);
    b.tokens.resize(size);
    b.deltas.resize(size);
    b.radiusTokens.resize(size);
    b.bitBytes.resize(size * (2 * kMostTokenBits + 2 * kEscapedBits + 7) / 8 + BitWriter::kSpareBytes);
    // Loops read and write through locals only: what they write cannot be what they read then.
    BitWriter bits(b.bitBytes.data());
    const FineScale scale = b.paths.fineScale();
    const PackedSample* const onPaths = b.onPath.data();
    const PackedSample* const positions = b.positions.data();
    const int32_t* const places = b.places.data();
    const int32_t* const kinds = b.kinds.data();
    const Neighbors* const neighbors = b.layout.neighbors.data();
    int32_t* const fine = b.fine.data();
    uint8_t* const tokens = b.tokens.data();
    uint8_t* const deltas = b.deltas.data();
    uint8_t* const radiusTokens = b.radiusTokens.data();
    for (size_t i = 0; i < size; ++i) fine[i + 1] = scale.fineOf(i, places[i]);
    withKinds(b.kinds, [&](auto isOneKind) {
      BitWriter put = bits;
      for (size_t i = 0; i < size; ++i) {
        const int32_t likely = scale.placeOf(i, likelyFine<isOneKind>(fine, kinds, neighbors[i], kinds[i + 1]));
        tokens[i] = putToken(zigzag(static_cast<int32_t>(static_cast<uint32_t>(places[i]) - static_cast<uint32_t>(likely))), put);
      }
      bits = put;
    });
    for (size_t i = 0; i < size; ++i) deltas[i] = deltaCode(onPaths[i], positions[i]);
    for (size_t i = 0; i < size; ++i) {
      if (deltas[i] != kEscape) continue;
      bits.put(static_cast<uint32_t>(onPaths[i] & 0x7ffffffu), kEscapedBits);
      bits.put(static_cast<uint32_t>(onPaths[i] >> 27 & 0x7ffffffu), kEscapedBits);
    }
    const RadiusPrediction radius(frame);
    for (size_t i = 0; i < size; ++i) {
      const auto likely = static_cast<int32_t>(radius(b.depths[i], b.paths.cosine(i), b.colors[i]));
      radiusTokens[i] = putToken(zigzag(static_cast<int32_t>(radiusCode(onPaths[i])) - likely), bits);
    }
    appendSection(out, b.tokens);
    appendSection(out, b.deltas);
    appendSection(out, b.radiusTokens);
    const std::span<const uint8_t> written = bits.finish();
    appendLittle(out, static_cast<uint32_t>(written.size()));
    appendSection(out, written);
  }
  b.colorPlanes.append(out, b.layout, rows.first, b.mask, rowBytes, b.colors, settings);
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
    b.fine.resize(size + 1);
    b.kinds.resize(size + 1);
    b.fine[0] = 0;
    b.kinds[0] = 0;
    std::copy_n(b.paths.kinds().begin(), size, b.kinds.begin() + 1);
    const FineScale scale = b.paths.fineScale();
    const Neighbors* const neighbors = b.layout.neighbors.data();
    const uint8_t* const tokens = b.tokens.data();
    const uint8_t* const deltas = b.deltas.data();
    const int32_t* const kinds = b.kinds.data();
    int32_t* const places = b.places.data();
    int32_t* const fine = b.fine.data();
    withKinds(b.kinds, [&](auto isOneKind) {
      BitReader take = bits;
      for (size_t i = 0; i < size; ++i) {
        const int32_t likely = scale.placeOf(i, likelyFine<isOneKind>(fine, kinds, neighbors[i], kinds[i + 1]));
        const int32_t difference = unzigzag(takeToken(tokens[i], take));
        places[i] = static_cast<int32_t>(static_cast<uint32_t>(likely) + static_cast<uint32_t>(difference));
        fine[i + 1] = scale.fineOf(i, places[i]);
      }
      bits = take;
    });
    b.positions.resize(size);
    b.depths.resize(size);
    b.paths.place(b.places, b.positions, b.depths);
    PackedSample* const positions = b.positions.data();
    for (size_t i = 0; i < size; ++i) positions[i] = moved(positions[i], deltas[i]);
    for (size_t i = 0; i < size; ++i) {
      if (deltas[i] != kEscape) continue;
      const uint64_t low = bits.take(kEscapedBits);
      positions[i] = low | static_cast<uint64_t>(bits.take(kEscapedBits)) << kEscapedBits;
    }
  }

  b.colors.resize(count);
  // Radii may follow from opacities, and their bits come before the colours' bytes: no other order would do for both.
  if (DecodeError error = b.colorPlanes.take(reader, b.layout, rows.first, coding, b.colors)) return error;
  if (reader.ranOut() || reader.left() > 0) return "a band is longer or shorter than it should be";
  if (size > 0) {
    const RadiusPrediction radius(frame);
    const uint8_t* const radiusTokens = b.radiusTokens.data();
    PackedSample* const positions = b.positions.data();
    BitReader take = bits;
    for (size_t i = 0; i < size; ++i) {
      const auto likely = radius(b.depths[i], b.paths.cosine(i), b.colors[i]);
      const uint32_t difference = static_cast<uint32_t>(unzigzag(takeToken(radiusTokens[i], take)));
      positions[i] = (positions[i] & kPositionMask) | static_cast<uint64_t>((likely + difference) & kRadiusCodeMax) << kRadiusShift;
    }
    bits = take;
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
