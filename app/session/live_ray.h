// The ray that the user looks at, traced in the background: anew whenever what it depends on has changed.
// Its worker reads the volume once for all rays of a scene.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "app/experiment/ray_look.h"
#include "render/base/newest_worker.h"
#include "render/core/crew.h"

namespace warpscope {

struct RayJob {
  VolumePtr volume;
  TransferFunction transferFunction;
  RayOfPixel ray;
  MarchSettings settings;
  SampleFramePtr frame;  ///< where the ray is of a gap, the one that leaves it; where it is of a sample, the one that has it; else null
  std::optional<RayOfPixel> own;  ///< where it is of a sample: the picture's own ray through the pixel that shows that

  bool operator==(const RayJob&) const = default;
};

/// What a pixel shows in truth, where that is not where the sample lies that it shows: nearer, that one is seen through a gap; farther, it covers what is to be seen.
struct MissedPlace {
  float depth = 0.0f;   ///< from the eye, volume units
  float before = 0.0f;  ///< the sample, by so much; below 0: behind it
  SeenByFrame seen;     ///< by the frame, of that place
};

struct RayResult {
  RayJob job;      ///< that was done
  RayTrace trace;
  std::optional<SeenByFrame> seen;  ///< of a gap: by the job's frame, of where the ray's depth is by its settings; nothing where it has none
  std::optional<MissedPlace> missed;  ///< of a sample: what the picture should have in its place
  std::string error;
};

using RayWorker = NewestWorker<RayJob, RayResult>;

class LiveRay {
 public:
  /// `onNews` is called on another thread after each result. Loops run on `crew`; null: on all cores.
  explicit LiveRay(std::function<void()> onNews, std::shared_ptr<Crew> crew = nullptr);

  /// Forgets all, the volume among it; what is at work ends.
  void clear();
  /// No ray is wanted any more; the next one of the same volume finds that read.
  void lookAway();
  /// The ray that is wanted from now on. True if it is another one than before. Where the volume is elsewhere error() says so.
  bool follow(RayJob wanted);
  /// Collects a result. True if there was one that is of use.
  bool take();

  /// The newest; nothing while there is none. It is of the wanted ray where isCurrent().
  const std::optional<RayResult>& result() const { return result_; }
  bool isCurrent() const { return result_ && wanted_ && result_->job == *wanted_; }
  /// Why there is none; empty if there is, or will be.
  const std::string& error() const { return error_; }

  void requestStop() { worker_.requestStop(); }
  bool waitForEnd(std::chrono::steady_clock::time_point time) const { return worker_.waitForEnd(time); }

 private:
  std::optional<RayJob> wanted_;
  std::optional<RayResult> result_;
  std::string error_;
  RayWorker worker_;
};

}  // namespace warpscope
