// Checks and statistics of volumes.
// See volume.h.
#include "render/volume/volume.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <span>

#include "render/base/error.h"
#include "render/base/looked_through.h"
#include "render/base/ranks.h"
#include "render/core/parallel.h"
#include "render/core/placed_hash.h"
#include "render/volume/kept_slices.h"
#include "render/volume/voxel_access.h"

namespace warpscope {

size_t sizeBytes(VoxelType type) {
  return visitVoxelType(type, [](auto voxel) { return sizeof(voxel); });
}

std::string_view nameOf(VoxelType type) {
  constexpr std::array<std::string_view, 8> names{"uint8",  "int8",  "uint16",  "int16",
                                                  "uint32", "int32", "float32", "float64"};
  return names[static_cast<size_t>(type)];
}

Box VolumeGeometry::bounds() const {
  const glm::vec3 half(0.5 * glm::dvec3(dims) * (spacing / unit()));
  return {-half, half};
}

size_t validate(const VolumeGeometry& geometry, VoxelType type, const std::string& source) {
  const glm::uvec3& n = geometry.dims;
  const std::string dims = std::to_string(n.x) + "x" + std::to_string(n.y) + "x" + std::to_string(n.z);
  if (n.x == 0 || n.y == 0 || n.z == 0) throw InputError(source + ": a volume of " + dims + " voxels is empty");
  // Voxel coordinates are floats while rendering: beyond 2^16 a side they would no longer resolve the filter's weights.
  constexpr uint32_t kMaxSide = 65536;
  if (n.x > kMaxSide || n.y > kMaxSide || n.z > kMaxSide)
    throw InputError(source + ": " + dims + " voxels: at most " + std::to_string(kMaxSide) + " along an axis");
  const size_t count = size_t{n.x} * n.y * n.z;  // at most 2^48
  if (count > std::numeric_limits<size_t>::max() / 2 / sizeBytes(type))
    throw InputError(source + ": " + dims + " voxels do not fit into memory");
  for (int axis = 0; axis < 3; ++axis)
    if (!(geometry.spacing[axis] > 0.0) || !std::isfinite(geometry.spacing[axis]) ||
        !std::isfinite(geometry.origin[axis]))
      throw InputError(source + ": voxel spacing and origin must be finite, and spacing positive");
  // Beyond this the shortest edge is nothing beside the longest in the floats of volume space.
  constexpr double kMaxAnisotropy = 1e6;
  const glm::dvec3& edges = geometry.spacing;
  if (glm::max(edges.x, glm::max(edges.y, edges.z)) > kMaxAnisotropy * glm::min(edges.x, glm::min(edges.y, edges.z)))
    throw InputError(source + ": one voxel edge is more than a million times another; check the file's voxel spacing");
  // Lengths and angles each: a determinant of 1 would let sheared axes pass.
  const glm::dmat3 gram = glm::transpose(geometry.direction) * geometry.direction;
  for (int column = 0; column < 3; ++column)
    for (int row = 0; row < 3; ++row)
      if (!(std::abs(gram[column][row] - (column == row ? 1.0 : 0.0)) < 1e-2))
        throw InputError(source + ": its axes do not form an orthonormal system");
  return count;
}

namespace {

constexpr size_t kGrain = 1 << 18;

using Histogram = std::array<size_t, 256>;

/// Voxels that are scanned here: all of a volume, or, where ranks have it, a share, which is there.
template <class T>
struct Scanned {
  const Volume& volume;
  const T* voxels;
  size_t count;
  Ranks* ranks;  ///< null: these are all

