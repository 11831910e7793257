// Copying a frame to the device.
// See device_frame.h.
#include "render/warp/device/device_frame.h"

#include <string>

#include "render/base/error.h"
#include "render/march/cuda_frame.h"

namespace warpscope {

void DeviceFrame::upload(const SampleFrame& frame, cudaStream_t stream) {
  view_ = {};
  if (frame.size() > kMaxLbvhSpheres)
    throw InputError("a frame may have at most " + std::to_string(kMaxLbvhSpheres) + " samples, not " + std::to_string(frame.size()));
  const auto count = static_cast<uint32_t>(frame.size());
  held_.reset();
  layers_ = nullptr;
  if (const CudaFrame* const there = CudaFrame::of(frame); there != nullptr && there->sizes().samples == frame.size()) {
    held_ = frame.device;
    const CudaFrameBuffers& buffers = there->buffers();
    view_ = {buffers.samples.data(), buffers.colors.data(), count, frame.grid()};
    layers_ = there->sizes().hasLayers ? buffers.layers.data() : nullptr;
    return;
  }
  samples_.upload(frame.samples, stream);
  colors_.upload(frame.colors, stream);
  view_ = {samples_.data(), colors_.data(), count, frame.grid()};
}

}  // namespace warpscope
