// Rays of a tile that the CPU has marched and whose segments are to be merged: they wait until there are as many as are merged at once.
#pragma once

#include <functional>
#include <vector>

#include "render/march/finished_ray.h"
#include "render/march/ray_relay.h"
#include "render/march/segment_batch_merger.h"

namespace warpscope {

/// What a ray has come to. Used again from ray to ray.
struct MarchedRay {
  FinishedRay finished;
  RayLattice lattice;
  RelayedRay* handed = nullptr;  ///< null where rays are marched whole
  std::vector<CountingSample> counting;  ///< where FinishedRay has them
  RaySamples found;
  FinishedSegments segments;
  EncodedSegments encoded;

  /// What is handed on of its segments.
  SegmentMerger& handedSegments() const { return finished.tile->segments[static_cast<size_t>(handed - finished.tile->rays.data())]; }
};

class WaitingRays {
 public:
  struct Job {
    int mostSegments = 0;              ///< of each ray; 0: none are wanted, and no ray waits
    const SampleRule* rule = nullptr;  ///< how they are sent; null where they are wanted as they are
    std::function<NormalCode(const MarchedRay& ray, float t)> normalAt = {};  ///< what light asks of the place `t` on a ray that is marched whole; empty where none are sent with them
    std::function<void(MarchedRay& ray)> onMerged = {};  ///< gets those that have ended, with their segments, but for what goes once more
  };

  /// `job` must stay.
  explicit WaitingRays(const Job& job) : job_(job), segments_(mergerRoomFor(job.mostSegments)) {}

  /// Used again from ray to ray: many, and a core's nearest cache has no room for those of all that wait.
  std::vector<CountingSample>& counting() { return counting_; }
  /// Where the next ray belongs.
  MarchedRay& next() { return rays_[count_]; }
  /// What gathers its segments: of one that begins, or of one that was handed on. Null where none are wanted.
  SegmentBatchMerger::Ray* begin() { return job_.mostSegments > 0 ? &segments_.begin(count_) : nullptr; }
  SegmentBatchMerger::Ray* beginHanded() { return job_.mostSegments > 0 ? &segments_.begin(count_, next().handedSegments()) : nullptr; }
  /// That ray has been marched, and waits.
  void add() {
    if (++count_ == SegmentBatchMerger::kRays) finish();
  }
  /// Merges what there is.
  void finish();

 private:
  /// What their segments are sent as; what they are.
  void encode(int count);
  void list(int lane);

  const Job& job_;
  std::vector<CountingSample> counting_;
  MarchedRay rays_[SegmentBatchMerger::kRays];
  int count_ = 0;  // the first so many wait
  SegmentBatchMerger segments_;
};

}  // namespace warpscope
