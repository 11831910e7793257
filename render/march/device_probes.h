// Where samples and segments of a march on a device lie along their rays, found there: with the frame's counts it comes without a trip of its own, and the host locates nothing.
// For .cu files and what they include.
#pragma once

#include "render/march/cuda_frame.h"
#include "render/march/frame_places.h"

namespace warpscope {

/// Of one march at a time.
class DeviceProbes {
 public:
  /// When the stream has got there placements can be asked for. `paths`: of the frame, with the device's noise; `width`: of its picture. `sampleCount`: on the device. `rays`: how many there are; 0: no segments.
  void ask(const PathGrid& paths, uint32_t width, const CudaFrameBuffers& frame, const uint32_t* sampleCount, size_t rays, cudaStream_t stream);
  /// Of a frame that has a lattice, and of so many segments.
  FramePlacements placements(size_t segments) const;

 private:
  struct Votes {
    SampleVotes samples;
    BorderVotes borders;
  };

  cuda::PinnedValue<Votes> votes_;  // written by the device
};

}  // namespace warpscope
