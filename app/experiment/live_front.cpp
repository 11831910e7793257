// Blocks, medians of times, means of errors.
// See live_front.h.
#include "app/experiment/live_front.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <utility>

#include "app/experiment/averages.h"
#include "app/experiment/findings.h"
#include "app/experiment/measured.h"

namespace warpscope {
namespace {

/// Panels at most (kMaxPanels), whose configurations were seen last.
constexpr std::ptrdiff_t kOnShow = 6;

static_assert(LiveFront::kBuckets <= 64, "a set of buckets is a word");

bool holds(uint64_t set, uint64_t part) { return (set & part) == part; }

/// The angles to rank by, one bit each: those which the most comparisons rest on, given where each configuration was seen. Finding the best of all sets
/// is hard (maximum biclique), so sets grow smaller greedily from each configuration's: by the one with which they keep the most. One alone is
/// ranked by its own.
uint64_t blockOf(const std::vector<uint64_t>& seen) {
  if (seen.size() == 1) return seen.front();
  uint64_t best = 0;
  std::pair<size_t, int> bestRank{0, 0};  // comparisons, then angles
  for (const uint64_t first : seen) {
    for (uint64_t block = first; block != 0;) {
      size_t members = 0;
      uint64_t next = 0;
      for (const uint64_t one : seen) {
        if (holds(one, block))
          ++members;
        else if (std::popcount(one & block) > std::popcount(next))
          next = one & block;
      }
      const std::pair rank{members * (members - 1) / 2 * static_cast<size_t>(std::popcount(block)), std::popcount(block)};
      if (rank.first > 0 && rank > bestRank) {
        bestRank = rank;
        best = block;
      }
      block = next;
    }
  }
  return best;
}

}  // namespace

size_t LiveFront::bucketOf(double angleDeg) { return static_cast<size_t>(std::min(std::floor(std::abs(angleDeg) / kBucketDeg), static_cast<double>(kBuckets - 1))); }

void LiveFront::setPictureSize(const glm::uvec2& size) {
  if (pictureSize_ == size) return;
  pictureSize_ = size;
  refresh();
}

void LiveFront::addError(const Configuration& configuration, const glm::uvec2& pictureSize, double angleDeg, double flip) {
  if (!configuration.technique->usesFrame || !std::isfinite(angleDeg) || !std::isfinite(flip)) return;
  Seen& seen = entryOf(configuration, pictureSize).buckets[bucketOf(angleDeg)];
  seen.flipSum += flip;
  ++seen.errors;
  refresh();
}

void LiveFront::addTime(const Configuration& configuration, const glm::uvec2& pictureSize, double angleDeg, double frameMs) {
  if (!configuration.technique->usesFrame || !std::isfinite(angleDeg) || !std::isfinite(frameMs)) return;
  Seen& seen = entryOf(configuration, pictureSize).buckets[bucketOf(angleDeg)];
  if (seen.framesMs.size() < kMostTimes)
    seen.framesMs.push_back(frameMs);
  else
    seen.framesMs[seen.times % kMostTimes] = frameMs;
  ++seen.times;
  refresh();
}

void LiveFront::clear() {
  entries_.clear();
  pointCount_ = 0;
  refresh();
}

uint64_t LiveFront::Entry::completeBuckets() const {
  uint64_t set = 0;
  for (const auto& [bucket, seen] : buckets)
    if (seen.isComplete()) set |= uint64_t{1} << bucket;
  return set;
}

LiveFront::Entry& LiveFront::entryOf(const Configuration& configuration, const glm::uvec2& pictureSize) {
  // By all that its picture depends on, what sweeps do not go through as well: modes, lights, planes.
  Configuration looked = normalized(configuration);
  const auto place = std::find_if(entries_.begin(), entries_.end(),
                                  [&](const Entry& entry) { return entry.pictureSize == pictureSize && entry.configuration == looked; });
  if (place != entries_.end()) {
    entries_.splice(entries_.begin(), entries_, place);
  } else {
    makeRoom();
    entries_.push_front({std::move(looked), pictureSize, {}, 0});
  }
  return entries_.front();
}

void LiveFront::makeRoom() {
  if (entries_.size() < kMostSeen) return;
  // What panels show was seen last and stays, so that it gets both its time and its error.
  const auto oldest = std::find_if(entries_.rbegin(), std::prev(entries_.rend(), kOnShow), [](const Entry& entry) { return entry.pointSince == 0; });
  entries_.erase(oldest == std::prev(entries_.rend(), kOnShow) ? std::prev(entries_.end()) : std::prev(oldest.base()));
}

LiveFront::Point LiveFront::pointOf(const Entry& entry, uint64_t buckets) {
  Point point{entry.configuration, entry.pictureSize, Standing::otherAngles, 0.0, 0.0, {}};
  std::vector<AngleFigures> figures;
  for (const auto& [bucket, seen] : entry.buckets) {
    if (!seen.isComplete()) continue;
    const double flip = seen.flipSum / static_cast<double>(seen.errors);
    point.buckets.push_back({static_cast<double>(bucket) * kBucketDeg, flip, seen.errors, measuredOf(seen.framesMs).medianMs});
    if (buckets >> bucket & 1) figures.push_back({flip, 0.0, point.buckets.back().frameMs, 0.0});
  }
  const AngleFigures over = overAngles(figures);
  point.frameMs = over.frameMs;
  point.flip = over.flip;
  return point;
}

void LiveFront::refresh() {
  ++version_;
  std::vector<const Entry*> shown;
  const auto isShown = [&](const Entry& entry) {
    return std::any_of(shown.begin(), shown.end(), [&](const Entry* other) { return other->configuration == entry.configuration; });
  };
  std::vector<uint64_t> seen;  // of those that may be ranked
  for (Entry& entry : entries_) {
    const uint64_t complete = entry.completeBuckets();
    if (complete == 0) continue;
    if (entry.pointSince == 0) entry.pointSince = ++pointCount_;
    if (entry.pictureSize != pictureSize_) continue;
    shown.push_back(&entry);
    seen.push_back(complete);
  }
  for (const Entry& entry : entries_)  // the one seen last comes first
    if (entry.pointSince > 0 && !isShown(entry)) shown.push_back(&entry);
  std::sort(shown.begin(), shown.end(), [](const Entry* a, const Entry* b) { return a->pointSince < b->pointSince; });

  const uint64_t block = seen.empty() ? 0 : blockOf(seen);
  rankedAnglesDeg_.clear();
  for (size_t bucket = 0; bucket < kBuckets; ++bucket)
    if (block >> bucket & 1) rankedAnglesDeg_.push_back(static_cast<double>(bucket) * kBucketDeg);
  points_.clear();
  std::vector<size_t> ranked;
  std::vector<CostAndError> costs;
  for (const Entry* entry : shown) {
    const uint64_t complete = entry->completeBuckets();
    const bool isOfSize = entry->pictureSize == pictureSize_, isRanked = isOfSize && block != 0 && holds(complete, block);
    Point& point = points_.emplace_back(pointOf(*entry, isRanked ? block : complete));
    point.standing = !isOfSize ? Standing::otherSize : isRanked ? Standing::ranked : Standing::otherAngles;
    if (!isRanked) continue;
    ranked.push_back(points_.size() - 1);
    costs.push_back({point.frameMs, point.flip});
  }
  front_.clear();
  for (const size_t i : paretoFront(costs)) front_.push_back(ranked[i]);
}

}  // namespace warpscope
