// One ray of a march, with all that became of it: for looking at why a depth is where it is.
// What is traced is marched by the CPU marcher's own code: the samples that count, the depths and the segments are those that a frame is made of.
#pragma once

#include <memory>
#include <vector>

#include "render/march/depth_heuristic.h"
#include "render/march/marcher.h"
#include "render/march/ray_segments.h"

namespace warpscope {

/// A place on a ray, whether or not anything is seen there.
struct RayPlace {
  float t = 0.0f;          ///< along the ray, volume units
  double value = 0.0;      ///< interpolated, in the volume's own units; NaN where a voxel beside it is not finite
  glm::vec4 look{0.0f};    ///< what the transfer function makes of that: linear RGB, straight, and opacity over one unit of volume space
};

/// One depth that could stand for the ray.
struct TracedDepth {
  Heuristic heuristic{};
  DepthResult result;
};

struct RayTrace {
  Ray ray;                   ///< from its beginning, where depths are 0; the direction has length 1
  float cosine = 1.0f;       ///< forward depth of a place over its distance along the ray
  float begin = 0.0f, end = 0.0f;  ///< where it is inside what is shown of the volume; end is not more than begin where it misses that
  std::vector<RayPlace> places;              ///< one a step, from begin to end
  std::vector<CountingSample> samples;       ///< that count, near to far
  std::vector<TracedDepth> depths;           ///< by each heuristic, in their order; without samples none of them has any
  std::vector<RaySegment> segments;          ///< near to far, as many as the settings ask for at most
  bool isEnded = false;      ///< hardly any light was left: what lies behind the last sample was not looked at
  glm::vec4 color{0.0f};     ///< linear, premultiplied: what the ray brings
};

/// Traces rays through one volume and its transfer function. For one thread at a time.
class RayTracer {
 public:
  virtual ~RayTracer() = default;

  /// The ray through the centre of pixel (x, y) of the camera's picture, (0, 0) being in the upper left corner, as march() with these settings marches it.
  /// Throws UsageError for settings out of range or a pixel outside of the picture, InputError for a camera that isUsable() refuses and a volume that is not kept in
  /// memory as a whole, OperationCancelled if `stop` is set.
  virtual RayTrace trace(const Camera& camera, const MarchSettings& settings, const glm::uvec2& pixel, const std::stop_token& stop = {}) = 0;
};

/// Reads all of the volume once. Never fails for a valid one; keeps it alive.
std::unique_ptr<RayTracer> makeRayTracer(VolumePtr volume, TransferFunction transferFunction);

/// Throws InputError where the volume is too large to be kept in memory as a whole (--memory): a ray that is looked at goes through all slices at once, of each of
/// which the system may map 2 MiB.
void requireWholeRays(const Volume& volume);

/// Of the places along the ray, one every `step`; at most kMostRayPlaces, farther apart then.
std::vector<RayPlace> placesAlong(const Volume& volume, const TransferFunction& transferFunction, const Ray& ray, float begin, float end, float step);
inline constexpr size_t kMostRayPlaces = 4096;

}  // namespace warpscope
