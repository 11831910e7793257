// A framebuffer in place of a window.
// See drawn_window.h.
#include "tests/drawn_window.h"

#include <EGL/egl.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include "app/ui/theme.h"

namespace warpscope::ui {
namespace {

template <class Function>
Function entryPoint(const char* name) {
  return reinterpret_cast<Function>(eglGetProcAddress(name));
}

}  // namespace

DrawnWindow::DrawnWindow() : context_(gl::makeHeadlessContext(gl::Platform::egl)) {}

WindowGl DrawnWindow::gl() const {
  context_->makeCurrent();
  return WindowGl([](const char* name) { return entryPoint<WindowGl::Function>(name); });
}

void DrawnWindow::begin() {
  context_->makeCurrent();
  ImGui_ImplOpenGL3_Init("#version 330 core");
}

void DrawnWindow::end() {
  context_->makeCurrent();
  ImGui_ImplOpenGL3_Shutdown();
}

void DrawnWindow::beginFrame() {
  context_->makeCurrent();
  ImGui_ImplOpenGL3_NewFrame();
}

Image<Rgba8> DrawnWindow::picture(const glm::uvec2& size) {
  context_->makeCurrent();
  const WindowGl gl = this->gl();
  const auto genFramebuffers = entryPoint<PFNGLGENFRAMEBUFFERSPROC>("glGenFramebuffers");
  const auto deleteFramebuffers = entryPoint<PFNGLDELETEFRAMEBUFFERSPROC>("glDeleteFramebuffers");
  const auto bindFramebuffer = entryPoint<PFNGLBINDFRAMEBUFFERPROC>("glBindFramebuffer");
  const auto framebufferTexture = entryPoint<PFNGLFRAMEBUFFERTEXTURE2DPROC>("glFramebufferTexture2D");
  GLuint texture = 0, framebuffer = 0;
  gl.genTextures(1, &texture);
  gl.bindTexture(GL_TEXTURE_2D, texture);
  gl.texImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, static_cast<GLsizei>(size.x), static_cast<GLsizei>(size.y), 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  genFramebuffers(1, &framebuffer);
  bindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  framebufferTexture(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
  gl.viewport(0, 0, static_cast<GLsizei>(size.x), static_cast<GLsizei>(size.y));
  gl.clearColor(palette().frame.x, palette().frame.y, palette().frame.z, 1.0f);
  gl.clear(GL_COLOR_BUFFER_BIT);
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  Image<Rgba8> picture = readPicture(gl, size);
  deleteFramebuffers(1, &framebuffer);
  gl.deleteTextures(1, &texture);
  return picture;
}

}  // namespace warpscope::ui
