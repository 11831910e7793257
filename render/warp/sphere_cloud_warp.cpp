// Frames become clouds of spheres.
// See sphere_cloud_warp.h.
#include "render/warp/sphere_cloud_warp.h"

#include "render/core/parallel.h"

namespace warpscope {

void SphereCloudWarp::setFrame(SampleFramePtr frame, const WarpSettings& settings, const std::stop_token&) {
  frame_ = nullptr;  // in case that building fails
  if (!frame) return;
  spheres_.resize(frame->size());
  const SampleGrid grid = frame->grid();
  parallelForRanges(spheres_.size(), 1 << 15, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) spheres_[i] = unpackSample(frame->samples[i], grid);
  });
  build(*frame, spheres_, settings);
  frame_ = std::move(frame);
}

void SphereCloudWarp::draw(const Camera& camera, const WarpSettings& settings, WarpedImage& image, const std::stop_token& stop) {
  requireUsable(camera);
  if (frame_) {
    drawSpheres(*frame_, camera, settings, image, stop);
  } else {
    image.samples.resize(camera.width, camera.height, kNoSample);
    image.color.resize(camera.width, camera.height);
  }
}

}  // namespace warpscope
