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

/// What `shot --ray` writes. Depths are distances along the ray from its beginning, in volume units.
nlohmann::json toJson(const RayTrace& trace, const RayOfPixel& ray, const MarchSettings& settings);

}  // namespace warpscope