  /// Calls `body(begin, end)` for pieces of them, in parallel.
  template <class Body>
  void visit(const std::stop_token& stop, const Body& body) const {
    const auto visitPiece = [&](size_t first, size_t last) {
      parallelForRanges(last - first, kGrain, stop, [&](size_t begin, size_t end) {
        keepWithinMemoryLimit();
        noteLooked((end - begin) * sizeof(T));
        body(first + begin, first + end);
      });
    };
    if (ranks != nullptr) return visitPiece(0, count);
    forKeptVoxels(volume, stop, visitPiece);
  }
};

/// The sum of what all ranks have counted.
Histogram summed(const Histogram& own, Ranks* ranks) {
  if (ranks == nullptr) return own;
  std::vector<size_t> all(own.begin(), own.end());
  ranks->allGather(all);
  Histogram sum{};
  for (size_t i = 0; i < all.size(); ++i) sum[i % sum.size()] += all[i];
  return sum;
}

/// Sums histograms that `count(local, begin, end)` fills, one a thread.
template <class T, class Count>
Histogram gatherHistogram(const Scanned<T>& scanned, const std::stop_token& stop, const Count& count) {
  tbb::enumerable_thread_specific<Histogram> partial(Histogram{});
  scanned.visit(stop, [&](size_t begin, size_t end) { count(partial.local(), begin, end); });
  Histogram sum{};
  for (const Histogram& local : partial)
    for (size_t bin = 0; bin < sum.size(); ++bin) sum[bin] += local[bin];
  return sum;
}

/// The histogram of bytes says everything: one pass.
VoxelStatistics gatherStatistics(const Scanned<uint8_t>& scanned, const std::stop_token& stop) {
  VoxelStatistics statistics;
  const uint8_t* const voxels = scanned.voxels;
  const Histogram own = gatherHistogram(scanned, stop, [&](Histogram& local, size_t begin, size_t end) {
    // Two tables, so that a run of equal voxels does not wait for its own last store.
    Histogram odd{};
    size_t i = begin;
    for (; i + 1 < end; i += 2) {
      ++local[voxels[i]];
      ++odd[voxels[i + 1]];
    }
    if (i < end) ++local[voxels[i]];
    for (size_t bin = 0; bin < odd.size(); ++bin) local[bin] += odd[bin];
  });
  statistics.histogram = summed(own, scanned.ranks);
  size_t lowest = 0, highest = 255;
  while (statistics.histogram[lowest] == 0) ++lowest;
  while (statistics.histogram[highest] == 0) --highest;
  statistics.lowest = static_cast<double>(lowest);
  statistics.highest = static_cast<double>(highest);
  statistics.rangeUpper = 255.0;
  return statistics;
}

template <class T>
VoxelStatistics gatherStatistics(const Scanned<T>& scanned, const std::stop_token& stop) {
  const T* const voxels = scanned.voxels;
  struct Extremes {
    T lowest = std::numeric_limits<T>::max();
    T highest = std::numeric_limits<T>::lowest();
    size_t finite = 0, scanned = 0;

    void include(const Extremes& other) {
      lowest = std::min(lowest, other.lowest);
      highest = std::max(highest, other.highest);
      finite += other.finite;
      scanned += other.scanned;
    }
  };
  tbb::enumerable_thread_specific<Extremes> partialExtremes;
  scanned.visit(stop, [&](size_t begin, size_t end) {
    Extremes local = partialExtremes.local();
    for (size_t i = begin; i < end; ++i) {
      const T voxel = voxels[i];
      if (!isFiniteVoxel(voxel)) continue;
      local.lowest = voxel < local.lowest ? voxel : local.lowest;
      local.highest = voxel > local.highest ? voxel : local.highest;
      ++local.finite;
    }
    partialExtremes.local() = local;
  });
  Extremes all;
  for (const Extremes& local : partialExtremes) all.include(local);
  all.scanned = scanned.count;
  if (scanned.ranks != nullptr) {
    std::vector<Extremes> ofRanks{all};
    scanned.ranks->allGather(ofRanks);
    all = {};
    for (const Extremes& one : ofRanks) all.include(one);
  }
  VoxelStatistics statistics;
  statistics.nonFinite = all.scanned - all.finite;
  if (all.finite > 0) {
    statistics.lowest = static_cast<double>(all.lowest);
    statistics.highest = static_cast<double>(all.highest);
  }
  statistics.rangeLower = statistics.lowest;
  statistics.rangeUpper = statistics.highest;

  // Differences before the product, because values may be large beside their extent; halves where the extent overflows. Powers of two bring the extent of
  // doubles to about 1: its reciprocal may overflow too.
  constexpr double kHalfOfAll = 0.5 * std::numeric_limits<double>::max();
  const double before = 0.5 * statistics.rangeUpper - 0.5 * statistics.rangeLower <= kHalfOfAll ? 1.0 : 0.5;
  const double extent = statistics.rangeUpper * before - statistics.rangeLower * before;
  const int exponent = extent > 0.0 ? -std::ilogb(extent) : 0;
  const double first = std::ldexp(1.0, exponent / 2), second = std::ldexp(1.0, exponent - exponent / 2);
  const double binsPerExtent = extent > 0.0 ? 256.0 / (extent * first * second) : 0.0;
  const Histogram own = gatherHistogram(scanned, stop, [&](Histogram& local, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      if (!isFiniteVoxel(voxels[i])) continue;
      const double bin = (static_cast<double>(voxels[i]) * before - statistics.rangeLower * before) * first * second * binsPerExtent;
      ++local[std::min<size_t>(static_cast<size_t>(bin), 255)];
    }
  });
  statistics.histogram = summed(own, scanned.ranks);
  return statistics;
}

/// Rows [begin, end), counted through all slices, and others of their slices.
VoxelRows rowsFrom(size_t begin, size_t end, const glm::uvec3& dims) {
  const auto first = static_cast<uint32_t>(begin / dims.y), last = static_cast<uint32_t>((end + dims.y - 1) / dims.y);
  if (last > first + 1) return {{0, first}, {dims.y, last}};
  return {{static_cast<uint32_t>(begin % dims.y), first}, {static_cast<uint32_t>(end - size_t{first} * dims.y), last}};
}

constexpr size_t kWord = sizeof(uint64_t);  // that is hashed

/// Of those that read the same bytes, one's share: [begin, end).
std::pair<size_t, size_t> bytesOf(const Sharer& reader, size_t bytes) {
  const auto [firstWord, endWord] = shareOf(reader, (bytes + kWord - 1) / kWord);
  return {firstWord * kWord, std::min(endWord * kWord, bytes)};
}

/// Of these bytes, of which somebody has said that they will be looked at; reads them in pieces. All readers' sum is that of all voxels.
uint64_t hashOfShare(const Volume& volume, size_t firstByte, size_t endByte, const std::stop_token& stop) {
  constexpr size_t kPieceBytes = 32 << 20;
  const auto* const bytes = static_cast<const std::byte*>(volume.voxels());
  const size_t rowBytes = volume.dims().x * sizeBytes(volume.type());
  std::atomic<uint64_t> sum = 0;
  for (size_t begin = firstByte; begin < endByte; begin += kPieceBytes) {
    const size_t end = std::min(begin + kPieceBytes, endByte);
    volume.provide(rowsFrom(begin / rowBytes, (end + rowBytes - 1) / rowBytes, volume.dims()), stop);
    parallelForRanges((end - begin + kWord - 1) / kWord, kGrain, stop, [&](size_t first, size_t last) {
      keepWithinMemoryLimit();
      uint64_t own = 0;
      for (size_t i = first; i < last; ++i) {
        uint64_t word = 0;
        const size_t at = begin + i * kWord;
        std::memcpy(&word, bytes + at, std::min(kWord, end - at));
        own += placedHash(word, at / kWord);
      }
      sum += own;
    });
    volume.releaseVoxels();
    noteLooked(end - begin);
  }
  return sum;
}

/// What ranks have is the same: size, type, place; voxels here and there, where they come from one file; else, from copies of it too, all of them.
/// `bytesAfterwards`: that will be looked at when that is done.
void requireSameEverywhere(const Volume& volume, const std::string& stamp, uint64_t bytesAfterwards, const std::stop_token& stop) {
  const VolumeGeometry& geometry = volume.geometry();
  std::vector<double> numbers{static_cast<double>(volume.type()), geometry.spacing.x, geometry.spacing.y, geometry.spacing.z};
  for (int axis = 0; axis < 3; ++axis) numbers.push_back(geometry.dims[axis]);
  volume.ranks()->requireSame(std::as_bytes(std::span<const double>(numbers)), volume.name() + ": size, type and spacing of voxels");
  const std::string what = volume.name() + ": voxels";
  const std::vector<std::vector<std::byte>> stamps = volume.ranks()->allGather(std::as_bytes(std::span<const char>(stamp)));
  const bool isCertain = !stamps.front().empty() && std::ranges::adjacent_find(stamps, std::ranges::not_equal_to()) == stamps.end();
  const auto own = stamps.begin() + volume.ranks()->rank();
  Sharer reader;
  if (!own->empty()) reader = {static_cast<size_t>(std::count(stamps.begin(), own, *own)), static_cast<size_t>(std::ranges::count(stamps, *own))};
  const auto [firstByte, endByte] = bytesOf(reader, volume.sizeBytes());
  beginLooking((isCertain ? 0 : endByte - firstByte) + bytesAfterwards);  // all at once, so that what is left never grows
  if (!isCertain) {
    std::vector<uint64_t> hashes{hashOfShare(volume, firstByte, endByte, stop)};
    volume.ranks()->allGather(hashes);
    const uint64_t hash = hashes[static_cast<size_t>(volume.ranks()->rank())];
    uint64_t sum = own->empty() ? hash : 0;  // without a stamp it has read all by itself
    for (size_t rank = 0; !own->empty() && rank < hashes.size(); ++rank)
      if (stamps[rank] == *own) sum += hashes[rank];
    return volume.ranks()->requireSame(std::as_bytes(std::span(&sum, 1)), what);
  }
  constexpr size_t kLooks = 64, kBytes = 512;
  std::vector<std::byte> seen;
  const auto* const bytes = static_cast<const std::byte*>(volume.voxels());
  const size_t rowBytes = geometry.dims.x * sizeBytes(volume.type());
  for (size_t look = 0; look < kLooks; ++look) {
    const size_t at = volume.sizeBytes() / kLooks * look, end = std::min(at + kBytes, volume.sizeBytes());
    volume.provide(rowsFrom(at / rowBytes, (end + rowBytes - 1) / rowBytes, geometry.dims));
    seen.insert(seen.end(), bytes + at, bytes + end);
  }
  volume.releaseVoxels();
  volume.ranks()->requireSame(seen, what);
}

}  // namespace

