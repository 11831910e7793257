// Targets, state, reading back.
// See canvas.h.
#include "render/gl/canvas.h"

#include <string>

#include "render/base/error.h"

namespace warpscope::gl {

Canvas::Canvas(GLenum format) : format_(format) {
  GLint side = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &side);
  largestSide_ = static_cast<uint32_t>(side);
}

void Canvas::prepare(uint32_t width, uint32_t height) {
  if (!framebuffer_ || width != width_ || height != height_) {
    if (width > largestSide_ || height > largestSide_)
      throw InputError("this OpenGL driver draws images of at most " + std::to_string(largestSide_) + " pixels a side");
    framebuffer_ = {};
    color_ = makeTexture2D(format_, width, height);
    depth_ = makeTexture2D(GL_DEPTH_COMPONENT32F, width, height);
    framebuffer_ = makeFramebuffer(color_, depth_);
    width_ = width;
    height_ = height;
  }
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
  glViewport(0, 0, static_cast<GLsizei>(width), static_cast<GLsizei>(height));
  const GLfloat farthest = 0.0f;
  glClearNamedFramebufferfv(framebuffer_.name(), GL_DEPTH, 0, &farthest);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_GREATER);
  glClipControl(GL_UPPER_LEFT, GL_ZERO_TO_ONE);
}

void Canvas::begin(uint32_t width, uint32_t height, uint32_t nothing) {
  prepare(width, height);
  const GLuint value[4] = {nothing, 0, 0, 0};
  glClearNamedFramebufferuiv(framebuffer_.name(), GL_COLOR, 0, value);
}

void Canvas::begin(uint32_t width, uint32_t height, const glm::vec4& nothing) {
  prepare(width, height);
  glClearNamedFramebufferfv(framebuffer_.name(), GL_COLOR, 0, &nothing[0]);
}

void Canvas::read(Image<uint32_t>& ids) const {
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glReadPixels(0, 0, static_cast<GLsizei>(width_), static_cast<GLsizei>(height_), GL_RED_INTEGER, GL_UNSIGNED_INT, ids.data());
}

void Canvas::read(Image<glm::vec4>& colors) const {
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glReadPixels(0, 0, static_cast<GLsizei>(width_), static_cast<GLsizei>(height_), GL_RGBA, GL_FLOAT, colors.data());
}

void Canvas::abandon() noexcept {
  color_.abandon();
  depth_.abandon();
  framebuffer_.abandon();
}

}  // namespace warpscope::gl
