// Accuracy against time, gathered while somebody plays: one point for each configuration that was seen.
// Time is counted as sweeps do (SweepRow::frameMs), the error is FLIP (Andersson et al. 2020) against the ground truth, the front is paretoFront().
#pragma once

#include <cstdint>
#include <list>
#include <map>
#include <string>
#include <vector>

#include "app/experiment/configuration.h"

namespace warpscope {

/// Bounded: of more configurations than there is room for, those without an error go first, then those that were seen longest ago.
class LiveFront {
 public:
  static constexpr size_t kMostConfigurations = 200;
  static constexpr size_t kMostTimes = 15;        ///< the last, of which the median counts
  static constexpr double kBucketDeg = 2.5;       ///< width of a bucket of angles
  static constexpr size_t kBuckets = 36;          ///< the last also holds all angles above

  /// Errors at angles from `fromDeg` to the next bucket's.
  struct Bucket {
    double fromDeg = 0.0;
    double flip = 0.0;  ///< mean
    size_t count = 0;   ///< of errors, at least 1
  };

  struct Point {
    Configuration configuration;  ///< normalized
    double frameMs = 0.0;         ///< decoding and building, and drawing: the median of each, summed
    double flip = 0.0;            ///< mean over the buckets' means, so that every angle counts alike, however long the camera rested there
    std::vector<Bucket> buckets;  ///< those that are not empty, by rising angle; at least one
  };

  /// A picture was drawn. `arrivalMs`: decoding and building, once a frame; `drawMs`: from the camera to the picture.
  void addPicture(const Configuration& configuration, double arrivalMs, double drawMs);
  /// A picture was judged; `angleDeg` is between the frame's camera and the picture's, its sign does not count. Values that are not finite
  /// are left out, and so is what was never told to addPicture().
  void addError(const Configuration& configuration, double angleDeg, double flip);
  void clear();

  /// Those with an error, in the order in which they got their first.
  const std::vector<Point>& points() const { return points_; }
  /// Indices into points() of what nothing beats in time and error, among techniques that use frames.
  const std::vector<size_t>& front() const { return front_; }
  /// How many errors it was told of.
  uint64_t errorCount() const { return errors_; }
  /// How many configurations are remembered, with and without an error.
  size_t remembered() const { return entries_.size(); }

 private:
  struct Sum {
    double flip = 0.0;
    size_t count = 0;
  };
  struct Entry {
    std::string key;
    Configuration configuration;
    std::vector<double> arrivalsMs, drawsMs;  // the last kMostTimes, as rings
    size_t pictures = 0;
    std::map<size_t, Sum> buckets;
    uint64_t firstError = 0;  // counts errors; 0: none
  };

  Entry* find(const std::string& key);
  void makeRoom();
  static Point pointOf(const Entry& entry);
  void refresh();

  std::list<Entry> entries_;  // the one seen last comes first
  uint64_t errors_ = 0;
  std::vector<Point> points_;
  std::vector<size_t> front_;
};

}  // namespace warpscope
