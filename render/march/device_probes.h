// Which samples and segments of a march on a device tell where the grid of its rays lies. They come with the frame's counts: asked for later they would be two more trips.
// For .cu files and what they include.
#pragma once

#include "render/march/cuda_frame.h"

namespace warpscope {

/// Of one march at a time.
class DeviceProbes {
 public:
  /// When the stream has got there they can be taken. `sampleCount`: on the device. `rays`: how many there are; 0: no segments.
  void ask(const CudaFrameBuffers& frame, const uint32_t* sampleCount, size_t rays, cudaStream_t stream);
  /// Gives them to the frame, which has its sizes.
  void giveTo(CudaFrame& frame) const;

 private:
  struct Found {
    PackedSample samples[kMostFrameProbes];
    FirstSegment segments[kMostFrameProbes];
  };

  cuda::PinnedValue<Found> found_;  // written by the device
};

}  // namespace warpscope
