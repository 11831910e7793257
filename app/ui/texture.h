// A picture on the graphics card, for ImGui to draw.
// The window loads its own few OpenGL entry points: those of render/gl belong to the headless contexts, which may be of another kind.
#pragma once

#include <glad/gl.h>
#include <imgui.h>

#include <memory>
#include <optional>
#include <string>

#include "app/picture/shown_picture.h"
#include "render/core/transfer_vector.h"
#include "render/cuda/gl_interop.h"

namespace warpscope::ui {

/// OpenGL entry points of the window's context.
struct WindowGl {
  using Function = void (*)();
  /// The entry point of that name in the window's context, which must be current; null if there is none.
  using Loader = Function (*)(const char* name);
  /// Throws InputError naming what is missing.
  explicit WindowGl(Loader loader);

  std::string renderer;  ///< as the driver says
  bool isDrawnByCpu = false;  ///< by one of Mesa's drivers without a device

  PFNGLGENTEXTURESPROC genTextures = nullptr;
  PFNGLDELETETEXTURESPROC deleteTextures = nullptr;
  PFNGLBINDTEXTUREPROC bindTexture = nullptr;
  PFNGLTEXPARAMETERIPROC texParameteri = nullptr;
  PFNGLTEXIMAGE2DPROC texImage2D = nullptr;
  PFNGLPIXELSTOREIPROC pixelStorei = nullptr;
  PFNGLREADPIXELSPROC readPixels = nullptr;
  PFNGLVIEWPORTPROC viewport = nullptr;
  PFNGLSCISSORPROC scissor = nullptr;
  PFNGLCLEARCOLORPROC clearColor = nullptr;
  PFNGLCLEARPROC clear = nullptr;
  PFNGLENABLEPROC enable = nullptr;
  PFNGLDISABLEPROC disable = nullptr;
};

/// The lower left corner, of that size, of what is drawn to at the moment: upright and opaque.
Image<Rgba8> readPicture(const WindowGl& gl, const glm::uvec2& size);

/// Follows a picture that changes: uploads it when it is another one.
class PictureTexture {
 public:
  /// `gl` must outlive the texture, whose context must be current whenever it is used or destroyed.
  explicit PictureTexture(const WindowGl& gl) : gl_(gl) {}
  ~PictureTexture();
  PictureTexture(const PictureTexture&) = delete;
  PictureTexture& operator=(const PictureTexture&) = delete;

  /// A picture on a CUDA device comes straight from there if the window's OpenGL runs on it too, else through page-locked memory.
  void show(const ShownPicture& picture);
  /// Blends between pixels (for sizes that are not a multiple of the picture's), or shows each as a square.
  void setSmooth(bool isSmooth);
  /// Adds it to the list, over whatever lies there: not blended with that, which is half of the work where the CPU draws the window.
  void draw(ImDrawList& list, const ImVec2& from, const ImVec2& to) const;
  /// What ImGui's lists of drawing have, as its backend for OpenGL understands it.
  void* id() const { return reinterpret_cast<void*>(uintptr_t{name_}); }

 private:
  void allocate(uint32_t width, uint32_t height, const Rgba8* pixels);
  void showDevice(const DevicePicture& picture);

  const WindowGl& gl_;
  ShownPicture picture_;
  GLuint name_ = 0;
  glm::uvec2 size_{0};
  std::unique_ptr<cuda::InteropTexture> interop_;  // of this size
  std::optional<bool> hasInterop_;                 // asked when it is first wanted
  TransferVector<Rgba8> staging_;
  bool isSmooth_ = false;
};

}  // namespace warpscope::ui
