// A frame in the memory of a CUDA device: what its marcher or decoder fills, and its coder and techniques read. For .cu files and what they include.
#pragma once

#include "render/base/shared_pool.h"
#include "render/cuda/memory.h"
#include "render/march/frame_segments.h"
#include "render/march/sample_frame.h"

namespace warpscope {

/// Grow and never shrink: frames follow one another in the same memory.
struct CudaFrameBuffers {
  cuda::DeviceBuffer<PackedSample> samples;
  cuda::DeviceBuffer<Rgba8> colors;
  cuda::DeviceBuffer<uint8_t> layers;
  cuda::DeviceBuffer<float> spreads;
  cuda::DeviceBuffer<RaySegmentCount> rays;
  cuda::DeviceBuffer<uint32_t> ends;  ///< of each ray's segments among all; a marcher's alone
  cuda::DeviceBuffer<SegmentDepths> depths;
  cuda::DeviceBuffer<Rgba8> segmentColors;
  cuda::DeviceBuffer<NormalCode> normals;
};

struct CudaFrameMemory {
  CudaFrameBuffers buffers;
  cuda::Stream stream;  ///< for those who look at a frame and have none
};

using CudaFramePool = SharedPool<CudaFrameMemory>;

/// How much there is in the buffers.
struct CudaFrameSizes {
  size_t samples = 0;
  size_t rays = 0, segments = 0;  ///< no rays: nobody asked for segments
  bool hasLayers = false;         ///< a ray has several samples
  bool hasSpreads = false, hasNormals = false;
};

class CudaFrame final : public FrameOnDevice {
 public:
  explicit CudaFrame(const std::shared_ptr<CudaFramePool>& pool) : memory_(pool->take()) {}

  /// Where `frame` is on a CUDA device; null if it is on none.
  static const CudaFrame* of(const SampleFrame& frame) { return dynamic_cast<const CudaFrame*>(frame.device.get()); }
  /// The same where it is nowhere else.
  static const CudaFrame* ofAway(const SampleFrame& frame) { return frame.isAway ? of(frame) : nullptr; }

  /// Of who makes the frame, to be filled; others read.
  CudaFrameBuffers& buffers() const { return memory_->buffers; }
  const CudaFrameSizes& sizes() const { return sizes_; }
  void setSizes(const CudaFrameSizes& sizes) { sizes_ = sizes; }
  void setPlacements(const FramePlacements& placements) { placements_ = placements; }
  void setHaveRadii(bool haveRadii) { haveRadii_ = haveRadii; }

  size_t sampleCount() const override { return sizes_.samples; }
  size_t segmentCount() const override { return sizes_.segments; }
  bool hasNormals() const override { return sizes_.hasNormals; }
  bool haveRadii() const override { return haveRadii_; }
  FramePlacements placements() const override { return placements_; }
  void copyTo(SampleFrame& frame) const override;
  /// As that, in a stream of the caller's; `copied` is when all was there.
  void copyTo(SampleFrame& frame, cudaStream_t stream, cuda::Event& copied) const;

 private:
  const CudaFramePool::Lease memory_;
  CudaFrameSizes sizes_;
  FramePlacements placements_;
  bool haveRadii_ = true;
};

}  // namespace warpscope
