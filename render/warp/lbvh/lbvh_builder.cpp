// Parallel construction of the hierarchy on the host.
// See lbvh_builder.h.
#include "render/warp/lbvh/lbvh_builder.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_invoke.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <sstream>
#include <stdexcept>

#include "render/base/error.h"
#include "render/core/parallel.h"

namespace warpscope {
namespace {

constexpr size_t kGrain = 16384;          // spheres a task looks at
constexpr uint32_t kSerialSpheres = 2048;  // subtrees below this size are built by one task

/// Above this many spheres, what only construction needs is given back before the nodes are made: then these lists together are far larger
/// than what touching their pages anew costs with the next frame.
constexpr size_t kKeptSpheres = size_t{1} << 22;

constexpr int kDigitBits = 11;
constexpr size_t kDigits = size_t{1} << kDigitBits;
constexpr size_t kSortBlock = 65536;  // items whose digits are counted together

bool isTraceable(const Sphere& sphere) {
  const glm::vec3 size = glm::abs(sphere.center);
  // Written so that NaN fails.
  return size.x <= kMaxSphereCoordinate && size.y <= kMaxSphereCoordinate && size.z <= kMaxSphereCoordinate &&
         sphere.radius > 0.0f && sphere.radius <= kMaxSphereCoordinate;
}

/// What one look at all spheres finds out.
struct CloudSummary {
  Box centers;
  Box spheres;
  size_t firstBad = SIZE_MAX;

  void include(const CloudSummary& other) {
    centers.include(other.centers);
    spheres.include(other.spheres);
    firstBad = std::min(firstBad, other.firstBad);
  }
};

CloudSummary summarize(std::span<const Sphere> cloud) {
  return tbb::parallel_reduce(
      tbb::blocked_range<size_t>(0, cloud.size(), kGrain), CloudSummary{},
      [&](const tbb::blocked_range<size_t>& range, CloudSummary summary) {
        for (size_t i = range.begin(); i < range.end(); ++i) {
          const Sphere& sphere = cloud[i];
          if (!isTraceable(sphere)) summary.firstBad = std::min(summary.firstBad, i);
          summary.centers.include(sphere.center);
          summary.spheres.include(sphereBounds(sphere));
        }
        return summary;
      },
      [](CloudSummary a, const CloudSummary& b) {
        a.include(b);
        return a;
      });
}

/// As summarize, but throws what validateSpheres promises.
CloudSummary summarizeValid(std::span<const Sphere> cloud) {
  if (cloud.size() > kMaxLbvhSpheres)
    throw InputError("a cloud may have at most " + std::to_string(kMaxLbvhSpheres) + " spheres, not " +
                     std::to_string(cloud.size()));
  const CloudSummary summary = summarize(cloud);
  if (summary.firstBad >= cloud.size()) return summary;
  const Sphere& bad = cloud[summary.firstBad];
  std::ostringstream text;
  text << "sphere " << summary.firstBad << " has centre (" << bad.center.x << ", " << bad.center.y << ", "
       << bad.center.z << ") and radius " << bad.radius
       << ", but coordinates must be finite, radii positive, and neither beyond " << kMaxSphereCoordinate;
  throw InputError(text.str());
}

}  // namespace

void validateSpheres(std::span<const Sphere> spheres) { summarizeValid(spheres); }

void sortByCode(std::vector<MortonItem>& items, std::vector<MortonItem>& scratch) {
  const size_t count = items.size();
  scratch.resize(count);
  const size_t blocks = (count + kSortBlock - 1) / kSortBlock;
  // Blocks are cut by size, never by thread, so that every run moves the same items in the same way.
  std::vector<std::array<uint32_t, kDigits>> offsets(blocks);
  for (int shift = 0; shift < 63; shift += kDigitBits) {
    const auto digitOf = [shift](const MortonItem& item) { return item.code >> shift & (kDigits - 1); };
    const auto endOf = [count](size_t block) { return std::min(count, (block + 1) * kSortBlock); };
    parallelForRanges(blocks, 1, [&](size_t begin, size_t end) {
      for (size_t block = begin; block < end; ++block) {
        offsets[block].fill(0);
        for (size_t i = block * kSortBlock; i < endOf(block); ++i) ++offsets[block][digitOf(items[i])];
      }
    });
    uint32_t total = 0;
    bool allEqual = false;
    for (size_t digit = 0; digit < kDigits; ++digit) {
      const uint32_t before = total;
      for (auto& block : offsets) {
        const uint32_t size = block[digit];
        block[digit] = total;
        total += size;
      }
      allEqual = allEqual || total - before == count;
    }
    if (allEqual) continue;
    parallelForRanges(blocks, 1, [&](size_t begin, size_t end) {
      for (size_t block = begin; block < end; ++block)
        for (size_t i = block * kSortBlock; i < endOf(block); ++i)
          scratch[offsets[block][digitOf(items[i])]++] = items[i];
    });
    std::swap(items, scratch);
  }
}

void Lbvh::build(std::span<const Sphere> spheres, std::span<const glm::vec3> halfLines) {
  ids_.clear();
  codes_.clear();
  halfLines_.clear();
  const CloudSummary summary = summarizeValid(spheres);
  const size_t count = spheres.size();
  if (!halfLines.empty() && halfLines.size() != count)
    throw std::invalid_argument(std::to_string(halfLines.size()) + " lines for " + std::to_string(count) + " spheres");
  if (count == 0) return;
  Box bounds = summary.spheres;
  for (size_t i = 0; i < halfLines.size(); ++i) bounds.include(capsuleBounds(spheres[i], halfLines[i]));
  reach_ = reachOf(bounds);
  halfLines_.assign(halfLines.begin(), halfLines.end());

  items_.resize(count);
  parallelForRanges(count, kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      items_[i] = {mortonCodeOf(spheres[i].center, summary.centers), static_cast<uint32_t>(i)};
  });
  sortByCode(items_, scratch_);
  if (count > kKeptSpheres) scratch_ = {};