Volume::Volume(std::string name, VoxelType type, const VolumeGeometry& geometry, std::shared_ptr<const void> storage,
               const void* voxels, const std::stop_token& stop, RanksPtr ranks, std::shared_ptr<VoxelSource> source)
    : name_(std::move(name)),
      type_(type),
      geometry_(geometry),
      storage_(std::move(storage)),
      voxels_(voxels),
      ranks_(std::move(ranks)),
      source_(std::move(source)) {
  const size_t count = validate(geometry_, type_, name_);
  bounds_ = geometry_.bounds();
  const std::pair<size_t, size_t> share = shareOf(ranks_, count);
  const size_t passes = type_ == VoxelType::uint8 ? 1 : 2, bytes = passes * (share.second - share.first) * warpscope::sizeBytes(type_);
  if (ranks_)
    requireSameEverywhere(*this, source_ ? source_->stamp() : "", bytes, stop);
  else
    beginLooking(bytes);
  if (ranks_ && share.first < share.second) provide(rowsFrom(share.first / dims().x, (share.second + dims().x - 1) / dims().x, dims()), stop);
  visitVoxelType(type_, [&]<class Voxel>(Voxel) { statistics_ = gatherStatistics(Scanned<Voxel>{*this, voxelsAs<Voxel>() + share.first, share.second - share.first, ranks_.get()}, stop); });
}

}  // namespace warpscope
