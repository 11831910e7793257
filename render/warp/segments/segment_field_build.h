// Makes what rays walk through of a frame's segments. On the host.
// Tiles: the minima and maxima of depth pyramids (Tevs, Ihrke, Seidel 2008), over cells instead of pixels.
#pragma once

#include <vector>

#include "render/effects/shading.h"
#include "render/march/sample_frame.h"
#include "render/warp/segments/segment_field.h"

namespace warpscope {

class BuiltSegmentField {
 public:
  /// Of the frame's segments; nothing for a frame without.
  void build(const SampleFrame& frame);
  /// Lights the segments for another camera, where the frame says what their normals are.
  void relight(const SampleFrame& frame, const Camera& camera);
  /// By pointers into this.
  SegmentField field() const;

  // What field() points to, for copies of it.
  const std::vector<uint32_t>& first() const { return first_; }
  const std::vector<FieldSegment>& segments() const { return segments_; }
  const std::vector<FieldTile>& tiles(int level) const { return tiles_[level]; }
  /// Colours of segments without light; empty where light does not depend on the eye.
  const std::vector<glm::vec3>& unlit() const { return unlit_; }
  /// The lights of the frame's scene as a camera has them. Those of the world are where the copy of the volume says; without it the volume's axes are the
  /// world's.
  static ShadingSetup lightsFor(const SampleFrame& frame, const Camera& camera);

 private:
  template <class F>
  void forEachLit(const SampleFrame& frame, const F& f);

  PixelGrid pixels_;
  int width_ = 0, height_ = 0;
  std::vector<uint32_t> first_;
  std::vector<FieldSegment> segments_;
  std::vector<glm::vec3> unlit_;
  std::vector<FieldTile> ofPixels_;
  std::vector<FieldTile> tiles_[kFieldLevels];
  int tileColumns_[kFieldLevels] = {};
};

}  // namespace warpscope
