// Copying a frame to the device.
// See device_frame.h.
#include "render/warp/device/device_frame.h"

#include <string>

#include "render/base/error.h"

namespace warpscope {

void DeviceFrame::upload(const SampleFrame& frame, cudaStream_t stream) {
  count_ = 0;
  if (frame.size() > kMaxLbvhSpheres)
    throw InputError("a frame may have at most " + std::to_string(kMaxLbvhSpheres) + " samples, not " + std::to_string(frame.size()));
  samples_.upload(frame.samples, stream);
  colors_.upload(frame.colors, stream);
  grid_ = frame.grid();
  count_ = static_cast<uint32_t>(frame.size());
}

}  // namespace warpscope
