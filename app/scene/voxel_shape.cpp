// One sentence a policy.
// See voxel_shape.h.
#include "app/scene/voxel_shape.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>

namespace warpscope {
namespace {

std::string instead(const VolumeGeometry& geometry, const std::string& wrong) {
  std::ostringstream text;
  const glm::dvec3& edges = geometry.spacing;
  text << "the voxels' edges are " << edges.x << " x " << edges.y << " x " << edges.z << ": " << wrong
       << "; --radius pixel does not depend on them";
  return text.str();
}

}  // namespace

std::optional<std::string> radiusWarning(const VolumeGeometry& geometry, RadiusPolicy policy) {
  const glm::dvec3& edges = geometry.spacing;
  const double longest = std::max({edges.x, edges.y, edges.z});
  if (longest <= kLongVoxelRatio * geometry.unit()) return std::nullopt;
  switch (policy) {
    case RadiusPolicy::voxel:
    case RadiusPolicy::uncertainty:
      return instead(geometry, "spheres of half a voxel's diagonal are far larger than its short edges");
    case RadiusPolicy::constant:
      return instead(geometry, "spheres of half the shortest edge leave gaps along the long ones");
    case RadiusPolicy::opacity:
      return instead(geometry, "opaque samples' spheres, of half a voxel's diagonal, are far larger than its short edges");
    case RadiusPolicy::pixel:
      return std::nullopt;
  }
  throw std::logic_error("a radius policy is none");
}

}  // namespace warpscope
