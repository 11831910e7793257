// A frame's samples in device memory. For .cu files and what they include.
#pragma once

#include "render/core/color.h"
#include "render/cuda/memory.h"
#include "render/march/sample_frame.h"
#include "render/warp/lbvh/lbvh.h"

namespace warpscope {

/// A frame's samples as kernels see them.
struct DeviceFrameView {
  const PackedSample* samples = nullptr;
  const Rgba8* colors = nullptr;
  uint32_t count = 0;
  SampleGrid grid;

  /// At least the distance of any point of any sphere from the coordinates' origin: radii are below twice the unit, and add to each
  /// coordinate.
  float reach() const { return reachOf(grid.bounds) + 6.0f * grid.radiusUnit; }
};

class DeviceFrame {
 public:
  /// Copies the frame's samples, in stream order, unless they are on the device (SampleFrame::device), which it then goes on with; the frame must stay until the
  /// stream has got there. Throws InputError for more samples than a hierarchy can hold, DeviceError.
  void upload(const SampleFrame& frame, cudaStream_t stream);
  const DeviceFrameView& view() const { return view_; }
  /// kLayerPlane where it is on the device as well; else null.
  const uint8_t* layers() const { return layers_; }

 private:
  cuda::DeviceBuffer<PackedSample> samples_;
  cuda::DeviceBuffer<Rgba8> colors_;
  FrameOnDevicePtr held_;  // null: in the memory above
  const uint8_t* layers_ = nullptr;
  DeviceFrameView view_;
};

}  // namespace warpscope
