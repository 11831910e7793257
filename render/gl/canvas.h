// Off-screen pictures of one value a pixel, with a reversed float depth buffer, read back with row 0 on top.
// Reversed depth: Reed 2015, "Depth Precision Visualized": 0 is the farthest, and what is greater is seen.
#pragma once

#include <glm/glm.hpp>

#include "render/core/image.h"
#include "render/gl/objects.h"

namespace warpscope::gl {

/// Holds its buffers from picture to picture. A context must be current wherever it is made, used or destroyed.
class Canvas {
 public:
  /// Of the format GL_R32UI (ids) or GL_RGBA32F (colours).
  explicit Canvas(GLenum format);

  /// Binds and clears the canvas, rows upside down so that row 0 of what is read back is the top one; of equal depths what was drawn first stays. Throws
  /// InputError for a size that the driver does not draw.
  void begin(uint32_t width, uint32_t height, uint32_t nothing);
  void begin(uint32_t width, uint32_t height, const glm::vec4& nothing);

  /// Into an image of the canvas's size.
  void read(Image<uint32_t>& ids) const;
  void read(Image<glm::vec4>& colors) const;

  /// See Object::abandon.
  void abandon() noexcept;

 private:
  void prepare(uint32_t width, uint32_t height);

  GLenum format_;
  uint32_t largestSide_ = 0, width_ = 0, height_ = 0;
  Texture color_, depth_;
  Framebuffer framebuffer_;
};

}  // namespace warpscope::gl
