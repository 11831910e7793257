// Makes what rays walk through of a frame's segments. On the host.
// Tiles: the minima and maxima of depth pyramids (Tevs, Ihrke, Seidel 2008), over cells instead of pixels.
#pragma once

#include <vector>

#include "render/effects/shading.h"
#include "render/march/sample_frame.h"
#include "render/warp/segments/segment_field.h"

namespace warpscope {

/// The lights of the frame's scene as a camera has them.
ShadingSetup segmentLightsFor(const SampleFrame& frame, const Camera& camera);

class BuiltSegmentField {
 public:
  /// Of the frame's segments; nothing for a frame without.
  void build(const SampleFrame& frame);
  /// Lights the segments for another camera, where the frame says what their normals are.
  void relight(const SampleFrame& frame, const Camera& camera);
  /// By pointers into this; its tiles lie in one array, level after level.
  SegmentField field() const;

 private:
  template <class F>
  void forEachLit(const SampleFrame& frame, const F& f);

  PixelGrid pixels_;
  PictureDepths depths_;
  int width_ = 0, height_ = 0;
  std::vector<uint32_t> first_;
  std::vector<FieldSpan> spans_;
  std::vector<FieldMatter> matter_;
  std::vector<float> places_;
  std::vector<glm::vec3> unlit_;  // colours without light; empty where light does not depend on the eye
  std::vector<FieldTile> ofPixels_;
  std::vector<FieldTile> tiles_;  // level after level
};

}  // namespace warpscope
