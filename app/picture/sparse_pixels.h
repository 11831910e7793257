// Every n-th pixel of a picture in both directions, so chosen that a camera of fewer pixels has exactly their rays: what is wrong with a picture at a fraction of the
// cost of its ground truth, without the errors that averaging would bring.
#pragma once

#include "render/core/camera.h"
#include "render/warp/warp.h"

namespace warpscope {

struct SparsePixels {
  uint32_t every = 1;      ///< odd
  glm::uvec2 first{0};     ///< column and row of the upper left one
  glm::uvec2 size{0};      ///< how many; at least 1

  glm::uvec2 place(const glm::uvec2& of) const { return first + every * of; }
};

/// Of a picture of that size, each edge at least 1: no more than about `most` along an edge, where it is not too narrow for that.
SparsePixels sparsePixels(const glm::uvec2& size, uint32_t most);
/// Whose pixels' rays are those of that camera's sparse pixels.
Camera sparseCamera(const Camera& camera, const SparsePixels& pixels);
WarpedImage sparseImage(const WarpedImage& image, const SparsePixels& pixels);

}  // namespace warpscope
