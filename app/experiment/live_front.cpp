// Medians of times, means of errors.
// See live_front.h.
#include "app/experiment/live_front.h"

#include <algorithm>
#include <cmath>

#include "app/experiment/findings.h"

namespace warpscope {
namespace {

/// Of the two in the middle the upper one, where their number is even.
double medianOf(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void putInRing(std::vector<double>& ring, size_t count, double value) {
  if (ring.size() < LiveFront::kMostTimes)
    ring.push_back(value);
  else
    ring[count % LiveFront::kMostTimes] = value;
}

}  // namespace

void LiveFront::addPicture(const Configuration& configuration, double arrivalMs, double drawMs) {
  if (!std::isfinite(arrivalMs) || !std::isfinite(drawMs)) return;
  const std::string key = keyOf(configuration);
  Entry* entry = find(key);
  if (entry == nullptr) {
    makeRoom();
    entries_.push_front({key, normalized(configuration), {}, {}, 0, {}, 0});
    entry = &entries_.front();
  }
  putInRing(entry->arrivalsMs, entry->pictures, arrivalMs);
  putInRing(entry->drawsMs, entry->pictures, drawMs);
  ++entry->pictures;
  if (entry->firstError > 0) refresh();
}

void LiveFront::addError(const Configuration& configuration, double angleDeg, double flip) {
  if (!std::isfinite(angleDeg) || !std::isfinite(flip)) return;
  Entry* entry = find(keyOf(configuration));
  if (entry == nullptr) return;
  const double bucket = std::min(std::floor(std::abs(angleDeg) / kBucketDeg), static_cast<double>(kBuckets - 1));
  Sum& sum = entry->buckets[static_cast<size_t>(bucket)];
  sum.flip += flip;
  ++sum.count;
  ++errors_;
  if (entry->firstError == 0) entry->firstError = errors_;
  refresh();
}

void LiveFront::clear() {
  entries_.clear();
  errors_ = 0;
  points_.clear();
  front_.clear();
}

LiveFront::Entry* LiveFront::find(const std::string& key) {
  const auto place = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) { return entry.key == key; });
  if (place == entries_.end()) return nullptr;
  entries_.splice(entries_.begin(), entries_, place);
  return &entries_.front();
}

void LiveFront::makeRoom() {
  if (entries_.size() < kMostConfigurations) return;
  // What is dropped is not the entry on show: that one was seen last.
  const auto oldest = std::find_if(entries_.rbegin(), entries_.rend(), [](const Entry& entry) { return entry.firstError == 0; });
  entries_.erase(oldest == entries_.rend() ? std::prev(entries_.end()) : std::prev(oldest.base()));
  refresh();
}

LiveFront::Point LiveFront::pointOf(const Entry& entry) {
  Point point{entry.configuration, medianOf(entry.arrivalsMs) + medianOf(entry.drawsMs), 0.0, {}};
  for (const auto& [bucket, sum] : entry.buckets) {
    const double mean = sum.flip / static_cast<double>(sum.count);
    point.buckets.push_back({static_cast<double>(bucket) * kBucketDeg, mean, sum.count});
    point.flip += mean;
  }
  point.flip /= static_cast<double>(entry.buckets.size());
  return point;
}

void LiveFront::refresh() {
  std::vector<const Entry*> shown;
  for (const Entry& entry : entries_)
    if (entry.firstError > 0) shown.push_back(&entry);
  std::sort(shown.begin(), shown.end(), [](const Entry* a, const Entry* b) { return a->firstError < b->firstError; });
  points_.clear();
  std::vector<size_t> candidates;
  std::vector<CostAndError> costs;
  for (const Entry* entry : shown) {
    points_.push_back(pointOf(*entry));
    if (!entry->configuration.technique->usesFrame) continue;
    candidates.push_back(points_.size() - 1);
    costs.push_back({points_.back().frameMs, points_.back().flip});
  }
  front_.clear();
  for (const size_t i : paretoFront(costs)) front_.push_back(candidates[i]);
}

}  // namespace warpscope
