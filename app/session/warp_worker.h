// A panel's worker: draws the newest frame for the newest camera with the panel's technique, and makes a picture of it.
// In its own thread with its own headless OpenGL context, because without a GPU a picture takes longer than the window may wait.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "app/experiment/measuring.h"
#include "app/picture/shown_picture.h"
#include "app/session/picture_plan.h"
#include "app/session/warp_job.h"
#include "render/base/newest_worker.h"
#include "render/core/crew.h"
#include "render/gl/context.h"

namespace warpscope {

/// How often a panel's worker did what, for pictures of one scene; timing them is not counted.
struct WarpCounts {
  uint64_t made = 0;          ///< techniques
  uint64_t builds = 0;        ///< what a technique derives from a frame
  uint64_t draws = 0;         ///< by a technique, for pictures on show
  uint64_t drawsToJudge = 0;  ///< by a technique, for nobody to see: to the ground truth's camera, or to host memory
  uint64_t shortcuts = 0;     ///< the frame's own picture, as it is or turned

  bool operator==(const WarpCounts&) const = default;
};

struct WarpResult {
  WarpJob job;             ///< that was done
  PicturePlan plan;        ///< by which
  WarpCounts counts;       ///< with this job, since jobs have been of this scene
  ShownPicture picture;    ///< none if there is an error
  double buildMs = 0.0;    ///< of what the technique derived from that frame; 0 where a shortcut takes its place
  double drawMs = 0.0;     ///< from the camera to colours in the memory that the picture is in
  std::chrono::steady_clock::time_point finishedAt{};  ///< when the picture was there
  /// What to judge: the frame as the reference's camera sees it. Null without a reference, and where that one's camera is an earlier one that was
  /// drawn already.
  std::shared_ptr<const WarpedImage> judged;
  /// Where there is nothing to judge, of what was drawn for the screen in host memory: its sparsePixels(), MovingErrors::kPixels. Else null.
  std::shared_ptr<const WarpedImage> sparse;
  std::optional<MeasuredPicture> timed;  ///< of a job that was to be timed; nothing if its picture was not the last that was drawn
  std::string error;

  uint64_t requestId() const { return job.frame ? job.frame->requestId : 0; }
};

using WarpWorker = NewestWorker<WarpJob, WarpResult>;

/// `resources`: the backend and whom a fallback is told; marcher and context are the jobs' and the worker's own. `crew`: that its loops run on, and its own thread
/// stands back as far; null: on all cores, as ever.
std::unique_ptr<WarpWorker> makeWarpWorker(gl::Platform platform, WarpResources resources, std::function<void()> onResult, std::shared_ptr<Crew> crew = nullptr);

struct ReferenceResult {
  ReferenceJob job;                             ///< that was done
  std::shared_ptr<const ReferenceImage> image;  ///< null if there is an error
  std::string error;
};

using ReferenceWorker = NewestWorker<ReferenceJob, ReferenceResult>;

/// `crew`: as makeWarpWorker().
std::unique_ptr<ReferenceWorker> makeReferenceWorker(std::function<void()> onResult, std::shared_ptr<Crew> crew = nullptr);

}  // namespace warpscope
