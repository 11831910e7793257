// Every technique in every view of a scene: pictures, errors, holes, times.
// The protocol of Zellmann 2020, section 4: one frame from the first view, warped to all of them.
#pragma once

#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "app/experiment/measuring.h"
#include "app/frames/frame_fetch.h"
#include "app/scene/scene.h"
#include "render/warp/warp.h"

namespace warpscope {

/// One technique in one view.
struct ComparisonRow {
  const WarpDescriptor* technique = nullptr;
  size_t view = 0;
  double psnrDb = 0.0;  ///< against the reference; infinite if equal
  double ssim = 1.0;    ///< likewise; 1 if equal
  double flip = 0.0;    ///< likewise; 0 if equal
  double holeFraction = 0.0;
  double filledFraction = 0.0;
  Measured draw;        ///< see MeasuredDraw
  MeasuredBuild build;  ///< once a frame, so the same in all views
  size_t bytes = 0;     ///< on the wire: what the technique draws of the frame; for `hold` what its picture alone would take; 0 without a frame
  size_t proxyBytes = 0;  ///< once a scene: the copy of the volume, where the technique draws it
  int draws = 0;        ///< that were timed
};

struct Comparison {
  ServedFrame served;
  SampleFramePtr frame;  ///< of it
  std::vector<Camera> cameras;  ///< one for each view
  std::vector<ComparisonRow> rows;
};

struct ComparisonSettings {
  std::vector<const WarpDescriptor*> techniques;  ///< some of comparedTechniques(), in that order; the reference first, against which the others are judged
  MarchSettings march;
  WarpSettings warp;
  FrameFetch fetch;  ///< where the frame comes from
  CodecSettings codec;   ///< that it was sent with
  uint32_t width = 0;
  uint32_t height = 0;
  int draws = 3;  ///< timed, after one that is not, and builds likewise; the reference is drawn once: the march of the frame has warmed it up
};

/// The techniques that show something of frames that are marched so (lackOf), in the registry's order.
std::vector<const WarpDescriptor*> comparedTechniques(const MarchSettings& march);

/// Runs the comparison. `onPicture` gets each picture as it is made: views in order, techniques as comparedTechniques has them, the reference
/// first. `onStep` is told before each. Throws as marching and warping do.
Comparison compareTechniques(const Scene& scene, const WarpResources& resources, const ComparisonSettings& settings,
                             const std::function<void(const WarpDescriptor&, size_t view, const WarpedImage&)>& onPicture,
                             const std::function<void(const std::string&)>& onStep, const std::stop_token& stop);

/// What one technique gains over another in a view: positive where it is better.
struct Gain {
  size_t view = 0;
  double psnrDb = 0.0;  ///< infinite, or NaN, where a picture equals the reference
  double flip = 0.0;    ///< less FLIP
  double holes = 0.0;   ///< less of the hole fraction
};

/// For each view; empty if the comparison lacks one of the two. Throws UsageError for names that are no techniques.
std::vector<Gain> gainsOf(const Comparison& comparison, std::string_view technique, std::string_view over);

/// "0°", "25°, nearer (0.83×)", "-30°, +10° up": a view as a caption, relative to the first.
std::string viewCaption(const View& view, const View& first);

}  // namespace warpscope
