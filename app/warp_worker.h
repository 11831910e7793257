// A panel's worker: draws the newest frame for the newest camera with the panel's technique, and makes a picture of it.
// In its own thread with its own headless OpenGL context, because without a GPU a picture takes longer than the window may wait.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "app/newest_worker.h"
#include "app/shown_picture.h"
#include "render/core/color.h"
#include "render/gl/context.h"
#include "render/warp/warp.h"

namespace warpscope {

/// The volume as the current camera sees it: what holes are counted against.
struct ReferenceImage {
  Camera camera;
  Image<glm::vec4> color;
};

struct WarpJob {
  const WarpDescriptor* technique = nullptr;
  MarcherPtr marcher;  ///< for techniques that march
  SampleFramePtr frame;
  Camera camera;
  WarpSettings settings;
  glm::vec3 background{0.0f};  ///< linear RGB
  Rgba8 uncovered = 0;         ///< colour of pixels that no sample covers; 0: the background
  std::shared_ptr<const ReferenceImage> reference;  ///< of the same camera; null while there is none

  bool operator==(const WarpJob&) const = default;
};

struct WarpResult {
  ShownPicture picture;    ///< none if there is an error
  const WarpDescriptor* technique = nullptr;
  MarcherPtr marcher;      ///< the job's
  uint64_t requestId = 0;  ///< of the frame that was drawn
  double buildMs = 0.0;    ///< of what the technique derived from that frame
  double drawMs = 0.0;     ///< from the camera to colours in the memory that the picture is in
  std::chrono::steady_clock::time_point finishedAt{};  ///< when the picture was there
  std::optional<double> holeFraction;  ///< if the job had a reference
  std::string error;
};

using WarpWorker = NewestWorker<WarpJob, WarpResult>;

/// `resources`: the backend and whom a fallback is told; marcher and context are the jobs' and the worker's own.
std::unique_ptr<WarpWorker> makeWarpWorker(gl::Platform platform, WarpResources resources, std::function<void()> onResult);

/// What the reference worker marches.
struct ReferenceJob {
  MarcherPtr marcher;
  Camera camera;
  MarchSettings settings;

  bool operator==(const ReferenceJob&) const = default;
};

struct ReferenceResult {
  std::shared_ptr<const ReferenceImage> image;
  std::string error;
};

using ReferenceWorker = NewestWorker<ReferenceJob, ReferenceResult>;

std::unique_ptr<ReferenceWorker> makeReferenceWorker(std::function<void()> onResult);

}  // namespace warpscope
