// A panel's worker: draws the newest frame for the newest camera with the panel's technique, and makes a picture of it.
// In its own thread with its own headless OpenGL context, because without a GPU a picture takes longer than the window may wait.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "app/experiment/measuring.h"
#include "app/picture/shown_picture.h"
#include "render/base/newest_worker.h"
#include "render/core/color.h"
#include "render/gl/context.h"
#include "render/metrics/picture_errors.h"
#include "render/warp/warp.h"

namespace warpscope {

/// What the reference worker marches.
struct ReferenceJob {
  MarcherPtr marcher;
  Camera camera;
  RenderSettings settings;
  glm::vec3 background{0.0f};  ///< linear RGB, that pictures are compared over

  bool operator==(const ReferenceJob&) const = default;
};

/// The volume as the job's camera sees it.
class ReferenceImage {
 public:
  ReferenceImage(ReferenceJob job, Image<glm::vec4> color) : job_(std::move(job)), color_(std::move(color)) {}

  const ReferenceJob& job() const { return job_; }
  const Image<glm::vec4>& color() const { return color_; }
  /// Prepared when first asked for; safe on any thread.
  const PictureJudge& judge() const;

 private:
  ReferenceJob job_;
  Image<glm::vec4> color_;
  mutable std::once_flag isPrepared_;
  mutable std::optional<PictureJudge> judge_;
};

struct WarpJob {
  const WarpDescriptor* technique = nullptr;
  MarcherPtr marcher;  ///< for techniques that march
  SampleFramePtr frame;
  Camera camera;
  WarpSettings settings;
  glm::vec3 background{0.0f};  ///< linear RGB
  Rgba8 uncovered = 0;         ///< colour of pixels that no sample covers; 0: the background
  /// What the picture is to be judged against; null while there is none. Of the same size, but its camera may be an earlier one.
  std::shared_ptr<const ReferenceImage> reference;
  /// Not to be drawn for the screen but to be timed, as the picture that is on show already; the frame came in that coding. Cancelling it costs nothing: the
  /// technique stays as it is.
  std::optional<CodecSettings> timedAs;

  bool operator==(const WarpJob&) const = default;
};

struct WarpResult {
  WarpJob job;             ///< that was done
  ShownPicture picture;    ///< none if there is an error
  bool isDrawn = false;    ///< anew; else only its colours behind it changed
  double buildMs = 0.0;    ///< of what the technique derived from that frame
  double drawMs = 0.0;     ///< from the camera to colours in the memory that the picture is in
  std::chrono::steady_clock::time_point finishedAt{};  ///< when the picture was there
  /// What to judge: the frame as the reference's camera sees it. Null without a reference, and where that one's camera is an earlier one that was
  /// drawn already.
  std::shared_ptr<const WarpedImage> judged;
  std::optional<MeasuredPicture> timed;  ///< of a job that was to be timed; nothing if its picture was not the last that was drawn
  std::string error;

  uint64_t requestId() const { return job.frame ? job.frame->requestId : 0; }
};

using WarpWorker = NewestWorker<WarpJob, WarpResult>;

/// `resources`: the backend and whom a fallback is told; marcher and context are the jobs' and the worker's own.
std::unique_ptr<WarpWorker> makeWarpWorker(gl::Platform platform, WarpResources resources, std::function<void()> onResult);

struct ReferenceResult {
  ReferenceJob job;                             ///< that was done
  std::shared_ptr<const ReferenceImage> image;  ///< null if there is an error
  std::string error;
};

using ReferenceWorker = NewestWorker<ReferenceJob, ReferenceResult>;

std::unique_ptr<ReferenceWorker> makeReferenceWorker(std::function<void()> onResult);

}  // namespace warpscope
