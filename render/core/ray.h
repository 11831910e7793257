// A ray: a half-line. Distances along it ("t", "view depth") are in units of its direction's length, which is 1 by construction.
#pragma once

#include "render/core/host_device.h"

namespace warpscope {

struct Ray {
  glm::vec3 origin;
  glm::vec3 direction;  ///< unit length unless a function says that it takes any

  WARPSCOPE_HD glm::vec3 at(float t) const { return origin + t * direction; }
};

}  // namespace warpscope
