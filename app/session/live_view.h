// From where the scene is looked at, and of which size pictures and the server's images are.
// A view of which no picture can be made gives way to the last good one.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <string>

#include "app/scene/scene.h"

namespace warpscope {

class LiveView {
 public:
  /// A scene's own view.
  void begin(const View& view);
  void set(const View& view) { wanted_ = view; }
  const View& get() const { return wanted_; }

  /// Area for each picture, in screen pixels, and the edge in screen pixels of one that pictures draw; 0: whatever keeps the display fluent.
  void setArea(const glm::uvec2& areaPx) { areaPx_ = areaPx; }
  void setScreenPixels(uint32_t edge) { screenPixels_ = edge; }

  /// False if no picture can be made of the view; error() says why, and the last good view is back.
  bool place(const Scene& scene);
  const std::string& error() const { return error_; }
  void dismissError() { error_.clear(); }

  /// Size of the pictures; 0 until there is an area.
  glm::uvec2 pictureSize() const;
  /// Of images whose longer side is that; 0 until there is an area.
  glm::uvec2 sizeOfSide(uint32_t sidePx) const;
  /// How many screen pixels a picture's pixel is wide.
  uint32_t screenPixels() const;
  /// Of the view that was placed last. One camera for all sizes: its distance depends on the picture's shape, which rounding changes a little.
  Camera cameraOfSize(const glm::uvec2& size) const;

 private:
  View wanted_, usable_;
  Camera camera_;  // of the pictures
  glm::uvec2 areaPx_{0};
  uint32_t screenPixels_ = 0;
  std::string error_;
};

}  // namespace warpscope
