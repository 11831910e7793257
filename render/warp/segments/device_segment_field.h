// A frame's segments as rays walk through them, made on a CUDA device. For .cu files and what they include.
// The same numbers as segment_field_build.h's: by the formulas of segment_field_parts.h.
#pragma once

#include "render/core/color.h"
#include "render/cuda/memory.h"
#include "render/march/cuda_frame.h"
#include "render/warp/segments/segment_field_parts.h"

namespace warpscope {

/// Keeps its buffers. Works in one stream.
class DeviceSegmentField {
 public:
  DeviceSegmentField() = default;
  DeviceSegmentField(const DeviceSegmentField&) = delete;
  DeviceSegmentField& operator=(const DeviceSegmentField&) = delete;

  /// Copies the frame's segments, in stream order, unless they are on the device (SampleFrame::device), which it then goes on with; the frame must stay until the
  /// stream has got there. Throws DeviceError.
  void upload(const SampleFrame& frame, cudaStream_t stream);
  /// Derives the field from what was copied; `tables` are the colours' in device memory.
  void build(const ColorTables* tables, cudaStream_t stream);
  /// Lights the segments for another camera, where the frame says what their normals are.
  void relight(const Camera& camera, cudaStream_t stream);

  /// Of the frame that was copied last, without what it holds.
  const SampleFrame& head() const { return head_; }
  bool empty() const { return width_ == 0; }
  SegmentField field() const;

 private:
  template <bool kUnlights>
  void light(const Camera& camera, cudaStream_t stream);

  SampleFrame head_;
  PixelGrid pixels_;
  FieldDepths fieldDepths_;
  int width_ = 0, height_ = 0;
  bool hasNormals_ = false;
  cuda::DeviceBuffer<OpticalDepths> opticalDepths_;
  FrameOnDevicePtr held_;       // what segments are read from, where they were on the device
  CudaFrameBuffers uploaded_;   // else
  const CudaFrameBuffers* from_ = &uploaded_;
  cuda::DeviceBuffer<uint32_t> first_;
  cuda::DeviceBuffer<FieldSpan> spans_;
  cuda::DeviceBuffer<FieldMatter> matter_, unlit_;
  cuda::DeviceBuffer<float> places_;
  cuda::DeviceBuffer<FieldTile> ofPixels_, tiles_[kFieldLevels];
  cuda::Scratch scratch_;
};

}  // namespace warpscope
