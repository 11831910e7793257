// The first surfaces along each of a camera's rays, over one another, of a frame's samples. Host only; the hierarchy is the one of lbvh.h.
// Multi-hit traversal after Gribble, Naveros, Kerzner 2014, "Multi-Hit Ray Traversal", JCGT 3(1); compositing: Porter, Duff 1984; what is one surface: surface_hits.h.
#pragma once

#include <span>
#include <stop_token>
#include <vector>

#include "render/core/camera.h"
#include "render/core/image.h"
#include "render/march/sample_frame.h"
#include "render/warp/lbvh/lbvh_builder.h"
#include "render/warp/multihit/surface_hits.h"

namespace warpscope {

/// A frame as surfaces. Its samples stand twice in hierarchies: with radii that just close their surfaces, of which rays meet what lies in the samples' own pixels, and with the frame's
/// radii, for rays that meet none of the first: these close gaps between surfaces as `spheres` does, but not where the frame's own picture is empty.
class SurfaceTracer {
 public:
  /// Takes a frame and the spheres of its samples (unpackSample); the frame has to stay. Throws as validateSpheres does; the tracer then is not to be used.
  void build(const SampleFrame& frame, std::span<const Sphere> spheres);

  /// For every pixel of `camera` (see isUsable) the first `most` (1..kMaxHits, else std::invalid_argument) surfaces along its ray, as surfacesOf() has them, of pieces in the order of
  /// (distance, id): `ids` takes the sample that shows the first one, kNoSample where there is none, and `color` their colours over one another, 0 where there is none. In the frame's own
  /// view that is the frame's own picture, if no ray has more samples than `most`. Both images take the camera's size. Throws OperationCancelled if `stop` is set; the images are then
  /// incomplete.
  void trace(const Camera& camera, int most, Image<uint32_t>& ids, Image<glm::vec4>& color, const std::stop_token& stop) const;

  /// The frame's samples with the radii of the pieces' spheres.
  std::span<const PackedSample> samples() const { return samples_; }

 private:
  template <int Capacity>
  void traceTiles(const Camera& camera, int most, Image<uint32_t>& ids, Image<glm::vec4>& color, const std::stop_token& stop) const;

  const SampleFrame* frame_ = nullptr;
  Image<uint32_t> firstOf_;
  SampleRays rays_;
  std::vector<PackedSample> samples_;
  std::vector<Sphere> spheres_;
  Lbvh pieces_, wide_;
};

}  // namespace warpscope
