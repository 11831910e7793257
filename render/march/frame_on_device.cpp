// See frame_on_device.h.
#include "render/march/frame_on_device.h"

#include <utility>

#include "render/march/sample_frame.h"

namespace warpscope {

SampleFrame onHost(const SampleFrame& frame) {
  SampleFrame here = frame;
  const FrameOnDevicePtr there = std::exchange(here.device, nullptr);
  if (std::exchange(here.isAway, false)) there->copyTo(here);
  return here;
}

}  // namespace warpscope
