// Loading and uploading.
// See texture.h.
#include "app/ui/texture.h"

#include <algorithm>
#include <array>
#include <string>

#include "app/shell/log.h"
#include "render/base/error.h"
#include "render/cuda/pinned_memory.h"

namespace warpscope::ui {
WindowGl::WindowGl(Loader loader) {
  const auto load = [loader](auto& function, const char* name) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(loader(name));
    if (function == nullptr) throw InputError("the screen's OpenGL driver lacks " + std::string(name));
  };
  load(genTextures, "glGenTextures");
  load(deleteTextures, "glDeleteTextures");
  load(bindTexture, "glBindTexture");
  load(texParameteri, "glTexParameteri");
  load(texImage2D, "glTexImage2D");
  load(pixelStorei, "glPixelStorei");
  load(readPixels, "glReadPixels");
  load(viewport, "glViewport");
  load(scissor, "glScissor");
  load(clearColor, "glClearColor");
  load(clear, "glClear");
  load(enable, "glEnable");
  load(disable, "glDisable");
  const GLubyte* (*getString)(GLenum) = nullptr;
  load(getString, "glGetString");
  if (const auto* name = reinterpret_cast<const char*>(getString(GL_RENDERER))) renderer = name;
  if (!renderer.empty()) logDetail("the window's OpenGL: " + renderer);
  constexpr std::array kOfMesa{"llvmpipe", "softpipe", "swrast"};
  isDrawnByCpu = std::ranges::any_of(kOfMesa, [&](const char* name) { return renderer.find(name) != std::string::npos; });
}

Image<Rgba8> readPicture(const WindowGl& gl, const glm::uvec2& size) {
  Image<Rgba8> upsideDown(size.x, size.y), picture(size.x, size.y);
  gl.pixelStorei(GL_PACK_ALIGNMENT, 4);
  gl.readPixels(0, 0, static_cast<GLsizei>(size.x), static_cast<GLsizei>(size.y), GL_RGBA, GL_UNSIGNED_BYTE, upsideDown.data());
  for (uint32_t y = 0; y < size.y; ++y)
    std::transform(upsideDown.row(y), upsideDown.row(y) + size.x, picture.row(size.y - 1 - y), [](Rgba8 pixel) { return pixel | 0xff000000u; });
  return picture;
}

PictureTexture::~PictureTexture() {
  interop_.reset();
  if (name_ != 0) gl_.deleteTextures(1, &name_);
}

void PictureTexture::show(const ShownPicture& picture) {
  if (picture == picture_) return;
  picture_ = picture;
  if (picture_.device)
    showDevice(*picture_.device);
  else if (picture_.host)
    allocate(picture_.host->width(), picture_.host->height(), picture_.host->data());
}

void PictureTexture::showDevice(const DevicePicture& picture) {
  const glm::uvec2 size(picture.width(), picture.height());
  if (!hasInterop_) {
    const std::string reason = cuda::whyNoInterop();
    hasInterop_ = reason.empty();
    logDetail("CUDA pictures reach the window " + (reason.empty() ? "by interop" : "through page-locked memory: " + reason));
  }
  if (*hasInterop_) {
    try {
      if (!interop_ || size != size_) {
        allocate(size.x, size.y, nullptr);
        interop_ = std::make_unique<cuda::InteropTexture>(name_, size.x, size.y);
      }
      return interop_->show(picture);
    } catch (const DeviceError& error) {  // some drivers promise it and refuse: the other way remains
      logDetail(std::string("CUDA pictures reach the window through page-locked memory: ") + error.what());
      interop_.reset();
      hasInterop_ = false;
    }
  }
  if (staging_.capacity() == 0) staging_ = TransferVector<Rgba8>(TransferAllocator<Rgba8>(cuda::pinnedMemory()));
  staging_.resize(size_t{size.x} * size.y);
  picture.download(staging_);
  allocate(size.x, size.y, staging_.data());
}

void PictureTexture::allocate(uint32_t width, uint32_t height, const Rgba8* pixels) {
  interop_.reset();  // what it registered goes
  const bool isNew = name_ == 0;
  if (isNew) gl_.genTextures(1, &name_);
  gl_.bindTexture(GL_TEXTURE_2D, name_);
  if (isNew) {
    for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T}) gl_.texParameteri(GL_TEXTURE_2D, axis, GL_CLAMP_TO_EDGE);
    for (const GLenum use : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER}) gl_.texParameteri(GL_TEXTURE_2D, use, GL_NEAREST);
    gl_.texParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
  }
  gl_.pixelStorei(GL_UNPACK_ALIGNMENT, 4);
  gl_.pixelStorei(GL_UNPACK_ROW_LENGTH, 0);
  gl_.texImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, static_cast<GLsizei>(width), static_cast<GLsizei>(height), 0, GL_RGBA, GL_UNSIGNED_BYTE,
                 pixels);
  size_ = {width, height};
}

void PictureTexture::draw(ImDrawList& list, const ImVec2& from, const ImVec2& to) const {
  const auto disable = [](const ImDrawList*, const ImDrawCmd* command) { static_cast<const WindowGl*>(command->UserCallbackData)->disable(GL_BLEND); };
  const auto enable = [](const ImDrawList*, const ImDrawCmd* command) { static_cast<const WindowGl*>(command->UserCallbackData)->enable(GL_BLEND); };
  list.AddCallback(disable, const_cast<WindowGl*>(&gl_));
  list.AddImage(id(), from, to);
  list.AddCallback(enable, const_cast<WindowGl*>(&gl_));
}

void PictureTexture::setSmooth(bool isSmooth) {
  if (name_ == 0 || isSmooth == isSmooth_) return;
  isSmooth_ = isSmooth;
  gl_.bindTexture(GL_TEXTURE_2D, name_);
  for (const GLenum use : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    gl_.texParameteri(GL_TEXTURE_2D, use, isSmooth ? GL_LINEAR : GL_NEAREST);
}

}  // namespace warpscope::ui
