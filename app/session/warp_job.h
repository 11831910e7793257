// What a panel's picture is to be: the job of its worker. And the ground truth that it is judged against.
// Plain data; warp_worker.h does it, picture_plan.h says what there is to do.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "render/codec/codec.h"
#include "render/core/color.h"
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
  ReferenceImage(ReferenceJob job, Image<glm::vec4> color);

  const ReferenceJob& job() const { return job_; }
  const Image<glm::vec4>& color() const { return color_; }
  /// Over the job's background, as a screen shows it.
  const std::shared_ptr<const Image<Rgba8>>& picture() const { return picture_; }
  /// Prepared when first asked for; safe on any thread.
  const PictureJudge& judge() const;

 private:
  ReferenceJob job_;
  Image<glm::vec4> color_;
  std::shared_ptr<const Image<Rgba8>> picture_;
  mutable std::once_flag isPrepared_;
  mutable std::optional<PictureJudge> judge_;
};

struct WarpJob {
  const WarpDescriptor* technique = nullptr;  ///< null: there is nothing to draw, and what was kept to draw with goes
  uint64_t scene = 0;  ///< that all of this is of: counted by the session
  MarcherPtr marcher;  ///< for techniques that march
  SampleFramePtr frame;
  Camera camera;
  WarpSettings settings;
  glm::vec3 background{0.0f};  ///< linear RGB
  PixelMarks marks;
  bool takesShortcuts =
      false;  ///< of a picture that the frame itself shows, instead of the technique's (picture_plan.h)
  /// What the picture is to be judged against; null while there is none. Of the same size, but its camera may be an
  /// earlier one.
  std::shared_ptr<const ReferenceImage> reference;
  /// Not to be drawn for the screen but to be timed, as the picture that is on show already; the frame came in that
  /// coding. Cancelling it costs nothing: the technique stays as it is.
  std::optional<CodecSettings> timedAs;

  bool operator==(const WarpJob&) const = default;
};

}  // namespace warpscope
