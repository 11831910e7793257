// Checks of cameras that come from outside.
// See camera.h.
#include "render/core/camera.h"

#include <string>

#include "render/base/error.h"
#include "render/core/picture_size.h"

namespace warpscope {
namespace {

bool isUnit(const glm::vec3& v) { return std::abs(glm::dot(v, v) - 1.0f) < 1e-3f; }
bool isFinite(const glm::vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

}  // namespace

bool isUsable(const Camera& camera) {
  return isFinite(camera.eye) && isUnit(camera.right) && isUnit(camera.up) && isUnit(camera.forward) &&
         std::abs(glm::dot(camera.right, camera.up)) < 1e-3f &&
         std::abs(glm::dot(camera.right, camera.forward)) < 1e-3f &&
         std::abs(glm::dot(camera.up, camera.forward)) < 1e-3f && camera.tanHalfFovY > 0.0f &&
         camera.tanHalfFovY < 1e4f && isPictureSize(camera.width, camera.height);
}

void requireUsable(const Camera& camera) {
  if (!isUsable(camera))
    throw InputError(
        "the camera is not usable: it must be finite, with a field of view inside 0 to 180 degrees and an image of " +
        pictureSizes());
}

}  // namespace warpscope