  codes_.resize(count);
  ids_.resize(count);
  parallelForRanges(count, kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      codes_[i] = items_[i].code;
      ids_[i] = items_[i].index;
    }
  });
  if (count > kKeptSpheres) items_ = {};
  spheres_.resize(count);
  parallelForRanges(count, kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) spheres_[i] = spheres[ids_[i]];
  });
  findLeaves();
  const size_t leaves = codes_.size();
  nodes_.resize(leaves - 1);
  if (leaves > 1) emitNode(0, {0, static_cast<uint32_t>(leaves - 1)});
}

/// Keeps the codes of the leaves' first spheres only: where those are told apart, so are the leaves.
void Lbvh::findLeaves() {
  const size_t count = codes_.size();
  isLeafFirst_.assign(count, 0);
  markLeaves({0, static_cast<uint32_t>(count - 1)});
  leafFirst_.clear();
  for (size_t i = 0; i < count; ++i) {
    if (!isLeafFirst_[i]) continue;
    codes_[leafFirst_.size()] = codes_[i];
    leafFirst_.push_back(static_cast<uint32_t>(i));
  }
  codes_.resize(leafFirst_.size());
  leafFirst_.push_back(static_cast<uint32_t>(count));
  if (count <= kKeptSpheres) return;
  codes_.shrink_to_fit();
  isLeafFirst_ = {};
}

void Lbvh::markLeaves(MortonRange spheres) {
  const uint32_t count = spheres.last - spheres.first + 1;
  if (count <= kLeafSpheres) {
    isLeafFirst_[spheres.first] = 1;
    return;
  }
  const uint32_t split = findSplit(codes_.data(), static_cast<uint32_t>(codes_.size()), spheres);
  const auto markLeft = [&] { markLeaves({spheres.first, split}); };
  const auto markRight = [&] { markLeaves({split + 1, spheres.last}); };
  if (count <= kSerialSpheres) {
    markLeft();
    markRight();
  } else {
    tbb::parallel_invoke(markLeft, markRight);
  }
}

Box Lbvh::boundsOf(uint32_t i) const { return halfLines_.empty() ? sphereBounds(spheres_[i]) : capsuleBounds(spheres_[i], halfLines_[ids_[i]]); }

Lbvh::Extent Lbvh::extentOf(uint32_t leaf) const {
  const MortonRange range = view().spheresOf(leaf);
  Extent extent{boundsOf(range.first), spheres_[range.first].radius};
  for (uint32_t i = range.first + 1; i <= range.last; ++i) {
    extent.bounds.include(boundsOf(i));
    extent.smallestRadius = std::min(extent.smallestRadius, spheres_[i].radius);
  }
  return extent;
}

Lbvh::Extent Lbvh::emitChild(uint32_t reference, MortonRange leaves) {
  return reference & kLbvhLeafBit ? extentOf(leaves.first) : emitNode(reference, leaves);
}

Lbvh::Extent Lbvh::emitNode(uint32_t index, MortonRange leaves) {
  LbvhNode& node = nodes_[index];
  const uint32_t split = findSplit(codes_.data(), static_cast<uint32_t>(codes_.size()), leaves);
  node.child[0] = leftReference(leaves, split);
  node.child[1] = rightReference(leaves, split);
  const auto emit = [&](int side, MortonRange below) {
    const Extent extent = emitChild(node.child[side], below);
    node.bounds[side] = extent.bounds;
    node.smallestRadius[side] = extent.smallestRadius;
  };
  const auto emitLeft = [&] { emit(0, {leaves.first, split}); };
  const auto emitRight = [&] { emit(1, {split + 1, leaves.last}); };
  if (leaves.last - leaves.first < kSerialSpheres / kLeafSpheres) {
    emitLeft();
    emitRight();
  } else {
    tbb::parallel_invoke(emitLeft, emitRight);
  }
  Box bounds = node.bounds[0];
  bounds.include(node.bounds[1]);
  return {bounds, std::min(node.smallestRadius[0], node.smallestRadius[1])};
}

GroupedLbvhView Lbvh::view() const {
  const size_t leaves = codes_.size();
  return {{nodes_.data(), spheres_.data(), ids_.data(), static_cast<uint32_t>(ids_.size()), reach_,
           halfLines_.empty() ? nullptr : halfLines_.data()},
          leafFirst_.data(),
          static_cast<uint32_t>(leaves)};
}

}  // namespace warpscope
