// Draws what a ScriptedWindow shows by OpenGL, headless, so that it can be photographed. EGL alone: Dear ImGui's renderer asks libGL for its entry points.
#pragma once

#include <memory>

#include "app/ui/texture.h"
#include "render/core/image.h"
#include "render/gl/context.h"

namespace warpscope::ui {

class DrawnWindow {
 public:
  /// Throws InputError where there is no EGL.
  DrawnWindow();

  WindowGl gl() const;
  /// Within Dear ImGui's context: before its first frame, and before it goes.
  void begin();
  void end();
  void beginFrame();
  /// What ImGui::Render() left, as a picture of that size.
  Image<Rgba8> picture(const glm::uvec2& size);

 private:
  const std::unique_ptr<gl::Context> context_;
};

}  // namespace warpscope::ui
