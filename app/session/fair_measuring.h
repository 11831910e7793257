// All techniques on show measured alike: one frame, one set of angles, one after the other with nothing of the panels' at work beside them.
// Times are measuring.h's, the error is FLIP (Andersson et al. 2020) against the volume marched for each camera.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/experiment/configuration.h"
#include "app/scene/scene.h"
#include "app/session/warp_job.h"
#include "render/base/newest_worker.h"
#include "render/core/crew.h"
#include "render/gl/context.h"

namespace warpscope {

/// Degrees by which the camera is turned away from the frame's.
inline constexpr std::array<double, 6> kFairAnglesDeg{0.0, 5.0, 10.0, 20.0, 30.0, 45.0};

struct FairJob {
  std::shared_ptr<const Scene> scene;   ///< without what it is not needed for
  MarcherPtr marcher;                   ///< of the ground truth
  SampleFramePtr frame;
  View frameView;                       ///< from which the frame was marched
  glm::uvec2 sizePx{0};                 ///< of the pictures
  RenderSettings reference;
  std::vector<Configuration> configurations;
  std::shared_ptr<std::atomic<size_t>> done;  ///< counts pictures and ground truths
};

/// One configuration, over all angles.
struct FairPoint {
  struct Angle {
    double angleDeg = 0.0, frameMs = 0.0, flip = 0.0;
  };
  Configuration configuration;
  double frameMs = 0.0;   ///< of the slowest angle
  double flip = 0.0;      ///< mean
  std::vector<Angle> angles;
  glm::uvec2 pictureSize{0};
};

struct FairResult {
  std::vector<FairPoint> points;
  std::string error;
};

using FairWorker = NewestWorker<FairJob, FairResult>;

class FairMeasuring {
 public:
  /// `onNews` is called on another thread after each result. Loops run on `crew`, of which nobody else makes use, as those of panels do on theirs; null: on all cores.
  FairMeasuring(gl::Platform platform, WarpResources resources, std::function<void()> onNews, std::shared_ptr<Crew> crew = nullptr);

  void start(FairJob job);
  /// Why nothing is begun.
  void refuse(std::string why) { error_ = std::move(why); }
  void cancel();
  /// Forgets what was measured, too.
  void clear();
  bool isMeasuring() const { return steps_ > 0; }
  /// Steps that were done, and all.
  size_t done() const { return done_ ? done_->load() : 0; }
  size_t steps() const { return steps_; }
  /// Collects a result. True if there was one.
  bool take();

  /// What was measured last.
  const std::vector<FairPoint>& points() const { return points_; }
  /// Indices of points that nothing beats in time and error.
  const std::vector<size_t>& front() const { return front_; }
  /// Why it could not be measured; empty if it could.
  const std::string& error() const { return error_; }

  void requestStop() { worker_.requestStop(); }
  bool waitForEnd(std::chrono::steady_clock::time_point time) const { return worker_.waitForEnd(time); }

 private:
  std::shared_ptr<std::atomic<size_t>> done_;
  size_t steps_ = 0;  // 0: nothing is at work
  std::vector<FairPoint> points_;
  std::vector<size_t> front_;
  std::string error_;
  FairWorker worker_;
};

}  // namespace warpscope
