// A picture on the graphics card, for ImGui to draw.
// The window loads its own few OpenGL entry points: those of render/gl belong to the headless contexts, which may be of another kind.
#pragma once

#include <glad/gl.h>

#include <memory>

#include "render/core/color.h"
#include "render/core/image.h"

namespace warpscope::ui {

/// OpenGL entry points of the window's context.
struct WindowGl {
  /// Loads through glfwGetProcAddress; the window's context must be current. Throws InputError naming what is missing.
  WindowGl();

  PFNGLGENTEXTURESPROC genTextures = nullptr;
  PFNGLDELETETEXTURESPROC deleteTextures = nullptr;
  PFNGLBINDTEXTUREPROC bindTexture = nullptr;
  PFNGLTEXPARAMETERIPROC texParameteri = nullptr;
  PFNGLTEXIMAGE2DPROC texImage2D = nullptr;
  PFNGLPIXELSTOREIPROC pixelStorei = nullptr;
  PFNGLREADPIXELSPROC readPixels = nullptr;
  PFNGLVIEWPORTPROC viewport = nullptr;
  PFNGLCLEARCOLORPROC clearColor = nullptr;
  PFNGLCLEARPROC clear = nullptr;
};

/// Follows a picture that changes: uploads it when it is another one.
class PictureTexture {
 public:
  /// `gl` must outlive the texture, whose context must be current whenever it is used or destroyed.
  explicit PictureTexture(const WindowGl& gl) : gl_(gl) {}
  ~PictureTexture();
  PictureTexture(const PictureTexture&) = delete;
  PictureTexture& operator=(const PictureTexture&) = delete;

  void show(const std::shared_ptr<const Image<Rgba8>>& picture);
  /// Blends between pixels (for sizes that are not a multiple of the picture's), or shows each as a square.
  void setSmooth(bool isSmooth);
  GLuint name() const { return name_; }

 private:
  const WindowGl& gl_;
  std::shared_ptr<const Image<Rgba8>> picture_;
  GLuint name_ = 0;
  bool isSmooth_ = false;
};

}  // namespace warpscope::ui
