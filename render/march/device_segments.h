// The segments of a march on a device: where kernels store them, and how those that are there come to the host.
// Scan, then copy: CUB's DeviceScan (Merrill, Garland 2016, decoupled look-back).
#pragma once

#include "render/cuda/memory.h"
#include "render/march/frame_segments.h"
#include "render/march/march_launch.h"

namespace warpscope {

/// Keeps its buffers. Works in one stream.
class DeviceSegments {
 public:
  /// Makes room for `slots` segments of each of so many pixels.
  void reserve(size_t pixels, int slots, bool hasNormals);
  /// Nothing in any pixel.
  void clear(cuda::Stream& stream);

  template <class Job>
  void giveTo(Job& job) {
    job.segmentSlots = slots_;
    job.segmentCounts = counts_.data();
    job.segments = {dense_.depths.data(), dense_.colors.data(), hasNormals_ ? dense_.normals.data() : nullptr};
  }

  /// Puts those that are there next to one another.
  void compact(cuda::Stream& stream);
  /// Fills `segments`, in pinned memory. Waits.
  void copyTo(FrameSegments& segments, cuda::Stream& stream);

 private:
  struct Buffers {
    cuda::DeviceBuffer<SegmentDepths> depths;
    cuda::DeviceBuffer<Rgba8> colors;
    cuda::DeviceBuffer<NormalCode> normals;
  };

  size_t pixels_ = 0;
  int slots_ = 0;
  bool hasNormals_ = false;
  cuda::DeviceBuffer<RaySegmentCount> counts_;
  cuda::DeviceBuffer<uint32_t> ends_;  // of each pixel's segments among all
  Buffers dense_, kept_;
  cuda::Scratch scratch_;
};

}  // namespace warpscope
