// A ray that somebody looks at: whose it is, and what is written about it.
// Of a pixel that shows a sample it is the server's ray on which that sample was found; of others the ray of the picture's own camera.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "app/picture/content.h"
#include "render/march/ray_trace.h"

namespace warpscope {

/// A ray through the centre of a pixel of a camera's picture.
struct RayOfPixel {
  bool isServers = false;  ///< of the frame's camera
  Camera camera;
  glm::uvec2 pixel{0};     ///< column, row from above
  std::optional<uint32_t> sample;  ///< in the frame
  bool isGap = false;  ///< nothing of the frame covers the pixel: it is a hole, or was filled in

  bool operator==(const RayOfPixel&) const = default;
};

/// The ray behind pixel `place` of a picture. Throws InputError for a pixel outside of it.
RayOfPixel rayBehind(const ContentInputs& inputs, const glm::uvec2& place);

/// The depth that stands for the ray by `heuristic`; nothing where no sample counts.
std::optional<float> depthBy(const RayTrace& trace, Heuristic heuristic);

/// Where on a ray its light comes from, seen from a depth that is to stand for all of it: shares that sum to 1, or zeros where no sample counts. What is not
/// `within` moves wrongly when the dot at that depth is seen from elsewhere.
struct LightAbout {
  float nearer = 0.0f, within = 0.0f, farther = 0.0f;
};

/// `within`: at most that far from the depth, volume units, which are edges of the smallest voxel.
inline constexpr float kLightReach = 1.0f;
LightAbout lightAbout(const RayTrace& trace, float depth);

/// What a frame has where a place of the volume is, as its own camera saw that.
struct SeenByFrame {
  enum class Kind {
    outside,  ///< the place is not in the frame's picture
    nothing,  ///< the pixel that it is in has no sample
    nearer,   ///< the pixel's sample lies in front: the place was hidden
    farther,  ///< the pixel's sample lies behind: its depth is not that of the place
    there,    ///< the pixel's sample lies at the place, within kLightReach or its radius
  };
  Kind kind = Kind::outside;
  glm::uvec2 pixel{0};   ///< of the frame
  float apart = 0.0f;    ///< volume units, along the frame's ray, between the place and the pixel's sample; 0 without one
  float radius = 0.0f;   ///< of that sample, likewise

  bool operator==(const SeenByFrame&) const = default;
};

/// Of several samples in the pixel the one whose distance is nearest to the place's. Looks at every sample.
SeenByFrame seenByFrame(const SampleFrame& frame, const glm::vec3& place);

/// What `shot --ray` writes. Depths are distances along the ray from its beginning, in volume units.
nlohmann::json toJson(const RayTrace& trace, const RayOfPixel& ray, const MarchSettings& settings);

}  // namespace warpscope
