// What is cut off a volume, as settings, and their text forms.
// See clip.h.
#pragma once

#include <string>
#include <string_view>

#include <glm/vec3.hpp>

#include "render/base/short_list.h"

namespace warpscope {

/// Kept is what lies at least so far from the volume's centre, along the normal.
struct ClipPlane {
  glm::vec3 normal{0.0f};  ///< a direction of the world, not 0
  float distance = 0.0f;   ///< world units, as in the volume's file

  bool operator==(const ClipPlane&) const = default;
};

/// What is in front of all is kept.
struct ClipPlanes : ShortList<ClipPlane, 6> {
  static constexpr float kFarthest = 1e12f;  ///< no number of a plane is greater
};

/// The part of the volume that is kept, along its own axes: 0 to 1 is all of it.
struct ClipBox {
  glm::vec3 lower{0.0f};
  glm::vec3 upper{1.0f};  ///< more than `lower` along each axis

  bool operator==(const ClipBox&) const = default;
};

/// What is kept between two planes across the view.
struct Slab {
  float thickness = 0.0f;  ///< volume units (smallest voxel edges); 0: there is no slab
  float depth = 0.0f;      ///< of its middle behind the volume's centre, volume units

  bool operator==(const Slab&) const = default;
};

struct Clip {
  ClipPlanes planes;
  ClipBox box{};
  Slab slab{};

  bool operator==(const Clip&) const = default;
};

/// "1,0,0,-5 0,0.5,1,0": X,Y,Z,DISTANCE with blanks between planes; "none" for none. Reads back as the same.
std::string textOf(const ClipPlanes& planes);
/// Back. Throws UsageError that begins with `name` and says which plane is wrong and why.
ClipPlanes parseClipPlanes(std::string_view text, std::string_view name);

/// "0,0,0,1,1,0.5": lower and upper corner. "none" for all of it.
std::string textOf(const ClipBox& box);
/// Back. Throws UsageError that begins with `name`.
ClipBox parseClipBox(std::string_view text, std::string_view name);

}  // namespace warpscope
