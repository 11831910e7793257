// What is left to gain: bounds of what warps of one frame can do, by those who know the volume. Offline, for sweeps.
// Two of them. One opaque dot a ray: whatever depth a heuristic chooses, a sample can be seen in those pixels alone that its ray passes, and a pixel shows one
// of them (epipolar geometry: Hartley, Zisserman 2004, chapter 9). A perfect warp: the volume itself wherever the frame's rays came, and nothing elsewhere.
#pragma once

#include <stop_token>

#include "render/march/sample_frame.h"
#include "render/volume/proxy.h"
#include "render/warp/warp.h"

namespace warpscope {

/// For each pixel of `camera`, whose true colours are `truth` (linear, premultiplied, of its size), what is least different from them as displayed over
/// `background` (linear RGB): the colour of a sample whose ray passes the pixel between the begin of its first segment and the end of its last, or nothing. No
/// choice of one depth a sample can do better, for dots as large as their pixels: here a sample may be seen in several pixels at once. Of a frame with one
/// sample and some segments a ray. Throws OperationCancelled if `stop` is set.
WarpedImage bestDots(const SampleFrame& frame, const Camera& camera, const Image<glm::vec4>& truth, const glm::vec3& background, const std::stop_token& stop);

/// What another camera sees of the volume where the frame knows it: inside of its view, in front of its rays' ends. The volume is that of `whole`, a copy in full
/// size, which has 256 values (proxy.h); the frame has segments, and its settings say how it is marched. Throws OperationCancelled if `stop` is set.
WarpedImage perfectlyWarped(const SampleFrame& frame, const ProxyPtr& whole, const Camera& camera, const std::stop_token& stop);

}  // namespace warpscope
