// The segments of a march on a device: where kernels store them, and how those that are there come to their frame.
// Scan, then copy: CUB's DeviceScan (Merrill, Garland 2016, decoupled look-back).
#pragma once

#include "render/cuda/memory.h"
#include "render/march/cuda_frame.h"
#include "render/march/march_launch.h"

namespace warpscope {

/// Keeps its buffers. Works in one stream.
class DeviceSegments {
 public:
  /// Makes room for `slots` segments of each of so many pixels, in `frame` as well, where what is there will go.
  void reserve(size_t pixels, int slots, bool hasNormals, CudaFrameBuffers& frame);
  /// Nothing in any pixel.
  void clear(CudaFrameBuffers& frame, cuda::Stream& stream);

  template <class Job>
  void giveTo(Job& job, CudaFrameBuffers& frame) {
    job.segmentSlots = slots_;
    job.segmentCounts = frame.rays.data();
    job.segments = {depths_.data(), colors_.data(), hasNormals_ ? normals_.data() : nullptr};
  }

  /// Puts those that are there next to one another in `frame`; how many there are goes to `count`, on the host, when the stream has got there.
  void compact(CudaFrameBuffers& frame, uint32_t* count, cuda::Stream& stream);

 private:
  size_t pixels_ = 0;
  int slots_ = 0;
  bool hasNormals_ = false;
  // As many places for each pixel.
  cuda::DeviceBuffer<SegmentDepths> depths_;
  cuda::DeviceBuffer<Rgba8> colors_;
  cuda::DeviceBuffer<NormalCode> normals_;
  cuda::Scratch scratch_;
};

}  // namespace warpscope
