// What is left to gain: bounds of what warps of one frame can do, by those who know the volume. Offline, for sweeps.
// Two of them. One opaque dot a ray: whatever depth a heuristic chooses, a sample can be seen in those pixels alone that its ray passes, and a pixel shows one
// of them (epipolar geometry: Hartley, Zisserman 2004, chapter 9). A perfect warp: the volume itself wherever the frame's rays came, and nothing elsewhere.
#pragma once

#include <stop_token>

#include "render/march/sample_frame.h"
#include "render/volume/proxy.h"
#include "render/warp/proxy_fill.h"
#include "render/warp/segments/segment_field_build.h"
#include "render/warp/warp.h"

namespace warpscope {

/// A copy with all of the volume's voxels, of 256 values: `whole` of an Oracle. Throws OperationCancelled if `stop` is set.
ProxyPtr wholeCopyOf(const Volume& volume, const TransferFunction& function, const std::stop_token& stop);

/// What is known of a frame and its volume, made once for all cameras. One thread at a time.
class Oracle {
 public:
  /// `whole`: wholeCopyOf() the volume. The frame has one sample and some segments a ray, and its settings say how it is
  /// marched. `background`: linear RGB.
  Oracle(SampleFramePtr frame, ProxyPtr whole, const glm::vec3& background);

  /// For each pixel of `camera`, whose true colours are `truth` (linear, premultiplied, of its size), what is least different from them as displayed over the
  /// background: the colour of a sample whose ray passes the pixel between the begin of its first segment and the end of its last, or nothing. No choice of one
  /// depth a sample can do better, for dots as large as their pixels: here a sample may be seen in several pixels at once. Throws OperationCancelled if `stop` is
  /// set.
  WarpedImage bestDots(const Camera& camera, const Image<glm::vec4>& truth, const std::stop_token& stop) const;

  /// What another camera sees of the volume where the frame knows it: inside of its view, in front of its rays' ends. Throws OperationCancelled if `stop` is set.
  WarpedImage perfectlyWarped(const Camera& camera, const std::stop_token& stop);

 private:
  const SampleFramePtr frame_;
  const ProxyPtr whole_;
  const glm::vec3 background_;
  BuiltSegmentField built_;
  Image<uint32_t> own_;  // sample of each of the frame's pixels
  Image<Rgba8> shown_;   // its colour as displayed
  ProxyFill fill_;
};

}  // namespace warpscope
