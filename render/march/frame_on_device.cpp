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

SampleFramePtr onHost(const SampleFramePtr& frame) {
  if (!frame || !frame->isAway) return frame;
  const FrameOnDevice& there = *frame->device;
  const std::scoped_lock lock(there.mutex_);
  if (there.asked_.lock() != frame) {
    there.here_ = std::make_shared<const SampleFrame>(onHost(*frame));
    there.asked_ = frame;
  }
  return there.here_;
}

}  // namespace warpscope
