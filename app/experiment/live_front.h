// Accuracy against time, gathered while somebody plays: one point for each configuration that was seen, judged and timed.
// Points are ranked by complete blocks (Fisher: The Design of Experiments, 1935, ch. 4); the error is FLIP (Andersson et al. 2020).
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <list>
#include <map>
#include <vector>

#include "app/experiment/configuration.h"

namespace warpscope {

/// Points are ranked by what they have in common alone. A block is an angle between frame and view, of pictures of the size on show.
///  - Ranked is by that set of angles which the most comparisons rest on: pairs of configurations that were seen at all of its angles, times the angles. Who
///    was seen at one angle alone does not take the others' ranking away, and stays out of it until it has caught up, or many are like that.
///  - Errors are means over these angles and times those of the slowest (overAngles), as in a sweep's summaries.
///  - Times are of one load: nothing but the technique was at work (measuring.h), so that they do not tell what ran beside it.
///  - Pictures of another size keep their points, and are ranked again when that size is back.
/// Bounded: of more configurations and sizes than there is room for, those that are no points yet go first, then those that were seen longest ago.
class LiveFront {
 public:
  static constexpr size_t kMostSeen = 200;
  static constexpr size_t kMostTimes = 15;   ///< at one angle: the last, of which the median counts
  static constexpr double kBucketDeg = 2.5;  ///< width of a bucket of angles: those in it count as one
  static constexpr size_t kBuckets = 36;     ///< the last also holds all angles above
  static size_t bucketOf(double angleDeg);

  /// Angles from `fromDeg` to the next bucket's.
  struct Bucket {
    double fromDeg = 0.0;
    double flip = 0.0;     ///< mean
    size_t count = 0;      ///< of errors, at least 1
    double frameMs = 0.0;  ///< SweepRow::frameMs
  };

  enum class Standing {
    ranked,
    otherAngles,  ///< it lacks one of rankedAnglesDeg()
    otherSize,    ///< its pictures were of another size than those on show
  };

  struct Point {
    Configuration configuration;  ///< normalized
    glm::uvec2 pictureSize{0};
    Standing standing = Standing::otherAngles;
    double frameMs = 0.0;         ///< over the ranked angles or, where it is not ranked, over its own
    double flip = 0.0;            ///< likewise
    std::vector<Bucket> buckets;  ///< where it was judged and timed, by rising angle; at least one
  };

  /// The size that pictures have from now on.
  void setPictureSize(const glm::uvec2& size);

  /// A picture was judged; `angleDeg` is between the frame's camera and the picture's, its sign does not count. Values that are not finite and
  /// techniques without frames are left out, here and below.
  void addError(const Configuration& configuration, const glm::uvec2& pictureSize, double angleDeg, double flip);
  /// A picture was timed, while nothing else was at work.
  void addTime(const Configuration& configuration, const glm::uvec2& pictureSize, double angleDeg, double frameMs);
  void clear();

  /// In the order in which they became one. Each configuration once: at the size on show or, if it was never seen at that, at the last that it was.
  const std::vector<Point>& points() const { return points_; }
  /// Where the buckets begin by which points are ranked; empty while no two were seen at the same angle.
  const std::vector<double>& rankedAnglesDeg() const { return rankedAnglesDeg_; }
  /// Indices into points() of what nothing that is ranked beats in time and error.
  const std::vector<size_t>& front() const { return front_; }
  /// Rises with every change of points().
  uint64_t version() const { return version_; }
  /// How many configurations, at how many sizes, are remembered, points or not.
  size_t remembered() const { return entries_.size(); }

 private:
  struct Seen {
    double flipSum = 0.0;
    size_t errors = 0;
    std::vector<double> framesMs;  // the last kMostTimes, as a ring
    size_t times = 0;

    bool isComplete() const { return errors > 0 && times > 0; }
  };
  struct Entry {
    Configuration configuration;  // normalized
    glm::uvec2 pictureSize;
    std::map<size_t, Seen> buckets;
    uint64_t pointSince = 0;  // counts points; 0: none yet

    uint64_t completeBuckets() const;  // one bit each
  };

  Entry& entryOf(const Configuration& configuration, const glm::uvec2& pictureSize);
  void makeRoom();
  void refresh();
  static Point pointOf(const Entry& entry, uint64_t buckets);

  std::list<Entry> entries_;  // the one seen last comes first
  glm::uvec2 pictureSize_{0};
  uint64_t pointCount_ = 0;
  uint64_t version_ = 0;
  std::vector<Point> points_;
  std::vector<double> rankedAnglesDeg_;
  std::vector<size_t> front_;
};

}  // namespace warpscope
